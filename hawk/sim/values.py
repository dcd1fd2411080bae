"""Values of the simulator's options: `hawk-drone --sim` and `hawk-sim` read them alike, before anything starts."""

from __future__ import annotations

import argparse
import math
from typing import Final

from hawk.config.options import number
from hawk.worlds.scale import COARSEST_M, FINEST_M

SLOWEST, FASTEST = 0.5, 4.0
"""Limits of the simulated seconds per real second: MAVSDK's own timers stay real."""
STEEPEST_PERCENT: Final = 30.0
"""A drone would slide on steeper ground."""

speed = number(SLOWEST, FASTEST)
scale = number(FINEST_M, COARSEST_M)
"""Metres on the ground that a pixel covers."""
gnss_sigma = number(0, 50)
"""Metres."""
camera_rate = number(1, 60)
"""Pictures in a simulated second."""
wind = number(0, 15)
"""Metres a second."""
rangefinder = number(0, 300)
"""Metres."""


def slope(text: str) -> tuple[float, float]:
    """Return PERCENT,DEG of rising ground."""
    try:
        percent, direction = (float(part) for part in text.split(","))
    except ValueError:
        percent = direction = math.nan
    if not (0.0 <= percent <= STEEPEST_PERCENT and -360.0 <= direction <= 360.0):
        raise argparse.ArgumentTypeError(
            f"must be PERCENT,DEG, 0 to {STEEPEST_PERCENT:g} and -360 to 360, not {text!r}"
        )
    return percent, direction
