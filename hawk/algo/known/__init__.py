"""A lot that is known already: its place on the map of a flight, and the states of its stalls."""
