from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from pathlib import Path

import pytest
from sqlalchemy import select

from hawk.lots import commands, lists, queries
from hawk.lots.answers import DroneProposals
from hawk.lots.storage.schema import STALL
from hawk.lots.values import LotInputError
from tests.unit.lots.documents.drones import NOW, WHO, Drone
from tests.unit.lots.documents.exchange import ask, meet, send
from tests.unit.lots.documents.test_lot_return import OTHER, labels, looks, lot_of, plan
from tests.unit.lots.surveys import later, survey

ADDED = {"do": "add_row", "front": [[30.0, 0.0], [30.0, 15.0]], "far": [35.0, 0.0], "count": 6}


class Place:
    """A lot that two drones and the desk have."""

    def __init__(self, folder: Path) -> None:
        self.drone, self.other, self.desk = (Drone.at(folder / f"{name}.db") for name in ("one", "two", "desk"))
        self.desk.now, self.other.now = NOW + 60, NOW + 120
        self.lot = lot_of(self.drone)
        self.meet()

    def copied(self, folder: Path) -> Place:
        """Return a copy; the stores must be closed."""
        made = copy(self)
        made.drone, made.other, made.desk = (each.copied(folder) for each in (self.drone, self.other, self.desk))
        return made

    def close(self) -> None:
        for each in (self.drone, self.other, self.desk):
            each.store.close()

    def meet(self) -> None:
        for _ in range(2):
            meet(self.drone, self.desk.store)
            meet(self.other, self.desk.store, OTHER)

    def proposed(self) -> list[DroneProposals]:
        with self.desk.store.reading() as connection:
            return queries.proposed(connection, self.lot).drones

    def plans(self) -> set[str]:
        return {plan(each.store, self.lot) for each in (self.drone, self.other, self.desk)}


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Place:
    made = Place(tmp_path_factory.mktemp("place"))
    made.close()
    return made


@pytest.fixture
def place(first: Place, tmp_path: Path) -> Iterator[Place]:
    made = first.copied(tmp_path)
    yield made
    made.close()


def test_stalls_that_another_drones_operator_added_are_taken_and_everybody_has_them(place: Place) -> None:
    place.other.edit(place.lot, ADDED, {"do": "rename", "row": "A", "to": "X"})
    place.meet()
    (found,) = place.proposed()
    assert (found.drone, len(found.begin), len(found.end), len(found.change)) == (OTHER, 6, 0, 20)
    assert len(place.plans()) == 1
    done = place.desk.do(commands.take_over, place.lot, {"drone": OTHER, "base": found.base}, WHO, NOW + 200)
    assert place.proposed() == []
    assert len(labels(place.desk.store, place.lot)) == 46
    assert {each.id for each in found.begin} <= ids(place.desk)
    place.meet()
    assert len(place.plans()) == 1
    assert len(labels(place.other.store, place.lot)) == 46
    place.desk.do(commands.undo, done.seq, NOW + 300)
    (again,) = place.proposed()
    assert len(again.begin) == 6
    place.desk.do(commands.take_over, place.lot, {"drone": OTHER, "base": found.base}, WHO, NOW + 400)
    place.meet()
    assert len(place.plans()) == 1
    assert len(labels(place.drone.store, place.lot)) == 46


def test_a_plan_changed_at_both_ends_keeps_what_each_changed_when_a_person_takes_it(place: Place) -> None:
    place.desk.edit(place.lot, {"do": "rename", "row": "A", "to": "X"})
    place.drone.edit(place.lot, {"do": "remove", "row": "B"}, ADDED)
    ring = [[-6.0, 52.0], [6.0, 52.0], [6.0, 80.0], [-6.0, 80.0]]
    place.drone.edit(place.lot, {"do": "draw_section", "name": "Kerb", "outline": ring, "kind": "parallel"})
    zone = [[20.0, 50.0], [26.0, 50.0], [26.0, 60.0], [20.0, 60.0]]
    place.drone.edit(place.lot, {"do": "forbid", "name": "Trees", "outline": zone})
    place.meet()
    assert len(place.plans()) == 1
    (found,) = place.proposed()
    assert (len(found.begin), len(found.end), found.areas) == (6, 20, ["Kerb", "Trees"])
    place.desk.do(commands.take_over, place.lot, {"drone": "Drone 1", "base": found.base}, WHO, NOW + 200)
    assert place.proposed() == []
    assert {label[0] for label in labels(place.desk.store, place.lot)} == {"X", found.begin[0].label[0]}
    with place.desk.store.reading() as connection:
        assert lists.layouts(connection, place.lot, lists.Asked(100, None)).items[-1].why == "changes of Drone 1"
    place.meet()
    assert len(place.plans()) == 1


def test_what_a_person_drops_is_proposed_no_more_until_the_drone_changes_more(place: Place) -> None:
    place.other.edit(place.lot, ADDED)
    place.meet()
    (found,) = place.proposed()
    asked = {"drone": OTHER, "base": found.base}
    place.desk.do(commands.drop, place.lot, asked, WHO, NOW + 200)
    assert place.proposed() == []
    with pytest.raises(LotInputError, match="has no changes that wait"):
        place.desk.do(commands.take_over, place.lot, asked, WHO, NOW + 201)
    place.meet()
    assert place.proposed() == []
    place.other.edit(place.lot, {"do": "remove", "row": "A"})
    place.meet()
    (more,) = place.proposed()
    assert (len(more.begin), len(more.end)) == (0, 20)


def test_the_same_correction_at_both_ends_proposes_nothing(place: Place) -> None:
    for where in (place.desk, place.other):
        where.edit(place.lot, ADDED)
    place.meet()
    assert place.proposed() == []
    assert len(place.plans()) == 1


def test_looks_of_a_stall_that_waits_for_a_person_are_there_when_it_is_taken(place: Place) -> None:
    other = place.other
    other.edit(place.lot, {"do": "remove", "row": "B"})
    seen = other.add(later(survey(seed=2), 2))
    assert seen.lot == place.lot
    send(other, place.desk.store, OTHER)
    other.edit(place.lot, {"do": "rename", "row": "A", "to": "Z"})
    ask(other, place.desk.store)
    before = looks(other.store)
    place.meet()
    assert looks(other.store) == before
    assert [each for each in looks(place.desk.store) if each[0] == seen.survey] == before


def ids(where: Drone) -> set[str]:
    with where.store.reading() as connection:
        return {*connection.execute(select(STALL.c.id).where(STALL.c.ends.is_(None))).scalars()}
