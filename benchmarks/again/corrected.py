"""The correction of a plan that a first survey has left, as a person makes it once by the lot's picture.

What is no stall is removed, what was not found is added at its place, and all is confirmed: operations of the editor.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection

from hawk.lots.plan import edits
from hawk.lots.plan.queries import all_stalls
from hawk.lots.registration.frames import Move
from hawk.lots.values import LotInputError
from hawk.worlds.world import World

Floats = NDArray[np.float64]
WHO: Final = "benchmark"
_WIDTHS: Final = (1.0, 0.9, 0.8, 0.7)


def correct(connection: Connection, lot: str, world: World, ids: Mapping[int, str], counted: Sequence[int]) -> int:
    """Correct the plan of a lot, and return the number of stalls that were removed and added.

    Args:
        connection: The store, in a transaction.
        lot: Id of the lot.
        world: The lot as the person sees it.
        ids: The stored stall that each true one was taken for.
        counted: True stalls that the picture shows whole: those of them that were not found are added.
    """
    held = edits.open_edit(connection, lot, {"who": WHO}, 0.0)["edit"]

    def do(operation: Mapping[str, Any]) -> None:
        edits.do(connection, lot, {"edit": held, "operation": operation}, 0.0)

    stored = {stall.id: stall for stall in all_stalls(connection, lot)}
    true = {stall.id: box_of(stall.corners, world.start()) for stall in world.stalls}
    pairs = [(true[number], stored[key]) for number, key in ids.items() if key in stored and number in true]
    move = fitted(
        np.array([(box[0], box[1]) for box, _ in pairs]), np.array([(each.north, each.east) for _, each in pairs])
    )
    false = sorted(stored.keys() - set(ids.values()))
    if false:
        do({"do": "remove", "stalls": false})
    missed = [number for number in counted if number not in ids]
    for number in missed:
        north, east, angle, width, length = true[number]
        ((north, east),) = move.of(np.array([(north, east)])).tolist()
        place = {"north": north, "east": east, "angle": (angle + move.turn) % np.pi}
        _add(do, {"do": "add_stall", **place, "length": length}, width)
    do({"do": "confirm", "all": True})
    edits.close(connection, lot, {"edit": held}, 0.0)
    return len(false) + len(missed)


def _add(do: Callable[[Mapping[str, Any]], None], asked: Mapping[str, Any], width: float) -> None:
    """Add a stall, narrower where a find beside it reaches into it."""
    for part in _WIDTHS[:-1]:
        with contextlib.suppress(LotInputError):
            do({**asked, "width": width * part})
            return
    do({**asked, "width": width * _WIDTHS[-1]})


def box_of(corners: Floats, start: tuple[float, float]) -> tuple[float, float, float, float, float]:
    """Return north and east about the start (metres), angle (radians), width and length of corners (4, 2) as (x, y)."""
    x, y = np.mean(corners, axis=0).tolist()
    sides = np.diff(corners[:3], axis=0)
    sizes = np.hypot(*sides.T)
    long = sides[int(np.argmax(sizes))]
    angle = float(np.arctan2(long[0], -long[1]) % np.pi)
    return start[1] - y, x - start[0], angle, float(sizes.min()), float(sizes.max())


def fitted(places: Floats, onto: Floats) -> Move:
    """Return the rigid move of places (N, 2) onto others with the least squares (Kabsch 1976)."""
    here, there = places.mean(0), onto.mean(0)
    a, b = places - here, onto - there
    turn = float(np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum()))
    north, east = (there - Move(turn=turn).of(here[None])[0]).tolist()
    return Move(north, east, turn)
