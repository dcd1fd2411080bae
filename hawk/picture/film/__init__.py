"""Films from the air as shots: a film beside its captions or with a flight's log, and hawk's own recordings.

`app.read_film` is the front door; docs/photographs.md describes what it needs.
"""
