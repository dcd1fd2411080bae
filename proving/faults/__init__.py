"""Faults, each with a required end and time, on the real programs: hawk-sim, hawk-drone, and a proxy between them."""
