from __future__ import annotations

import json
import random
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import select

from hawk.lots import commands
from hawk.lots.documents import parts, survey_document
from hawk.lots.documents.arrival import Outcome
from hawk.lots.storage.database import Database
from hawk.lots.storage.erasure import erased_id
from hawk.lots.storage.schema import ERASED, SECTION_LOOK, SURVEY
from hawk.lots.values import ErasedError, LotInputError, OtherDroneError
from tests.examples import examples
from tests.unit.lots import whole
from tests.unit.lots.documents.drones import NOW, WHO, Drone, collected, days, vehicle
from tests.unit.lots.documents.tables import tables
from tests.unit.lots.plan.plans import FAST
from tests.unit.lots.surveys import box, later, survey

Tables = dict[str, list[str]]
THEIRS = ("lot", "layout", "zone", "section", "observation", "section_look", "order", "looks")
"""Tables of a centre that are those of the drone, but for numbers."""


@pytest.fixture(scope="module")
def drone(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Drone]:
    """A drone at the end of its life, and every document that it could have sent."""
    made = Drone.at(tmp_path_factory.mktemp("drone") / "lots.db")
    for _ in days(made):
        made.send()
    yield made
    made.store.close()


@pytest.fixture
def centre(tmp_path: Path) -> Iterator[Database]:
    opened = Database(tmp_path / "centre.db", FAST)
    yield opened
    opened.close()


def shown(store: Database) -> Tables:
    with store.reading() as connection:
        return tables(connection)


def surveys(store: Database) -> list[dict[str, Any]]:
    with store.reading() as connection:
        return whole.surveys(connection)


@pytest.mark.slow
def test_all_documents_make_the_tables_of_the_drone(drone: Drone, centre: Database) -> None:
    for data in drone.sent:
        collected(centre, data)
    assert len(drone.sent) > 30
    found, theirs = shown(centre), shown(drone.store)
    assert {name: found[name] for name in THEIRS} == {name: theirs[name] for name in THEIRS}
    plain = [
        [{**json.loads(row), "first_survey": 0, "first_id": 0} for row in each["stall"]] for each in (found, theirs)
    ]
    key = str
    assert sorted(plain[0], key=key) == sorted(plain[1], key=key)


@pytest.mark.slow
@pytest.mark.fault(
    "documents of surveys come in any order, twice, cut, and the program ends in between",
    "the tables are the same as of all of them in their order",
)
@settings(
    max_examples=examples(36),
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(data=st.data())
def test_any_order_doubling_cut_and_restart_ends_in_the_same_tables(
    drone: Drone, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    size = len(drone.sent)
    among = data.draw(st.lists(st.integers(0, size - 1), min_size=1, max_size=12, unique=True))
    orders = [data.draw(st.permutations(among)), data.draw(st.permutations(among))]
    twice = data.draw(st.lists(st.sampled_from(among), max_size=4))
    seed = data.draw(st.integers(0, 1000))
    found = []
    for number, order in enumerate(orders):
        path = tmp_path_factory.mktemp("centre") / "lots.db"
        found.append(
            after(path, drone.sent, [*order, *twice] if number else order, random.Random(seed) if number else None)
        )
    assert found[0] == found[1]


def after(path: Path, sent: list[bytes], order: list[int], chance: random.Random | None) -> Tables:
    """Return the tables of a centre after documents; ``chance``: mixes them, cuts some first, and ends the program."""
    store = Database(path, FAST)
    if chance is not None:
        chance.shuffle(order)
    for number in order:
        if chance is not None and chance.random() < 0.3:
            with pytest.raises(LotInputError):
                collected(store, sent[number][: chance.randrange(len(sent[number]))])
        if chance is not None and chance.random() < 0.2:
            with pytest.raises(KeyboardInterrupt), store.writing() as connection:
                _taken_and_killed(connection, sent[number])
            store.close()
            store = Database(path, FAST)
        collected(store, sent[number])
    found = shown(store)
    store.close()
    return found


def _taken_and_killed(connection: Any, data: bytes) -> None:
    from hawk.lots.documents.collection import collect

    collect(connection, survey_document.unpacked(data), "Drone 1")
    raise KeyboardInterrupt


@pytest.mark.slow
def test_the_same_document_again_answers_the_same_and_writes_nothing(drone: Drone, centre: Database) -> None:
    answers = [collected(centre, data) for data in drone.sent[:6]]
    before = shown(centre)
    last = drone.sent[5]
    taken, known = Outcome.TAKEN, Outcome.KNOWN
    outcomes = [taken, taken, taken, taken, known, taken]
    assert [each.outcome for each in answers] == outcomes, (
        "the fourth brings a plan, the fifth neither that nor a survey"
    )
    assert collected(centre, last) == replace(answers[-1], outcome=Outcome.KNOWN)
    assert shown(centre) == before


@pytest.mark.nightly
def test_an_earlier_state_that_comes_later_changes_nothing(drone: Drone, centre: Database) -> None:
    documents = [survey_document.unpacked(data) for data in drone.sent]
    states = [each for each in documents if each.survey.landing == 1]
    newest = max(states, key=lambda each: each.survey.state)
    assert len(states) > 2
    taken = collected(centre, parts.packed(newest))
    before = shown(centre)
    for each in states:
        assert collected(centre, parts.packed(each)).state == taken.state
    assert shown(centre)["survey"] == before["survey"]


def test_a_survey_of_another_drone_and_of_this_store_is_refused(drone: Drone, tmp_path: Path) -> None:
    store = Database(tmp_path / "centre.db", FAST)
    first = drone.sent[0]
    collected(store, first)
    before = shown(store)
    for writer in ("Drone 2", ""):
        with pytest.raises(OtherDroneError, match=r"survey\.id: this survey is another's"):
            collected(store, first, writer)
    document = survey_document.unpacked(first)
    other = document.survey.model_copy(update={"id": "123e4567-e89b-42d3-a456-426614174000", "state": 999})
    renamed = parts.packed(document.model_copy(update={"survey": other}))
    with pytest.raises(OtherDroneError, match=r"survey\.id: this flight was sent as another survey"):
        collected(store, renamed)
    assert shown(store) == before
    collected(store, renamed, "Drone 2")  # of a journal with the same name, begun in the same second
    assert set(before["survey"]) < set(shown(store)["survey"])
    assert shown(store)["lot"] == before["lot"]
    store.close()
    with pytest.raises(OtherDroneError, match=r"survey\.id: this survey is another's"):
        collected(drone.store, first)


def test_a_plan_of_another_drones_lot_is_left_out_and_the_survey_is_kept(drone: Drone, centre: Database) -> None:
    collected(centre, drone.sent[0])
    before = shown(centre)
    document = survey_document.unpacked(drone.sent[2])
    lot = document.lots[0].model_copy(update={"name": "Mine now", "state": 10**6})
    theirs = document.model_copy(update={"lots": (lot,)})
    assert collected(centre, parts.packed(theirs), "Drone 2").keeps_plan
    found = shown(centre)
    assert [found[name] for name in ("lot", "stall", "layout")] == [before[name] for name in ("lot", "stall", "layout")]
    assert len(found["survey"]) == len(before["survey"]) + 1


@pytest.mark.slow
def test_what_was_erased_here_does_not_come_back(drone: Drone, centre: Database) -> None:
    document = survey_document.unpacked(drone.sent[0])
    for named, field in ((document.survey.id, r"survey\.id"), (document.lots[0].id, r"lots\[0\]\.id")):
        with centre.writing() as connection:
            connection.execute(ERASED.delete())
            connection.execute(ERASED.insert().values(id=erased_id(named)))
        with pytest.raises(ErasedError, match=f"{field}: it was erased here"):
            collected(centre, drone.sent[0])
    assert shown(centre)["survey"] == []


@pytest.mark.nightly
def test_what_a_person_says_at_the_centre_of_a_plan_stays_and_surveys_go_on(tmp_path: Path, centre: Database) -> None:
    drone = Drone.at(tmp_path / "lots.db")
    first = drone.add(survey())
    assert first.lot is not None
    drone.send()
    collected(centre, drone.sent[-1])
    part = [list(corner) for corner in box(-4, -4, 9, 26).polygons[0]]
    with centre.writing() as connection:
        commands.rename(connection, first.lot, "At the centre", WHO, NOW)
        split = commands.split(connection, first.lot, {"name": "South", "outline": part}, WHO, NOW)
    before = shown(centre)
    drone.do(commands.rename, first.lot, "On the drone", WHO, NOW)
    drone.edit(first.lot, {"do": "remove", "row": "B"})
    drone.add(later(survey(seed=2), 2))
    drone.send()
    for data in drone.sent[1:]:
        assert collected(centre, data).keeps_plan
    found = shown(centre)
    assert [found[name] for name in ("lot", "stall", "layout")] == [before[name] for name in ("lot", "stall", "layout")]
    assert len(surveys(centre)) == 2
    with centre.writing() as connection:
        commands.undo(connection, split.seq, NOW)
    assert not collected(centre, drone.sent[-1]).keeps_plan
    with centre.reading() as connection:
        assert whole.lots(connection)[0]["name"] == "At the centre"
        assert len(whole.stalls(connection, first.lot)) == 20
    drone.store.close()


@pytest.mark.nightly
def test_a_survey_that_a_person_at_the_centre_deleted_or_moved_stays_so(tmp_path: Path, centre: Database) -> None:
    drone = Drone.at(tmp_path / "lots.db")
    given = [survey(), later(survey(seed=2), 2)]
    stored = [drone.add(each) for each in given]
    drone.send()
    for data in drone.sent:
        collected(centre, data)
    with centre.writing() as connection:
        commands.delete(connection, stored[1].survey, WHO, NOW)
        commands.move(connection, stored[0].survey, {"lot": None, "name": "Elsewhere"}, WHO, NOW, None)
    drone.add(replace(given[0], ended=given[0].ended + 60))
    drone.add(replace(given[1], ended=given[1].ended + 60))
    drone.send()
    for data in drone.sent:
        collected(centre, data)
    with centre.reading() as connection:
        rows = {row.id: row for row in connection.execute(select(SURVEY))}
        names = {each["id"]: each["name"] for each in whole.lots(connection)}
    assert rows[stored[1].survey].placed == "deleted"
    assert rows[stored[0].survey].lot != stored[0].lot
    assert names[rows[stored[0].survey].lot] == "Elsewhere"
    assert rows[stored[0].survey].ended == given[0].ended + 60
    drone.store.close()


@pytest.mark.nightly
def test_a_new_survey_of_a_lot_that_a_person_at_the_centre_merged_is_registered_in_the_other_one(
    tmp_path: Path, centre: Database
) -> None:
    drone = Drone.at(tmp_path / "lots.db")
    first = drone.add(survey())
    away = drone.do(commands.move, drone.add(later(survey(seed=2), 2)).survey, {"lot": None}, WHO, NOW, None)
    drone.send()
    for data in drone.sent:
        collected(centre, data)
    with centre.writing() as connection:
        commands.merge(connection, away.lot, first.lot, WHO, NOW)
    third = drone.add(later(survey(seed=3), 3, 48.0))
    drone.do(commands.move, third.survey, {"lot": first.lot}, WHO, NOW, None) if third.lot != first.lot else None
    drone.send()
    for data in drone.sent:
        collected(centre, data)
    with centre.reading() as connection:
        row = connection.execute(select(SURVEY).where(SURVEY.c.id == third.survey)).one()
        looks = [each for each in tables(connection)["observation"] if third.survey in each]
    assert (row.lot, row.placed) == (away.lot, "registered")
    assert len(looks) == 40
    drone.store.close()


@pytest.mark.nightly
def test_counts_of_sections_by_vehicles_stay_though_no_vehicle_is_here(tmp_path: Path, centre: Database) -> None:
    drone = Drone.at(tmp_path / "lots.db")
    first = drone.add(survey())
    assert first.lot is not None
    ring = [[-6.0, 52.0], [6.0, 52.0], [6.0, 62.0], [-6.0, 62.0]]
    drone.edit(first.lot, {"do": "draw_section", "name": "Kerb", "outline": ring, "kind": "parallel"})
    seen = drone.add(replace(later(survey(seed=2), 2), vehicles=(vehicle(1, -1.0, 60.0),)))
    drone.send()
    for data in drone.sent:
        collected(centre, data)
    asked = select(SECTION_LOOK.c.source, SECTION_LOOK.c.parked)
    with centre.writing() as connection:
        gone = commands.delete(connection, seen.survey, WHO, NOW)
        commands.undo(connection, gone.seq, NOW)
        found = connection.execute(asked).all()
    assert ("vehicles", 1) in [tuple(row) for row in found]
    drone.store.close()
