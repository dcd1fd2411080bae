"""Rules: facts in, acts out."""
