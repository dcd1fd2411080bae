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
from hawk.ddc.motion import RoamingWatch
from hawk.model import HeightParameters, MapPose, PathPlan, StateName

WANTED: Final = 0.98
"""Share of the lot that must be seen."""
FRAME_S: Final = 0.25
"""Seconds between two frames that are worked on; a plan leads the drone when the next one is taken."""
_LONGEST_S: Final = 300.0
_LONGEST_S_M: Final = 1.5  # and so many seconds for each metre of the least way


class Pilot(Protocol):
    """Whoever plans a flight."""

    def plan(self, frame: FrameInput, known: SurveyedMap) -> PathPlan:
        """Return where to fly next."""
        ...


@dataclass(frozen=True, slots=True)
class Flown:
    """One flight. ``way`` (metres) and ``seconds`` until 98 % of the lot were seen, None when they never were.

    ``whole_way`` and ``whole_seconds`` are until the pilot was done by itself, with ``coverage`` then; ``plan_ms`` the
    processor's milliseconds of each plan, ``excursions`` counts how often the true place left the fence, ``end`` says
    why it ended. ``track`` (N, 3) holds true north, east and the share seen, frame by frame.
    """

    way: float | None
    seconds: float | None
    whole_way: float
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


def fly(
    lot: Lot, setup: Setup, pilot: Pilot, *, errors: bool = True, to_the_end: bool = True, maps: bool = True
) -> Flown:
    """Fly until the pilot is done, is stuck or takes far too long; with ``to_the_end`` False at 98 % at the latest.

    ``errors`` False takes away the errors of position and map. The seed's own generators give equal errors to all.
    ``maps`` False leaves the map blank, for a pilot that knows the lot: looking takes half of a flight's time.
    """
    generators = [np.random.default_rng([lot.seed, stream]) for stream in (1, 2)]
    start = MapPose(*lot.start, setup.height, 0.0, 0.0, lot.yaw)
    drone = Drone(start, lot.fence, generators[0], GNSS_SIGMA_M if errors else 0.0)
    known = SurveyedMap(lot, setup, generators[1], errors=errors)
    coverage, excursions, roaming = Coverage(lot, setup), _Excursions(lot), RoamingWatch()
    goal, waiting = None, PathPlan()
    wanted: tuple[float, float] | None = None
    ticks_per_frame, tick, end = round(FRAME_S / STEP_S), 0, ""
    plan_ms: list[float] = []
    track: list[tuple[float, float, float]] = []
    while not end:
        if tick % ticks_per_frame == 0:
            goal = goal_of(waiting, drone.believed, goal)
            if maps:
                known.look(drone.true, drone.believed)
            coverage.look(drone.true)
            begun = time.thread_time()
            waiting = pilot.plan(_frame(lot, setup, drone, len(track)), known)
            plan_ms.append((time.thread_time() - begun) * 1e3)
            track.append((drone.true.north, drone.true.east, coverage.share))
            if wanted is None and coverage.share >= WANTED:
                wanted = drone.way, drone.seconds
            end = _end(waiting, wanted if not to_the_end else None, drone.seconds, setup.bound(lot.area))
        drone.step(goal)
        excursions.look(drone.true)
        end = end or ("stuck" if roaming.is_stuck(drone.believed, drone.seconds) else "")
        tick += 1
    way, seconds = wanted if wanted is not None else (None, None)
    times, places = np.array(plan_ms), np.array(track)
    return Flown(way, seconds, drone.way, drone.seconds, coverage.share, excursions.count, end, times, places)


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
