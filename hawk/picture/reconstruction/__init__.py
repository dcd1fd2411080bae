"""Poses of photographs, adjusted together: features matched between neighbours, one bundle of poses and lens."""
