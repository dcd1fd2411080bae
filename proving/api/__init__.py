"""The API by its own definition: schemathesis sends what it allows, and what it does not, to a real server."""
