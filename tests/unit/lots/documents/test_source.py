from __future__ import annotations

import gzip
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest
from sqlalchemy import select, update

from hawk.lots import commands, outbox
from hawk.lots.documents import lot_document, parts, source
from hawk.lots.storage import states
from hawk.lots.storage.backup import backup, restore
from hawk.lots.storage.schema import DELIVERY, OUTBOX, SURVEY
from hawk.lots.values import LotInputError, LotStoreError, NotFoundError, new_id
from tests.unit.lots.documents.drones import NOW, WHO, Drone, days, tile, vehicle
from tests.unit.lots.surveys import later, survey

THERE, ELSEWHERE = "one", "other"


@pytest.fixture
def drone(tmp_path: Path) -> Iterator[Drone]:
    made = Drone.at(tmp_path / "lots.db")
    yield made
    made.store.close()


@pytest.mark.slow
def test_a_document_says_what_the_survey_found_and_where_it_lies(drone: Drone) -> None:
    first = drone.add(survey())
    again = drone.add(later(survey(seed=2), 2))
    document = drone.document(again.survey, {(0, -1): tile()})
    assert (document.survey.placed, document.survey.lot, document.survey.layout) == ("registered", first.lot, 1)
    assert document.survey.place is not None
    assert (document.survey.name, document.survey.landing) == ("000002-20260505T103000Z", 2)
    assert [each.id for each in document.stalls] == list(range(1, 41))
    (lot,) = document.lots
    assert {each.stall for each in document.looks} == {each.id for each in lot.stalls}
    assert [(each.row, each.column, each.jpeg) for each in document.mosaic] == [(0, -1, tile())]


@pytest.mark.nightly
def test_no_vehicle_is_in_a_document_and_the_counts_of_sections_are(drone: Drone) -> None:
    first = drone.add(survey())
    assert first.lot is not None
    ring = [[-6.0, 52.0], [6.0, 52.0], [6.0, 62.0], [-6.0, 62.0]]
    drone.edit(first.lot, {"do": "draw_section", "name": "Kerb", "outline": ring, "kind": "parallel"})
    seen = drone.add(replace(later(survey(), 2), vehicles=(vehicle(1, -1.25, 60.125),)))
    document = drone.document(seen.survey)
    assert [(each.source, each.parked) for each in document.sections] == [("vehicles", 1)]
    text = gzip.decompress(parts.packed(document)).decode()
    assert "60.12" not in text
    assert "1.25" not in text
    assert '"car"' not in text


@pytest.mark.nightly
def test_a_survey_goes_with_every_lot_that_it_looked_at_and_those_that_became_part_of_them(drone: Drone) -> None:
    for _ in days(drone):
        for document in drone.documents():
            lots = {each.id: each for each in document.lots}
            stalls = {stall.id for lot in lots.values() for stall in lot.stalls}
            assert {look.stall for look in document.looks} <= stalls
            assert {lot.merged_into for lot in lots.values()} - {None} <= lots.keys()
            assert document.survey.lot is None or document.survey.lot in lots


def test_each_change_gives_survey_and_lot_a_higher_state_and_nothing_else_does(drone: Drone) -> None:
    first = drone.add(survey())
    assert first.lot is not None
    one = drone.document(first.survey)
    assert drone.document(first.survey) == one
    drone.do(commands.rename, first.lot, "North", WHO, NOW)
    two = drone.document(first.survey)
    assert two.survey.state == one.survey.state
    assert two.lots[0].state > max(one.lots[0].state, one.survey.state)
    drone.do(commands.delete, first.survey, WHO, NOW)
    three = drone.document(first.survey)
    assert three.survey.state > two.lots[0].state
    assert three.survey.placed == "deleted"


@pytest.mark.nightly
def test_a_state_is_sent_until_it_is_received_the_newest_first_and_then_the_oldest(drone: Drone) -> None:
    for number in range(4):
        drone.add(later(survey(seed=number), number + 1, 24.0 * number))

    def next_one(now: float) -> outbox.Message | None:
        message: outbox.Message | None = drone.do(outbox.due_state, THERE, now)
        return message

    newest = next_one(NOW)
    assert newest is not None
    with drone.store.reading() as connection:
        kinds = select(OUTBOX.c.seq).where(OUTBOX.c.kind.in_(states.KINDS)).order_by(OUTBOX.c.seq)
        numbers = list(connection.execute(kinds).scalars())
    order = [newest.seq]
    drone.do(outbox.note_sent, newest, THERE, NOW)
    while (message := next_one(NOW)) is not None:
        order.append(message.seq)
        drone.do(outbox.note_sent, message, THERE, NOW)
    assert order == [numbers[-1], *numbers[:-1]]
    assert drone.do(outbox.due_state, ELSEWHERE, NOW) is not None
    assert next_one(NOW + 1e9) is None


@pytest.mark.slow
def test_a_state_is_never_given_up(drone: Drone) -> None:
    drone.add(survey())
    now = NOW
    for _ in range(60):
        message = drone.do(outbox.due_state, THERE, now)
        assert message is not None
        assert not drone.do(outbox.note_failed, message, THERE, now)
        now += 86_400.0
    assert drone.do(outbox.due_state, THERE, now + 365 * 86_400.0) is not None


def test_an_answer_to_a_state_in_whose_place_a_newer_one_is_notes_nothing(drone: Drone) -> None:
    survey_id = drone.add(survey()).survey
    message = drone.do(outbox.due_state, THERE, NOW)
    drone.do(commands.delete, survey_id, WHO, NOW)
    assert not drone.do(outbox.note_failed, message, THERE, NOW)
    drone.do(outbox.note_sent, message, THERE, NOW)
    drone.do(outbox.give_up, message, THERE, NOW)
    assert drone.do(lambda c: c.execute(select(DELIVERY)).all()) == []
    assert drone.do(outbox.due_state, THERE, NOW).seq > message.seq


def test_reports_to_programs_are_no_states(drone: Drone) -> None:
    drone.add(survey())
    kinds = []
    while (message := drone.do(outbox.due, THERE, NOW)) is not None:
        kinds.append(message.kind)
        drone.do(outbox.note_sent, message, THERE, NOW)
    assert kinds == ["layout", "survey"]


@pytest.mark.slow
def test_each_state_of_a_lot_makes_a_document_that_can_be_read(drone: Drone) -> None:
    asked = select(OUTBOX.c.seq, OUTBOX.c.body).where(OUTBOX.c.kind == states.LOT_STATE)
    for _ in days(drone):
        with drone.store.reading() as connection:
            for seq, lot in connection.execute(asked).all():
                document = source.document_of_lot(connection, lot)
                assert document is not None
                assert document.state == seq
                assert lot_document.unpacked(parts.packed(document)) == document
                assert lot in {each.id for each in document.lots}
                assert source.document_of_lot(connection, new_id()) is None


def test_what_is_due_is_said_of_the_lots_of_a_schedule_and_of_a_drone_alone(drone: Drone) -> None:
    first = drone.add(survey())
    moment = datetime.fromtimestamp(NOW, UTC)

    def due(name: str, writer: str | None) -> list[tuple[str, float | None, tuple[float, ...]]]:
        with drone.store.reading() as connection:
            found = source.lots_due(connection, lambda _, given, *__: [moment] if given == name else [], writer)
        return [(each.lot, each.last, each.moments) for each in found]

    assert due("Lot 1", None) == [(first.lot, survey().ended, (NOW,))]
    assert due("Lot 2", None) == []
    assert due("Lot 1", "Drone 2") == []


def test_a_document_names_what_is_due_once(drone: Drone) -> None:
    lot = lot_document.LotDue(lot=str(drone.add(survey()).lot), last=None, moments=(NOW,))
    with drone.store.reading() as connection:
        lots = source.changed_lots(connection, 0, 10, None)
    assert lot_document.unpacked(parts.packed(lots.model_copy(update={"due": (lot,)}))).due == (lot,)
    with pytest.raises(LotInputError, match="due: names one of them twice"):
        lot_document.unpacked(parts.packed(lots.model_copy(update={"due": (lot, lot)})))


def test_what_is_not_there_or_damaged_is_refused_with_its_name(drone: Drone) -> None:
    with pytest.raises(NotFoundError, match="there is no survey with this id"):
        drone.document("123e4567-e89b-42d3-a456-426614174000")
    first = drone.add(survey())
    drone.do(lambda connection: connection.execute(update(SURVEY).values(latitude=123.0)).close())
    with pytest.raises(LotStoreError, match=r"no document can be made of it: survey\.latitude: must be 90 or less"):
        drone.document(first.survey)


@pytest.mark.nightly
def test_a_restored_store_has_newer_states_than_the_one_before_it(drone: Drone, tmp_path: Path) -> None:
    first = drone.add(survey())
    backup(drone.store.path, tmp_path / "backup.db")
    drone.do(commands.rename, first.lot, "North", WHO, NOW)
    drone.do(commands.delete, first.survey, WHO, NOW)
    before = drone.document(first.survey)
    drone.store.close()
    restore(drone.store.path, tmp_path / "backup.db")
    drone.store = Drone.at(drone.store.path).store
    after = drone.document(first.survey)
    assert (after.survey.placed, after.lots[0].name) == ("first", "Lot 1")
    assert min(after.survey.state, after.lots[0].state) > before.survey.state
