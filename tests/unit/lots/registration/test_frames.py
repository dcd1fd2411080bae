"""Moves between frames keep places on Earth where they are, and pairs of stalls are one to one."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from hawk.lots.plan.values import LayoutStall
from hawk.lots.registration.frames import MATCH_M, Move, frame_of, frames_of, same_stalls, turned
from hawk.lots.registration.georeference import about
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import to_global
from tests.unit.lots.surveys import DATUM, stall

METRES = st.floats(-300, 300)
MOVES = st.builds(Move, METRES, METRES, st.floats(-math.pi, math.pi))
PLACES = st.lists(st.tuples(METRES, METRES), min_size=1, max_size=20).map(np.array)
LATITUDES = st.floats(-70, 70)


def stored(number: int, label: str, **changed: float) -> LayoutStall:
    shown = replace(stall(number), **changed)  # type: ignore[arg-type]
    return LayoutStall(label, label, shown.north, shown.east, shown.angle, shown.width, shown.length, "", False, False)


@pytest.mark.slow
@given(PLACES, MOVES, MOVES)
def test_two_moves_one_after_the_other_are_one_move(places: np.ndarray, first: Move, then: Move) -> None:
    assert then.after(first).of(places) == pytest.approx(then.of(first.of(places)), abs=1e-6)
    assert first.back(first.of(places)) == pytest.approx(places, abs=1e-6)


@pytest.mark.slow
@given(PLACES, LATITUDES, st.floats(-40, 40), st.floats(-40, 40))
def test_a_place_is_the_same_on_earth_in_both_frames(
    places: np.ndarray, latitude: float, north: float, east: float
) -> None:
    datum = GlobalPose(latitude, 5.0, 0.0)
    ((a, b),) = to_global(datum, np.array([[north, east]])).tolist()
    other = GlobalPose(a, b, 0.0)
    move = frame_of((latitude, 5.0), (a, b))
    truth = about((latitude, 5.0), to_global(other, places))[:, :2]
    assert move.of(places) == pytest.approx(truth, abs=0.002)
    assert move.of(np.zeros((1, 2)))[0] == pytest.approx([north, east], abs=0.001)


@given(PLACES, st.floats(-math.pi, math.pi))
def test_many_places_are_turned_as_each_alone_is(places: np.ndarray, turn: float) -> None:
    turns = np.linspace(turn, 2 * turn, len(places))
    alone = [Move(turn=float(angle)).of(place[None])[0] for place, angle in zip(places, turns, strict=True)]
    assert turned(places, turns) == pytest.approx(np.array(alone), abs=1e-9)


def test_many_frames_are_those_of_each_alone() -> None:
    here, others = (52.0, 5.0), np.array([(52.0001, 5.0002), (51.9, 5.1), (52.0, 5.0)])
    shifts, turns = frames_of(here, others)
    for shift, turn, (latitude, longitude) in zip(shifts.tolist(), turns.tolist(), others.tolist(), strict=True):
        move = frame_of(here, (latitude, longitude))
        assert (move.north, move.east, move.turn) == (*shift, turn)


@pytest.mark.parametrize("metres", [3.0, 30.0])
def test_there_and_back_is_no_move(metres: float) -> None:
    here = (DATUM.latitude, DATUM.longitude)
    ((a, b),) = to_global(DATUM, np.array([[metres, -metres]])).tolist()
    round_trip = frame_of((a, b), here).after(frame_of(here, (a, b)))
    places = np.array([(0.0, 0.0), (150.0, 0.0), (0.0, -150.0)])
    assert round_trip.of(places) == pytest.approx(places, abs=1e-3)


def test_a_turn_is_clockwise_and_turns_stalls_and_ground_alike() -> None:
    move = Move(10.0, 20.0, math.pi / 2)
    assert move.of(np.array([[5.0, 0.0]])) == pytest.approx(np.array([[10.0, 25.0]]))  # what is north comes to lie east
    (moved,) = move.stalls([replace(stall(1), north=5.0, east=0.0, angle=0.1)])
    assert (moved.north, moved.east, moved.angle) == pytest.approx((10.0, 25.0, math.pi / 2 + 0.1))
    assert move.ground(shapely.box(0, 0, 4, 2)).bounds == pytest.approx((8.0, 20.0, 10.0, 24.0))
    assert move.stalls([]) == ()


def test_each_stall_is_the_nearest_one_and_no_two_are_the_same() -> None:
    known = [stored(1, "a", north=0.0, east=0.0), stored(1, "b", north=0.0, east=2.5)]
    near = replace(stall(1), id=7, north=0.2, east=0.1, angle=known[0].angle)
    nearer = replace(near, id=8, north=0.0, east=0.1)
    far = replace(near, id=9, north=0.0, east=2.5 + MATCH_M + 0.01)
    crossed = replace(near, id=10, north=0.0, east=2.5, angle=known[0].angle + 0.5)
    opposite = replace(near, id=11, north=0.0, east=2.6, angle=known[0].angle + math.pi - 0.01)
    assert same_stalls(known, [near, nearer, far, crossed]) == {8: "a"}
    assert same_stalls(known, [near, opposite]) == {7: "a", 11: "b"}
    assert same_stalls(known, []) == same_stalls([], [near]) == {}


@given(st.lists(st.tuples(METRES, METRES), min_size=2, max_size=20, unique=True).map(np.array), MOVES)
def test_the_nearest_move_of_places_that_were_moved_is_that_move(places: np.ndarray, move: Move) -> None:
    found = Move.nearest(places, move.of(places))
    assert found.of(places) == pytest.approx(move.of(places), abs=1e-6)


def test_one_place_has_a_shift_and_no_turn() -> None:
    assert Move.nearest(np.array([[1.0, 2.0]]), np.array([[4.0, 6.0]])) == Move(3.0, 4.0, 0.0)
