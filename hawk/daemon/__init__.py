"""The daemon: its composition root, its start, and what keeps it going."""
