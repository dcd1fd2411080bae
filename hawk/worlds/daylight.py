"""Light of a place at a moment: where the sun stands, dusk and night."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np

from hawk.model.sun import SunPosition
from hawk.worlds.conditions import set_condition
from hawk.worlds.moment import Condition
from hawk.worlds.plan import SitePlan
from hawk.worlds.scene.light import Sun

DUSK_BELOW_DEG: Final = 4.0
"""A sun lower than this is dusk: shadows are faint and lamps are lit."""
NIGHT_BELOW_DEG: Final = -6.0
"""A sun lower than this is night: the end of civil twilight."""


def light_at(plan: SitePlan, weather: Condition, position: SunPosition, sampled: Sun, rng: np.random.Generator) -> Sun:
    """Prepare a plan for the weather and the light of a moment; return the sun.

    ``sampled`` gives depth and softness of shadows; their direction and length are those of ``position``.
    """
    sun = set_condition(plan, weather, replace(sampled, shadow=shadow_of(position)), rng)
    if position.elevation >= DUSK_BELOW_DEG:
        return sun
    if position.elevation < NIGHT_BELOW_DEG:
        return set_condition(plan, Condition.NIGHT, sun, rng)
    # dusk doubles the shadow of the sun that it gets
    return set_condition(plan, Condition.DUSK, replace(sun, shadow=(sun.shadow[0] / 2, sun.shadow[1] / 2)), rng)


def shadow_of(position: SunPosition) -> tuple[float, float]:
    """Return the shadow of one metre of height, metres (x east, y south): no longer than at `DUSK_BELOW_DEG`."""
    shadow = position.shadow()
    if shadow is None:
        return 0.0, 0.0
    north, east = shadow
    longest = 1 / math.tan(math.radians(DUSK_BELOW_DEG))
    scale = min(1.0, longest / math.hypot(north, east))
    return east * scale, -north * scale
