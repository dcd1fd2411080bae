"""Addresses of the version 1 of the API: lots and what surveys saw of them, for other programs."""
