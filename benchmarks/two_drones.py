"""Two drones over one lot, one of them without a link at first: each stall has one id in both stores and at the centre.

``python -m benchmarks.two_drones [--seeds 1-10] [--json FILE]``

Each drone surveys each drawn lot six times, as `benchmarks.lots` does: other cars at other hours, a receiver that is
off by up to 3 m and a compass that is off by up to 2° for a whole survey, the third one of half the lot. The first
drone sends each survey at once. The second one makes a lot of its own in three surveys, before it has a link; then the
centre proposes that both lots are one, and a person merges them: into the first drone's, with every second seed into
the second one's. The second drone flies the other three without a link, too. Documents and lots are those that travel
between daemon and desk.
"""

from __future__ import annotations

import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

import cv2

from benchmarks.figures import BenchmarkError, Figure, Limit, Section, print_and_write, share
from benchmarks.lots.archive import Surveyed, numbered, observed_ids, wrong_ids
from benchmarks.lots.looks import Look, StillEye
from benchmarks.lots.visits import DrawnLot, Visit, visits
from benchmarks.options import make_parser, seeds_option
from hawk.algo.vision.network import StallNetwork
from hawk.daemon.lots.keeper import find_stalls
from hawk.lots import commands, queries
from hawk.lots.values import Saved
from tests.unit.lots.documents.drones import NOW, WHO, Drone
from tests.unit.lots.documents.exchange import meet

NAMES: Final = ("Drone 1", "Drone 2")
CENTRE: Final = "centre"
OFFLINE: Final = 3
"""Surveys of the second drone before its first link, and after it."""
_OTHER: Final = 1000
"""The second drone's receiver errs as that of a seed that is higher by this."""
_LATER_H: Final = 5.0


@dataclass(frozen=True, slots=True)
class Flown:
    """A survey of one of the drones with its truth."""

    drone: str
    visit: Visit
    look: Look
    saved: Saved


@dataclass(frozen=True, slots=True)
class OneLot:
    """The ids of a lot's stalls in the end.

    Of ``both`` true stalls that have an id in both drones' stores, ``same`` have one alone over all surveys of all
    three stores. ``wrong``: ids that stand on two true stalls, or on a place between two, in any store. ``left``: true
    stalls that both drones found and that have no id in one of their stores. ``is_one``: the centre proposed that both
    lots are one. ``doubts``: surveys without a place in it, in any store.
    """

    name: str
    surveys: int
    both: int
    same: int
    wrong: int
    left: int
    is_one: bool
    doubts: tuple[str, ...]


class Ends:
    """The stores of both drones and of the centre, and what was flown."""

    def __init__(self, folder: Path, look: Callable[[Visit], Look]) -> None:
        self._look = look
        self.stores = {name: Drone.at(folder / f"{name}.db") for name in (*NAMES, CENTRE)}
        self.flown: list[Flown] = []

    def close(self) -> None:
        """Close the stores."""
        for each in self.stores.values():
            each.store.close()

    def fly(self, drone: str, surveys: Sequence[Visit], *, has_link: bool) -> None:
        """Let a drone survey the lot, and exchange everything with the centre behind each survey."""
        for visit in surveys:
            look = self._look(visit)
            self.flown.append(Flown(drone, visit, look, self.stores[drone].add(numbered(look))))
            if has_link:
                self.meet(drone)

    def meet(self, *drones: str) -> None:
        """Exchange everything between drones and the centre."""
        for name in drones:
            meet(self.stores[name], self.stores[CENTRE].store, name)

    def meet_all(self) -> None:
        """Exchange everything until it has come from either drone to the other one."""
        for _ in range(2):
            self.meet(*NAMES)

    def first_lot(self, drone: str) -> str:
        """Return the lot that a drone's first survey made."""
        made = next(each.saved.lot for each in self.flown if each.drone == drone)
        if made is None:
            raise BenchmarkError(f"{drone}: its first survey made no lot")
        return made

    def merge(self, kept: str, other: str) -> bool:
        """Merge two lots as a person does who reads the centre's proposals; return whether it proposed that."""
        centre = self.stores[CENTRE]
        with centre.store.reading() as connection:
            is_proposed = other in [each.lot for each in queries.proposed(connection, kept).same]
        if is_proposed:
            centre.do(commands.merge, kept, other, WHO, NOW, find_stalls)
        return is_proposed


def both_visits(seed: int) -> dict[str, list[Visit]]:
    """Return the six surveys of each drone, none of them after a repaint or of the lot next door."""
    drawn = zip(NAMES, (seed, seed + _OTHER), (0.0, _LATER_H), strict=True)
    return {
        name: [replace(each, hours=each.hours + late, repaint=0, is_next_door=False) for each in visits(number)]
        for name, number, late in drawn
    }


def survey_lot(
    name: str, surveys: Mapping[str, Sequence[Visit]], look: Callable[[Visit], Look], *, is_into_second: bool
) -> OneLot:
    """Let both drones survey a lot, exchange everything, and judge the ids.

    Args:
        name: Name of the lot.
        surveys: Those of each drone, in their order.
        look: Makes one.
        is_into_second: The person merges the first drone's lot into the second one's.

    Raises BenchmarkError.
    """
    first, second = NAMES
    with tempfile.TemporaryDirectory(prefix="hawk-two-drones-") as folder, closing(Ends(Path(folder), look)) as ends:
        ends.fly(first, surveys[first][:OFFLINE], has_link=True)
        ends.fly(second, surveys[second][:OFFLINE], has_link=False)
        ends.meet_all()
        lots = [ends.first_lot(each) for each in NAMES]
        is_one = ends.merge(*(lots[::-1] if is_into_second else lots))
        ends.meet_all()
        ends.fly(first, surveys[first][OFFLINE:], has_link=True)
        ends.fly(second, surveys[second][OFFLINE:], has_link=False)
        ends.meet_all()
        return judged(name, ends, is_one=is_one)


def judged(name: str, ends: Ends, *, is_one: bool) -> OneLot:
    """Compare the ids of all surveys in all stores."""
    ids: dict[str, dict[int, set[str]]] = {each: defaultdict(set) for each in ends.stores}
    found: dict[str, set[int]] = {each: set() for each in NAMES}
    owner: dict[str, int] = {}
    place: dict[str, tuple[float, float]] = {}
    wrong: set[str] = set()
    doubts = []
    for one in ends.flown:
        found[one.drone].update(one.look.true.values())
        for where in (one.drone, CENTRE):
            with ends.stores[where].store.reading() as connection:
                stored = observed_ids(connection, one.saved.survey)
            if not stored:
                doubts.append(f"{one.drone}, {one.visit.number} ({where})")
            true = {stall: stored[number] for number, stall in one.look.true.items() if number in stored}
            at = {stored[number]: there for number, there in one.look.at.items() if number in stored}
            for stall, each in true.items():
                ids[where][stall].add(each)
            wrong |= wrong_ids(Surveyed(one.visit, one.saved, len(stored), true, at=at), 0, owner, place)
    both = ids[NAMES[0]].keys() & ids[NAMES[1]].keys()
    same = sum(len(set[str]().union(*(stalls[stall] for stalls in ids.values()))) == 1 for stall in both)
    left = len(set.intersection(*found.values()) - both)
    return OneLot(name, len(ends.flown), len(both), same, len(wrong), left, is_one, tuple(doubts))


def figures(found: Sequence[OneLot]) -> list[Figure]:
    """Return the figures over all lots."""
    both, same, wrong, left, surveys = (
        sum(getattr(one, name) for one in found) for name in ("both", "same", "wrong", "left", "surveys")
    )
    doubtful = sum(len(one.doubts) for one in found)
    return [
        Figure("same_id", "stalls with one id over all stores and surveys", share(same, both), limit=Limit(0.995)),
        Figure("wrong_id", "ids that stand on another stall", float(wrong), limit=Limit(highest=0.0)),
        Figure("proposed", "lots made apart that the centre proposed as one",
               share(sum(one.is_one for one in found), len(found)), limit=Limit(1.0)),
        Figure("without_place", "surveys without a place in a store", float(doubtful)),
        Figure("left", "stalls that both drones found, without an id in a store", float(left)),
        Figure("stalls", "stalls with an id in both drones' stores", float(both)),
        Figure("surveys", "surveys", float(surveys)),
        Figure("lots", "lots", float(len(found))),
    ]  # fmt: skip


def line(one: OneLot) -> str:
    """Return a lot in one line."""
    doubts = f"; no place: {', '.join(one.doubts)}" if one.doubts else ""
    proposed = "" if one.is_one else "; not proposed as one"
    return f"{one.name}: {one.same} of {one.both} stalls, {one.wrong} wrong, {one.left} left{proposed}{doubts}"


def _look(eye: StillEye, lot: DrawnLot, visit: Visit) -> Look:
    return eye.look(lot.world(visit), visit)


def main(arguments: Sequence[str] | None = None) -> int:
    """Survey all lots, print a line each and a table of all; return 1 when a figure lies outside its limits."""
    parser = make_parser("benchmarks.two_drones", __doc__, model=True)
    parser.add_argument("--seeds", type=seeds_option, default="1-10", metavar="A-B", help="drawn lots (1-10)")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    eye = StillEye(StallNetwork.load(options.model))
    found = []
    for seed in options.seeds:
        look = partial(_look, eye, DrawnLot(seed))
        found.append(survey_lot(f"seed {seed}", both_visits(seed), look, is_into_second=seed % 2 == 0))
        print(line(found[-1]), file=sys.stderr, flush=True)
    return print_and_write([Section("two drones over one lot", figures(found))], options.json)


if __name__ == "__main__":
    sys.exit(main())
