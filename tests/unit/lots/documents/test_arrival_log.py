from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import Connection, func, select

from hawk.lots.documents import arrival_log, survey_document
from hawk.lots.documents.arrival import Arrival, ArrivalKind, ListedArrival, Outcome
from hawk.lots.lists import Asked
from hawk.lots.storage.database import Database
from hawk.lots.storage.erasure import erased_id
from hawk.lots.storage.schema import ARRIVAL, ERASED
from hawk.lots.store import LotStore
from hawk.lots.values import LotInputError
from tests.unit.lots.documents.drones import DRONE, NOW, Drone
from tests.unit.lots.documents.tables import tables
from tests.unit.lots.plan.plans import FAST
from tests.unit.lots.surveys import later, survey

ID = "123e4567-e89b-42d3-a456-426614174000"
REFUSED = Arrival(DRONE, ArrivalKind.SURVEY, ID, Outcome.REFUSED, reason="survey.ended: is before survey.began")
TAKEN = Arrival(DRONE, ArrivalKind.LOT, ID, Outcome.TAKEN, ID, 7)


@pytest.fixture
def connection(tmp_path: Path) -> Iterator[Connection]:
    store = Database(tmp_path / "lots.db", FAST)
    with store.writing() as opened:
        yield opened
    store.close()


def items(connection: Connection, *asked: object) -> list[ListedArrival]:
    return arrival_log.listed(connection, Asked(), *asked).items  # type: ignore[arg-type]


def test_refusals_alike_in_a_row_are_one_and_others_are_not(connection: Connection) -> None:
    for number in range(3):
        arrival_log.note(connection, REFUSED, NOW + number)
    for each in (
        TAKEN,
        TAKEN,
        REFUSED,
        replace(REFUSED, reason="another"),
        replace(REFUSED, sender="Drone 2"),
        REFUSED,
    ):
        arrival_log.note(connection, each, NOW + 9)
    found = [(each.sender, each.outcome, each.times) for each in items(connection)]
    assert found == [
        (DRONE, "refused", 1), ("Drone 2", "refused", 1), (DRONE, "refused", 1), (DRONE, "refused", 1),
        (DRONE, "taken", 1), (DRONE, "taken", 1), (DRONE, "refused", 3),
    ]  # fmt: skip
    assert items(connection)[-1].at.timestamp() == NOW + 2


def test_a_part_of_the_list_is_of_a_sender_a_lot_or_an_outcome(connection: Connection) -> None:
    for each in (TAKEN, REFUSED, replace(REFUSED, sender="")):
        arrival_log.note(connection, each, NOW)
    assert [each.lot for each in items(connection, DRONE)] == [None, ID]
    assert [each.sender for each in items(connection, "")] == [""]
    assert [(each.name, each.state) for each in items(connection, None, ID)] == [(ID, 7)]
    assert [each.sender for each in items(connection, None, None, "refused")] == ["", DRONE]
    first = arrival_log.listed(connection, Asked(limit=2))
    assert [each.seq for each in first.items] == [3, 2]
    assert [each.seq for each in arrival_log.listed(connection, Asked(after=first.next)).items] == [1]
    with pytest.raises(LotInputError, match="after: is no place in this list"):
        arrival_log.listed(connection, Asked(after="x"))


def test_the_oldest_go_and_a_stranger_moves_out_no_row_of_a_drone(
    connection: Connection, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(arrival_log, "MOST", 50)
    monkeypatch.setattr(arrival_log, "MOST_UNKNOWN", 10)
    for number in range(200):
        arrival_log.note(connection, replace(TAKEN, state=number), NOW)
    for number in range(200):
        arrival_log.note(connection, replace(REFUSED, sender="", name=str(number)), NOW)
    asked = select(func.count(), func.min(ARRIVAL.c.seq), func.max(ARRIVAL.c.seq))
    assert connection.execute(asked.where(ARRIVAL.c.sender == DRONE)).one() == (50, 151, 200)
    assert connection.execute(asked.where(ARRIVAL.c.sender == "")).one() == (10, 391, 400)


def test_what_was_erased_is_named_no_more(connection: Connection) -> None:
    connection.execute(ERASED.insert().values(id=erased_id(ID)))
    arrival_log.note(connection, replace(REFUSED, reason=f"survey.id: must be {ID}"), NOW)
    (row,) = connection.execute(select(ARRIVAL)).mappings().all()
    assert ID not in str(dict(row))
    assert row["name"] == ""


@pytest.mark.nightly
async def test_what_comes_is_logged_with_its_outcome_and_the_order_is_in_no_other_table(tmp_path: Path) -> None:
    drone = Drone.at(tmp_path / "drone.db")
    first = drone.add(survey())
    drone.send()
    drone.add(replace(survey(), ended=survey().ended + 60))
    drone.add(later(survey(seed=2), 2))
    drone.send()
    drone.store.close()
    early, late, other = drone.sent
    found, logged = [], []
    for order in ((early, late, other, other), (other, late, early)):
        store = LotStore(tmp_path / f"{len(order)}.db", pragmas=FAST, wall=lambda: NOW + 86_400.0)
        for data in order:
            await store.collect(data, survey_document.unpacked(data).survey.id, DRONE)
        found.append(await store.read(tables))
        logged.append([(each.name, each.outcome) for each in await store.read(items)][::-1])
        await store.close()
    assert found[0] == found[1]
    assert [outcome for _, outcome in logged[0]] == ["taken", "taken", "taken", "known"]
    assert [outcome for _, outcome in logged[1]] == ["taken", "taken", "older"]
    assert [name for name, _ in logged[0]][:2] == [first.survey] * 2
