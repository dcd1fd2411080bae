"""One flight of a pilot over a lot: frames go to the pilot as the daemon's chain gives them, plans lead the drone."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.exploration.lots import Lot
from benchmarks.exploration.setups import Setup
from benchmarks.exploration.surveyed import Coverage, SurveyedMap
from benchmarks.kinematic_drone import GNSS_SIGMA_M, STEP_S, Drone, goal_of
from hawk.algo.frame import FrameInput
from hawk.ddc.motion import Goal, Roaming
from hawk.model.operation import StateName
from hawk.model.plans import HeightParameters, PathPlan
from hawk.model.poses import MapPose

WANTED: Final = 0.98
"""Share of the lot that must be seen."""
FRAME_S: Final = 0.25
"""Seconds between two frames that are worked on; a plan leads the drone when the next one is taken."""
_TICKS: Final = round(FRAME_S / STEP_S)
_LONGEST_S: Final = 300.0
_LONGEST_S_M: Final = 1.5  # seconds for each metre of the least distance


class Pilot(Protocol):
    """Plans a flight."""

    def plan(self, frame: FrameInput, known: SurveyedMap) -> PathPlan:
        """Return where to fly next."""
        ...


@dataclass(frozen=True, slots=True)
class Flown:
    """One flight. ``distance_m`` and ``seconds`` until 98 % of the lot were seen, None when they never were.

    ``whole_distance_m`` and ``whole_seconds`` are until the pilot was done by itself, with ``coverage`` then;
    ``plan_ms`` the processor's milliseconds of each plan, ``excursions`` counts how often the true place left the
    fence, ``end`` says why it ended. ``track`` (N, 3) holds true north, east and the share seen, frame by frame.
    """

    distance_m: float | None
    seconds: float | None
    whole_distance_m: float
    whole_seconds: float
    coverage: float
    excursions: int
    end: str
    plan_ms: NDArray[np.float64]
    track: NDArray[np.float64]


class _Excursions:
    def __init__(self, lot: Lot) -> None:
        self._inside = shapely.Polygon(lot.fence.polygon)
        shapely.prepare(self._inside)
        self._outside = False
        self.count = 0

    def look(self, pose: MapPose) -> None:
        outside = not shapely.contains_xy(self._inside, pose.north, pose.east)
        self.count += outside and not self._outside
        self._outside = outside


class Stage:
    """A flight between two frames."""

    def __init__(self, lot: Lot, setup: Setup, rng: np.random.Generator, *, errors: bool) -> None:
        start = MapPose(*lot.start, setup.height, 0.0, 0.0, lot.yaw)
        self.drone = Drone(start, lot.fence, rng, GNSS_SIGMA_M if errors else 0.0)
        self.coverage, self.excursions, self.roaming = Coverage(lot, setup), _Excursions(lot), Roaming()
        self.goal: Goal | None = None
        self.waiting = PathPlan()
        self.wanted: tuple[float, float] | None = None
        self.plan_ms: list[float] = []
        self.track: list[tuple[float, float, float]] = []

    def tick(self) -> bool:
        """Let one tick pass; whether the drone is stuck."""
        self.drone.step(self.goal)
        self.excursions.look(self.drone.true)
        return self.roaming.is_stuck(self.drone.believed, self.drone.seconds)


def fly(
    lot: Lot,
    setup: Setup,
    pilot: Pilot,
    *,
    errors: bool = True,
    to_the_end: bool = True,
    maps: bool = True,
    survey: type[SurveyedMap] = SurveyedMap,
) -> Flown:
    """Fly until the pilot is done, is stuck or takes far too long; with ``to_the_end`` False at 98 % at the latest.

    ``errors`` False takes away the errors of position and map. The seed's own generators give equal errors to all.
    ``maps`` False leaves the map blank, for a pilot that knows the lot: looking takes half of a flight's time.
    ``survey`` is how the map comes to be.
    """
    generators = [np.random.default_rng([lot.seed, stream]) for stream in (1, 2)]
    known = survey(lot, setup, generators[1], errors=errors)
    now = Stage(lot, setup, generators[0], errors=errors)
    end = ""
    while not end:
        now.goal = goal_of(now.waiting, now.drone.believed, now.goal)
        if maps:
            known.look(now.drone.true, now.drone.believed)
        now.coverage.look(now.drone.true)
        begun = time.thread_time()
        now.waiting = pilot.plan(_frame(lot, setup, now.drone, len(now.track)), known)
        now.plan_ms.append((time.thread_time() - begun) * 1e3)
        now.track.append((now.drone.true.north, now.drone.true.east, now.coverage.share))
        if now.wanted is None and now.coverage.share >= WANTED:
            now.wanted = now.drone.distance_m, now.drone.seconds
        end = _end(now.waiting, now.wanted if not to_the_end else None, now.drone.seconds, setup.bound(lot.area))
        end = _let_pass(now, end)
    return _flown(now, end)


def _let_pass(now: Stage, end: str) -> str:
    """Let the ticks pass until the next frame, or one when the flight is over; return why it ended."""
    for _ in range(_TICKS):
        is_stuck = now.tick()
        end = end or ("stuck" if is_stuck else "")
        if end:
            break
    return end


def _flown(now: Stage, end: str) -> Flown:
    distance, seconds = now.wanted if now.wanted is not None else (None, None)
    drone, times, places = now.drone, np.array(now.plan_ms), np.array(now.track)
    count = now.excursions.count
    return Flown(distance, seconds, drone.distance_m, drone.seconds, now.coverage.share, count, end, times, places)


def _frame(lot: Lot, setup: Setup, drone: Drone, sequence: int) -> FrameInput:
    return FrameInput(
        sequence=sequence,
        captured=drone.seconds,
        jpeg=b"",
        camera=setup.camera,
        pose=drone.believed,
        speed=drone.speed,
        state=StateName.AUTONOMOUS_EXPLORE,
        desired=None,
        heights=HeightParameters(),
        fence=lot.fence,
        home=None,
    )


def _end(plan: PathPlan, wanted: tuple[float, float] | None, seconds: float, bound: float) -> str:
    if plan.explore.done:
        return "done"
    if wanted is not None:
        return "seen"
    return "too long" if seconds > _LONGEST_S + _LONGEST_S_M * bound else ""
