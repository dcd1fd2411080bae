"""Follows the plan of the lot at which the drone stands, for the map of its flight. The flight waits for none of it."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from hawk.daemon.lot_tour import TourKeeper
from hawk.lots.store import LotStore
from hawk.lots.values import LotStoreError
from hawk.model.known_lot import KnownLot, LotAhead
from hawk.model.operation import Level
from hawk.model.poses import GlobalPose
from hawk.model.sentences import say

if TYPE_CHECKING:  # loaded on the store's thread
    from sqlalchemy import Connection

_LOG = logging.getLogger(__name__)

LOOK_S: Final = 2.0
"""Real seconds between two looks for a changed plan: a person may correct it in flight."""


_Read = tuple[tuple[object, ...] | None, str, KnownLot | None, tuple[LotAhead, ...]]


class KnownLotFollower:
    """`current` is the plan to fly with."""

    def __init__(
        self,
        store: LotStore,
        datum: Callable[[], GlobalPose | None],
        survey: Callable[[], str],
        add_message: Callable[[Level, str, str], object],
        look_s: float = LOOK_S,
        tours: TourKeeper | None = None,
    ) -> None:
        """Take the parts; nothing runs before `run`.

        Args:
            store: The lots' store; nothing is read before somebody has opened it.
            datum: Returns the origin of the map, where the drone was armed; None before.
            survey: Returns the name of the survey under way: it is no witness of itself.
            add_message: Adds a message for the operator: level, text, details.
            look_s: Real seconds between two looks.
            tours: Plans the flight over a lot that is surveyed again; None: no lot is.
        """
        self._store = store
        self._datum = datum
        self._survey = survey
        self._add_message = add_message
        self._look_s = look_s
        self._tours = tours
        self._known: tuple[object, ...] | None = None
        self._named = ""
        self.current: KnownLot | None = None

    async def run(self) -> None:
        """Follow the plan until cancelled."""
        while True:
            await self.look()
            await asyncio.sleep(self._look_s)

    async def look(self) -> None:
        """Read the plan of the lot at the map's origin where it is another one than before."""
        asked = "" if self._tours is None else self._tours.asked
        datum = self._datum() or (None if self._tours is None else self._tours.here)
        if datum is None or not (self._store.is_open or asked):
            return
        place, survey, before = (datum.latitude, datum.longitude), self._survey(), self._known

        def read(connection: Connection) -> _Read:
            from hawk.lots.known import known_lot, lot_near, lots_ahead

            ahead = () if self._tours is None else lots_ahead(connection, place)
            near = lot_near(connection, place, asked)
            if near is None:
                return None, "", None, ahead
            stamp, name = near
            if (stamp, place, survey) == before:
                return before, name, self.current, ahead
            lot = known_lot(connection, stamp[0], place, survey)
            return (stamp, place, survey), name, lot if lot.stalls else None, ahead

        try:
            self._known, name, self.current, ahead = await self._store.read(read)
        except LotStoreError as error:
            _LOG.warning("the plan of the lot cannot be read: %s", error)
            if self._tours is not None:
                self._tours.fail(str(error))
            return
        if self._tours is not None:
            await self._tours.follow(self.current, datum, ahead)
        if self.current is not None and self.current.id != self._named:
            self._named = self.current.id
            self._report(name, self.current)

    def _report(self, name: str, lot: KnownLot) -> None:
        confirmed = sum(stall.is_confirmed for stall in lot.stalls)
        count = say("{confirmed} of {stalls} stalls are confirmed.", confirmed=confirmed, stalls=len(lot.stalls))
        self._add_message("info", say("This is {name}: its plan is known.", name=name), count)
