"""Documents, pictures and recordings that come to a desk, and the log of all that comes."""
