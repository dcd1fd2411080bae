"""All that a store says of a lot after each thing that happens to it, to the last decimal that is shown."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Connection, select

from hawk.lots import commands, lists, queries
from hawk.lots.known_lot import known_lot, lots_ahead
from hawk.lots.lists import Asked
from hawk.lots.storage.schema import OUTBOX
from hawk.lots.storage.states import KINDS
from hawk.results.survey_map import to_global
from tests.golden import NamedIds, check_values
from tests.unit.lots import whole
from tests.unit.lots.repaints import NOW, Archive, extra, flown, without
from tests.unit.lots.surveys import DATUM, box, later, survey

HERE = Path(__file__).parent / "drawn_life"
WHO = "operator"


class Life(Archive):
    """A store whose ids are named by the order in which they are shown."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.plain = NamedIds().plain

    def ask(self, read: Callable[[Connection], Any]) -> Any:
        with self.store.reading() as connection:
            return self.plain(read(connection))

    def do(self, change: Callable[..., Any], *asked: object) -> int:
        with self.store.writing() as connection:
            return int(change(connection, *asked, WHO, NOW).seq)

    def lots(self) -> Any:
        """Return every lot with what belongs to it."""
        return self.ask(lambda c: [whole.lot(c, each["id"]) for each in whole.lots(c)])

    def rest(self) -> Any:
        """Return what is said beside the lots."""
        return self.ask(
            lambda c: {
                "changes": lists.changes(c, whole.ALL),
                "proposed": [queries.proposed(c, each["id"]) for each in whole.lots(c)],
                "observations": lists.observations(c, Asked(limit=12, newest_first=True)),
                "without_lot": [each for each in whole.surveys(c) if each["lot"] is None],
            }
        )


@pytest.fixture
def life(tmp_path: Path) -> Life:
    made = Life(tmp_path / "lots.db")
    made.add(flown(1))
    return made


def point(north: float, east: float, to: tuple[float, float]) -> dict[str, list[float]]:
    places = to_global(DATUM, np.array([(north, east), to])).tolist()
    return {"from": places[0], "to": places[1]}


@pytest.mark.nightly
def test_surveys_and_what_they_propose(life: Life) -> None:
    life.add(extra(without(flown(2), 7, 44)))
    last = life.add(extra(without(flown(3), 7)))
    found = {"before": [life.lots(), life.rest()]}
    life.take_over(last.survey, begin="all")
    life.drop(last.survey, end="all")
    check_values(HERE / "surveys.json", found | {"after": [life.lots(), life.rest()]}, digits=8)


@pytest.mark.slow
def test_edits_of_a_plan(life: Life) -> None:
    of = life.stalls()
    life.edit(
        {"do": "set_kind", "row": "B", "kind": "disabled"},
        {"do": "rename", "row": "A", "to": "P"},
        {"do": "reverse", "row": "B"},
        {"do": "shift", "row": "C", "by": 5},
        {"do": "add_row", "front": [[20.0, 0.0], [20.0, 25.0]], "far": [25.0, 0.0], "lean": 0.3},
        {"do": "add_row", "front": [[40.0, 0.0], [40.0, 25.0]], "far": [50.0, 0.0], "count": 8, "double": True},
        {"do": "add_row", "front": [[60.0, 0.0], [60.0, 25.0]], "far": [62.5, 0.0], "parallel": True},
        {"do": "add_stall", "north": 80.0, "east": 3.0, "angle": 0.3, "width": 2.5, "length": 5.0, "label": "Gate"},
        {"do": "move", "stalls": [of["A 20"]], "north": 0.5, "east": 2.0},
        {"do": "turn", "stalls": [of["A 19"]], "by": 0.1, "about": "each"},
        {"do": "turn", "row": "C", "by": 0.05},
        {"do": "widen", "stalls": [of["A 20"]], "width": 2.7, "length": 5.2},
        {"do": "split", "stall": of["B 1"], "parts": 2},
        {"do": "swap", "rows": ["B", "C"]},
        {"do": "renumber", "stalls": [of["A 3"], of["A 4"]], "labels": ["North 1", "North 2"]},
        {"do": "confirm", "stalls": [of["A 5"]]},
        {"do": "draw_zone", "outline": [[-5, -5], [-5, 20], [5, 20], [5, -5]], "name": "Front", "kind": "bus"},
        {"do": "forbid", "outline": [[-20, 30], [-20, 60], [-14, 60], [-14, 30]], "name": "Works"},
    )
    plans = life.ask(
        lambda c: [
            queries.plan(c, life.lot), queries.plan(c, life.lot, layout=1), queries.plan(c, life.lot, since=5),
            lists.stalls_of_layout(c, life.lot, 1, Asked(limit=7, after="3")),
            lists.stalls(c, life.lot, Asked(limit=5), row="P"), lists.stalls(c, life.lot, whole.ALL, kind="bus"),
            lists.stalls(c, life.lot, Asked(limit=3), state="free"),
        ]
    )  # fmt: skip
    life.add(without(flown(2), 3, 44))
    check_values(HERE / "edits.json", {"plans": plans, "lots": life.lots(), "rest": life.rest()}, digits=8)


@pytest.mark.nightly
def test_changes_of_lots_and_their_undo(life: Life) -> None:
    life.add(flown(2))
    away = replace(DATUM, longitude=5.01)
    far = replace(later(survey(stalls=20, seed=9), 3), datum=away, outline=box(-5, -3, 20, 54, away))
    other = life.add(replace(far, seen_ground=box(-9, -9, 20, 70, away)), lambda *_: pytest.fail("it is another lot"))
    found: dict[str, Any] = {}
    with life.store.writing() as connection:
        moved = commands.pin(connection, life.lot, {"points": [point(0.0, 0.0, (1.23456, -0.98765))]}, WHO, NOW)
        commands.undo(connection, moved.seq, NOW)
    assert (moved.north, moved.east, moved.turn, moved.residual) == (1.235, -0.988, 0.0, 0.0)
    begin = [each["name"] for each in life.lots()]
    outline = [list(corner) for corner in box(-30, -5, 22, 70).polygons[0]]
    turned = [point(0.0, 0.0, (0.8, -0.4)), point(0.0, 50.0, (1.3, 49.7))]
    done = [
        life.do(commands.rename, life.lot, " Old  yard "),
        life.do(commands.choose_time_zone, life.lot, "Asia/Tokyo"),
        life.do(commands.pin, life.lot, {"points": turned}),
    ]
    found["pinned"] = [life.lots(), life.ask(lambda c: asdict(known_lot(c, life.lot, (52.0, 5.0))))]
    done.append(life.do(commands.split, life.lot, {"name": "Back", "outline": outline}))
    found["split"] = life.lots()
    done.append(life.do(commands.merge, life.lot, str(other.lot)))
    found["merged"] = [life.lots(), life.rest()]
    for seq in reversed(done):
        with life.store.writing() as connection:
            commands.undo(connection, seq, NOW)
    assert [each["name"] for each in life.lots()] == begin
    check_values(HERE / "lots.json", found, digits=8)


@pytest.mark.nightly
def test_surveys_that_move_and_go(life: Life) -> None:
    second, third = life.add(flown(2)), life.add(flown(3))
    with life.store.writing() as connection:
        commands.move(connection, third.survey, {"lot": None}, WHO, NOW, None)
    assert [each["name"] for each in life.lots()] == ["Lot 1", "Lot 2"]
    life.do(commands.delete, second.survey)
    ahead = life.ask(lambda c: [asdict(each) for each in lots_ahead(c, (52.0001, 5.0))])
    messages = life.ask(
        lambda c: [
            [row.kind, row.body]
            for row in c.execute(select(OUTBOX).where(OUTBOX.c.kind.not_in(KINDS)).order_by(OUTBOX.c.seq))
        ]
    )
    found = {"lots": life.lots(), "rest": life.rest(), "ahead": ahead, "messages": messages}
    check_values(HERE / "moved.json", found, digits=8)
    assert not math.isnan(found["lots"][0]["datum"][0])


@pytest.mark.slow
def test_every_list_read_part_by_part_is_the_whole_one(life: Life) -> None:
    life.add(flown(2))
    life.edit({"do": "set_kind", "row": "B", "kind": "bus"}, {"do": "shift", "row": "C", "by": 1})
    life.do(commands.rename, life.lot, "Yard")
    reads: list[tuple[Callable[..., Any], dict[str, Any]]] = [
        (lists.lots, {}), (lists.surveys, {}), (lists.changes, {}), (lists.observations, {"lot_id": life.lot}),
        (lists.stalls, {"lot_id": life.lot}), (lists.layouts, {"lot_id": life.lot}),
        (lists.zones, {"lot_id": life.lot}),
    ]  # fmt: skip
    with life.store.reading() as connection:
        for read, more in reads:
            for newest_first in (False, True) if read in (lists.surveys, lists.observations) else (False,):
                whole_list = read(connection, asked=Asked(limit=1000, newest_first=newest_first), **more)
                parts, after = [], None
                while True:
                    part = read(connection, asked=Asked(limit=7, after=after, newest_first=newest_first), **more)
                    parts += part.items
                    assert len(part.items) <= 7
                    if (after := part.next) is None:
                        break
                assert parts == list(whole_list.items), read.__name__
                assert whole_list.next is None
