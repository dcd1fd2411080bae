"""Scales of pictures that a world is made of; apart from the rest, so that a command line reads it at no cost."""

from __future__ import annotations

from typing import Final

FINEST_M: Final = 0.005
"""Side of a pixel on the ground, metres: the least."""
COARSEST_M: Final = 1.0
"""The greatest."""
