"""The correction of a plan that a first survey has left, as a person makes it once by the lot's picture.

What is no stall is removed, and what was not found is added at its place: operations of the editor.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from sqlalchemy import Connection

from benchmarks.perception.boxes import Boxes, Floats
from benchmarks.world_lots import north_east
from hawk.lots.plan import edits
from hawk.lots.plan.answers import Edited
from hawk.lots.plan.queries import all_stalls
from hawk.lots.registration.frames import Move
from hawk.lots.values import LotInputError
from hawk.worlds.world import World

WHO: Final = "benchmark"
_WIDTHS: Final = (1.0, 0.9, 0.8, 0.7, 0.55)
"""Shares of its width with which a stall is tried, where a find beside it reaches into it."""
Do = Callable[..., Edited]
Shape = tuple[float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Corrected:
    """The true stall of each stored one, by its id, and how many stalls were removed and added."""

    true: Mapping[str, int]
    removed: int
    added: int


@contextlib.contextmanager
def edited(connection: Connection, lot: str, at: float = 0.0) -> Iterator[Do]:
    """Open a lot's plan to a person; gives what does an operation."""
    edit = edits.open_edit(connection, lot, {"who": WHO}, at).edit
    yield lambda **operation: edits.do(connection, lot, {"edit": edit, "operation": operation}, at)
    edits.close(connection, lot, {"edit": edit, "why": "corrected"}, at)


def correct(
    connection: Connection, lot: str, do: Do, world: World, true: Mapping[str, int], wanted: Collection[int]
) -> Corrected:
    """Correct the plan of a lot.

    Args:
        connection: The store, in a transaction.
        lot: Id of the lot.
        do: Does an operation (`edited`).
        world: The lot as the person sees it.
        true: The true stall that each stored one was taken for, by its id.
        wanted: True stalls that are to be in the plan.
    """
    stored = {stall.id: stall for stall in all_stalls(connection, lot)}
    shapes = shapes_of(world)
    pairs = [(shapes[number], stored[key]) for key, number in true.items() if key in stored and number in shapes]
    move = fitted(
        np.array([(shape[0], shape[1]) for shape, _ in pairs]), np.array([(each.north, each.east) for _, each in pairs])
    )
    false = sorted(stored.keys() - true.keys())
    if false:
        do(do="remove", stalls=false)
    missed = [number for number in wanted if number not in true.values()]
    added = {_added(do, shapes[number], move): number for number in missed}
    return Corrected({**true, **added}, len(false), len(missed))


def _added(do: Do, shape: Shape, move: Move) -> str:
    """Add a stall, narrower where a find beside it reaches into it; return its id."""
    ((north, east),) = move.of(np.array([shape[:2]])).tolist()
    angle, width, length = (shape[2] + move.turn) % np.pi, shape[3], shape[4]
    place = {"do": "add_stall", "north": north, "east": east, "angle": angle, "length": length}
    for part in _WIDTHS[:-1]:
        with contextlib.suppress(LotInputError):
            return str(do(**place, width=width * part).stalls[0].id)
    return str(do(**place, width=width * _WIDTHS[-1]).stalls[0].id)


def shapes_of(world: World) -> dict[int, Shape]:
    """Return north and east about the start (metres), angle (radians), width and length of each stall, by its id."""
    corners = north_east(np.array([stall.corners for stall in world.stalls]).reshape(-1, 4, 2), world.start())
    boxes = Boxes.of(corners)
    angle = np.arctan2(boxes.along[:, 1], boxes.along[:, 0]) % np.pi
    table = np.column_stack([boxes.centre, angle, boxes.width, boxes.length]).tolist()
    return {stall.id: (n, e, a, w, le) for stall, (n, e, a, w, le) in zip(world.stalls, table, strict=True)}


def fitted(places: Floats, onto: Floats) -> Move:
    """Return the rigid move of places (N, 2) onto others with the least squares (Kabsch 1976)."""
    here, there = places.mean(0), onto.mean(0)
    a, b = places - here, onto - there
    turn = float(np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum()))
    north, east = (there - Move(turn=turn).of(here[None])[0]).tolist()
    return Move(north, east, turn)
