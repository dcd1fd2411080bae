"""Drawn and photographed parking lots with their truth."""

from typing import Final

FINEST_M: Final = 0.005
"""Side of a pixel of a world's picture on the ground, metres: the least. It stands here so that a command line reads it
without the libraries that draw."""
COARSEST_M: Final = 1.0
"""The greatest."""
MOST_CHANGES: Final = 100
"""Of a drawn lot's layout."""
