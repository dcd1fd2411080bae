"""Counts the sections of the lots that are flown over, beside the flight, for its heartbeats."""

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
    from sqlalchemy import Connection

    from hawk.lots.plan import versions
    from hawk.lots.sections import flown_sections as queries
else:
    queries, versions = late("hawk.lots.sections.flown_sections"), late("hawk.lots.plan.versions")

_LOG = logging.getLogger(__name__)

COUNT_S: Final = 2.0
"""Real seconds between two counts."""


class SectionCounter:
    """`current` are the sections as they are counted so far; none where no lot has any or is known."""

    def __init__(
        self,
        store: LotStore,
        lots: Callable[[], tuple[str, ...]],
        datum: Callable[[], GlobalPose | None],
        occupancy: Callable[[], OccupancyMap | None],
        count_s: float = COUNT_S,
    ) -> None:
        """Take the parts; nothing runs before `run`.

        Args:
            store: The lots' store; nothing is read before somebody has opened it.
            lots: Returns the ids of the lots that are flown over.
            datum: Returns the origin of the map; None before there is one.
            occupancy: Returns the map; None before there is one.
            count_s: Real seconds between two counts.
        """
        self._store = store
        self._lots = lots
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
        """Count again where lots, their plans or the map changed. A store that cannot be read leaves the counts."""
        lots, datum = self._lots(), self._datum()
        if not lots or datum is None or not self._store.is_open:
            self.current, self._counted = (), ()
            return
        place, now = (datum.latitude, datum.longitude), self._occupancy() or OccupancyMap()

        def count(connection: Connection) -> tuple[FlownSection, ...]:
            return tuple(one for lot in lots for one in queries.flown_sections(connection, lot, place, now))

        try:
            revisions = await self._store.read(
                lambda connection: [versions.revision_of(connection, lot) for lot in lots]
            )
            asked = (lots, revisions, place, now.map_id, now.version)
            if asked == self._counted:
                return
            found = await self._store.read(count)
        except LotStoreError as error:
            _LOG.warning("the sections of the lots cannot be counted: %s", error)
            return
        self._counted = asked
        if found != self.current:
            self.current = found
