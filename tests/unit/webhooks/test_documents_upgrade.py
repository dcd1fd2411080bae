"""A day of traffic between a desk and a drone of which one is a version newer, and their upgrade: nothing is lost.

The newer program is the present one with documents of version 2, which hold one thing more. It reads both versions.
"""

from __future__ import annotations

import asyncio
import gzip
import json
import sqlite3
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from sqlalchemy import Connection, func, select

from hawk.config.sections import CollectSettings
from hawk.lots import commands
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import DELIVERY, OUTBOX
from hawk.lots.storage.states import KINDS
from hawk.web.v1.desk import documents as desk_answers
from hawk.webhooks import documents as drone_sender
from hawk.webhooks.delivery import SenderTimes
from hawk.webhooks.documents import DocumentSender
from tests.unit.lots.documents.drones import NOW, WHO, Drone, days
from tests.unit.lots.documents.exchange import meet, send
from tests.unit.lots.documents.tables import tables
from tests.unit.lots.plan.plans import FAST
from tests.unit.lots.surveys import survey
from tests.unit.webhooks.lines import Line, running
from tests.unit.webhooks.test_documents import edited

Tables = dict[str, list[str]]
HOUR_S = 3600.0
WEATHER = "rain"
DESK_IS_OLDER = "The desk {} is of an older hawk-drone: upgrade it. Surveys wait here."
DESK_IS_NEWER = "The desk {} is of a newer hawk-drone: upgrade this one. Lots wait there."
REMEDY = "version is 2, of a newer hawk-drone; who takes it in reads up to 1: upgrade that one"


@dataclass
class Newer:
    """The newer program: how it packs and reads documents, and what it read that version 1 has not."""

    weather: list[str] = field(default_factory=list)

    def packed(self, document: Any) -> bytes:
        found = json.loads(document.model_dump_json())
        return gzip.compress(json.dumps({**found, "version": 2, "weather": WEATHER}).encode(), mtime=0)

    def read(self, data: bytes) -> bytes:
        """Return a document of either version as version 1, and keep the rest."""
        found = json.loads(gzip.decompress(data))
        if found["version"] == 2:
            self.weather.append(found.pop("weather"))
        return gzip.compress(json.dumps({**found, "version": 1}).encode(), mtime=0)

    def reads(self, take: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function that takes documents in as this program does."""
        return lambda data, *given: take(self.read(data), *given)

    def sends_in(self, monkeypatch: pytest.MonkeyPatch, module: Any) -> None:
        """Let one end send documents as this program does."""
        monkeypatch.setattr(module, "parts", SimpleNamespace(packed=self.packed))


@dataclass
class Clock:
    now: float = field(default_factory=time.time)


def sender_of(line: Line, clock: Clock) -> DocumentSender:
    settings = CollectSettings(url=line.url, token_file=line.folder / "token")
    return DocumentSender(
        line.store, settings, lambda: clock.now, lambda: False,
        lambda level, text, details: line.said.append((str(text), details)), SenderTimes(look_s=0.01, try_s=20.0),
    )  # fmt: skip


def untried(connection: Connection) -> int:
    asked = select(func.count()).select_from(OUTBOX).where(OUTBOX.c.kind.in_(KINDS))
    return int(connection.execute(asked.where(OUTBOX.c.seq.not_in(select(DELIVERY.c.message)))).scalar_one())


async def until_none(count: Callable[[], Any]) -> None:
    async with asyncio.timeout(60):
        while await count():  # noqa: ASYNC110 - another thread writes it
            await asyncio.sleep(0.01)


def copied(path: Path, to: Path) -> Database:
    """Return a copy of a store."""
    with closing(sqlite3.connect(path)) as one, closing(sqlite3.connect(to)) as other:
        one.backup(other)
    return Database(to, FAST)


def in_one_version(drone: Path, desk: Path, folder: Path) -> list[Tables]:
    """Return the tables of desk and drone as they are once copies of both have met in one version."""
    theirs, here = copied(desk, folder / "desk copy.db"), Drone(copied(drone, folder / "drone copy.db"))
    meet(here, theirs)
    found = [tables_of(theirs), tables_of(here.store)]
    theirs.close()
    here.store.close()
    return found


def tables_of(store: Database) -> Tables:
    with store.reading() as connection:
        return tables(connection)


@pytest.mark.slow
@pytest.mark.fault(
    "the desk is a version older than the drone",
    "what it cannot read waits on the drone, which says so, and comes once the desk is upgraded",
)
async def test_an_older_desk_loses_nothing(line: Line, monkeypatch: pytest.MonkeyPatch) -> None:
    newer, clock = Newer(), Clock()
    newer.sends_in(monkeypatch, drone_sender)
    async with running(sender_of(line, clock)):
        for _ in days(line.drone):
            await until_none(lambda: line.store.read(untried))
    host = line.url.split("/")[2]
    assert line.said == [(DESK_IS_OLDER.format(host), f"answered HTTP 422: {REMEDY}")], "once, with the remedy"
    assert await line.surveys() == []
    assert await line.waiting() > len(line.drone.documents())

    monkeypatch.setattr(line.centre, "collect", newer.reads(line.centre.collect))
    monkeypatch.setattr(line.centre, "collect_lot", newer.reads(line.centre.collect_lot))
    clock.now += HOUR_S
    async with running(sender_of(line, clock)):
        await line.is_received()
    desk = Database(line.folder / "one version.db", FAST)
    send(line.drone, desk)
    assert await line.centre.read(tables) == tables_of(desk)
    desk.close()
    assert len(newer.weather) >= len(line.drone.documents()), "what version 1 has not came, too"
    assert len(line.said) == 1


@pytest.mark.slow
@pytest.mark.fault(
    "the desk is a version newer than the drone",
    "it takes all surveys; its lots wait there, which the drone says, and come once the drone is upgraded",
)
async def test_a_newer_desk_takes_everything_and_its_lots_wait_for_the_drone(
    line: Line, monkeypatch: pytest.MonkeyPatch
) -> None:
    newer, clock = Newer(), Clock()
    newer.sends_in(monkeypatch, desk_answers)
    monkeypatch.setattr(line.centre, "collect", newer.reads(line.centre.collect))
    monkeypatch.setattr(line.centre, "collect_lot", newer.reads(line.centre.collect_lot))
    lot = str(line.drone.add(survey()).lot)
    async with running(sender_of(line, clock)):
        await line.is_received()
        await line.centre.write(lambda c: commands.rename(c, lot, "Market", WHO, NOW))
        await line.centre.write(lambda c: edited(c, lot, {"do": "remove", "row": "B"}))
        for _ in days(line.drone):
            await line.is_received()
        await until_none(lambda: asyncio.sleep(0, not line.said))
    details = REMEDY.replace("version is", "version: is")
    assert line.said == [(DESK_IS_NEWER.format(line.url.split("/")[2]), details)], "once, with the remedy"
    assert "Market" not in await line.names()
    wanted = in_one_version(line.store.path, line.centre.path, line.folder)

    monkeypatch.setattr(line.store, "take_back", newer.reads(line.store.take_back))
    async with running(sender_of(line, clock)):
        async with asyncio.timeout(30):
            while "Market" not in await line.names():  # noqa: ASYNC110 - another thread writes it
                await asyncio.sleep(0.01)
        await line.is_received()
    assert WEATHER in newer.weather
    found = [await each.read(tables) for each in (line.centre, line.store)]
    for each in (*found, *wanted):
        del each["lot_document"]  # it holds numbers of states, which rise with each document
    assert found == wanted
