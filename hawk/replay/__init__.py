"""Recorded flights again: read by time, processed by today's vision, and given to other programs."""
