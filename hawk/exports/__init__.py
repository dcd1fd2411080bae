"""Surveys of lots as files that other programs open."""
