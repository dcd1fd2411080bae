from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.mapper.app import MapperApp
from hawk.model.known_lot import KnownLot, KnownStall
from hawk.model.lot_map import OccupancyMap, Stall, StallState
from tests.examples import nightly
from tests.unit.algo.synthetic import SyntheticVision, Truth, frame_at, pose_at, rows_lot

SHIFT, TURN = np.array([1.2, -0.9]), math.radians(1.0)
PASS = np.arange(-30, 31, 1.5)
SLOWLY = np.arange(-30, 31, 1.0)
NOISE = {"noise_m": 0.15, "miss": 0.1, "state_error": 0.05}


def plan_of(stalls: NDArray[np.float64], confirmed: Sequence[bool] | bool = True) -> KnownLot:
    """The stalls as a receiver and a compass that err place them."""
    c, s = math.cos(TURN), math.sin(TURN)
    places = stalls[:, :2] @ np.array([[c, s], [-s, c]]) + SHIFT
    flags = [confirmed] * len(stalls) if isinstance(confirmed, bool) else list(confirmed)
    known = tuple(
        KnownStall(
            f"stall-{k}",
            float(n),
            float(e),
            float((row[2] + TURN) % math.pi),
            float(row[3]),
            float(row[4]),
            flag,
            f"A {k}",
        )
        for k, ((n, e), row, flag) in enumerate(zip(places, stalls, flags, strict=True))
    )
    box = ((-60.0, -60.0), (60.0, -60.0), (60.0, 60.0), (-60.0, 60.0))
    return KnownLot("lot", known, ((box,),))


class Flight:
    def __init__(self, truth: Truth, known: KnownLot | None, *more: KnownLot, **faults: float) -> None:
        self.vision = SyntheticVision(truth, np.random.default_rng(1), **faults)  # type: ignore[arg-type]
        self.mapper = MapperApp(map_id="survey")
        self.mapper.init(self.vision, None)  # type: ignore[arg-type]
        self.known, self.more = known, more
        self.number = 0

    def fly(self, easts: Sequence[float] | NDArray[np.float64] = PASS) -> OccupancyMap:
        for east in easts:
            self.number += 1
            frame = replace(
                frame_at(pose_at(0.0, float(east), math.pi / 2), self.number),
                known=(() if self.known is None else (self.known, *self.more)),
            )
            self.mapper.fuse(frame, self.vision.see(frame))
        return self.mapper.get_occupancy_map()


def of_plan(shown: OccupancyMap) -> dict[int, Stall]:
    return {int(stall.known.split("-")[1]): stall for stall in shown.stalls.values() if stall.known}


TRUTH = rows_lot(turn=0.3)


@pytest.fixture(scope="module")
def flown() -> OccupancyMap:
    flight = Flight(TRUTH, plan_of(TRUTH.stalls), **NOISE)
    flight.fly()
    return flight.fly(PASS[::-1])


@pytest.mark.nightly
def test_each_confirmed_stall_is_on_the_map_at_its_place_under_its_id(flown: OccupancyMap) -> None:
    found = of_plan(flown)
    assert sorted(found) == list(range(len(TRUTH.stalls)))
    assert flown.counts.total == len(TRUTH.stalls)
    assert {k: stall.label for k, stall in found.items()} == {k: f"A {k}" for k in found}
    away = [math.dist(TRUTH.stalls[k, :2], (stall.north, stall.east)) for k, stall in found.items()]
    assert max(away) < 0.5


def test_the_pictures_show_the_state_of_each(flown: OccupancyMap) -> None:
    right = [StallState.TAKEN if TRUTH.taken[k] else StallState.FREE for k in range(len(TRUTH.taken))]
    assert [stall.state for _, stall in sorted(of_plan(flown).items())] == right


@pytest.mark.slow
@pytest.mark.nightly
def test_the_shape_of_the_plan_stays() -> None:
    flight = Flight(TRUTH, plan_of(TRUTH.stalls), noise_m=0.4, miss=0.3)
    flight.fly([*SLOWLY, *SLOWLY[::-1]])
    before = of_plan(flight.fly(SLOWLY))
    after = of_plan(flight.fly(SLOWLY[::-1]))
    assert len(after) == len(TRUTH.stalls)
    assert {k: (s.north, s.east, s.angle) for k, s in before.items()} == {
        k: (s.north, s.east, s.angle) for k, s in after.items()
    }
    gaps = [math.dist((before[k].north, before[k].east), (before[k + 1].north, before[k + 1].east)) for k in range(19)]
    assert max(abs(gap - 2.6) for gap in gaps) < 0.01


@pytest.mark.slow
def test_a_confirmed_stall_that_vision_never_finds_stays_and_its_state_is_read() -> None:
    hidden = 25
    seen = Truth(TRUTH.lot, np.delete(TRUTH.stalls, hidden, 0), np.delete(TRUTH.taken, hidden))
    flight = Flight(seen, plan_of(TRUTH.stalls), **NOISE)
    flight.fly(SLOWLY)
    found = of_plan(flight.fly(SLOWLY[::-1]))
    assert len(found) == len(TRUTH.stalls)
    assert found[hidden].state is StallState.FREE
    assert found[hidden].score < 0.3
    assert found[hidden].existence == 1.0


@pytest.mark.nightly
def test_what_is_found_beside_confirmed_stalls_is_proposed_and_not_counted() -> None:
    known = np.delete(TRUTH.stalls, [10, 48], 0)
    flight = Flight(TRUTH, plan_of(known), **NOISE)
    flight.fly()
    shown = flight.fly(PASS[::-1])
    assert shown.counts.total == len(known)
    beside = [stall for stall in shown.stalls.values() if not stall.known]
    assert len(beside) == 2
    assert {stall.state for stall in beside} == {StallState.SUGGESTED}
    assert {stall.extra for stall in beside} <= {StallState.FREE, StallState.TAKEN, StallState.UNKNOWN}
    assert {stall.extra for stall in shown.stalls.values() if stall.known} == {None}


BEYOND = np.array([[27.0, east, 0.0, 2.6, 5.2] for east in (-3.9, -1.3, 1.3, 3.9)])
"""Places beside each other, more than 15 m from the rows."""


@pytest.mark.slow
@pytest.mark.parametrize("count", [3, 4, *nightly(1)])
def test_a_find_alone_beyond_the_plan_is_proposed_and_a_new_part_of_the_lot_counts(count: int) -> None:
    truth = rows_lot()
    assert np.abs(truth.stalls[:, 0] - BEYOND[0, 0]).min() > 15.0
    stalls = np.vstack([truth.stalls, BEYOND[:count]])
    taken = np.concatenate([truth.taken, np.ones(count, np.bool_)])
    flight = Flight(Truth(truth.lot, stalls, taken), plan_of(truth.stalls))
    flight.fly()
    shown = flight.fly(PASS[::-1])
    beyond = [stall for stall in shown.stalls.values() if not stall.known and stall.north > 20.0]
    assert shown.counts.total == len(truth.stalls) + (count if count > 3 else 0)
    assert [stall.state is StallState.SUGGESTED for stall in beyond] == [count <= 3] * len(beyond)


@pytest.mark.nightly
def test_a_plan_that_nobody_confirmed_is_changed_by_the_flight() -> None:
    known = np.vstack([TRUTH.stalls, TRUTH.stalls[5:6] + np.array([-7.5, 0, 0, 0, 0])])
    flight = Flight(TRUTH, plan_of(known, confirmed=False), **NOISE)
    flight.fly(SLOWLY)
    shown = flight.fly(SLOWLY[::-1])
    assert shown.counts.total == len(TRUTH.stalls)
    assert not of_plan(shown)


@pytest.mark.nightly
def test_a_confirmed_row_does_not_make_proposals_of_an_unconfirmed_one() -> None:
    flags = [k < 20 for k in range(len(TRUTH.stalls))]
    flight = Flight(TRUTH, plan_of(TRUTH.stalls, flags), **NOISE)
    flight.fly()
    shown = flight.fly(PASS[::-1])
    assert sorted(of_plan(shown)) == list(range(20))
    assert shown.counts.total == len(TRUTH.stalls)
    assert shown.counts.suggested == 0


@pytest.mark.nightly
def test_the_plan_of_another_lot_is_not_put_onto_the_map() -> None:
    other = rows_lot(turn=0.3, columns=14)
    stalls = other.stalls + np.array([0.0, 3.9, 0.0, 0.0, 0.0])
    stalls[:, 3] = 3.4
    stalls[:, 1] *= 3.4 / 2.6
    shown = Flight(TRUTH, plan_of(stalls), **NOISE).fly()
    assert not of_plan(shown)
    assert shown.counts.suggested == 0


@pytest.mark.slow
def test_a_plan_that_a_person_changes_in_flight_replaces_the_one_before() -> None:
    flight = Flight(TRUTH, plan_of(TRUTH.stalls[:-1]), **NOISE)
    flight.fly()
    assert len(of_plan(flight.fly(PASS[::-1]))) == len(TRUTH.stalls) - 1
    flight.known = plan_of(TRUTH.stalls)
    flight.fly()
    shown = flight.fly(PASS[::-1])
    assert sorted(of_plan(shown)) == list(range(len(TRUTH.stalls)))
    assert shown.counts.suggested == 0


@pytest.mark.slow
def test_stalls_on_ground_that_was_seen_before_the_plan_was_placed_have_a_state_at_once() -> None:
    hidden = [3, 25, 44]
    seen = Truth(TRUTH.lot, np.delete(TRUTH.stalls, hidden, 0), np.delete(TRUTH.taken, hidden))
    flight = Flight(seen, None, **NOISE)
    flight.fly([*PASS, *PASS[::-1]])
    flight.known = plan_of(TRUTH.stalls)
    shown: OccupancyMap | None = None
    while shown is None or not of_plan(shown):
        shown = flight.fly([70.0])  # beside the lot
    states = {number: stall.state for number, stall in of_plan(shown).items()}
    assert len(states) == len(TRUTH.stalls)
    assert all(of_plan(shown)[number].seen for number in hidden)
    right = [states[k] is (StallState.TAKEN if TRUTH.taken[k] else StallState.FREE) for k in states if k not in hidden]
    assert sum(right) >= 0.95 * len(right)


@pytest.mark.slow
def test_the_plans_of_two_lots_come_onto_one_map_each_at_its_own_place() -> None:
    """The receiver places the second lot's plan half a metre elsewhere than the first one's."""
    away = np.array([0.0, 90.0, 0.0, 0.0, 0.0])
    east = TRUTH.stalls + away
    both = Truth(
        np.array([[-30.0, -40.0], [30.0, -40.0], [30.0, 130.0], [-30.0, 130.0]]),
        np.vstack([TRUTH.stalls, east]),
        np.concatenate([TRUTH.taken, ~TRUTH.taken]),
    )
    count = len(TRUTH.stalls)
    first, second = plan_of(TRUTH.stalls), moved_lot(plan_of(east), 0.5)
    flight = Flight(both, first, second, **NOISE)
    flight.fly([*PASS, *PASS[::-1]])
    assert flight.mapper.plan_places("lot") is not None
    assert flight.mapper.plan_places("other") is None
    flight.fly(np.arange(-29, 121, 1.0))
    shown = flight.fly(np.arange(120, 60, -1.0))
    found = {stall.known: stall for stall in shown.stalls.values() if stall.known}
    assert sorted(found) == sorted([*(f"stall-{k}" for k in range(count)), *(f"other-{k}" for k in range(count))])
    off = [
        math.dist(both.stalls[k, :2], (found[name].north, found[name].east))
        for k, name in enumerate([*(f"stall-{k}" for k in range(count)), *(f"other-{k}" for k in range(count))])
    ]
    assert max(off) < 0.6
    assert len({stall.label for stall in found.values()}) == 2 * count


@pytest.mark.nightly
@pytest.mark.slow
def test_a_stall_that_the_flight_has_ended_does_not_come_back_with_the_plan_of_the_next_lot() -> None:
    away = np.array([0.0, 90.0, 0.0, 0.0, 0.0])
    phantom = TRUTH.stalls[5:6] + np.array([-7.5, 0, 0, 0, 0])
    both = Truth(
        np.array([[-30.0, -40.0], [30.0, -40.0], [30.0, 130.0], [-30.0, 130.0]]),
        np.vstack([TRUTH.stalls, TRUTH.stalls + away]),
        np.concatenate([TRUTH.taken, TRUTH.taken]),
    )
    first = plan_of(np.vstack([TRUTH.stalls, phantom]), confirmed=False)
    flight = Flight(both, first, moved_lot(plan_of(TRUTH.stalls + away, confirmed=False), 0.0), **NOISE)
    flight.fly(SLOWLY)
    flight.fly(SLOWLY[::-1])

    def at_phantom() -> int:
        stalls = flight.mapper.get_occupancy_map().stalls.values()
        return sum(math.dist(phantom[0, :2], (stall.north, stall.east)) < 1.5 for stall in stalls)

    before = at_phantom()
    flight.fly([*np.arange(-29, 121, 1.0), *np.arange(120, 60, -1.0)])
    assert flight.mapper.plan_places("other") is not None
    assert before == at_phantom() == 0


def moved_lot(lot: KnownLot, metres: float) -> KnownLot:
    """Return a plan under other ids, moved to the north."""
    stalls = tuple(
        replace(stall, id=f"other-{k}", label=f"B {k}", north=stall.north + metres)
        for k, stall in enumerate(lot.stalls)
    )
    box = ((-60.0, 30.0), (60.0, 30.0), (60.0, 150.0), (-60.0, 150.0))
    return replace(lot, id="other", stalls=stalls, ground=((box,),))


def test_sections_alone_have_no_place_on_the_map_and_the_plan_beside_them_has() -> None:
    plan = plan_of(TRUTH.stalls)
    sections = KnownLot("sections", (), plan.ground, plan.stalls[:3])
    flight = Flight(TRUTH, sections, plan, **NOISE)
    shown = flight.fly([*PASS, *PASS[::-1]])
    assert flight.mapper.plan_places("lot") is not None
    assert flight.mapper.plan_places("sections") is None
    assert len(of_plan(shown)) == len(TRUTH.stalls)
    alone = Flight(TRUTH, sections, **NOISE)
    assert of_plan(alone.fly(PASS)) == {}
