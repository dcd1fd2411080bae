"""Parking Lot Hawk: one drone, one parking lot, every free and taken stall."""
