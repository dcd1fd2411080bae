"""A studied lot in a store: its surveys through the daemon's registration, its plan corrected after the first one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, select

from benchmarks.lots.looks import Look, StillEye
from benchmarks.lots.visits import Visit
from benchmarks.study.visits import CLOCK, DAY, StudyLot
from hawk.daemon.lot_keeper import find_stalls
from hawk.lots.ingest import save
from hawk.lots.plan import edits
from hawk.lots.registration.frames import Move
from hawk.lots.schema import STALL
from hawk.lots.storage.database import Database
from hawk.lots.values import LotInputError, Placed, Saved
from hawk.stats.panel import Period, read_panel
from hawk.stats.values import Panel
from hawk.worlds.world import TrueStall, World

_FAST: Final = {"synchronous": 0}
WHO: Final = "study"
ZONES: Final = ("East", "West")
_NARROWER: Final = (1.0, 0.85, 0.7, 0.55)


@dataclass(frozen=True, slots=True)
class Studied:
    """A lot with its surveys: ``true`` is the true stall of each stored one, by its id."""

    name: str
    world: World = field(repr=False)
    panel: Panel = field(repr=False)
    true: dict[str, int] = field(repr=False)
    doubts: tuple[str, ...]


def study(
    lot: StudyLot, eye: StillEye, folder: Path, most: int | None = None, say: Callable[[str], None] = print
) -> Studied:
    """Survey a lot, and return the panel of its store. ``most``: surveys after the mapping flight."""
    store = Database(folder / "lots.db", _FAST)
    try:
        first, *visits = lot.visits(most)
        world = lot.world(first)
        saved, look = _saved(store, lot, eye, first)
        assert saved.lot is not None, "the mapping flight made no lot"
        with store.writing() as connection:
            true = correct(connection, saved.lot, world, look, first)
        doubts = []
        for visit in visits:
            saved, _ = _saved(store, lot, eye, visit)
            if saved.placed is not Placed.REGISTERED:
                doubts.append(f"{visit.number}: {saved.doubt or saved.placed.value}")
            at = visit.at.astimezone(CLOCK)
            say(f"{lot.name}: survey {visit.number} at {at:%a %H:%M}, {saved.known} known stalls")
        with store.reading() as connection:
            panel = read_panel(connection, saved.lot or "", Period(DAY.timestamp(), None, CLOCK, str(CLOCK)))
        return Studied(lot.name, world, panel, true, tuple(doubts))
    finally:
        store.close()


def _saved(store: Database, lot: StudyLot, eye: StillEye, visit: Visit) -> tuple[Saved, Look]:
    look = eye.look(lot.world(visit), visit, None)
    with store.writing() as connection:
        return save(connection, look.survey, find_stalls), look


def correct(connection: Connection, lot: str, world: World, look: Look, visit: Visit) -> dict[str, int]:
    """Correct the plan as a person does on the page, and draw two zones; return the true stall of each, by its id.

    Finds that are no stalls are removed, stalls that were not found are added, and accessible ones get their kind.
    """
    true = _true_stalls(connection, lot, look)
    edit = edits.open_edit(connection, lot, {"who": WHO}, visit.at.timestamp())["edit"]

    def do(**operation: Any) -> dict[str, Any]:
        return edits.do(connection, lot, {"edit": edit, "operation": operation}, visit.at.timestamp())

    present = set(connection.execute(select(STALL.c.id).where(STALL.c.lot == lot, STALL.c.ends.is_(None))).scalars())
    if wrong := sorted(present - true.keys()):
        do(do="remove", stalls=wrong)
    frame = on_map(world, visit)
    for stall in world.stalls:
        if stall.id in true.values() or stall.closed:
            continue
        true[_added(do, frame(stall))] = stall.id
    kinds = {stall.id: stall.kind for stall in world.stalls}
    if accessible := [each for each, number in true.items() if kinds[number] == "accessible"]:
        do(do="set_kind", stalls=accessible, kind="disabled")
    places = np.array(connection.execute(select(STALL.c.north, STALL.c.east).where(STALL.c.lot == lot)).all())
    (south, west), (north, east) = places.min(axis=0) - 5, places.max(axis=0) + 5
    middle = float(np.median(places[:, 1]))
    for name, ends in zip(ZONES, ((middle, east), (west, middle)), strict=True):
        ring = [[a, b] for a, b in ((south, ends[0]), (north, ends[0]), (north, ends[1]), (south, ends[1]))]
        do(do="draw_zone", name=name, outline=[[float(a), float(b)] for a, b in ring])
    edits.close(connection, lot, {"edit": edit, "why": "corrected"}, visit.at.timestamp())
    return true


def _added(do: Callable[..., dict[str, Any]], shape: tuple[float, ...]) -> str:
    """Add a stall and return its id: a narrower one where the neighbours that vision found are too wide."""
    for share in _NARROWER:
        north, east, angle, width, length = shape
        try:
            done = do(do="add_stall", north=north, east=east, angle=angle, width=share * width, length=length)
        except LotInputError:
            if share == _NARROWER[-1]:
                raise
        else:
            return str(done["stalls"][0]["id"])
    raise AssertionError("no share is left")


def _true_stalls(connection: Connection, lot: str, look: Look) -> dict[str, int]:
    rows = connection.execute(select(STALL.c.id, STALL.c.first_id).where(STALL.c.lot == lot)).all()
    return {row.id: look.true[row.first_id] for row in rows if row.first_id in look.true}


def on_map(world: World, visit: Visit) -> Callable[[TrueStall], tuple[float, float, float, float, float]]:
    """Return what gives a true stall's north, east, angle, width and length on the map of a survey, with its errors."""
    x, y = world.start()
    middle = np.array([[y - world.size_m[1] / 2, world.size_m[0] / 2 - x]])
    ((north, east),) = (middle - Move(turn=visit.compass).of(middle)).tolist()
    move = Move(north, east, visit.compass)

    def shape(stall: TrueStall) -> tuple[float, float, float, float, float]:
        corners: NDArray[np.float64] = move.of(np.column_stack([y - stall.corners[:, 1], stall.corners[:, 0] - x]))
        across, along = corners[1] - corners[0], corners[2] - corners[1]
        a, b = corners.mean(axis=0).tolist()
        angle = float(np.arctan2(along[1], along[0]) % np.pi)
        return a, b, angle, float(np.hypot(*across)), float(np.hypot(*along))

    return shape
