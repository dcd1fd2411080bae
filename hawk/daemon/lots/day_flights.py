"""Plans a day from the settings' ``[[schedule]]`` when a person asks: reads the lots that are due, and their flights.

Tours are planned on a thread of its own, never in flight. Nothing here commands a drone.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from datetime import datetime
from functools import lru_cache
from typing import TYPE_CHECKING

from hawk.comm.cameras.calibration import load_calibration
from hawk.config.sections import Config
from hawk.daemon.lots.day_plan import DayLimits, DueLot, RoundFlight, day_plan, day_rounds, flight_seconds
from hawk.daemon.lots.schedule import Timetable, unclear_lot
from hawk.daemon.lots.tour import planned_tours
from hawk.ddc.battery.energy import ASSUMED_DRAIN
from hawk.ddc.battery.survey import Battery, Sweep, need_on_ground
from hawk.ddc.fence.geometry import to_map
from hawk.lots.store import LotStore
from hawk.model.day_plan import DayPlan, DayPlanError, Forecast
from hawk.model.known_lot import AGAIN_M, KnownLot
from hawk.model.pictures import CameraModel
from hawk.model.plans import Fence, HeightParameters
from hawk.model.poses import GlobalPose
from hawk.model.sentences import say
from hawk.runtime.late import late
from hawk.runtime.process import WORKER_NICENESS, set_niceness

if TYPE_CHECKING:  # loaded on the store's thread
    from sqlalchemy import Connection

    from hawk.lots import known_lot as queries
    from hawk.lots import names
else:
    queries, names = late("hawk.lots.known_lot"), late("hawk.lots.names")

PICTURE = (1280, 720)
"""Pixels of a picture of a camera that has sent none yet."""
KEPT_TOURS = 16
"""Rounds whose tours are kept: a plan that took too long is there when it is asked for again."""


@dataclass(frozen=True, slots=True)
class DayDrone:
    """The drone that flies the rounds: its camera and heights, a full battery, place and fence where it is here.

    ``fence`` returns the fence on the map of a datum for a drone at a place; None where there is none.
    """

    camera: CameraModel
    heights: HeightParameters
    battery: Battery
    here: GlobalPose | None = None
    is_flying: bool = False
    fence: Callable[[GlobalPose, GlobalPose], Fence | None] = field(default=lambda *_: None)


def drone_of(config: Config) -> DayDrone:
    """Return the drone that settings describe: no flight has measured its drain. Raises ConfigError."""
    heights = HeightParameters(config.heights.minimum_m, config.heights.desired_m, config.heights.maximum_m)
    full = Battery(100.0, config.flight.battery_reserve_percent, ASSUMED_DRAIN, is_measured=False)
    return DayDrone(load_calibration(config.camera).for_size(*PICTURE), heights, full)


class DayPlanner:
    """`plan` belongs to the loop; one plan is made at a time."""

    def __init__(
        self, store: LotStore, config: Config, timetable: Timetable, drone: Callable[[], DayDrone],
        wall: Callable[[], float] = time.time,
    ) -> None:  # fmt: skip
        """``wall`` returns UTC, Unix seconds."""
        self._store = store
        self._timetable = timetable
        self._flight = config.flight
        self._drone = drone
        self._wall = wall
        self._one = asyncio.Lock()
        self._tours = lru_cache(KEPT_TOURS)(planned_tours)
        self._thread = ThreadPoolExecutor(
            1, thread_name_prefix="hawk-day", initializer=set_niceness, initargs=(WORKER_NICENESS,)
        )

    def close(self) -> None:
        """End the thread, without waiting for a tour under way."""
        self._thread.shutdown(wait=False, cancel_futures=True)

    async def plan(self, forecast: Forecast | None, batteries: int) -> DayPlan:
        """Return the rounds of the next 24 hours for a number of full batteries.

        Raises DayPlanError in flight, LotStoreError.
        """
        drone, now = self._drone(), self._wall()
        if drone.is_flying:
            raise DayPlanError(say("The drone flies: plan the day after its landing."))
        if not self._timetable.lots():
            return DayPlan(problems=(say("The settings have no [[schedule]]: write one for each lot."),))
        async with self._one:
            await self._store.open()
            due, problems = await self._store.read(lambda connection: self._due(connection, now))
            flights = [await self._flight_over(lots, drone) for lots in day_rounds(due)]
        return day_plan(flights, DayLimits(now, batteries, self._flight.maximum_wind_m_s, forecast), problems)

    def _due(self, connection: Connection, now: float) -> tuple[list[DueLot], list[str]]:
        moments: dict[str, list[datetime]] = {}

        def note(lot: str, name: str, last: float | None) -> bool:
            moments[lot] = self._timetable.moments(lot, name, last, now, 1)
            return bool(moments[lot])

        lots = queries.lots_ahead(connection, None, note, self._timetable.lots())
        written = sorted({entry.lot for entry in self._timetable.entries})
        unclear, there = names.unclear_lots(connection, written)
        due = [DueLot(lot, moment) for lot in lots for moment in moments[lot.id]]
        return due, [unclear_lot(each, of, there) for each, of in unclear.items()]

    async def _flight_over(self, lots: tuple[DueLot, ...], drone: DayDrone) -> RoundFlight:
        place = lots[0].lot.outline.polygons[0][0]
        empty = next((each.lot for each in lots if not each.lot.has_plan), None)
        if empty is not None:
            reason = say("{name} has no stalls: survey it first, or draw them in its plan.", name=empty.name)
            return RoundFlight(lots, place, problem=reason)
        datum = GlobalPose(*place, 0.0)
        known = await self._store.read(
            lambda connection: [queries.known_lot(connection, each.lot.id, place) for each in lots]
        )
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._thread, self._planned, lots, tuple(known), datum, drone)

    def _planned(
        self, lots: tuple[DueLot, ...], known: tuple[KnownLot, ...], datum: GlobalPose, drone: DayDrone
    ) -> RoundFlight:
        places = [(stall.north, stall.east) for lot in known for stall in (*lot.stalls, *lot.section_places)]
        start, fence = _start(places, datum, drone)
        first = frozenset(each.lot.id for each in lots)
        tours = self._tours(known, first, drone.camera, drone.heights, fence, start)
        distance = sum(tour.distance_m for tour in tours)
        sweep = Sweep.of(self._flight.speed_m_s, drone.heights.desired, drone.camera.width / drone.camera.fx)
        heights = drone.heights.desired, drone.heights.maximum
        need = need_on_ground("outline", _extent_m2(places, start), distance, sweep, heights, drone.battery)
        by_id = {each.lot.id: each for each in lots}
        order = tuple(by_id[tour.lot] for tour in tours)
        seconds = flight_seconds(need, drone.battery, drone.heights.desired)
        return RoundFlight(order, (datum.latitude, datum.longitude), distance, seconds, need.batteries)


def _start(
    places: Sequence[tuple[float, float]], datum: GlobalPose, drone: DayDrone
) -> tuple[tuple[float, float], Fence | None]:
    """Return where a round begins, metres (north, east), and the fence about it.

    A drone within `AGAIN_M` begins where it stands; else the round begins at its first lot.
    """
    if drone.here is not None:
        here = to_map(datum, drone.here.latitude, drone.here.longitude)
        if min(math.dist((here.north, here.east), place) for place in places) <= AGAIN_M:
            return (here.north, here.east), drone.fence(datum, drone.here)
    return places[0], None


def _extent_m2(places: Sequence[tuple[float, float]], start: tuple[float, float]) -> float:
    """Return the area of a square lot whose middle is the start and whose corner is as far as the farthest place."""
    return 2 * max(math.dist(start, place) for place in places) ** 2
