"""All lots in one answer are those of the list of lots, after each day of their life."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import Connection, select

from hawk.exports.lot_places import lot_places
from hawk.lots import lists
from hawk.lots.storage.schema import LOT
from hawk.lots.survey import last_surveys
from hawk.lots.values import utc
from tests.unit.lots.documents.drones import Drone, days
from tests.unit.lots.surveys import later, survey


@pytest.fixture
def drone(tmp_path: Path) -> Iterator[Drone]:
    made = Drone.at(tmp_path / "lots.db")
    yield made
    made.store.close()


def listed(connection: Connection) -> list[tuple[object, ...]]:
    """Return what the list of lots says, as the answer's values of each lot have it."""
    found: list[tuple[object, ...]] = []
    for lot in lists.lots(connection, lists.Asked()).items:
        last = lot.last_survey
        counts = (None,) * 6
        if last is not None:
            ended = utc(last.ended.timestamp())
            counts = (last.id, ended, last.free, last.taken, last.unknown, last.drone)  # type: ignore[assignment]
        found.append((lot.id, lot.name, lot.time_zone, lot.stalls, lot.survey_count, lot.due, *counts))
    return found


def shown(connection: Connection) -> list[tuple[object, ...]]:
    values = dict(lot_places(connection))
    rows = select(LOT.c.latitude, LOT.c.longitude).where(LOT.c.merged_into.is_(None)).order_by(LOT.c.made, LOT.c.id)
    places = [(round(north, 6), round(east, 6)) for north, east in connection.execute(rows)]
    assert [*zip(values.pop("latitudes"), values.pop("longitudes"), strict=True)] == places
    return list(zip(*values.values(), strict=True))


@pytest.mark.nightly
def test_they_are_those_of_the_list_after_each_change_of_a_survey_or_a_plan(drone: Drone) -> None:
    states = []
    for _ in days(drone):
        with drone.store.reading() as connection:
            states.append(shown(connection))
            assert states[-1] == listed(connection)
    assert len({str(each) for each in states}) > 8
    assert {len(each) for each in states} >= {1, 2}


def test_nothing_is_counted_for_them_where_the_store_has_kept_it(drone: Drone, monkeypatch: pytest.MonkeyPatch) -> None:
    lot = drone.add(survey()).lot
    assert lot is not None
    for change in (lambda: drone.add(later(survey(seed=2), 2)), lambda: drone.edit(lot, {"do": "remove", "row": "A"})):
        change()
        with drone.store.reading() as connection, monkeypatch.context() as patched:
            patched.setattr(last_surveys, "made", lambda *_: pytest.fail("it is counted"))
            assert shown(connection) == listed(connection)


def test_a_damaged_survey_is_passed_over_as_in_the_list(drone: Drone) -> None:
    drone.add(survey())
    drone.do(lambda connection: connection.exec_driver_sql("UPDATE survey SET ended = 1e300"))
    with drone.store.reading() as connection:
        ((*_, survey_id, ended, free, _, _, _),) = shown(connection)
        assert (survey_id, ended, free) == (None, None, None)
        assert shown(connection) == listed(connection)
