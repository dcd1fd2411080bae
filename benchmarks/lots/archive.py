"""Surveys of one lot, stored one after the other, and the ids that its stalls get."""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np
from sqlalchemy import Connection, select

from benchmarks.lots.looks import Look, StillEye
from benchmarks.lots.visits import DrawnLot, PictureLot, Visit
from hawk.daemon.lots.keeper import find_stalls
from hawk.lots.change_detection.proposals import proposals
from hawk.lots.change_detection.takeover import take_over
from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import OBSERVATION, STALL, SURVEY
from hawk.lots.values import PLACED, FinishedSurvey, Placed, Saved
from hawk.survey.accuracy import match
from hawk.worlds.world import World

_FAST: Final = {"synchronous": 0}
MOVED_M: Final = 1.0
"""An id whose find lies this far from the find that first had it is that of another place: .4 of a usual stall's width,
where a third is what a find may be off its stall."""


@dataclass(frozen=True, slots=True)
class Repainted:
    """A repaint and what the first survey after it reported: all of it is taken over.

    ``gone``, ``came`` and ``closed`` are true stalls that ended, began, and are behind fences; ``ended`` are stored
    stalls, ``begun`` true ones: the proposals.
    """

    gone: frozenset[int]
    came: frozenset[int]
    closed: frozenset[int]
    ended: frozenset[str]
    begun: frozenset[int]


@dataclass(frozen=True, slots=True)
class Surveyed:
    """One stored survey: ``ids`` says which stored stall each true stall was taken for, ``at`` where the find of each
    stored stall lies among the true ones, metres north and east: also of finds that are no true stall.
    """

    visit: Visit
    saved: Saved
    found: int
    ids: dict[int, str] = field(repr=False)
    repainted: Repainted | None = field(default=None, repr=False)
    at: dict[str, tuple[float, float]] = field(default_factory=dict, repr=False)


@dataclass(frozen=True, slots=True)
class Judged:
    """The surveys of one lot. ``again`` stalls were seen by a survey before, of which ``same`` have the id of then, and
    ``wrong`` is the number of ids that another stall has, or a find at another place, as one between two stalls that
    overlaps neither. ``doubts``: why surveys of the lot were not registered. Of ``stayed`` known stalls
    that a repaint left alone, ``kept`` have their ids after the take-over. Of ``changed`` ones, ``reported`` were
    proposed.
    """

    name: str
    surveys: int
    again: int
    same: int
    wrong: int
    doubts: tuple[str, ...]
    stayed: int = 0
    kept: int = 0
    changed: int = 0
    reported: int = 0


def survey_lot(lot: DrawnLot | PictureLot, eye: StillEye) -> Judged:
    """Make all surveys of a lot, store them, and judge their ids."""
    with tempfile.TemporaryDirectory(prefix="hawk-lots-") as folder:
        store = Database(Path(folder) / "lots.db", _FAST)
        try:
            visits = lot.visits()
            first = lot.world(visits[0])
            surveys: list[Surveyed] = []
            repaint = 0
            for visit in visits:
                surveys.append(_survey(store, lot, visit, eye, first, is_repainted=visit.repaint > repaint))
                if surveys[-1].saved.placed in PLACED:
                    repaint = visit.repaint
            return judged(lot.name, surveys)
        finally:
            store.close()


def judged(name: str, surveys: list[Surveyed]) -> Judged:
    """Compare the ids of each survey with those of the ones before."""
    mine = [one for one in surveys if not one.visit.is_next_door]
    first_id: dict[int, str] = {}
    owner: dict[str, int] = {}
    place: dict[str, tuple[float, float]] = {}
    again = same = wrong = 0
    stayed = kept = changed = reported = 0
    for one in surveys:
        world = 1 if one.visit.is_next_door else 0
        if (paint := one.repainted) is not None:
            known = {stall // 2: stored for stall, stored in first_id.items() if stall % 2 == 0}
            left = [known[true] for true in known.keys() - paint.gone - paint.closed]
            lost = [known[true] for true in known.keys() & paint.gone]
            stayed, kept = stayed + len(left), kept + sum(stored not in paint.ended for stored in left)
            changed += len(lost) + len(paint.came)
            reported += sum(stored in paint.ended for stored in lost) + len(paint.came & paint.begun)
        for true, stored in one.ids.items():
            stall = true * 2 + world
            if stall in first_id:
                again += 1
                same += first_id[stall] == stored
            first_id.setdefault(stall, stored)
        wrong += len(wrong_ids(one, world, owner, place))
    doubts = tuple(
        f"{one.visit.number}: {one.saved.doubt or one.saved.placed.value}"
        for one in mine
        if one.saved.placed not in PLACED
    )
    return Judged(name, len(mine), again, same, wrong, doubts, stayed, kept, changed, reported)


def wrong_ids(one: Surveyed, world: int, owner: dict[str, int], place: dict[str, tuple[float, float]]) -> set[str]:
    """Return the ids of a survey that were another true stall's, or were elsewhere; note those that are new.

    ``world``: 1 for the lot next door, else 0.
    """
    wrong = {
        stored for true, stored in one.ids.items() if owner.setdefault(stored, true * 2 + world) != true * 2 + world
    }
    return wrong | {stored for stored, at in one.at.items() if math.dist(place.setdefault(stored, at), at) > MOVED_M}


def _survey(
    store: Database, lot: DrawnLot | PictureLot, visit: Visit, eye: StillEye, first: World, *, is_repainted: bool
) -> Surveyed:
    world = lot.world(visit)
    look = eye.look(world, visit)
    saved = store_look(store, look)
    repainted = None
    if is_repainted and saved.placed is Placed.REGISTERED:
        former = lot.world(replace(visit, repaint=visit.repaint - 1))
        repainted = _taken_over(store, saved, look, former, world)
    with store.reading() as connection:
        ids, begun = stored_ids(connection, saved.survey, look), _begun(connection)
        stored = observed_ids(connection, saved.survey)
    lasting = {} if visit.is_next_door else lasting_ids(first, world)
    lasted = {true if each in begun else lasting.get(true, true): each for true, each in ids.items()}
    at = {stored[number]: place for number, place in look.at.items() if number in stored}
    return Surveyed(visit, saved, len(look.survey.stalls), lasted, repainted, at)


def _begun(connection: Connection) -> set[str]:
    """Return the stored stalls that a take-over made: a row at another pitch begins whole, and its stalls are new."""
    return set(connection.execute(select(STALL.c.id).where(STALL.c.begins > 1)).scalars())


def lasting_ids(first: World, later: World) -> dict[int, int]:
    """Return which stall of the first world each stall of a repainted one is: it fits where it overlaps by half.

    A row at another pitch has new stalls to the simulator; some of them are where a stall was, and no map differs.
    """
    before = {stall.id for stall in first.stalls}
    left = {stall.id for stall in later.stalls}
    old = [stall for stall in first.stalls if stall.id not in left]
    new = [stall for stall in later.stalls if stall.id not in before]
    if not old or not new:
        return {}
    pairs = match(np.array([stall.corners for stall in new]), np.array([stall.corners for stall in old]))
    return {new[k].id: old[j].id for k, j in zip(pairs.found.tolist(), pairs.true.tolist(), strict=True)}


def _taken_over(store: Database, saved: Saved, look: Look, former: World, world: World) -> Repainted:
    """Take over all that the first survey after a repaint proposes."""
    assert saved.lot is not None
    with store.writing() as connection:
        found = next((each for each in proposals(connection, saved.lot) if each.survey == saved.survey), None)
        if found is not None:
            asked = {"survey": saved.survey, "begin": "all", "end": "all"}
            take_over(connection, saved.lot, asked, "benchmark", found.ended)
    before, after = ({stall.id for stall in each.stalls} for each in (former, world))
    begun = {look.true[stall.id] for stall in found.begin if stall.id in look.true} if found else set()
    return Repainted(
        gone=frozenset(before - after),
        came=frozenset(after - before),
        closed=frozenset(stall.id for stall in world.stalls if stall.closed),
        ended=frozenset(stall.id for stall in found.end) if found else frozenset(),
        begun=frozenset(begun),
    )


def numbered(look: Look) -> FinishedSurvey:
    """Return a survey whose looks have the stalls' numbers as times, by which `observed_ids` finds them."""
    return replace(look.survey, stalls=tuple(replace(stall, looked_at=float(stall.id)) for stall in look.survey.stalls))


def store_look(store: Database, look: Look) -> Saved:
    """Store a survey, `numbered`."""
    with store.writing() as connection:
        return save(connection, numbered(look), find_stalls)


def stored_ids(connection: Connection, survey: str, look: Look) -> dict[int, str]:
    """Return the stored id of each true stall that a survey observed, by the survey's id."""
    stored = observed_ids(connection, survey)
    return {true: stored[number] for number, true in look.true.items() if number in stored}


def observed_ids(connection: Connection, survey: str) -> dict[int, str]:
    """Return the stored id of each stall that a `numbered` survey observed, by its number there."""
    rows = connection.execute(
        select(OBSERVATION.c.looked_at, STALL.c.id)
        .join(STALL, STALL.c.key == OBSERVATION.c.stall)
        .join(SURVEY, SURVEY.c.seq == OBSERVATION.c.survey)
        .where(SURVEY.c.id == survey)
    )
    return {round(looked): stall for looked, stall in rows}
