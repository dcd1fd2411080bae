"""The bulk writer's rows are those that the product's writer stores one by one, table by table."""

from __future__ import annotations

import json
import re
import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.archive import BIAS, DATUM, drawn_lot, flight
from benchmarks.many_lots_store import FLOWN_OFTEN, fill, place_of
from hawk.daemon.lots.keeper import find_stalls
from hawk.lots.ingest import save
from hawk.lots.registration.frames import Move
from hawk.lots.registration.georeference import about, ring_on_earth
from hawk.lots.storage.database import Database
from hawk.lots.storage.outlines import unpack_outline
from hawk.lots.storage.schema import METADATA
from hawk.lots.survey.observations import looks_of
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose

LOTS, SURVEYS, SIZE = 3, 3, 30
_ID = re.compile(r"[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}")
_MICRODEGREES = 7


def _one_by_one(path: Path) -> None:
    rng = np.random.default_rng(1)
    stalls = drawn_lot(SIZE, rng)
    datum = DATUM.latitude, DATUM.longitude
    with closing(Database(path, {"synchronous": 0})) as store:
        for number in range(SURVEYS):
            flown = flight(number + 1, stalls, BIAS if number else Move(), rng)
            for lot in range(LOTS):
                place = place_of(datum, lot)

                def there(outline: Outline, place: tuple[float, float] = place) -> Outline:
                    rings = (ring_on_earth(place, about(datum, np.array(ring))[:, :2]) for ring in outline.polygons)
                    return Outline(tuple(rings))

                moved = replace(
                    flown, name=f"{flown.name} {lot}", datum=GlobalPose(*place, 0.0), outline=there(flown.outline),
                    seen_ground=there(flown.seen_ground),
                )  # fmt: skip
                with store.writing() as connection:
                    save(connection, moved, find_stalls)


def _rows(path: Path, table: str) -> list[tuple[Any, ...]]:
    """Return the rows of a table; ids are numbers in the order of surveys, lots and stalls."""
    with closing(sqlite3.connect(path)) as store:
        named = [str(each) for (each,) in store.execute("SELECT lot FROM survey ORDER BY seq")]
        named += [str(each) for (each,) in store.execute("SELECT id FROM survey ORDER BY seq")]
        named += [str(each) for (each,) in store.execute("SELECT id FROM stall ORDER BY key")]
        numbers = {each: f"<{number}>" for number, each in enumerate(dict.fromkeys(named))}
        columns = [each.name for each in METADATA.tables[table].columns if (table, each.name) not in _LEFT_OUT]
        found = store.execute(f"SELECT {', '.join(columns)} FROM {table}")  # noqa: S608 - our own words
        return sorted((tuple(_alike(each, numbers) for each in row) for row in found), key=repr)


_LEFT_OUT = {("outbox", "seq"), ("outbox", "made"), ("survey", "origin"), ("digest", "digest"), ("lot", "name")}


def _alike(value: object, numbers: dict[str, str]) -> object:
    if isinstance(value, str):
        value = _ID.sub(lambda found: numbers[found[0]], value)
        return _rounded(json.loads(value)) if value.startswith('{"polygons"') else value
    if isinstance(value, float):
        return round(value, _MICRODEGREES)
    is_ground = isinstance(value, bytes) and (ground := unpack_outline(value)).polygons
    return _rounded(ground.polygons) if is_ground else value


def _rounded(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    return [_rounded(each) for each in value] if isinstance(value, list | tuple) else round(value, 6)


@pytest.fixture(scope="module")
def stores(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("stores")
    each, bulk = folder / "each.db", folder / "bulk.db"
    _one_by_one(each)
    fill(bulk, LOTS, SURVEYS, SIZE)
    return each, bulk


@pytest.mark.parametrize("table", sorted(METADATA.tables))
def test_a_table_written_in_bulk_is_that_of_surveys_stored_one_by_one(stores: tuple[Path, Path], table: str) -> None:
    each, bulk = (_rows(path, table) for path in stores)
    assert bulk == each
    filled = ("lot", "layout", "plan", "survey", "stall", "observation", "looks", "outbox", "digest", "last_survey")
    assert bool(bulk) == (table in filled)


def test_every_digest_of_a_store_written_in_bulk_is_right(stores: tuple[Path, Path], tmp_path: Path) -> None:
    often = tmp_path / "often.db"
    fill(often, 2, FLOWN_OFTEN, 40)
    for path in (stores[1], often):
        with closing(Database(path)) as store:
            assert store.damage == ""
            with store.reading() as connection:
                looks = looks_of(connection, [2, 3])
                assert set(looks.stall[looks.line == 0]).isdisjoint(looks.stall[looks.line == 1])
