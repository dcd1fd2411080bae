"""How the drone will fly way points: many tours at a time are flown in the mind, as the daemon and the autopilot would.

The secret is the drone: a carrot goes ahead of it at travel speed (`hawk.ddc.motion.Carrot`), ArduCopter's position
controller follows the carrot within its limits of acceleration and jerk, and the camera leans as the drone speeds up,
turns and brakes. Positions are metres (north, east), angles radians, times seconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.algo.path_plan.footprint import Bools, Floats
from hawk.algo.path_plan.settings import PathPlanSettings

Complexes = NDArray[np.complex128]

STEP_S: Final = 0.25
_GAIN: Final = 1.0
"""ArduCopter's PSC_POSXY_P, 1/s."""
_BRAKING_SHARE: Final = 0.75
"""The position controller plans its braking with less than the limit: hawk.sim.control's, as observed on ArduCopter."""
_YAW_GAIN: Final = 2.0
_SLEW_RAD_S: Final = math.radians(60.0)
"""ArduCopter's ATC_SLEW_YAW."""
_JERK: Final = 5.0
"""ArduCopter's PSC_JERK_XY, m/s^3."""
DRAG: Final = 0.15
"""Acceleration by air, (m/s^2) per (m/s): some 4 degrees of lean at 5 m/s."""
_YAW_FROM_M: Final = 1.0


@dataclass(frozen=True, slots=True)
class Motion:
    """How the drone moves as a flight begins: ``place``, ``velocity``, ``pull`` (acceleration) and ``carrot`` are
    (2,), ``yaw`` is the picture's heading. For ``waits`` seconds the carrot still goes to ``before``."""

    place: Floats
    velocity: Floats
    pull: Floats
    carrot: Floats
    yaw: float
    before: Floats
    waits: float = STEP_S


@dataclass(frozen=True, slots=True)
class Flights:
    """B flights of T steps. ``places`` (T, B, 2), ``yaws`` (T, B), ``leans`` (T, B, 2): the acceleration that the
    drone leans for; ``flies`` (T, B): whether the end was not reached yet; ``ways`` (B,): metres until it was, and on
    to the way points that no step reached."""

    places: Floats
    yaws: Floats
    leans: Floats
    flies: Bools
    ways: Floats


def fly(motion: Motion, tours: Floats, sizes: NDArray[np.intp], settings: PathPlanSettings, steps: int) -> Flights:
    """Fly B tours (B, K, 2) of so many way points each (B,) from the same motion, for so many steps at most.

    The drone arrives at a way point as the explorer has it arrive, and turns its picture to the next one.
    """
    flock = _Flock(motion, tours[..., 0] + 1j * tours[..., 1], sizes, settings)
    places, leans = np.empty((2, steps, len(tours)), np.complex128)
    yaws, flies = np.empty((steps, len(tours))), np.zeros((steps, len(tours)), np.bool_)
    used = steps
    for step in range(steps):
        if not flock.flying.any():
            used = step
            break
        flies[step] = flock.flying
        flock.step(is_led=step * STEP_S >= motion.waits)
        places[step], yaws[step] = flock.place, flock.yaw
        leans[step] = flock.pull + DRAG * flock.velocity
    return Flights(_flat(places[:used]), yaws[:used], _flat(leans[:used]), flies[:used], flock.way + flock.left())


class _Flock:
    """Places, velocities and accelerations (B,) are complex numbers: north + 1j * east."""

    def __init__(self, motion: Motion, tours: Complexes, sizes: NDArray[np.intp], settings: PathPlanSettings) -> None:
        count = len(tours)
        self._tours, self._sizes, self._order = tours, sizes, np.arange(count)
        self._speed, self._arrival = settings.speed_m_s, settings.arrival_m
        self._most = settings.acceleration_m_s2
        self._lead = settings.lead_m
        self._next = np.zeros(count, np.intp)
        self._goal = tours[:, 0]
        self._before, self.place, self.velocity, self.pull, self._carrot = (
            np.full(count, complex(*vector))
            for vector in (motion.before, motion.place, motion.velocity, motion.pull, motion.carrot)
        )
        self.yaw = np.full(count, motion.yaw)
        self.way = np.zeros(count)
        self.flying = sizes > 0

    def step(self, *, is_led: bool) -> None:
        """Let one step pass; before it ``is_led``, the drone goes on to where it went before."""
        goal = self._goal if is_led else self._before
        self._move_carrot(goal)
        self._turn(goal - self.place)
        off = self._carrot - self.place
        away = np.abs(off)
        allowed = _speed_for(away, _BRAKING_SHARE * self._most)
        gap = off * (np.minimum(allowed, away) / np.maximum(away, 1e-6)) - self.velocity
        size = np.maximum(np.abs(gap), 1e-6)
        aim = gap * np.minimum(1.0 / STEP_S, np.minimum(self._most, np.sqrt(2.0 * _JERK * size)) / size)
        self.pull = self.pull + _limited(aim - self.pull, _JERK * STEP_S)
        self.velocity = self.velocity + self.pull * STEP_S
        moved = self.velocity * STEP_S
        self.place = self.place + moved
        self.way += np.abs(moved) * self.flying
        if is_led:
            self._arrive()

    def left(self) -> Floats:
        """Return the metres (B,) from the drone over the way points that it did not reach."""
        result = np.zeros(len(self.place))
        for number in np.flatnonzero(self.flying).tolist():
            rest = self._tours[number, self._next[number] : self._sizes[number]]
            result[number] = np.abs(np.diff(rest, prepend=self.place[number])).sum()
        return result

    def _arrive(self) -> None:
        there = self.flying & (np.abs(self._goal - self.place) <= self._arrival)
        if there.any():
            self._next = self._next + there
            self.flying = self._next < self._sizes
            self._goal = self._tours[self._order, np.minimum(self._next, self._sizes - 1)]

    def _move_carrot(self, goal: Complexes) -> None:
        self._carrot = led_on(self._carrot, goal, self.place, self._speed * STEP_S, self._lead)

    def _turn(self, off: Complexes) -> None:
        error = np.angle(off * np.exp(-1j * self.yaw)) * (np.abs(off) > _YAW_FROM_M)
        self.yaw = self.yaw + np.clip(error * _YAW_GAIN, -_SLEW_RAD_S, _SLEW_RAD_S) * STEP_S


def led_on(carrot: Complexes, goal: Complexes, place: Complexes, step: float, lead: float) -> Complexes:
    """Return where the carrot is after a step (metres) to the goal: it waits where it is ``lead`` ahead of the drone's
    place."""
    moved = carrot + _limited(goal - carrot, step)
    away = np.abs(moved - place)
    waits = (away > lead) & (away > np.abs(carrot - place))
    return np.where(waits, carrot, moved)


def _speed_for(away: Floats, braking: float) -> Floats:
    """Return the speed for a distance: ArduPilot's ``sqrt_controller``."""
    linear = braking / _GAIN**2
    return np.where(away <= linear, away * _GAIN, np.sqrt(2.0 * braking * np.maximum(away - linear / 2.0, 0.0)))


def _limited(vectors: Complexes, longest: float) -> Complexes:
    return np.asarray(vectors * np.minimum(1.0, longest / np.maximum(np.abs(vectors), 1e-9)))


def _flat(vectors: Complexes) -> Floats:
    return np.stack([vectors.real, vectors.imag], -1)
