"""A studied lot in a store: its surveys through the daemon's registration, its plan corrected after the first one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
from sqlalchemy import Connection, select

from benchmarks.lots.correction import correct, edited
from benchmarks.lots.looks import Look, StillEye
from benchmarks.lots.visits import Visit
from benchmarks.study.visits import CLOCK, DAY, StudyLot
from hawk.daemon.lots.keeper import find_stalls
from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import STALL
from hawk.lots.values import Placed, Saved
from hawk.stats.panel import Period, read_panel
from hawk.stats.values import Panel
from hawk.worlds.world import World

_FAST: Final = {"synchronous": 0}
ZONES: Final = ("East", "West")


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
        look = eye.look(world, first)
        saved = _saved(store, look)
        assert saved.lot is not None, "the mapping flight made no lot"
        with store.writing() as connection:
            true = _corrected(connection, saved.lot, world, look, first)
        doubts = []
        for visit in visits:
            saved = _saved(store, eye.look(lot.world(visit), visit))
            if saved.placed is not Placed.REGISTERED:
                doubts.append(f"{visit.number}: {saved.doubt or saved.placed.value}")
            at = visit.at.astimezone(CLOCK)
            say(f"{lot.name}: survey {visit.number} at {at:%a %H:%M}, {saved.known} known stalls")
        with store.reading() as connection:
            panel = read_panel(connection, saved.lot or "", Period(DAY.timestamp(), None, CLOCK, str(CLOCK)))
        return Studied(lot.name, world, panel, true, tuple(doubts))
    finally:
        store.close()


def _saved(store: Database, look: Look) -> Saved:
    with store.writing() as connection:
        return save(connection, look.survey, find_stalls)


def _corrected(connection: Connection, lot: str, world: World, look: Look, visit: Visit) -> dict[str, int]:
    """Correct the plan as a person does on the page, and draw two zones; return the true stall of each, by its id.

    Accessible stalls get their kind.
    """
    rows = connection.execute(select(STALL.c.id, STALL.c.first_id).where(STALL.c.lot == lot)).all()
    found = {row.id: look.true[row.first_id] for row in rows if row.first_id in look.true}
    present = [stall.id for stall in world.stalls if stall.id in found.values() or not stall.closed]
    kinds = {stall.id: stall.kind for stall in world.stalls}
    with edited(connection, lot, visit.at.timestamp()) as do:
        true = correct(connection, lot, do, world, found, present).true
        if accessible := [each for each, number in true.items() if kinds[number] == "accessible"]:
            do(do="set_kind", stalls=accessible, kind="disabled")
        places = np.array(connection.execute(select(STALL.c.north, STALL.c.east).where(STALL.c.lot == lot)).all())
        (south, west), (north, east) = places.min(axis=0) - 5, places.max(axis=0) + 5
        middle = float(np.median(places[:, 1]))
        for name, ends in zip(ZONES, ((middle, east), (west, middle)), strict=True):
            ring = [[a, b] for a, b in ((south, ends[0]), (north, ends[0]), (north, ends[1]), (south, ends[1]))]
            do(do="draw_zone", name=name, outline=[[float(a), float(b)] for a, b in ring])
    return dict(true)
