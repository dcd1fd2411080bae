"""Follows the plan of the lot at which the drone stands, for the map of its flight. The flight waits for none of it."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from hawk.lots.store import LotStore
from hawk.lots.values import LotStoreError
from hawk.model.known_lot import KnownLot
from hawk.model.operation import Level
from hawk.model.poses import GlobalPose
from hawk.model.sentences import say

if TYPE_CHECKING:  # loaded on the store's thread
    from sqlalchemy import Connection

_LOG = logging.getLogger(__name__)

LOOK_S: Final = 2.0
"""Real seconds between two looks for a changed plan: a person may correct it in flight."""


class KnownLotFollower:
    """`current` is the plan to fly with."""

    def __init__(
        self,
        store: LotStore,
        datum: Callable[[], GlobalPose | None],
        survey: Callable[[], str],
        add_message: Callable[[Level, str, str], object],
        look_s: float = LOOK_S,
    ) -> None:
        """Take the parts; nothing runs before `run`.

        Args:
            store: The lots' store; nothing is read before somebody has opened it.
            datum: Returns the origin of the map, where the drone was armed; None before.
            survey: Returns the name of the survey under way: it is no witness of itself.
            add_message: Adds a message for the operator: level, text, details.
            look_s: Real seconds between two looks.
        """
        self._store = store
        self._datum = datum
        self._survey = survey
        self._add_message = add_message
        self._look_s = look_s
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
        datum = self._datum()
        if datum is None or not self._store.is_open:
            return
        place, survey, before = (datum.latitude, datum.longitude), self._survey(), self._known

        def read(connection: Connection) -> tuple[tuple[object, ...] | None, str, KnownLot | None]:
            from hawk.lots.known import known_lot, lot_near

            near = lot_near(connection, place)
            if near is None:
                return None, "", None
            stamp, name = near
            if (stamp, place, survey) == before:
                return before, name, self.current
            lot = known_lot(connection, stamp[0], place, survey)
            return (stamp, place, survey), name, lot if lot.stalls else None

        try:
            self._known, name, self.current = await self._store.read(read)
        except LotStoreError as error:
            _LOG.warning("the plan of the lot cannot be read: %s", error)
            return
        if self.current is not None and self.current.id != self._named:
            self._named = self.current.id
            self._report(name, self.current)

    def _report(self, name: str, lot: KnownLot) -> None:
        confirmed = sum(stall.is_confirmed for stall in lot.stalls)
        count = say("{confirmed} of {stalls} stalls are confirmed.", confirmed=confirmed, stalls=len(lot.stalls))
        self._add_message("info", say("This is {name}: its plan is known.", name=name), count)
