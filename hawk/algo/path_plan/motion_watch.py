"""How the drone moves, found out from frame to frame: velocity from its places, the carrot from what it was told."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from hawk.algo.path_plan.field import Place
from hawk.algo.path_plan.following import DRAG, Motion, led_on
from hawk.algo.path_plan.footprint import GRAVITY, Floats
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.model import MapPose

_LONGEST_S: Final = 1.0
"""After a longer gap between frames the drone is taken to stand at its carrot."""
_FASTEST: Final = 1.5
"""So many times its travel speed the drone flies at most: a position that leaps is no speed."""


class MotionWatch:
    """Keeps what the rehearsal of a flight begins from."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._speed = settings.speed_m_s
        self._lead = settings.lead_m
        self._time = -math.inf
        self._place = np.zeros(2)
        self._carrot = np.zeros(2)
        self._followed: Place | None = None
        self._told: Place | None = None

    def take(self, pose: MapPose, now: float, heading: float) -> Motion:
        """Return the motion at a frame's pose. ``heading`` is the picture's, radians, ``now`` in seconds."""
        place, passed = np.array([pose.north, pose.east]), now - self._time
        velocity, pull = np.zeros(2), np.zeros(2)
        if 0 < passed <= _LONGEST_S:
            velocity = (place - self._place) / passed
            velocity *= min(1.0, _FASTEST * self._speed / max(math.hypot(*velocity), 1e-9))
            self._move_carrot(place, self._speed * passed)
            c, s = math.cos(pose.yaw), math.sin(pose.yaw)
            ahead, aside = -GRAVITY * math.tan(pose.pitch), GRAVITY * math.tan(pose.roll)
            pull = np.array([ahead * c - aside * s, ahead * s + aside * c]) - DRAG * velocity
        else:
            self._carrot, self._followed, self._told = place, None, None
        self._time, self._place, self._followed = now, place, self._told
        before = self._carrot if self._told is None else np.array(self._told)
        return Motion(place, velocity, pull, self._carrot, heading, before)

    def tell(self, target: Place | None) -> None:
        """Take note of where the drone is led from the next frame on; None: it goes on to where it went."""
        self._told = target or self._told

    def _move_carrot(self, place: Floats, step: float) -> None:
        if math.dist(self._carrot, place) > self._lead + 2.0:
            self._carrot = place
        if self._followed is None:
            return
        carrot, goal, drone = (np.array([complex(*at)]) for at in (self._carrot, self._followed, place))
        moved = led_on(carrot, goal, drone, step, self._lead)
        self._carrot = np.array([moved[0].real, moved[0].imag])
