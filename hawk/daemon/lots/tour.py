"""Plans the flight over a lot that is surveyed again, beside the flight, and says how long it is."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Final

from hawk.algo.frame import outcome
from hawk.ddc.fence.geometry import to_map
from hawk.model.known_lot import KnownLot, LotAhead, LotsAhead, LotTour, PlanOffer
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import Fence, HeightParameters
from hawk.model.poses import GlobalPose
from hawk.runtime.process import WORKER_NICENESS, set_niceness

_MOVED_M: Final = 20.0
"""A drone that has moved so far since its flight was planned begins elsewhere."""


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Readings and limits that a flight over a lot depends on; each is asked for when it is needed.

    ``fence`` returns the fence on the map of a datum for a drone at a place: the one in force, else that of the next
    Arm; None where there is none.
    """

    asked: Callable[[], str]
    """Id of the lot that is surveyed again, else ""."""
    here: Callable[[], GlobalPose | None]
    camera: Callable[[], CameraModel | None]
    heights: Callable[[], HeightParameters]
    fence: Callable[[GlobalPose, GlobalPose], Fence | None]
    state: Callable[[], StateName]
    publish: Callable[[LotsAhead], object]
    is_flying: Callable[[], bool] = lambda: False
    """Returns True while the motors are on: the plan of the lot stays then."""
    taken: Callable[[], str] = lambda: ""
    """Id of the changed plan that who has control took last, else ""."""


class TourKeeper:
    """`current` is the tour to fly; None while no lot is surveyed again, and until it is planned."""

    def __init__(self, around: Surroundings) -> None:
        self._around = around
        self._thread = ThreadPoolExecutor(
            1, thread_name_prefix="hawk-tour", initializer=set_niceness, initargs=(WORKER_NICENESS,)
        )
        self._planned: tuple[object, ...] = ()
        self._start = (math.inf, math.inf)
        self._ahead: tuple[LotAhead, ...] = ()
        self._offer: PlanOffer | None = None
        self.current: LotTour | None = None

    def close(self) -> None:
        """End the thread, without waiting for a tour under way."""
        self._thread.shutdown(wait=False, cancel_futures=True)

    @property
    def asked(self) -> str:
        """Id of the lot that is surveyed again, else ""."""
        return self._around.asked()

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
        known: KnownLot | None,
        datum: GlobalPose,
        ahead: tuple[LotAhead, ...],
        offer: PlanOffer | None = None,
    ) -> None:
        """Plan the tour where another one is due. ``known`` is the plan of the lot, on the map of a datum; ``offer`` is
        a changed one, which is shown and not flown.
        """
        around, self._ahead, is_answered = self._around, ahead, offer != self._offer
        self._offer = offer
        if is_answered:
            self._publish()  # a tour takes seconds to plan
        if known is None or known.id != around.asked():
            self._planned, self.current = (), None
            self._publish()
            return
        here, camera = around.here(), around.camera()
        if here is None or camera is None:
            self._publish()
            return
        place = to_map(datum, here.latitude, here.longitude)
        start, fence, heights = (place.north, place.east), around.fence(datum, here), around.heights()
        due = (known, fence, heights, camera)
        is_moved = math.dist(start, self._start) > _MOVED_M and around.state() is not StateName.AUTONOMOUS_EXPLORE
        if due != self._planned or is_moved:
            loop = asyncio.get_running_loop()
            planned = loop.run_in_executor(self._thread, _planned_tour, known, camera, heights, fence, start)
            self.current = await planned
            self._planned, self._start = due, start
        self._publish()

    def _publish(self, problem: str = "") -> None:
        tour = self.current
        length, missed = (None, 0) if tour is None else (round(tour.distance_m, 1), tour.missed)
        self._around.publish(LotsAhead(self._ahead, problem, length, missed, self._offer))


def _planned_tour(
    known: KnownLot, camera: CameraModel, heights: HeightParameters, fence: Fence | None, start: tuple[float, float]
) -> LotTour:
    from hawk.algo.path_plan.known_tour import lot_tour  # its libraries are loaded off the loop

    return outcome(lot_tour(known, camera, heights, fence, start))
