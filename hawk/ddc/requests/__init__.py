"""Requests to the autopilot: sent, answered, timed out."""
