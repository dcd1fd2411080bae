"""Perception on still pictures and videos, without a flight."""
