"""A known lot surveyed again: how far the second flight goes, and what it reports."""
