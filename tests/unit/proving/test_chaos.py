from __future__ import annotations

import asyncio
import random
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from sqlalchemy import delete, select

from hawk.lots import outbox
from hawk.lots.storage.schema import OBSERVATION, SURVEY
from proving.chaos import link as link_module
from proving.chaos.drones import ChaosDrone, difference, reference
from proving.chaos.link import HOST, Link, LinkState
from tests.pace import PATIENCE_S

NOW = 1_770_000_000.0
ASKED, ANSWERED = b"a document", b"it is here"


class Desk:
    """A server that answers what it hears."""

    def __init__(self) -> None:
        self.heard: list[bytes] = []

    async def talk(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.heard.append(await reader.read(100))
        writer.write(ANSWERED)
        writer.close()


@pytest.fixture
def desk() -> Desk:
    return Desk()


@pytest.fixture
async def line(desk: Desk) -> AsyncIterator[tuple[Link, int]]:
    server = await asyncio.start_server(desk.talk, HOST, 0)
    link = Link(server.sockets[0].getsockname()[1], random.Random(1))
    yield link, await link.open()
    link.close()
    server.close()


async def asked(port: int) -> bytes:
    reader, writer = await asyncio.open_connection(HOST, port)
    writer.write(ASKED)
    try:
        async with asyncio.timeout(PATIENCE_S):
            return await reader.read(100)
    finally:
        writer.close()


async def test_a_good_link_lets_pass(line: tuple[Link, int], desk: Desk) -> None:
    assert await asked(line[1]) == ANSWERED
    assert desk.heard == [ASKED]


async def test_a_link_without_answers_is_heard_and_says_nothing(line: tuple[Link, int], desk: Desk) -> None:
    line[0].state = LinkState.NO_ANSWERS
    assert await asked(line[1]) == b""
    assert desk.heard == [ASKED]


async def test_a_bad_link_loses_a_share_of_the_connections(
    line: tuple[Link, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(link_module, "LATE_S", 0.0)
    monkeypatch.setattr(link_module, "_LONGEST_LIFE", 1)
    line[0].state = LinkState.BAD
    answers = []
    for _ in range(40):
        try:
            answers.append(await asked(line[1]))
        except ConnectionResetError:
            answers.append(b"")
    assert 0 < answers.count(b"") < 40
    assert answers.count(ANSWERED) > 10


async def test_a_desk_that_was_killed_ends_the_connection() -> None:
    server = await asyncio.start_server(lambda *_: None, HOST, 0)
    link = Link(server.sockets[0].getsockname()[1], random.Random(1))
    server.close()
    await server.wait_closed()
    assert await asked(await link.open()) == b""
    link.close()


# -- drones -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def drone(tmp_path: Path) -> ChaosDrone:
    made, rng = ChaosDrone("Drone 0", tmp_path / "00", 0), random.Random(5)
    for _ in range(8):
        made.change(rng, NOW)
    return made


@pytest.mark.slow
def test_a_desk_that_got_every_state_differs_in_nothing_and_one_that_lost_or_doubled_is_found(
    drone: ChaosDrone, tmp_path: Path
) -> None:
    wanted, desk = (reference([drone], tmp_path / name) for name in ("wanted.db", "desk.db"))
    assert drone.surveys > 3
    same = difference(desk, wanted)
    assert (same.surveys, same.lost, same.doubled, same.other_rows) == (drone.surveys, 0, 0, {})
    with desk.writing() as connection:
        first = select(OBSERVATION.c.stall).where(OBSERVATION.c.survey == 1).limit(3)
        connection.execute(delete(OBSERVATION).where(OBSERVATION.c.survey == 1, OBSERVATION.c.stall.in_(first)))
    found = difference(desk, wanted)
    assert (found.lost, found.doubled, found.other_rows) == (3, 0, {"observation": 3})
    assert difference(wanted, desk).doubled == 3


def test_all_is_sent_when_the_desk_has_noted_every_state(drone: ChaosDrone) -> None:
    later = NOW + 1e6
    while not drone.is_sent("desk", later):
        with drone.base.writing() as connection:
            message = outbox.due_state(connection, "desk", later)
            assert message is not None
            outbox.note_sent(connection, message, "desk", later)
    drone.change(random.Random(6), NOW)
    assert not drone.is_sent("desk", later)


def test_deletions_are_taken_back_for_the_recordings_of_what_was_deleted(drone: ChaosDrone) -> None:
    def deleted() -> int:
        with drone.base.reading() as connection:
            return len(connection.execute(select(SURVEY.c.id).where(SURVEY.c.lot.is_(None))).all())

    rng = random.Random(7)
    while not deleted():
        drone.change(rng, NOW)
    drone.change(rng, NOW)
    drone.take_back(NOW)
    assert not deleted()
