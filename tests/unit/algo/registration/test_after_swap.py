"""Another flight over a map of before: its position is off by more than half a stall's width."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.registration.after_swap import AfterSwap, Inside, Stalls, TooFewError
from tests.examples import nightly
from tests.unit.algo.mapper.test_app import PASS, Rig
from tests.unit.algo.synthetic import rows_lot

Floats = NDArray[np.float64]
PITCH = 2.6


def everywhere(places: Floats) -> NDArray[np.bool_]:
    return np.ones(len(places), bool)


def nowhere(places: Floats) -> NDArray[np.bool_]:
    return np.zeros(len(places), bool)


def row(count: int, taken: Floats, start: float = 0.0) -> Stalls:
    places = np.column_stack([np.zeros(count), start + np.arange(count) * PITCH])
    return Stalls(places, np.zeros(count), taken)


def settled(relocation: AfterSwap, known: Stalls, found: Stalls, was_seen: Inside = nowhere) -> Floats | None:
    while not relocation.is_over:
        step = relocation.look(known, found, nowhere_but_known(known), was_seen)
        if step is not None:
            return step
    return None


def nowhere_but_known(known: Stalls) -> Inside:
    """The picture shows as many known stalls as are needed, and none of them is missed."""
    first = known.places[:4]

    def inside(places: Floats) -> NDArray[np.bool_]:
        return np.asarray((np.abs(places[:, None] - first).sum(2) < 1e-9).any(1))

    return inside


@pytest.mark.parametrize("error", [(0.0, 1.9), (0.0, -PITCH), (1.4, -1.4), (0.0, 0.0)])
def test_taken_stalls_distinguish_a_row_from_the_same_row_a_pitch_farther(error: tuple[float, float]) -> None:
    taken = np.random.default_rng(5).integers(0, 2, 14).astype(float)
    known, found = row(20, np.append(taken, np.zeros(6))), row(14, taken)
    moved = Stalls(found.places + error, found.angles, found.taken)
    step = settled(AfterSwap(), known, moved)
    assert step == pytest.approx(-np.array(error), abs=0.02)


def other_cars() -> tuple[Stalls, Stalls]:
    """Return a known row and a part of it, found where it is, whose cars stand as a pitch farther along before."""
    taken = np.random.default_rng(5).integers(0, 2, 21).astype(float)
    return row(20, taken[:20]), row(12, taken[5:17], start=4 * PITCH)


def test_other_cars_mislead_by_their_states_while_the_swap_counts_as_young() -> None:
    known, found = other_cars()
    assert settled(AfterSwap(), known, found) == pytest.approx([0.0, PITCH], abs=0.02)


@pytest.mark.slow
def test_after_half_an_hour_states_say_nothing_and_a_row_without_an_end_is_not_certain() -> None:
    known, found = other_cars()
    relocation = AfterSwap(has_same_cars=False)
    step = settled(relocation, known, found)
    assert step is None or step == pytest.approx([0.0, 0.0], abs=0.02)
    assert relocation.is_over


@pytest.mark.slow
def test_equal_stalls_without_an_end_in_sight_are_left_where_they_are() -> None:
    known, found = row(30, np.ones(30)), row(10, np.ones(10), start=10 * PITCH)
    relocation = AfterSwap()
    moved = Stalls(found.places + np.array([0.0, 1.2]), found.angles, found.taken)
    step = settled(relocation, known, moved)
    assert relocation.is_over
    assert step is None or abs(step[1] + 1.2) < 0.1  # nothing, or the nearer of two: never a pitch farther


def test_the_end_of_a_row_on_seen_ground_fixes_its_place() -> None:
    known, found = row(12, np.ones(12)), row(12, np.ones(12))
    moved = Stalls(found.places + np.array([0.0, 1.8]), found.angles, found.taken)
    assert settled(AfterSwap(), known, moved, everywhere) == pytest.approx([0.0, -1.8], abs=0.02)


def test_too_little_of_the_earlier_map_is_no_frame() -> None:
    with pytest.raises(TooFewError):
        AfterSwap().look(row(20, np.ones(20)), row(3, np.ones(3)), everywhere, everywhere)
    with pytest.raises(TooFewError):
        AfterSwap().look(row(20, np.ones(20)), row(9, np.ones(9)), nowhere, everywhere)


def flown_half(error: tuple[float, float] = (0.0, 0.0)) -> Rig:
    """A mapper with the map of half a lot, from another flight, and a vision with an error of position."""
    rig = Rig()
    rig.fly(PASS[:32])
    again = Rig(pose_error=error)
    assert again.mapper.restore([rig.mapper.changes_since(0).parts]) == []
    again.sequence = 1000
    return again


@pytest.mark.fault(
    "another flight over an earlier map, the position off by 2 m along the rows",
    "the place on the map is found before anything is mapped; no row is joined a stall farther along",
)
@pytest.mark.flight
@pytest.mark.parametrize("error", [(1.4, 1.4), *nightly(((0.0, 2.0),), ((-2.0, 0.5),))])
def test_the_rest_of_a_lot_meets_the_first_half(error: tuple[float, float]) -> None:
    again = flown_half(error)
    before = dict(again.mapper.get_occupancy_map().stalls)
    again.fly(PASS[20:])
    after = again.map.stalls
    assert len(after) == len(again.truth.stalls)
    assert before.keys() <= after.keys()
    assert again.unmatched(after.values()) == 0
    moved = [math.dist((before[i].north, before[i].east), (after[i].north, after[i].east)) for i in before]
    assert max(moved) < 0.3


@pytest.mark.flight
def test_a_flight_that_begins_beside_the_map_is_mapped_at_once() -> None:
    again = flown_half()
    known = len(again.mapper.get_occupancy_map().stalls)
    again.truth = again.vision.truth = rows_lot(turn=0.3, middle=(200.0, 0.0))
    again.fly(PASS[:20], north=200.0)
    assert len(again.map.stalls) > known + 10


@pytest.mark.fault(
    "the next flight begins on ground that the earlier one did not see, or at the edge of its map, the "
    "position off by 2 m",
    "a few stalls at the edge wait; once the place on the map is found, all that was found before moves to "
    "it; no stall is counted twice",
)
@pytest.mark.flight
@pytest.mark.parametrize("error", [(-1.6, 0.8), *nightly(((0.0, 1.9),))])
def test_what_was_found_before_the_drone_met_the_earlier_map_moves_to_its_place_on_it(
    error: tuple[float, float],
) -> None:
    again = flown_half(error)
    before = dict(again.mapper.get_occupancy_map().stalls)
    again.fly([*PASS[::-1], *PASS])
    after = again.map.stalls
    assert len(after) == len(again.truth.stalls)
    assert before.keys() <= after.keys()
    assert again.unmatched(after.values()) == 0


@pytest.mark.fault(
    "the next flight begins on ground that the earlier one did not see, or at the edge of its map, the "
    "position off by 2 m"
)
@pytest.mark.flight
def test_a_few_stalls_at_the_edge_of_the_earlier_map_are_not_counted_twice() -> None:
    again = flown_half((0.0, 1.9))
    known = again.mapper.get_occupancy_map().stalls
    again.truth = again.vision.truth = replace(again.truth, stalls=again.truth.stalls[:3], taken=again.truth.taken[:3])
    again.fly([-30.0] * 20)
    assert again.mapper.get_occupancy_map().stalls.keys() == known.keys()


def test_few_stalls_are_doubtful_near_known_ones_only_and_not_for_ever() -> None:
    known = row(3, np.ones(3)).places
    relocation = AfterSwap()
    assert relocation.is_doubtful(known, np.array([[0.0, 2.0]]))
    assert not relocation.is_doubtful(known, np.array([[0.0, 20.0]]))
    assert not relocation.is_doubtful(known, known[:0])
    assert not relocation.is_doubtful(known[:0], known)
    assert not all(relocation.is_doubtful(known, known) for _ in range(50))
