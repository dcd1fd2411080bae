"""Surveys of one lot, stored one after the other, and the ids that its stalls get."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np
from sqlalchemy import Connection, select

from benchmarks.lots.looks import Eye, Look, datum_of
from benchmarks.lots.visits import DrawnLot, PictureLot, Visit
from hawk.daemon.lot_keeper import find_stalls
from hawk.lots.database import Database
from hawk.lots.known import known_lot, lot_near
from hawk.lots.saving import save
from hawk.lots.tables import OBSERVATION, STALL
from hawk.lots.values import Placed, Saved
from hawk.model.known_lot import KnownLot
from hawk.survey.scoring import match
from hawk.worlds.world import World

_FAST: Final = {"synchronous": 0}


@dataclass(frozen=True, slots=True)
class Surveyed:
    """One stored survey: ``ids`` says which stored stall each true stall was taken for."""

    visit: Visit
    saved: Saved
    found: int
    ids: dict[int, str] = field(repr=False)


@dataclass(frozen=True, slots=True)
class Judged:
    """The surveys of one lot. ``again`` stalls were seen by a survey before, of which ``same`` have the id of then, and
    ``wrong`` that of another stall. ``doubts``: why surveys of the lot were not registered.
    """

    name: str
    surveys: int
    again: int
    same: int
    wrong: int
    doubts: tuple[str, ...]


def survey_lot(lot: DrawnLot | PictureLot, eye: Eye) -> Judged:
    """Make all surveys of a lot, store them, and judge their ids."""
    with tempfile.TemporaryDirectory(prefix="hawk-lots-") as folder:
        store = Database(Path(folder) / "lots.db", _FAST)
        try:
            first = lot.world(lot.visits()[0])
            return judged(lot.name, [_survey(store, lot, visit, eye, first) for visit in lot.visits()])
        finally:
            store.close()


def judged(name: str, surveys: list[Surveyed]) -> Judged:
    """Compare the ids of each survey with those of the ones before."""
    mine = [one for one in surveys if not one.visit.is_next_door]
    first_id: dict[int, str] = {}
    owner: dict[str, int] = {}
    again = same = wrong = 0
    for one in surveys:
        world = 1 if one.visit.is_next_door else 0
        for true, stored in one.ids.items():
            stall = true * 2 + world
            if stall in first_id:
                again += 1
                same += first_id[stall] == stored
            wrong += owner.setdefault(stored, stall) != stall
            first_id.setdefault(stall, stored)
    doubts = tuple(
        f"{one.visit.number}: {one.saved.doubt or one.saved.placed.value}"
        for one in mine
        if one.saved.placed not in (Placed.FIRST, Placed.REGISTERED)
    )
    return Judged(name, len(mine), again, same, wrong, doubts)


def _survey(store: Database, lot: DrawnLot | PictureLot, visit: Visit, eye: Eye, first: World) -> Surveyed:
    world = lot.world(visit)
    datum = datum_of(world, visit)
    with store.reading() as connection:
        known = _known(connection, (datum.latitude, datum.longitude))
    look = eye.look(world, visit, known)
    numbered = tuple(replace(stall, looked=float(stall.id)) for stall in look.survey.stalls)
    with store.writing() as connection:
        saved = save(connection, replace(look.survey, stalls=numbered), find_stalls)
    with store.reading() as connection:
        ids = _ids(connection, saved, look)
    lasting = {} if visit.is_next_door else lasting_ids(first, world)
    return Surveyed(
        visit, saved, len(look.survey.stalls), {lasting.get(true, true): each for true, each in ids.items()}
    )


def lasting_ids(first: World, later: World) -> dict[int, int]:
    """Return which stall of the first world each stall of a repainted one is: it fits where it overlaps by half.

    A row at another pitch has new stalls to the simulator; some of them lie where a stall lay, and no map differs.
    """
    before = {stall.id for stall in first.stalls}
    left = {stall.id for stall in later.stalls}
    old = [stall for stall in first.stalls if stall.id not in left]
    new = [stall for stall in later.stalls if stall.id not in before]
    if not old or not new:
        return {}
    pairs = match(np.array([stall.corners for stall in new]), np.array([stall.corners for stall in old]))
    return {new[k].id: old[j].id for k, j in zip(pairs.found.tolist(), pairs.true.tolist(), strict=True)}


def _known(connection: Connection, datum: tuple[float, float]) -> KnownLot | None:
    near = lot_near(connection, datum)
    return None if near is None else known_lot(connection, near[0][0], datum)


def _ids(connection: Connection, saved: Saved, look: Look) -> dict[int, str]:
    """Return the stored id of each true stall that the survey observed: its looks have the stall's number as time."""
    if saved.placed not in (Placed.FIRST, Placed.REGISTERED):
        return {}
    rows = connection.execute(
        select(OBSERVATION.c.looked, STALL.c.id)
        .join(STALL, STALL.c.key == OBSERVATION.c.stall)
        .where(OBSERVATION.c.survey == saved.seq)
    )
    stored = {round(looked): stall for looked, stall in rows}
    return {true: stored[number] for number, true in look.true.items() if number in stored}
