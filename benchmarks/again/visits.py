"""Two surveys of one lot, the second one over the plan that the first has left in the daemon's store.

Between them the cars have moved (26 hours), receiver and compass err otherwise. Both fly camera, vision, mapper and
planner on hawk-sim's body.
"""

from __future__ import annotations

import contextlib
import shutil
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, select

from benchmarks.chain_flight.flight import HEIGHTS, Errors, Flown, Glance, camera, fly, lot_of
from benchmarks.chain_flight.measure import ORIGIN
from benchmarks.chain_flight.views import Views
from benchmarks.exploration.lots import Lot
from benchmarks.lots.archive import store_look, stored_ids
from benchmarks.lots.correction import correct, edited
from benchmarks.lots.looks import GNSS_M, datum_of, flown_look
from benchmarks.lots.visits import DrawnLot, PictureLot, Visit
from hawk.algo.frame import outcome
from hawk.algo.path_plan.known_tour import lot_tour
from hawk.lots.known_lot import known_lot, lot_near
from hawk.lots.schema import OBSERVATION, STALL
from hawk.lots.storage.database import Database
from hawk.lots.values import PLACED, Saved
from hawk.model.known_lot import KnownLot, LotTour
from hawk.survey.truth import parse_truth
from hawk.worlds.world import World

Floats = NDArray[np.float64]
NAMED: Final = ("free", "taken")
_FAST: Final = {"synchronous": 0}


@dataclass(frozen=True, slots=True)
class Again:
    """The second survey of a lot: ``planned_m`` was given before its start, ``first_m`` the first one flew.

    Of ``stalls`` that can be seen, ``looked_at`` were as a whole in a picture, ``looked_at_well`` in the good part of
    one. Of ``changed`` stalls, whose true state is another one than at the first visit, ``reported`` have the new
    state; of ``unchanged`` ones ``false`` have another state than in the first survey.
    """

    name: str
    first_m: float
    planned_m: float
    flown_m: float
    seconds: float
    finished: bool
    placed: str
    stalls: int
    looked_at: int
    looked_at_well: int
    changed: int
    reported: int
    unchanged: int
    false: int


@dataclass(frozen=True, slots=True)
class Surveyed:
    """A stored survey: the state of each stall of the store, and which stall each true one is."""

    flown: Flown
    saved: Saved
    states: dict[str, str] = field(repr=False)
    ids: dict[int, str] = field(repr=False)


@dataclass(frozen=True, slots=True)
class Twice:
    """The second survey of a lot over the plan as the first one left it, and over that plan corrected by a person.

    ``corrections`` is the number of stalls that the person removed and added.
    """

    found: Again
    corrected: Again
    corrections: int


def survey_again(lot: DrawnLot | PictureLot) -> Twice:
    """Survey a lot, then survey it again over the plan as it is, and over the corrected plan."""
    before, after = (lot.world(visit) for visit in lot.visits()[:2])
    with tempfile.TemporaryDirectory(prefix="hawk-again-") as folder:
        found, corrected = Path(folder) / "found.db", Path(folder) / "corrected.db"
        with _opened(found) as store:
            first = _survey(store, before, lot.visits()[0])
        shutil.copyfile(found, corrected)
        with _opened(corrected) as store, store.writing() as connection:
            assert first.saved.lot is not None
            whole = [stall.id for stall, yes in zip(before.stalls, Views(before).counted, strict=True) if yes]
            found_as = {stored: true for true, stored in first.ids.items()}
            with edited(connection, first.saved.lot) as do:
                mended = correct(connection, first.saved.lot, do, before, found_as, whole)
                do(do="confirm", all=True)
        seconds = []
        for file in (found, corrected):
            with _opened(file) as store:
                seconds.append(_again(store, lot, before, after, first))
        return Twice(seconds[0], seconds[1], mended.removed + mended.added)


@contextlib.contextmanager
def _opened(file: Path) -> Iterator[Database]:
    store = Database(file, _FAST)
    try:
        yield store
    finally:
        store.close()


def _again(store: Database, lot: DrawnLot | PictureLot, before: World, after: World, first: Surveyed) -> Again:
    """Fly the second survey over the plan of the store."""
    visit = lot.visits()[1]
    datum = datum_of(after, visit)
    with store.reading() as connection:
        known = _known_at(connection, (datum.latitude, datum.longitude))
    assert known is not None
    ground = _lot(after)
    tour = outcome(lot_tour(known, camera(), HEIGHTS, ground.fence, ground.start))
    watch = Views(after)
    second = _survey(store, after, visit, known, tour, watch.see)
    changed, reported, unchanged, false = _compared(before, after, first, second)
    return Again(
        lot.name, first.flown.distance_m, tour.distance_m, second.flown.distance_m, second.flown.seconds,
        second.flown.finished, second.saved.placed.value, int(watch.counted.sum()),
        int((watch.whole & watch.counted).sum()), int((watch.well & watch.counted).sum()),
        changed, reported, unchanged, false,
    )  # fmt: skip


def _survey(
    store: Database,
    world: World,
    visit: Visit,
    known: KnownLot | None = None,
    tour: LotTour | None = None,
    watch: Callable[[Glance], None] = lambda _: None,
) -> Surveyed:
    errors, seed = Errors(GNSS_M, compass=visit.compass), (world.seed or 0) * 10 + visit.number
    flown = fly(world, _lot(world), errors=errors, seed=seed, known=known, tour=tour, watch=watch)
    look = flown_look(flown, world, visit)
    saved = store_look(store, look)
    with store.reading() as connection:
        return Surveyed(flown, saved, _states(connection, saved), stored_ids(connection, saved, look))


def _known_at(connection: Connection, datum: tuple[float, float]) -> KnownLot | None:
    """Return the plan of the lot at a datum (latitude, longitude); None where the store has none there."""
    near = lot_near(connection, datum)
    return None if near is None else known_lot(connection, near[0][0], datum)


def _lot(world: World) -> Lot:
    return lot_of(replace(parse_truth(world.truth_json()), origin=ORIGIN), world.start())


def _states(connection: Connection, saved: Saved) -> dict[str, str]:
    if saved.placed not in PLACED:
        return {}
    rows = select(STALL.c.id, OBSERVATION.c.state).join(STALL, STALL.c.key == OBSERVATION.c.stall)
    return {str(key): str(state) for key, state in connection.execute(rows.where(OBSERVATION.c.survey == saved.seq))}


def _compared(before: World, after: World, first: Surveyed, second: Surveyed) -> tuple[int, int, int, int]:
    """Return how many stalls changed, changed and were reported, stayed, and stayed and were reported as changed."""
    was = {stall.id: stall.state for stall in before.stalls}
    both = [(stall.id, was[stall.id], stall.state) for stall in after.stalls if was.get(stall.id) in NAMED]
    both = [each for each in both if each[2] in NAMED]
    changed = [(true, now) for true, then, now in both if then != now]
    stayed = [true for true, then, now in both if then == now]
    reported = sum(second.states.get(second.ids.get(true, "")) == now for true, now in changed)
    false = 0
    for true in stayed:
        key = second.ids.get(true, "")
        states = {first.states.get(key), second.states.get(key)}
        false += states == set(NAMED)
    return len(changed), reported, len(stayed), false
