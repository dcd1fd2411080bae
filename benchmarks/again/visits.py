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

from benchmarks.again.corrected import correct
from benchmarks.chain_flight.flight import HEIGHT_M, Errors, Flown, Glance, camera, fly, lot_of
from benchmarks.exploration.lots import Lot
from benchmarks.lots.archive import known_at, stored_ids
from benchmarks.lots.looks import GNSS_M, ORIGIN, Look, datum_of, landed, true_ids, turn_of
from benchmarks.lots.visits import DrawnLot, Visit
from benchmarks.perception.edges import cut_labels
from benchmarks.perception.places import Place
from hawk.algo.mapper.core import MapperSettings
from hawk.algo.mapper.evidence import quality_mask
from hawk.algo.path_plan.known_tour import lot_tour
from hawk.algo.steps import outcome
from hawk.algo.vision import decode
from hawk.daemon.lot_keeper import find_stalls
from hawk.lots.ingest import save
from hawk.lots.registration.frames import Move
from hawk.lots.schema import OBSERVATION, STALL
from hawk.lots.storage.database import Database
from hawk.lots.values import PLACED, Saved
from hawk.model.known_lot import KnownLot, LotTour
from hawk.model.plans import HeightParameters
from hawk.survey import scoring
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


class Watch:
    """Notes the true stalls that lie as a whole in a frame's picture, without its edge; ``see`` goes to `fly`."""

    def __init__(self, world: World) -> None:
        x0, y0 = world.start()
        corners = np.array([stall.corners for stall in world.stalls]).reshape(-1, 4, 2)
        self._corners = np.stack([y0 - corners[..., 1], corners[..., 0] - x0], axis=-1)
        labels = scoring.LabelledPlace(corners, np.array([stall.state for stall in world.stalls], object))
        self.counted = ~cut_labels(Place(world.name, world.ground, world.metres_per_pixel, labels))
        """A mask (N,) of the stalls that can be seen: the world's picture shows them whole."""
        self.whole, self.well = (np.zeros(len(corners), np.bool_) for _ in range(2))

    def see(self, glance: Glance) -> None:
        """Take a frame."""
        image, settings = glance.seen.lot, MapperSettings()
        parts = quality_mask(image.valid, image.metres_per_pixel, settings.edge_m, settings.good_share)
        places = image.pixel_points(self._corners + np.array(glance.off))
        for known, least in ((self.whole, 1), (self.well, 2)):
            known |= np.asarray(decode.sample(parts >= least, places).all(axis=1))


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


def survey_again(seed: int) -> Twice:
    """Survey the drawn lot of a seed, then survey it again over the plan as it is, and over the corrected plan."""
    lot = DrawnLot(seed)
    before, after = (lot.world(visit) for visit in lot.visits()[:2])
    with tempfile.TemporaryDirectory(prefix="hawk-again-") as folder:
        found, corrected = Path(folder) / "found.db", Path(folder) / "corrected.db"
        with _opened(found) as store:
            first = _survey(store, before, lot.visits()[0])
        shutil.copyfile(found, corrected)
        with _opened(corrected) as store, store.writing() as connection:
            assert first.saved.lot is not None
            whole = [stall.id for stall, yes in zip(before.stalls, Watch(before).counted, strict=True) if yes]
            corrections = correct(connection, first.saved.lot, before, first.ids, whole)
        seconds = []
        for file in (found, corrected):
            with _opened(file) as store:
                seconds.append(_again(store, lot, before, after, first))
        return Twice(seconds[0], seconds[1], corrections)


@contextlib.contextmanager
def _opened(file: Path) -> Iterator[Database]:
    store = Database(file, _FAST)
    try:
        yield store
    finally:
        store.close()


def _again(store: Database, lot: DrawnLot, before: World, after: World, first: Surveyed) -> Again:
    """Fly the second survey over the plan of the store."""
    visit = lot.visits()[1]
    datum = datum_of(after, visit)
    with store.reading() as connection:
        known = known_at(connection, (datum.latitude, datum.longitude))
    assert known is not None
    ground = _lot(after)
    tour = outcome(lot_tour(known, camera(), HeightParameters(15, HEIGHT_M, 60), ground.fence, ground.start))
    watch = Watch(after)
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
    survey = landed(flown, datum_of(world, visit), visit)
    numbered = replace(survey, stalls=tuple(replace(stall, looked=float(stall.id)) for stall in survey.stalls))
    places = np.array([(stall.north, stall.east) for stall in survey.stalls]).reshape(-1, 2)
    turned = Move(turn=-turn_of(world, places, visit.compass)).of(places)
    look = Look(survey, true_ids(world, turned, [stall.id for stall in survey.stalls]))
    with store.writing() as connection:
        saved = save(connection, numbered, find_stalls)
    with store.reading() as connection:
        return Surveyed(flown, saved, _states(connection, saved), stored_ids(connection, saved, look))


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
