"""Algorithms of one frame: vision, mapper, path plan."""
