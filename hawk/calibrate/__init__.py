"""Calibration: of the lens with a printed board, of latency and mount from a flight."""
