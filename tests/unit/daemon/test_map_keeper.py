from __future__ import annotations

import asyncio
import logging
from collections.abc import Mapping
from dataclasses import dataclass, field

import pytest

from hawk.algo.mapper.delta import MapDelta
from hawk.daemon.map_keeper import MapKeeper


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


async def test_a_failure_is_reported_and_tried_again(caplog: pytest.LogCaptureFixture) -> None:
    kept = asyncio.Event()
    keeper = MapKeeper(Map(failing=True).changes_since, lambda _: kept.set(), interval_s=0.0)
    with caplog.at_level(logging.ERROR):
        task = asyncio.create_task(keeper.run())
        async with asyncio.timeout(5):
            await kept.wait()
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
    assert "could not be journalled" in caplog.text


async def test_another_map_is_kept_from_its_beginning_and_nothing_of_the_old_one_goes_into_its_journal() -> None:
    put: list[Mapping[str, bytes]] = []
    source, begun = Map(), asyncio.Event()
    keeper = MapKeeper(source.changes_since, put.append)

    async def begin() -> None:
        begun.set()
        for _ in range(3):
            await asyncio.sleep(0)  # a turn of `run` comes meanwhile
        assert len(put) == 1, "the old map's last changes, before the new journal"

    switching = asyncio.create_task(keeper.switch(begin))
    await begun.wait()
    meanwhile = asyncio.create_task(keeper.keep())
    await asyncio.gather(switching, meanwhile)
    assert source.asked == [0, 0], "all of the new map is asked for"


async def test_an_old_map_that_cannot_be_kept_does_not_hold_up_the_new_one(caplog: pytest.LogCaptureFixture) -> None:
    begun: list[bool] = []

    async def begin() -> None:
        begun.append(True)

    await MapKeeper(Map(failing=True).changes_since, lambda _: None).switch(begin)
    assert begun == [True]
    assert "not journalled" in caplog.text
