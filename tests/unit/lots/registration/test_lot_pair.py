from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from pathlib import Path

import pytest
from sqlalchemy import select

from hawk.daemon.lots.keeper import find_stalls
from hawk.lots import commands, queries
from hawk.lots.answers import LotPair
from hawk.lots.ingest import save
from hawk.lots.registration.lot_pair import move_onto
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LOT, OBSERVATION, SURVEY
from hawk.lots.values import Doubtful
from tests.unit.lots.documents.drones import NOW, WHO, Drone
from tests.unit.lots.documents.exchange import meet
from tests.unit.lots.surveys import later, survey

NAMES = ("Drone 1", "Drone 2")


class Apart:
    """Two drones that each have made a lot of the same ground, and the desk that has both."""

    def __init__(self, folder: Path) -> None:
        self.drones = {name: Drone.at(folder / f"{name}.db") for name in NAMES}
        self.desk = Drone.at(folder / "desk.db")
        self.desk.now = NOW + 60
        made = [drone.add(later(survey(seed=n, stalls=60), n)).lot for n, drone in enumerate(self.drones.values(), 1)]
        self.kept, self.other = (str(each) for each in made)
        self.drones[NAMES[1]].add(later(survey(seed=3, stalls=60), 3, 24.0))

    def copied(self, folder: Path) -> Apart:
        """Return a copy; the stores must be closed."""
        other = copy(self)
        other.drones = {name: drone.copied(folder) for name, drone in self.drones.items()}
        other.desk = self.desk.copied(folder)
        return other

    def close(self) -> None:
        for each in (*self.drones.values(), self.desk):
            each.store.close()

    def meet(self) -> None:
        for _ in range(2):
            for name, drone in self.drones.items():
                meet(drone, self.desk.store, name)

    def same(self, lot: str) -> list[LotPair]:
        with self.desk.store.reading() as connection:
            return queries.proposed(connection, lot).same


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Apart:
    found = Apart(tmp_path_factory.mktemp("apart"))
    found.close()
    return found


@pytest.fixture(scope="module")
def introduced(made: Apart, tmp_path_factory: pytest.TempPathFactory) -> Apart:
    found = made.copied(tmp_path_factory.mktemp("met"))
    found.meet()
    found.close()
    return found


@pytest.fixture
def apart(made: Apart, tmp_path: Path) -> Iterator[Apart]:
    """Two drones that have not met the desk yet."""
    found = made.copied(tmp_path)
    yield found
    found.close()


@pytest.fixture
def met(introduced: Apart, tmp_path: Path) -> Iterator[Apart]:
    """Two drones and a desk that have met."""
    found = introduced.copied(tmp_path)
    yield found
    found.close()


def surveys(store: Database) -> list[tuple[str, str, int]]:
    """Return lot, relation and number of looks of each survey, by time."""
    with store.reading() as connection:
        found = []
        for row in connection.execute(select(SURVEY).order_by(SURVEY.c.ended)):
            looks = connection.execute(select(OBSERVATION.c.stall).where(OBSERVATION.c.survey == row.seq)).all()
            found.append((row.lot, row.placed, len(looks)))
        return found


def test_two_lots_made_apart_over_the_same_ground_are_proposed_as_one(met: Apart) -> None:
    (same,) = met.same(met.kept)
    assert same.lot == met.other
    assert same.share == pytest.approx(1.0, abs=0.05)
    assert [each.lot for each in met.same(met.other)] == [met.kept]


def test_a_merge_registers_the_surveys_of_both_and_every_drone_flies_the_one_lot_on(met: Apart) -> None:
    done = met.desk.do(commands.merge, met.kept, met.other, WHO, NOW + 100, find_stalls)
    assert surveys(met.desk.store) == [(met.kept, "first", 60), *[(met.kept, "registered", 60)] * 2]
    assert met.same(met.kept) == []
    met.meet()
    second = met.drones[NAMES[1]]
    assert surveys(second.store) == [(met.kept, "registered", 60)] * 2
    for number, (name, drone) in enumerate(met.drones.items(), 4):
        saved = drone.add(later(survey(seed=number, stalls=60), number, 24.0 * number))
        assert (saved.lot, saved.placed) == (met.kept, "registered"), name
    met.meet()
    assert [each[0] for each in surveys(met.desk.store)] == [met.kept] * 5
    with met.desk.store.reading() as connection:
        into = connection.execute(select(LOT.c.merged_into).where(LOT.c.id == met.other)).scalar_one()
    assert into == met.kept
    assert done.kind == "merge"


def test_a_merge_with_its_surveys_is_undone_once(met: Apart) -> None:
    before = surveys(met.desk.store)
    done = met.desk.do(commands.merge, met.kept, met.other, WHO, NOW + 100, find_stalls)
    met.desk.do(commands.undo, done.seq, NOW + 200)
    assert surveys(met.desk.store) == before


def test_a_drone_without_a_link_sends_surveys_of_the_lot_that_became_part_of_another_one(met: Apart) -> None:
    met.desk.do(commands.merge, met.kept, met.other, WHO, NOW + 100, find_stalls)
    saved = met.drones[NAMES[1]].add(later(survey(seed=7, stalls=60), 7, 96.0))
    assert saved.lot == met.other, "it does not know yet"
    met.meet()
    assert surveys(met.desk.store)[-1] == (met.kept, "registered", 60)
    assert surveys(met.drones[NAMES[1]].store)[-1] == (met.kept, "registered", 60)


def test_a_merge_finds_the_place_of_a_survey_that_had_none_in_its_own_lot(apart: Apart) -> None:
    second = apart.drones[NAMES[1]]
    second.do(save, later(survey(seed=5, stalls=60), 5, 48.0), None)
    assert surveys(second.store)[-1] == (apart.other, "unregistered", 0)
    apart.meet()
    apart.desk.do(commands.merge, apart.kept, apart.other, WHO, NOW + 100, find_stalls)
    assert surveys(apart.desk.store)[-1] == (apart.kept, "registered", 60)
    apart.meet()
    assert surveys(second.store)[-1] == (apart.kept, "registered", 60)


def test_surveys_of_a_lot_that_is_not_certainly_the_other_one_find_their_places_by_themselves(met: Apart) -> None:
    met.desk.edit(met.other, {"do": "remove", "row": "A"})
    met.desk.edit(met.other, {"do": "remove", "row": "B"})
    met.desk.edit(met.other, {"do": "remove", "row": "C"})
    assert met.desk.do(move_onto, met.kept, met.other, find_stalls) is None
    met.desk.do(commands.merge, met.kept, met.other, WHO, NOW + 100, find_stalls)
    assert surveys(met.desk.store)[1:] == [(met.kept, "registered", 60)] * 2


def test_surveys_whose_places_are_not_certain_wait_with_their_doubts(met: Apart) -> None:
    doubtful = Doubtful("too few stalls")
    met.desk.do(commands.merge, met.kept, met.other, WHO, NOW + 100, lambda *_: doubtful)
    assert surveys(met.desk.store)[1:] == [(met.kept, "unregistered", 0)] * 2
    with met.desk.store.reading() as connection:
        doubts = connection.execute(select(SURVEY.c.doubt).where(SURVEY.c.placed == "unregistered")).scalars()
        assert all("too few stalls" in each for each in doubts)
