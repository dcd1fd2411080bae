"""Carries what must outlive the process from the algorithms to the flight journal."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping
from typing import Protocol

_LOG = logging.getLogger(__name__)

INTERVAL_S = 0.3
"""Real seconds between two looks at what changed: with the journal's own quarter of a second less than one is lost."""


class Delta(Protocol):
    """What changed in the map: ``parts`` by key, up to ``version``."""

    @property
    def parts(self) -> Mapping[str, bytes]:
        """Changed parts; empty bytes for one that is no more."""
        ...

    @property
    def version(self) -> int:
        """The map's version with these changes."""
        ...


class MapKeeper:
    """Asks for the map's changes at an interval and puts them into the journal, until it is cancelled."""

    def __init__(
        self,
        changes_since: Callable[[int], Awaitable[Delta]],
        put: Callable[[Mapping[str, bytes]], None],
        interval_s: float = INTERVAL_S,
    ) -> None:
        self._changes_since = changes_since
        self._put = put
        self._interval = interval_s
        self._version = 0

    def forget(self) -> None:
        """The journal is another one: put everything again."""
        self._version = 0

    async def run(self) -> None:
        """Keep the map for ever; one failure is told and tried again."""
        while True:
            await asyncio.sleep(self._interval)
            try:
                await self.keep()
            except Exception:
                _LOG.exception("the map could not be journalled")

    async def keep(self) -> None:
        """Put what changed since the last time."""
        delta = await self._changes_since(self._version)
        if delta.parts:
            self._put(delta.parts)
        self._version = delta.version
