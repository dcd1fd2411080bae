"""The counter of sections: what it reads when, and what stays while the store cannot be read."""

from __future__ import annotations

import asyncio
import contextlib
from dataclasses import replace
from pathlib import Path

import pytest

from hawk.daemon.lots.flown_sections import SectionCounter
from hawk.lots.plan import edits
from hawk.lots.store import LotStore
from hawk.model.lot_map import OccupancyMap
from hawk.model.poses import GlobalPose
from tests.unit.comm.waiting import until
from tests.unit.lots.sections.test_flown_sections import KERB, flown, make_lot
from tests.unit.lots.surveys import BEGAN, DATUM


class Flight:
    def __init__(self, path: Path) -> None:
        self.store = LotStore(path)
        self.lot = ""
        self.datum: GlobalPose | None = DATUM
        self.map: OccupancyMap | None = flown()
        self.counter = SectionCounter(
            self.store, lambda: (self.lot,) if self.lot else (), lambda: self.datum, lambda: self.map, count_s=0.01
        )  # fmt: skip

    async def draw(self, name: str) -> None:
        if not self.lot:
            self.lot = await self.store.write(make_lot)
            self.edit = (await self.store.write(lambda c: edits.open_edit(c, self.lot, {"who": "Ann"}, BEGAN))).edit
        shift = {"line": [[north, east + 0.1 * len(name)] for north, east in KERB["line"]]}
        asked = {"edit": self.edit, "operation": {"do": "draw_section", "name": name, **KERB, **shift}}
        await self.store.write(lambda c: edits.do(c, self.lot, asked, BEGAN))

    @property
    def counts(self) -> list[tuple[str, int | None]]:
        return [(each.name, None if each.count is None else each.count.parked) for each in self.counter.current]


@pytest.fixture
async def flight(tmp_path: Path):  # type: ignore[no-untyped-def]
    made = Flight(tmp_path / "lots.db")
    yield made
    await made.store.close()


async def test_nothing_is_read_before_the_store_is_open_and_a_lot_and_a_map_are_known(flight: Flight) -> None:
    flight.lot = "another"
    await flight.counter.count()
    assert not flight.store.is_open
    flight.lot = ""
    await flight.draw("Elm")
    flight.datum = None
    await flight.counter.count()
    assert flight.counts == []


async def test_a_changed_map_and_a_changed_plan_are_counted_again_and_nothing_else(flight: Flight) -> None:
    await flight.draw("Elm")
    await flight.counter.count()
    assert flight.counts == [("Elm", 2)]
    before = flight.counter.current
    flight.map = replace(flown((4.5,)))  # of the same version: nothing is looked at
    await flight.counter.count()
    assert flight.counter.current is before
    flight.map = replace(flown((4.5,)), version=4)
    await flight.counter.count()
    assert flight.counts == [("Elm", 1)]
    await flight.draw("Oak")
    await flight.counter.count()
    assert flight.counts == [("Elm", 1), ("Oak", 1)]


async def test_a_store_that_cannot_be_read_leaves_the_counts(flight: Flight, caplog: pytest.LogCaptureFixture) -> None:
    await flight.draw("Elm")
    await flight.counter.count()
    await flight.store.write(lambda c: c.exec_driver_sql("ALTER TABLE section RENAME TO another").close())
    flight.map = replace(flown((4.5,)), version=4)
    await flight.counter.count()
    assert flight.counts == [("Elm", 2)]
    assert "cannot be counted" in caplog.text


async def test_the_counts_end_with_the_lot(flight: Flight) -> None:
    await flight.draw("Elm")
    task = asyncio.create_task(flight.counter.run())
    await until(lambda: flight.counts == [("Elm", 2)])
    flight.lot = ""
    await until(lambda: flight.counts == [])
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task
