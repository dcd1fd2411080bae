"""Drawn and photographed parking lots with their truth."""
