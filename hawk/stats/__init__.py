"""Statistics of a lot's use, from the states of its stalls alone (docs/statistics.md)."""
