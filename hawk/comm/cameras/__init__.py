"""Cameras: pictures with the time at which they were taken."""
