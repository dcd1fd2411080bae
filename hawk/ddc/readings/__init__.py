"""Readings: what is believed of the drone, its surroundings and the people."""
