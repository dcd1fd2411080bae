"""The operator page and its server."""
