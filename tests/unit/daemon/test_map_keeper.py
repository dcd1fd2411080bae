from __future__ import annotations

import asyncio
import logging
from collections.abc import Mapping
from dataclasses import dataclass, field

import pytest

from hawk.algo.mapper.delta import MapDelta
from hawk.map_keeper import MapKeeper


@dataclass
class Map:
    asked: list[int] = field(default_factory=list)
    failing: bool = False

    async def changes_since(self, version: int) -> MapDelta:
        self.asked.append(version)
        if self.failing:
            self.failing = False
            raise OSError("worker gone")
        return MapDelta(7, {"stalls": b"x"} if version < 7 else {})


async def test_only_what_changed_is_put() -> None:
    put: list[Mapping[str, bytes]] = []
    source = Map()
    keeper = MapKeeper(source.changes_since, put.append)
    await keeper.keep()
    await keeper.keep()
    assert source.asked == [0, 7]
    assert put == [{"stalls": b"x"}]


async def test_a_failure_is_told_and_tried_again(caplog: pytest.LogCaptureFixture) -> None:
    kept = asyncio.Event()
    keeper = MapKeeper(Map(failing=True).changes_since, lambda _: kept.set(), interval_s=0.0)
    with caplog.at_level(logging.ERROR):
        task = asyncio.create_task(keeper.run())
        await asyncio.wait_for(kept.wait(), 5)
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
    assert "could not be journalled" in caplog.text
