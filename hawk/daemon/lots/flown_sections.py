"""Counts the sections of the lot that is flown over, beside the flight, for its heartbeats."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from hawk.lots.store import LotStore
from hawk.lots.values import LotStoreError
from hawk.model.known_lot import FlownSection
from hawk.model.lot_map import OccupancyMap
from hawk.model.poses import GlobalPose
from hawk.runtime.late import late

if TYPE_CHECKING:  # loaded on the store's thread
    from hawk.lots import flown_sections as queries
    from hawk.lots.plan import versions
else:
    queries, versions = late("hawk.lots.flown_sections"), late("hawk.lots.plan.versions")

_LOG = logging.getLogger(__name__)

COUNT_S: Final = 2.0
"""Real seconds between two counts."""


class SectionCounter:
    """`current` are the sections as they are counted so far; none where the lot has none or is not known."""

    def __init__(
        self,
        store: LotStore,
        lot: Callable[[], str],
        datum: Callable[[], GlobalPose | None],
        occupancy: Callable[[], OccupancyMap | None],
        count_s: float = COUNT_S,
    ) -> None:
        """Take the parts; nothing runs before `run`.

        Args:
            store: The lots' store; nothing is read before somebody has opened it.
            lot: Returns the id of the lot that is flown over, "" where none is known.
            datum: Returns the origin of the map; None before there is one.
            occupancy: Returns the map; None before there is one.
            count_s: Real seconds between two counts.
        """
        self._store = store
        self._lot = lot
        self._datum = datum
        self._occupancy = occupancy
        self._count_s = count_s
        self._counted: tuple[object, ...] = ()
        self.current: tuple[FlownSection, ...] = ()

    async def run(self) -> None:
        """Count until cancelled."""
        while True:
            await self.count()
            await asyncio.sleep(self._count_s)

    async def count(self) -> None:
        """Count again where the lot, its plan or the map changed. A store that cannot be read leaves the counts."""
        lot, datum = self._lot(), self._datum()
        if not lot or datum is None or not self._store.is_open:
            self.current, self._counted = (), ()
            return
        place, now = (datum.latitude, datum.longitude), self._occupancy() or OccupancyMap()
        try:
            revision = await self._store.read(lambda connection: versions.revision_of(connection, lot))
            asked = (lot, revision, place, now.map_id, now.version)
            if asked == self._counted:
                return
            found = await self._store.read(lambda connection: queries.flown_sections(connection, lot, place, now))
        except LotStoreError as error:
            _LOG.warning("the sections of the lot cannot be counted: %s", error)
            return
        self._counted = asked
        if found != self.current:
            self.current = found
