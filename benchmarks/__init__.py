"""Measurements: one command each, a table and a flat JSON object."""
