"""A drone with its store, a desk that collects, and the line between both."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Literal

from sqlalchemy import func, select

from hawk.config.sections import CollectSettings, StoreSettings
from hawk.lots.documents.lot_document import LotDue
from hawk.lots.storage.schema import DELIVERY, LOT, OUTBOX, SURVEY
from hawk.lots.storage.states import KINDS
from hawk.lots.store import LotStore
from hawk.store.recordings import Recordings
from hawk.webhooks.delivery import SenderTimes
from hawk.webhooks.documents import DocumentSender
from tests.unit.lots.documents.drones import Drone
from tests.unit.web.rig import Rig

ONE = "Drone 1"


@dataclass
class Line:
    """A drone with its store, a desk that collects, and the line between both."""

    drone: Drone
    store: LotStore
    centre: LotStore
    folder: Path
    url: str
    is_flown: bool = False
    said: list[tuple[str, str]] = field(default_factory=list)
    rig: Rig = field(default_factory=Rig)
    moments: list[datetime] = field(default_factory=list)
    """When surveys of Lot 1 are due at the desk."""

    def sender(
        self, url: str = "", kbit_s: int = 0, recordings: Literal["never", "asked"] = "never",
        take_due: Callable[[Sequence[LotDue]], object] = lambda _: None,
    ) -> DocumentSender:  # fmt: skip
        settings = CollectSettings(
            url=url or self.url, token_file=self.folder / "token", kbit_s=kbit_s, recordings=recordings
        )
        return DocumentSender(
            self.store, settings, time.time, lambda: self.is_flown,
            lambda level, text, details: self.said.append((text, details)), SenderTimes(look_s=0.01, try_s=20.0),
            take_due, Recordings(StoreSettings(directory=self.store.path.parent)),
        )  # fmt: skip

    async def waiting(self) -> int:
        """Return how many states the desk has not got."""
        sent = select(DELIVERY.c.message).where(DELIVERY.c.sent.is_not(None))
        asked = select(func.count()).select_from(OUTBOX).where(OUTBOX.c.kind.in_(KINDS), OUTBOX.c.seq.not_in(sent))
        return int(await self.store.read(lambda c: c.execute(asked).scalar_one()))

    async def is_received(self) -> None:
        """Wait until the desk has everything."""
        async with asyncio.timeout(15):
            while await self.waiting():  # noqa: ASYNC110 - another thread writes it
                await asyncio.sleep(0.01)

    async def names(self) -> list[str]:
        """Return the names of the drone's lots."""
        return list(await self.store.read(lambda c: c.execute(select(LOT.c.name)).scalars().all()))

    async def surveys(self) -> list[str]:
        found = await self.centre.read(lambda c: c.execute(select(SURVEY.c.id).order_by(SURVEY.c.seq)).scalars().all())
        return [str(each) for each in found]


@asynccontextmanager
async def running(sender: DocumentSender) -> AsyncIterator[None]:
    task = asyncio.create_task(sender.run())
    try:
        yield
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
