"""Any sequence of operations, undo and redo: what holds of every plan."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import select

from hawk.lots.plan import geometry
from hawk.lots.plan.kinds import KINDS
from hawk.lots.plan.values import Floats
from hawk.lots.storage.schema import STALL
from hawk.lots.values import LotStoreError
from tests.examples import examples
from tests.unit.lots.plan.plans import Json, Person

STALLS, MOST_OVERLAP = 12, 0.10
METRES = st.floats(-30.0, 40.0)
SHIFT = st.floats(-12.0, 12.0)
PLACE = st.tuples(METRES, METRES).map(list)
LETTERS = st.sampled_from("ABCDEK")
SOME = st.lists(st.integers(0, 40), min_size=1, max_size=4, unique=True)
"""Numbers of stalls, which the test turns into ids of the plan."""


def operation(**fields: st.SearchStrategy[Any]) -> st.SearchStrategy[Json]:
    return st.fixed_dictionaries(fields)


def do(name: str, /, **fields: st.SearchStrategy[Any]) -> st.SearchStrategy[Json]:
    return operation(do=st.just(name), **fields)


SIZES = {"width": st.floats(1.0, 3.0), "length": st.floats(2.5, 8.0)}


@st.composite
def rows(draw: st.DrawFn) -> Json:
    """Draw a row of up to eight stalls, most of which can be drawn."""
    (north, east), heading, count = draw(PLACE), draw(st.floats(-math.pi, math.pi)), draw(st.integers(1, 8))
    along = (math.cos(heading), math.sin(heading))
    length, depth, double = count * draw(st.floats(2.0, 3.0)), draw(st.floats(4.0, 6.0)), draw(st.booleans())
    far = depth * (2 if double else 1)
    return {
        "do": "add_row",
        "front": [[north, east], [north + length * along[0], east + length * along[1]]],
        "far": [north - far * along[1], east + far * along[0]],
        "lean": draw(st.floats(-0.7, 0.7)),
        "double": double,
        "count": count,
    }


KERBS, SIDES = st.sampled_from(["", "parallel", "across"]), st.sampled_from(["left", "right"])
OPERATIONS = st.one_of(
    do("add_stall", north=METRES, east=METRES, angle=st.floats(0, 3), **SIZES),
    rows(),
    do("remove", stalls=SOME),
    do("move", stalls=SOME, north=SHIFT, east=SHIFT),
    do("move", row=LETTERS, north=SHIFT, east=SHIFT),
    do("turn", stalls=SOME, by=st.floats(-math.pi, math.pi), about=st.sampled_from(["each", "middle"])),
    do("turn", row=LETTERS, by=st.floats(-math.pi, math.pi)),
    do("widen", stalls=SOME, **SIZES),
    do("split", stall=st.integers(0, 40), parts=st.integers(2, 4)),
    do("renumber", row=LETTERS, letter=LETTERS, first=st.integers(0, 30)),
    do("renumber", stalls=SOME, letter=LETTERS, first=st.integers(0, 30)),
    do("renumber", stalls=SOME, labels=st.just(["P 1", "B 2", "B 3", "X"])),
    do("rename", row=LETTERS, to=st.sampled_from(["A", "B", "Q", "North"])),
    do("rename", stalls=SOME, to=LETTERS),
    do("reverse", row=LETTERS),
    do("reverse", stalls=SOME),
    do("shift", row=LETTERS, by=st.integers(-2, 3)),
    do("shift", stalls=SOME, by=st.integers(-2, 3)),
    do("swap", rows=st.tuples(LETTERS, LETTERS).map(list)),
    do("set_kind", stalls=SOME, kind=st.sampled_from(sorted(KINDS))),
    do("forbid", outline=st.lists(PLACE, min_size=3, max_size=4)),
    do("allow", zone=st.integers(0, 3)),
    do("draw_zone", outline=st.lists(PLACE, min_size=3, max_size=4), name=LETTERS),
    do("erase_zone", zone=st.integers(0, 3)),
    do("draw_section", name=LETTERS, outline=st.lists(PLACE, min_size=3, max_size=4), kind=KERBS),
    do("draw_section", name=LETTERS, line=st.lists(PLACE, min_size=2, max_size=3), side=SIDES, width=st.just(2.2)),
    do("change_section", section=st.integers(0, 3), name=LETTERS, kind=KERBS, capacity=st.none() | st.integers(1, 9)),
    do("remove_section", section=st.integers(0, 3)),
    do("confirm", row=LETTERS),
    do("confirm", stalls=SOME),
)
ACTS = st.lists(
    st.one_of(OPERATIONS, OPERATIONS, st.sampled_from(["undo", "redo", "close", "undo edit"])), min_size=6, max_size=16
)


@contextmanager
def a_person() -> Iterator[Person]:
    with tempfile.TemporaryDirectory() as folder:
        person = Person.at_work(Path(folder) / "lots.db", STALLS)
        try:
            yield person
        finally:
            person.store.close()


def with_ids(person: Person, asked: Json) -> Json:
    """Return an operation whose numbers are ids of the plan, where the plan has as many."""
    plan = person.plan()
    ids = [each["id"] for each in plan["stalls"]]
    zones = [each["id"] for each in (*plan["zones"], *plan["named_zones"])]
    named = dict(asked)
    sections = [each["id"] for each in plan["sections"]]
    for field, known in (("stalls", ids), ("stall", ids), ("zone", zones), ("section", sections)):
        value = named.get(field)
        if isinstance(value, list):
            named[field] = list(dict.fromkeys(known[n % len(known)] for n in value)) if known else ["none"]
            if "labels" in named:
                named["labels"] = named["labels"][: len(named[field])]
        elif value is not None:
            named[field] = known[value % len(known)] if known else "none"
    return named


class Ledger:
    """All ids that were ever seen, with their keys."""

    def __init__(self) -> None:
        self.keys: dict[str, int] = {}

    def check(self, person: Person) -> None:
        plan = person.plan()
        shapes = geometry.normal(_shapes(plan["stalls"]))
        worst = geometry.overlaps(shapes, shapes[:0], MOST_OVERLAP + 1e-5)
        assert worst == []
        labels = [each["label"] for each in plan["stalls"]]
        assert len(set(labels)) == len(labels)
        assert all(labels)
        with person.store.reading() as connection:
            keys = {row.id: row.key for row in connection.execute(select(STALL.c.id, STALL.c.key))}
        assert keys.items() >= self.keys.items()
        assert len({*keys.values()}) == len(keys)
        self.keys = keys
        names = [each["name"] for each in plan["sections"]]
        assert len(set(names)) == len(names)
        for zone in plan["zones"]:
            ring = tuple((a, b) for a, b in zone["outline"])
            assert not any(geometry.within(ring, shapes[:, :2]))


def _shapes(stalls: list[Json]) -> Floats:
    names = ("north", "east", "angle", "width", "length")
    return np.array([[each[name] for name in names] for each in stalls], float).reshape(-1, 5)


@pytest.mark.nightly
@settings(
    max_examples=examples(20), deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
@given(ACTS)
def test_any_edit_keeps_ids_for_ever_labels_apart_and_no_stall_on_another(acts: list[Any]) -> None:
    with a_person() as person:
        closed: list[int] = []
        ledger, first = Ledger(), person.plan(layout=1)
        for act in acts:
            before = person.shown()
            try:
                answer = _done(person, act, closed)
            except LotStoreError:
                assert person.shown() == before
                continue
            if isinstance(act, dict) and answer["undo"]:
                _check_undo_and_redo(person, before, answer)
            ledger.check(person)
            assert person.plan(layout=1) == first


def _done(person: Person, act: Any, closed: list[int]) -> Json:
    if isinstance(act, dict):
        return person.operate(with_ids(person, act))
    if act == "undo":
        return person.undo()
    if act == "redo":
        return person.redo()
    changed = person.close()
    if changed["seq"] is not None:
        closed.append(changed["seq"])
    if act == "undo edit" and closed:
        person.undo_change(closed.pop())
    person.open()
    return {}


def _check_undo_and_redo(person: Person, before: Json, answer: Json) -> None:
    """Undo an operation that changed something, and do it again."""
    after = person.shown()
    if after == before:
        return
    person.undo()
    assert person.shown() == before
    person.redo()
    assert person.shown() == after
