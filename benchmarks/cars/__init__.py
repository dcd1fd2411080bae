"""Vehicles of real pictures: recall, precision and calibration (``python -m benchmarks.cars``)."""
