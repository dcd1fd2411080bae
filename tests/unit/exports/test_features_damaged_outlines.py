"""Outlines that the disk, or another program, has damaged: every front door answers, without that ground."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

import pytest
from sqlalchemy import Connection, select

from hawk.exports import features
from hawk.exports.features import Box, Choice
from hawk.exports.feeds import feed_text
from hawk.exports.files import TABLES
from hawk.exports.formats import FEEDS, Wanted
from hawk.exports.records import read_survey
from hawk.lots import commands, known_lot, lists, queries
from hawk.lots.lists import Asked
from hawk.lots.storage.schema import LOT, SURVEY
from hawk.lots.training_set import read_lesson
from hawk.lots.values import LotStoreError
from hawk.stats.period import period_of
from hawk.stats.queries import stalls_use, statistics, surveys_use
from tests.examples import nightly
from tests.unit.exports.stored import Stored
from tests.unit.lots.repaints import NOW
from tests.unit.lots.surveys import BEGAN

CUT = '{"polygons": 3'
WRONG = {
    "cut": CUT,
    "a number": "7",
    "no rings": '{"polygons": 3, "holes": []}',
    "a ring of two corners": '{"polygons": [[[52.0, 5.0], [52.0, 5.1]]], "holes": []}',
    "a corner of one number": '{"polygons": [[[52.0], [52.0, 5.0]]], "holes": []}',
    "a corner of text": '{"polygons": [[["52", "5"]]], "holes": []}',
    "a corner that is no number": '{"polygons": [[[NaN, 5.0], [52.0, 5.0], [52.0, 5.1]]], "holes": []}',
    "a corner beyond the Earth": '{"polygons": [[[1e300, 5.0], [52.0, 5.0], [52.0, 5.1]]], "holes": []}',
}
OUTLINED = ("lot", "survey", "zone")
AROUND, PERIOD = Box(4.9, 51.9, 5.1, 52.1), period_of(None, None, "UTC")
Door = Callable[[Connection, Stored], object]
DOORS: dict[str, Door] = {
    "listed lots": lambda c, stored: lists.lots(c, Asked()),
    "listed lot": lambda c, stored: lists.lot(c, stored.lot),
    "listed zones": lambda c, stored: lists.zones(c, stored.lot, Asked()),
    "listed stalls": lambda c, stored: lists.stalls(c, stored.lot, Asked()),
    "listed surveys": lambda c, stored: lists.surveys(c, Asked()),
    "listed observations": lambda c, stored: lists.observations(c, Asked(), lot_id=stored.lot),
    "plan": lambda c, stored: queries.plan(c, stored.lot),
    "proposals": lambda c, stored: queries.proposed(c, stored.lot),
    "extent": lambda c, stored: features.extent(c),
    "features of lots": lambda c, stored: features.lots(c, Choice()),
    "features of lots in a box": lambda c, stored: features.lots(c, Choice(box=AROUND)),
    "features of surveys": lambda c, stored: features.surveys(c, Choice()),
    "features of surveys in a box": lambda c, stored: features.surveys(c, Choice(box=AROUND)),
    "features of stalls": lambda c, stored: features.stalls(c, Choice()),
    "features of stalls in a box": lambda c, stored: features.stalls(c, Choice(box=AROUND)),
    "files": lambda c, stored: [make(read_survey(c, stored.first.survey)) for make in TABLES.values()],
    "feeds": lambda c, stored: [feed_text(c, name, Wanted(stored.lot), BEGAN) for name in FEEDS],
    "figures": lambda c, stored: statistics(c, stored.lot, PERIOD, "zone"),
    "surveys with figures": lambda c, stored: surveys_use(c, stored.lot, PERIOD).model_dump(mode="json"),
    "stalls with figures": lambda c, stored: stalls_use(c, stored.lot, PERIOD),
    "the lot about a drone": lambda c, stored: [
        known_lot.lots_flown(c, (52.0, 5.0)),
        known_lot.lots_ahead(c, (52.0, 5.0)),
    ],
    "the lot for a flight": lambda c, stored: known_lot.known_lot(c, stored.lot, (52.0, 5.0)),
    "pictures with labels": lambda c, stored: read_lesson(c, stored.lot),
}


@pytest.fixture
def zoned(stored: Stored) -> Stored:
    """Return a store whose stalls are confirmed, with a zone that has a name and an area without stalls."""
    stored.edit(
        {"do": "confirm", "all": True},
        {"do": "draw_zone", "name": "Front", "outline": [[-1, -1], [-1, 9], [1, 9]]},
        {"do": "forbid", "outline": [[60, 60], [60, 70], [70, 70]]},
    )
    return stored


def damage(stored: Stored, table: str, column: str, value: object) -> None:
    """Write over a column of every row; its digests are made again, as by a program with a fault."""
    with stored.store.writing() as connection:
        connection.exec_driver_sql(f"UPDATE {table} SET {column} = ?", (value,))  # noqa: S608 - our own words


def answers(stored: Stored) -> dict[str, object]:
    """Return which doors do not answer, and how."""
    failed: dict[str, object] = {}
    for name, door in DOORS.items():
        with stored.store.reading() as connection:
            try:
                door(connection, stored)
            except Exception as error:
                failed[name] = error
    return failed


@pytest.mark.slow
@pytest.mark.fault(
    "an outline of a lot, survey or zone in the store of lots is damaged",
    "its ground is passed over, and the log says it; every list, file and figure is given; no change writes over it",
)
@pytest.mark.parametrize(
    ("tables", "wrong"),
    [
        *(((table,), ("cut",)) for table in OUTLINED),
        (OUTLINED, tuple(WRONG)),
        *nightly(*(((table,), tuple(WRONG)) for table in OUTLINED)),
    ],
)
def test_every_front_door_answers_over_a_damaged_outline(
    zoned: Stored, tables: tuple[str, ...], wrong: tuple[str, ...], caplog: pytest.LogCaptureFixture
) -> None:
    assert answers(zoned) == {}
    for name in wrong:
        caplog.clear()
        for table in tables:
            damage(zoned, table, "outline", WRONG[name])
        assert answers(zoned) == {}, name
        assert "an outline in the store of lots is damaged" in caplog.text, name


@pytest.mark.nightly
@pytest.mark.parametrize("data", [b"no zlib", zlib.compress(CUT.encode()), zlib.compress(b"\xff")])
def test_every_front_door_answers_over_damaged_ground_of_a_survey(zoned: Stored, data: bytes) -> None:
    damage(zoned, "survey", "seen_ground", data)
    assert answers(zoned) == {}


@pytest.mark.slow
def test_the_other_features_are_given_beside_a_damaged_one(zoned: Stored) -> None:
    damage(zoned, "lot", "outline", CUT)
    with zoned.store.reading() as connection:
        (lot,) = features.lots(connection, Choice()).features
        stalls = features.stalls(connection, Choice(limit=1000, box=AROUND))
    assert lot.geometry is None
    assert (stalls.matched, len(stalls.features)) == (60, 60)


@pytest.mark.slow
@pytest.mark.parametrize("change", ["merge", "split", "pin"])
def test_a_change_that_would_write_over_a_damaged_outline_is_refused(zoned: Stored, change: str) -> None:
    with zoned.store.reading() as connection:
        outline = json.loads(connection.execute(select(LOT.c.outline)).scalar_one())["polygons"][0]
        survey = connection.execute(select(SURVEY.c.id)).scalar_one()
    with zoned.store.writing() as connection:
        other = commands.move(connection, survey, {"lot": None}, "operator", NOW, None).lot
    damage(zoned, "lot", "outline", CUT)
    points = [{"from": [52.0, 5.0], "to": [52.00002, 5.0]}]
    acts: dict[str, Callable[[Connection], Any]] = {
        "merge": lambda c: commands.merge(c, zoned.lot, other, "operator", NOW),
        "split": lambda c: commands.split(c, zoned.lot, {"name": "A", "outline": outline[:3]}, "operator", NOW),
        "pin": lambda c: commands.pin(c, zoned.lot, {"points": points}, "operator", NOW),
    }
    with pytest.raises(LotStoreError, match="its outline is damaged"), zoned.store.writing() as connection:
        acts[change](connection)
    with zoned.store.reading() as connection:
        assert {*connection.execute(select(LOT.c.outline)).scalars()} == {CUT}


@pytest.mark.slow
@pytest.mark.fault(
    "a value in the store of lots that cannot be: a probability of 1.5, a state or a kind of no name",
    "its item is passed over, and the log says it; the list goes on; by its id it is refused in words",
)
@pytest.mark.parametrize(
    ("table", "column", "value"),
    [
        ("observation", "taken_probability", 1.5),
        ("observation", "state", "gone"),
        ("stall", "kind", "no kind"),
        ("survey", "placed", "?"),
    ],
)
def test_every_list_goes_on_beside_a_value_that_cannot_be(
    zoned: Stored, table: str, column: str, value: object, caplog: pytest.LogCaptureFixture
) -> None:
    damage(zoned, table, column, value)
    assert [each for each in answers(zoned).values() if not isinstance(each, LotStoreError)] == []
    assert "a row in the store of lots is damaged" in caplog.text
    with zoned.store.reading() as connection, pytest.raises(LotStoreError) if table == "survey" else nullcontext():
        lists.survey(connection, zoned.first.survey)
