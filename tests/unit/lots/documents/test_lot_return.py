from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import func, select, update

from hawk.lots import commands
from hawk.lots.documents import source
from hawk.lots.documents.lot_document import plan_digest
from hawk.lots.plan import edits
from hawk.lots.plan.queries import all_stalls
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import CHANGE, LOT, OBSERVATION, STALL, SURVEY
from tests.unit.lots.documents.drones import NOW, WHO, Drone
from tests.unit.lots.documents.exchange import ask, documents_to_send, meet, send, take
from tests.unit.lots.surveys import box, later, survey

OTHER = "Drone 2"


@pytest.fixture
def drone(tmp_path: Path) -> Iterator[Drone]:
    made = Drone.at(tmp_path / "drone.db")
    yield made
    made.store.close()


@pytest.fixture
def other(tmp_path: Path) -> Iterator[Drone]:
    made = Drone.at(tmp_path / "other.db")
    yield made
    made.store.close()


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Drone]:
    """The desk's store: a person there does what a drone's operator does."""
    made = Drone.at(tmp_path / "desk.db")
    made.now = NOW + 60
    yield made
    made.store.close()


def plan(store: Database, lot: str) -> str:
    with store.reading() as connection:
        return plan_digest(source.lot_part(connection, lot))


def labels(store: Database, lot: str) -> list[str]:
    with store.reading() as connection:
        return sorted(stall.label for stall in all_stalls(connection, lot))


def looks(store: Database) -> list[Any]:
    asked = select(SURVEY.c.id, STALL.c.id, OBSERVATION.c.taken_probability)
    joined = asked.join(OBSERVATION, OBSERVATION.c.survey == SURVEY.c.seq)
    with store.reading() as connection:
        return sorted(map(tuple, connection.execute(joined.join(STALL, STALL.c.key == OBSERVATION.c.stall))))


def lot_of(drone: Drone) -> str:
    saved = drone.add(survey())
    assert saved.lot is not None
    return saved.lot


def test_a_plan_corrected_at_the_desk_comes_to_the_drone_and_its_looks_stay(drone: Drone, desk: Drone) -> None:
    lot = lot_of(drone)
    drone.add(later(survey(seed=2), 2))
    assert meet(drone, desk.store) == []
    before = looks(drone.store)
    desk.edit(lot, {"do": "rename", "row": "A", "to": "X"}, {"do": "remove", "row": "B"})
    desk.do(commands.rename, lot, "North", WHO, NOW)
    desk.do(commands.choose_time_zone, lot, "Europe/Oslo", WHO, NOW)
    assert meet(drone, desk.store) == []
    assert plan(drone.store, lot) == plan(desk.store, lot)
    assert {label[0] for label in labels(drone.store, lot)} == {"X"}
    assert looks(drone.store) == before
    with drone.store.reading() as connection:
        row = connection.execute(select(LOT.c.name, LOT.c.time_zone)).one()
    assert tuple(row) == ("North", "Europe/Oslo")
    assert documents_to_send(drone) == []


def test_what_the_drone_changes_of_the_desks_plan_changes_it_there(drone: Drone, desk: Drone) -> None:
    lot = lot_of(drone)
    meet(drone, desk.store)
    desk.edit(lot, {"do": "rename", "row": "A", "to": "X"})
    meet(drone, desk.store)
    drone.edit(lot, {"do": "remove", "row": "B"})
    drone.do(commands.rename, lot, "South", WHO, NOW)
    assert meet(drone, desk.store) == []
    assert labels(desk.store, lot) == labels(drone.store, lot)
    assert {label[0] for label in labels(desk.store, lot)} == {"X"}
    with desk.store.reading() as connection:
        assert connection.execute(select(LOT.c.name)).scalar_one() == "South"


def test_a_plan_changed_at_both_ends_is_the_desks_and_the_drone_says_so(drone: Drone, desk: Drone) -> None:
    lot = lot_of(drone)
    meet(drone, desk.store)
    desk.edit(lot, {"do": "rename", "row": "A", "to": "X"})
    drone.edit(lot, {"do": "remove", "row": "B"})
    before = plan(desk.store, lot)
    assert ask(drone, desk.store) == [], "the desk has not got the drone's change: it stays"
    assert {label[0] for label in labels(drone.store, lot)} == {"A"}
    assert meet(drone, desk.store) == ["Lot 1"]
    assert plan(drone.store, lot) == plan(desk.store, lot) == before
    assert {label[0] for label in labels(drone.store, lot)} == {"X", "B"}


def test_a_plan_that_is_edited_on_the_drone_stays_until_the_end_of_the_edit(drone: Drone, desk: Drone) -> None:
    lot = lot_of(drone)
    meet(drone, desk.store)
    desk.edit(lot, {"do": "rename", "row": "A", "to": "X"})
    opened = drone.do(edits.open_edit, lot, {"who": "Ann"}, NOW)
    assert ask(drone, desk.store) == []
    assert {label[0] for label in labels(drone.store, lot)} == {"A", "B"}
    drone.do(edits.close, lot, {"edit": opened.edit}, NOW)
    ask(drone, desk.store)
    assert {label[0] for label in labels(drone.store, lot)} == {"X", "B"}


def test_a_lot_of_another_drone_comes_and_its_next_survey_is_registered_in_it(
    drone: Drone, other: Drone, desk: Drone
) -> None:
    lot = lot_of(drone)
    meet(drone, desk.store)
    desk.edit(lot, {"do": "rename", "row": "A", "to": "X"})
    assert ask(other, desk.store, writer=OTHER) == []
    assert labels(other.store, lot) == []
    meet(other, desk.store, OTHER)
    saved = other.add(later(survey(seed=2), 2))
    assert (saved.lot, saved.placed, saved.known) == (lot, "registered", 40)
    meet(other, desk.store, OTHER)
    with desk.store.reading() as connection:
        rows = connection.execute(select(SURVEY.c.lot, SURVEY.c.placed).order_by(SURVEY.c.ended)).all()
    assert [tuple(row) for row in rows] == [(lot, "first"), (lot, "registered")]
    assert [each for each in looks(desk.store) if each[0] == saved.survey] == looks(other.store)


def test_another_drones_change_of_a_plan_changes_nothing_by_itself(drone: Drone, other: Drone, desk: Drone) -> None:
    lot = lot_of(drone)
    meet(drone, desk.store)
    meet(other, desk.store, OTHER)
    before = plan(desk.store, lot)
    other.edit(lot, {"do": "remove", "row": "B"})
    assert meet(other, desk.store, OTHER) == ["Lot 1"]
    assert plan(other.store, lot) == plan(desk.store, lot) == before


def test_lots_merged_at_the_desk_are_one_on_the_drone_with_all_its_surveys(drone: Drone, desk: Drone) -> None:
    lot = lot_of(drone)
    second = drone.add(later(survey(seed=2), 2))
    away = drone.do(commands.move, second.survey, {"lot": None, "name": "East"}, WHO, NOW, None)
    meet(drone, desk.store)
    desk.do(commands.merge, away.lot, lot, WHO, NOW)
    meet(drone, desk.store)
    asked = select(SURVEY.c.lot, SURVEY.c.placed).order_by(SURVEY.c.ended)
    with drone.store.reading() as connection:
        found = [tuple(row) for row in connection.execute(asked)]
    assert found == [(away.lot, "registered"), (away.lot, "first")]
    third = drone.add(later(survey(seed=3), 3, 48.0))
    assert (third.lot, third.placed) == (away.lot, "registered")
    meet(drone, desk.store)
    with desk.store.reading() as connection:
        assert {row.lot for row in connection.execute(select(SURVEY.c.lot))} == {away.lot}


def test_a_lot_split_at_the_desk_takes_its_stalls_and_looks_along_on_the_drone(drone: Drone, desk: Drone) -> None:
    lot = lot_of(drone)
    meet(drone, desk.store)
    before = looks(drone.store)
    part = [list(corner) for corner in box(-4, -4, 9, 26).polygons[0]]
    desk.do(commands.split, lot, {"name": "South", "outline": part}, WHO, NOW)
    with desk.store.reading() as connection:
        lots = connection.execute(select(LOT.c.id)).scalars().all()
    ask(drone, desk.store, limit=1)
    assert {each: plan(drone.store, each) for each in lots} == {each: plan(desk.store, each) for each in lots}
    assert looks(drone.store) == before
    meet(drone, desk.store)
    assert looks(desk.store) == before


def test_a_desk_with_another_store_is_asked_from_the_start(drone: Drone, desk: Drone, tmp_path: Path) -> None:
    lot = lot_of(drone)
    meet(drone, desk.store)
    for number in range(3):
        desk.do(commands.rename, lot, f"North {number}", WHO, NOW)
    meet(drone, desk.store)
    fresh = Drone.at(tmp_path / "fresh.db")
    drone.add(later(survey(seed=2), 2))
    send(drone, fresh.store)
    fresh.do(commands.rename, lot, "South", WHO, NOW)
    meet(drone, fresh.store)
    with drone.store.reading() as connection:
        assert connection.execute(select(LOT.c.name)).scalar_one() == "South"
    fresh.store.close()


def test_a_damaged_lot_is_named_and_nothing_of_it_is_written(drone: Drone, desk: Drone) -> None:
    lot = lot_of(drone)
    meet(drone, desk.store)
    desk.do(lambda connection: connection.execute(update(LOT).values(latitude=400.0)).close())
    with pytest.raises(Exception, match=r"latitude: must be 90 or less"):
        ask(drone, desk.store)
    assert labels(drone.store, lot) == labels(desk.store, lot)


def test_a_change_that_the_drone_undoes_before_it_came_back_is_undone_at_the_desk(drone: Drone, desk: Drone) -> None:
    lot = lot_of(drone)
    meet(drone, desk.store)
    before = plan(desk.store, lot)
    drone.edit(lot, {"do": "remove", "row": "B"})
    send(drone, desk.store)
    assert plan(desk.store, lot) != before
    with drone.store.reading() as connection:
        newest = connection.execute(select(func.max(CHANGE.c.seq)).where(CHANGE.c.edit.is_(None))).scalar_one()
    drone.do(commands.undo, newest, NOW)
    assert meet(drone, desk.store) == []
    assert plan(desk.store, lot) == plan(drone.store, lot) == before


def test_a_lot_that_the_drone_splits_right_after_it_came_back_is_split_at_the_desk(drone: Drone, desk: Drone) -> None:
    lot = lot_of(drone)
    meet(drone, desk.store)
    desk.do(commands.rename, lot, "North", WHO, NOW)
    meet(drone, desk.store)
    part = [list(corner) for corner in box(-4, -4, 9, 26).polygons[0]]
    drone.do(commands.split, lot, {"name": "South", "outline": part}, WHO, NOW)
    for kind, _, data in reversed(documents_to_send(drone)):
        take(desk.store, kind, data, "Drone 1")
    assert meet(drone, desk.store) == []
    with desk.store.reading() as connection:
        assert connection.execute(select(func.count()).select_from(LOT)).scalar_one() == 2
    assert plan(desk.store, lot) == plan(drone.store, lot)
