"""Mapper App: what all frames together say."""
