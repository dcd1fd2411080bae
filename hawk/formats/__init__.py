"""Formats of others: pictures and files with an area."""
