"""Two drones and a desk live for some days; documents are exchanged late, twice, cut, and programs end in between."""

from __future__ import annotations

import contextlib
import random
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import Connection, select

from hawk.daemon.lots.keeper import find_stalls
from hawk.lots import commands
from hawk.lots.documents import lot_document, source
from hawk.lots.documents.lot_document import plan_digest
from hawk.lots.registration.lot_pair import pairs_of
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import CHANGE, LOT, STALL, SURVEY
from hawk.lots.storage.states import LOT_STATE
from hawk.lots.values import LotInputError, LotStoreError
from tests.examples import examples
from tests.unit.lots.documents.drones import WHO, Drone
from tests.unit.lots.documents.exchange import ask, documents_to_send, meet, take
from tests.unit.lots.plan.plans import FAST
from tests.unit.lots.surveys import box, later, survey

NAMES = ("Drone 1", "Drone 2")
_PART = [list(corner) for corner in box(-4, -4, 9, 26).polygons[0]]


class Days:
    """Stores of two drones and a desk, and each document that went to the desk."""

    def __init__(self, folder: Path, chance: random.Random) -> None:
        self.drones = {name: Drone.at(folder / f"{name}.db") for name in NAMES}
        self.desk = Drone.at(folder / "desk.db")
        self.chance = chance
        self.days = 0
        self.sent: list[tuple[str, bytes, str]] = []

    def close(self) -> None:
        for each in (*self.drones.values(), self.desk):
            each.store.close()

    def act(self) -> None:
        """Let one thing happen at one end."""
        where = self.chance.choice([*self.drones.values(), self.desk])
        self.days += 1
        where.now += 60.0 * self.days
        acts = (self._fly, self._edit, self._edit, self._rename, self._split, self._merge, self._undo)
        does = self.chance.choice(acts)
        with contextlib.suppress(LotInputError, LotStoreError):  # there is nothing to do it with
            does(where)

    def _lots(self, where: Drone) -> list[str]:
        asked = select(LOT.c.id).where(LOT.c.merged_into.is_(None)).order_by(LOT.c.id)
        return list(where.do(lambda connection: connection.execute(asked).scalars().all()))

    def _fly(self, where: Drone) -> None:
        if where is not self.desk:
            stalls = self.chance.choice([40, 60])
            where.add(later(survey(seed=self.days, stalls=stalls), 100 * (where is self.drones[NAMES[0]]) + self.days))

    def _edit(self, where: Drone) -> None:
        lots = self._lots(where)
        if lots:
            row, to = self.chance.choice("ABCXY"), self.chance.choice("XYZ")
            operation = self.chance.choice([{"do": "remove", "row": row}, {"do": "rename", "row": row, "to": to}])
            where.edit(self.chance.choice(lots), operation)

    def _rename(self, where: Drone) -> None:
        lots = self._lots(where)
        if lots:
            where.do(commands.rename, self.chance.choice(lots), f"Name {self.days}", WHO, where.now)

    def _split(self, where: Drone) -> None:
        lots = self._lots(where)
        if lots:
            asked = {"name": f"Part {self.days}", "outline": _PART}
            where.do(commands.split, self.chance.choice(lots), asked, WHO, where.now)

    def _undo(self, where: Drone) -> None:
        asked = select(CHANGE.c.seq).where(CHANGE.c.state == "done", CHANGE.c.edit.is_(None))
        newest = where.do(lambda c: c.execute(asked.order_by(CHANGE.c.seq.desc()).limit(1)).scalar())
        if newest is not None:
            where.do(commands.undo, newest, where.now)

    def _merge(self, where: Drone) -> None:
        lots = self._lots(where)
        if len(lots) > 1:
            where.do(commands.merge, *self.chance.sample(lots, 2), WHO, where.now)

    def exchange(self) -> None:
        """Let documents go from a drone to the desk or back, with faults."""
        name = self.chance.choice(NAMES)
        drone = self.drones[name]
        if self.chance.random() < 0.5:
            ask(drone, self.desk.store, limit=self.chance.choice([1, 3]))
            return
        documents = documents_to_send(drone)
        for kind, _, data in self.chance.sample(documents, len(documents) // 2):
            self.sent.append((kind, data, name))  # the answer is lost: it is sent again later
            self._take(kind, data, name)
        for _ in range(2):
            if self.sent:
                self._take(*self.chance.choice(self.sent))  # an old one, once more

    def meet(self) -> None:
        """Let everything come to everybody."""
        for _ in range(3):
            for name, drone in self.drones.items():
                meet(drone, self.desk.store, name)

    def join(self) -> None:
        """Merge lots that were made apart on the same ground, as the desk proposes it."""
        for lot in self._lots(self.desk):
            for other in self.desk.do(pairs_of, lot) if lot in self._lots(self.desk) else ():
                self.desk.do(commands.merge, lot, other.lot, WHO, self.desk.now, find_stalls)

    def _take(self, kind: str, data: bytes, name: str) -> None:
        if data and self.chance.random() < 0.2 and kind == LOT_STATE:
            with pytest.raises(LotInputError):
                lot_document.unpacked(data[: self.chance.randrange(len(data))])
        if data and self.chance.random() < 0.2:
            with pytest.raises(KeyboardInterrupt), self.desk.store.writing() as connection:
                _interrupted(connection)
            path = self.desk.store.path
            self.desk.store.close()
            self.desk.store = Database(path, FAST)
        take(self.desk.store, kind, data, name)


def _interrupted(connection: Connection) -> None:
    connection.execute(LOT.delete().where(LOT.c.id == "none"))
    raise KeyboardInterrupt


def plans(where: Drone) -> dict[str, tuple[str, Any]]:
    """Return each lot's plan, and its name."""
    with where.store.reading() as connection:
        found = {}
        for lot in connection.execute(select(LOT.c.id)).scalars():
            part = source.lot_part(connection, lot)
            found[lot] = (plan_digest(part), part.name)
    return found


@pytest.mark.slow
@pytest.mark.fault(
    "plans are changed on two drones and at the desk while documents come late, twice, cut, and programs end",
    "all three stores have the desk's plans in the end, and no look is lost",
)
@settings(
    max_examples=examples(16),
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(seed=st.integers(0, 10**6))
def test_two_drones_and_a_desk_end_with_the_same_plans(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    chance = random.Random(seed)
    days = Days(tmp_path_factory.mktemp("days"), chance)
    days.drones[NAMES[0]].add(survey())
    for _ in range(12):
        chance.choice([days.act, days.act, days.exchange])()
    days.meet()
    days.join()
    days.meet()
    wanted = plans(days.desk)
    for drone in days.drones.values():
        assert plans(drone) == wanted
        assert documents_to_send(drone) == []
    before = wanted
    for kind, data, name in days.sent:
        take(days.desk.store, kind, data, name)
    assert plans(days.desk) == before, "documents of before change nothing"
    _check_surveys(days)
    days.close()


def _check_surveys(days: Days) -> None:
    asked = select(SURVEY.c.id)
    theirs = [each for drone in days.drones.values() for each in drone.do(lambda c: c.execute(asked).scalars().all())]
    assert Counter(theirs) == Counter(days.desk.do(lambda c: c.execute(asked).scalars().all()))
    for where in (days.desk, *days.drones.values()):
        names = where.do(lambda c: c.execute(select(STALL.c.id)).scalars().all())
        assert len(names) == len(set(names))
