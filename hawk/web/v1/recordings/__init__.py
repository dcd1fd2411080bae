"""Recordings of flights: on the disk, as films, and asked for by a desk."""
