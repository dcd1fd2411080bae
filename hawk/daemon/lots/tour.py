"""Plans the flight over lots that are surveyed again, beside the flight, and says how long it is."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Final

from hawk.algo.frame import outcome
from hawk.ddc.fence.geometry import to_map
from hawk.model.known_lot import KnownLot, LotAhead, LotsAhead, LotTour, PlanOffer
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import Fence, HeightParameters, RoundLot
from hawk.model.poses import GlobalPose
from hawk.runtime.process import WORKER_NICENESS, set_niceness

_MOVED_M: Final = 20.0
"""A drone that has moved so far since its flight was planned begins elsewhere."""


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Readings and limits that a flight over known lots depends on; each is asked for when it is needed.

    ``fence`` returns the fence on the map of a datum for a drone at a place: the one in force, else that of the next
    Arm; None where there is none.
    """

    asked: Callable[[], tuple[RoundLot, ...]]
    """Lots that are surveyed again; empty: none."""
    here: Callable[[], GlobalPose | None]
    camera: Callable[[], CameraModel | None]
    heights: Callable[[], HeightParameters]
    fence: Callable[[GlobalPose, GlobalPose], Fence | None]
    state: Callable[[], StateName]
    publish: Callable[[LotsAhead], object]
    is_flying: Callable[[], bool] = lambda: False
    """Returns True while the motors are on: the plans of the lots stay then."""
    taken: Callable[[], str] = lambda: ""
    """Id of the changed plan that who has control took last, else ""."""


@dataclass(frozen=True, slots=True)
class RoundPlace:
    """Place of the drone, ``here``, and the origin of its map, ``datum``."""

    datum: GlobalPose
    here: GlobalPose

    @property
    def start(self) -> tuple[float, float]:
        """The place on the map, metres (north, east)."""
        place = to_map(self.datum, self.here.latitude, self.here.longitude)
        return place.north, place.east


class TourKeeper:
    """`current` are the tours to fly, lot by lot; empty while none is surveyed again, and until they are planned."""

    def __init__(self, around: Surroundings) -> None:
        self._around = around
        self._thread = ThreadPoolExecutor(
            1, thread_name_prefix="hawk-tour", initializer=set_niceness, initargs=(WORKER_NICENESS,)
        )
        self._planned: tuple[object, ...] = ()
        self._start = (math.inf, math.inf)
        self._left: tuple[RoundLot, ...] = ()
        self._ahead: tuple[LotAhead, ...] = ()
        self._offer: PlanOffer | None = None
        self.current: tuple[LotTour, ...] = ()

    def close(self) -> None:
        """End the thread, without waiting for a tour under way."""
        self._thread.shutdown(wait=False, cancel_futures=True)

    @property
    def asked(self) -> tuple[str, ...]:
        """Ids of the lots that are surveyed again."""
        return tuple(lot.id for lot in self._around.asked())

    @property
    def here(self) -> GlobalPose | None:
        """Place of the drone; None while it is not known."""
        return self._around.here()

    @property
    def is_flying(self) -> bool:
        """True while the motors are on."""
        return self._around.is_flying()

    @property
    def taken(self) -> str:
        """Id of the changed plan that who has control took last, else ""."""
        return self._around.taken()

    def fail(self, problem: str) -> None:
        """Say that the store cannot be read. A tour that was planned stays."""
        self._publish(problem)

    async def follow(
        self,
        known: tuple[KnownLot, ...],
        datum: GlobalPose,
        ahead: tuple[LotAhead, ...],
        offer: PlanOffer | None = None,
    ) -> None:
        """Plan the tours where others are due. ``known`` are the plans of the lots, on the map of a datum; ``offer`` is
        a changed one, which is shown and not flown.
        """
        around, self._ahead, is_answered = self._around, ahead, offer != self._offer
        self._offer = offer
        if is_answered:
            self._publish()  # a tour takes seconds to plan
        asked, here, camera = around.asked(), around.here(), around.camera()
        plans = {lot.id: lot for lot in known}
        if not asked or any(lot.id not in plans for lot in asked):
            self._planned, self.current = (), ()
        elif here is not None and camera is not None:
            await self._plan(asked, plans, RoundPlace(datum, here), camera)
        self._publish()

    async def _plan(
        self, asked: tuple[RoundLot, ...], plans: Mapping[str, KnownLot], place: RoundPlace, camera: CameraModel
    ) -> None:
        """Plan the tours over the lots that are not over, over all when none is left. While it explores, those that it
        flies stay.
        """
        around, start, is_exploring = self._around, place.start, self._around.state() is StateName.AUTONOMOUS_EXPLORE
        left = tuple(lot for lot in asked if not lot.is_over)
        is_less, left = bool(left) and left != self._left, left or asked
        fence, heights = around.fence(place.datum, place.here), around.heights()
        due = (tuple(plans[lot.id] for lot in asked), fence, heights, camera)
        is_moved = math.dist(start, self._start) > _MOVED_M or is_less
        if due == self._planned and (is_exploring or not is_moved):
            return
        lots, first = tuple(plans[lot.id] for lot in left), frozenset(lot.id for lot in left if lot.is_first)
        loop = asyncio.get_running_loop()
        planned = loop.run_in_executor(self._thread, planned_tours, lots, first, camera, heights, fence, start)
        self.current = await planned
        self._planned, self._start, self._left = due, start, left

    def _publish(self, problem: str = "") -> None:
        length = round(sum(tour.distance_m for tour in self.current), 1) if self.current else None
        missed = sum(tour.missed for tour in self.current)
        self._around.publish(LotsAhead(self._ahead, problem, length, missed, self._offer))


def planned_tours(
    lots: tuple[KnownLot, ...],
    first: frozenset[str],
    camera: CameraModel,
    heights: HeightParameters,
    fence: Fence | None,
    start: tuple[float, float],
) -> tuple[LotTour, ...]:
    """Return the tours over lots, see `hawk.algo.path_plan.round_tour.round_tour`; it takes up to seconds for each."""
    from hawk.algo.path_plan.round_tour import RoundScene, round_tour  # its libraries are loaded off the loop

    return outcome(round_tour(lots, first, RoundScene(start, camera, heights, fence)))
