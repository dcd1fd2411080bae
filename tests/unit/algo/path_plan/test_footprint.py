from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.ground import Bools, Floats
from hawk.algo.path_plan.footprint import Corners, Footprint, Lean, LeanObserver, Singles, Swath, momenta
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.model.poses import MapPose

PICTURE = Footprint(40.0, 24.0, 19.0, 23.0)
CELLS = np.random.default_rng(3).uniform(-30, 30, (1500, 2)).astype(np.float32)
LEANING = Footprint(40.0, 24.0, 19.0, 19.0, Lean(corner=10.0, start=12.0, stop=6.0, radius=16.0))
NORTH, NOWHERE = (1.0, 0.0), (0.0, 0.0)


def corners(
    *, before: tuple[float, float] | Floats = NORTH, turned: float = 0.0, last: bool = False, legs: int = 1
) -> Corners:
    return Corners(np.broadcast_to(np.array(before), (legs, 2)), np.full(legs, turned), np.full(legs, last))


def in_picture(cells: Singles, heading: float) -> Bools:
    """Return True for cells that a picture taken at the origin shows."""
    along = cells[:, 0] * math.cos(heading) + cells[:, 1] * math.sin(heading)
    across = cells[:, 1] * math.cos(heading) - cells[:, 0] * math.sin(heading)
    return np.asarray((np.abs(along) <= PICTURE.depth / 2) & (np.abs(across) <= PICTURE.width / 2))


@pytest.mark.slow
@settings(max_examples=40)
@given(st.floats(-3.1, 3.1), st.floats(-3.1, 3.1))
def test_a_turn_shows_what_the_picture_passes_over(begin: float, end: float) -> None:
    turn = math.remainder(end - begin, math.tau)
    passed = np.any([in_picture(CELLS, begin + turn * share) for share in np.linspace(0, 1, 200)], axis=0)
    near = np.hypot(*CELLS.T) <= PICTURE.spun
    shown = PICTURE.swept(CELLS, np.zeros(2), begin, np.array([end]))[0]
    assert not shown[~near].any()
    assert np.count_nonzero(shown[near] != passed[near]) <= 0.01 * len(CELLS)


def test_turning_by_as_much_as_a_cell_needs_shows_it() -> None:
    near = CELLS[np.hypot(*CELLS.T) <= PICTURE.spun]
    left, right = PICTURE.turns_until_shown(near, 0.4)
    assert ((left == 0) == in_picture(near, 0.4)).all()
    assert ((right == 0) == in_picture(near, 0.4)).all()
    for cell, to_left, to_right in zip(near[::50], left[::50], right[::50], strict=True):
        for turn in (-to_left, to_right):
            assert in_picture(cell[None], 0.4 + turn + math.copysign(1e-3, turn))[0]
            assert turn == 0 or not in_picture(cell[None], 0.4 + turn - math.copysign(1e-2, turn))[0]


def test_a_leg_shows_a_disc_about_its_ends_where_the_picture_turns() -> None:
    begin, end = np.array([[0.0, 0.0]]), np.array([[50.0, 0.0]])
    cells = np.array([[-18.0, 0.0], [72.0, 0.0], [-14.0, 14.0], [25.0, 19.0], [25.0, 21.0]], np.float32)
    assert PICTURE.shown(cells, begin, end)[0].tolist() == [False, False, False, True, False]
    for there, shown in ((corners(turned=PICTURE.turned), [1, 0, 0, 1, 0]), (corners(last=True), [0, 1, 0, 1, 0])):
        assert PICTURE.shown(cells, begin, end, there)[0].astype(int).tolist() == shown
    straight = Footprint(40.0, 24.0)
    assert straight.shown(cells, begin, end, corners(last=True))[0].tolist() == [False, False, False, True, False]


def test_half_a_turn_shows_the_disc_that_the_corners_sweep_and_nothing_beyond_them() -> None:
    swath = Swath(PICTURE.width, PICTURE.depth, 35.0)
    near, far = (np.hypot(*CELLS.T) <= 0.999 * swath.reach, np.hypot(*CELLS.T) > swath.reach)
    passed = np.any([in_picture(CELLS, angle) for angle in np.linspace(0, math.pi, 400)], axis=0)
    assert np.count_nonzero(near & ~passed) <= 0.002 * len(CELLS)
    assert not (far & passed).any()
    left, right = PICTURE.turns_until_shown(CELLS[near], 0.0)
    assert max(left.max(), right.max()) < math.radians(122)
    assert Footprint.of(swath, PathPlanSettings(spun_share=0.9)).spun == pytest.approx(0.9 * swath.reach)


def test_between_two_legs_the_turning_picture_shows_the_disc_that_is_counted_on() -> None:
    """Whatever the corner: two legs and the turn on the spot between them."""
    radius = np.hypot(*CELLS.T)
    for turn in np.linspace(0.1, math.pi, 12):
        ends = np.array([[-60.0, 0.0], [60 * math.cos(turn), 60 * math.sin(turn)]])
        legs = PICTURE.shown(CELLS, np.array([ends[0], [0, 0]]), np.array([[0, 0], ends[1]])).any(0)
        turned = np.any([in_picture(CELLS, turn * share) for share in np.linspace(0, 1, 100)], axis=0)
        counted = PICTURE.shown(CELLS, np.zeros((1, 2)), ends[1:], corners(turned=PICTURE.turned))[0]
        assert not (counted & (radius <= PICTURE.turned) & ~legs & ~turned).any()


def test_cells_far_off_are_shown_by_no_turn() -> None:
    far = np.array([[50.0, 0.0]], np.float32)
    assert not PICTURE.swept(far, np.zeros(2), 0.0, np.array([3.0])).any()
    assert PICTURE.shown(
        far, np.zeros((1, 2)), np.ones((1, 2)), corners(turned=PICTURE.turned, last=True)
    ).sum() == pytest.approx(0)


def test_a_drone_that_speeds_up_looks_behind_and_one_that_brakes_ahead() -> None:
    begin, end = np.zeros((1, 2)), np.array([[50.0, 0.0]])
    cells = np.array([[-23.0, 18.0], [-25.0, 0.0], [67.0, -18.0], [69.5, 0.0]], np.float32)
    assert not LEANING.shown(cells, begin, end)[0].any()
    assert LEANING.shown(cells, begin, end, corners(before=NOWHERE))[0].tolist() == [True, False, False, False]
    assert LEANING.shown(cells, begin, end, corners(last=True))[0].tolist() == [False, False, True, False]


def test_in_a_corner_the_picture_swings_outwards() -> None:
    """Flying north, then east: north-west of the corner is shown; flying on straight on nothing more than the swath."""
    begin, east, north = np.zeros((1, 2)), np.array([[0.0, 60.0]]), np.array([[60.0, 0.0]])
    cells = np.array([[20.0, -15.0], [20.0, 15.0], [-20.0, -15.0]], np.float32)
    assert LEANING.shown(cells, begin, east, corners())[0].tolist() == [True, True, False]
    assert Footprint(40.0, 24.0, 19.0, 19.0).shown(cells, begin, east, corners())[0].tolist() == [False, True, False]
    aside = np.array([[0.0, 21.0], [0.0, -21.0], [-21.0, 0.0]], np.float32)
    assert not LEANING.shown(aside, begin, north, corners())[0].any()


def test_on_a_flight_straight_back_the_picture_swings_farthest() -> None:
    back = np.array([[-60.0, 0.0]])
    cells = np.array([[35.0, 0.0], [37.0, 0.0], [30.0, 12.0]], np.float32)
    assert LEANING.shown(cells, np.zeros((1, 2)), back, corners())[0].tolist() == [True, False, True]


def test_on_a_leg_too_short_to_gather_speed_the_picture_moves_by_as_little() -> None:
    """Waypoints a step apart would else promise what only a drone at speed shows, ahead, behind and outwards."""
    begin, step, leg = np.zeros((1, 2)), np.array([[0.3, 0.0]]), np.array([[30.0, 0.0]])
    behind = np.array([[-14.0, 0.0]], np.float32)
    for end, shown in ((step, False), (leg, True)):
        assert bool(LEANING.shown(behind, begin, end, corners(before=NOWHERE))[0, 0]) is shown
        far = np.array([[end[0, 0] + LEANING.depth / 2 + 5.0, LEANING.width / 2 - 1.0]], np.float32)
        assert bool(LEANING.shown(far, begin, end, corners(last=True))[0, 0]) is shown
    back = np.array([[-60.0, 0.0]])
    ahead = np.array([[20.0, 0.0]], np.float32)
    for length, shown in ((0.3, False), (3.0, True), (40.0, True)):
        before = momenta(np.array([[length, 0.0]]))
        assert bool(LEANING.shown(ahead, begin, back, corners(before=before))[0, 0]) is shown
    assert not LEANING.shown(ahead, begin, np.array([[-0.3, 0.0]]), corners())[0, 0]


def test_how_far_a_picture_moves_follows_from_height_and_lean() -> None:
    swath = Swath(41.6, 23.4, 35.0)
    lean = Lean.of(swath, PathPlanSettings(lean_deg=16.0, stop_lean_deg=9.0, lean_share=0.8))
    assert lean.corner == pytest.approx(35 * math.tan(math.radians(16)))
    rear = math.degrees(math.atan2(23.4 / 2 + lean.start, 35.0))
    assert rear == pytest.approx(math.degrees(math.atan2(23.4 / 2, 35.0)) + 16.0)
    assert 0 < lean.stop < lean.start
    assert lean.radius == pytest.approx(0.8 * 41.6 / 2)


def test_a_drone_that_leans_less_than_expected_is_found_out_and_one_that_leans_more_is_not_counted_on() -> None:
    settings = PathPlanSettings(lean_deg=16.0)
    for tilt_deg, share in ((0.0, 0.0), (8.0, 0.5), (25.0, 1.0)):
        watch = LeanObserver(settings)
        assert watch.share == 1.0
        for number in range(60):
            pitch = math.radians(tilt_deg) if number % 10 == 3 else 0.0
            watch.take(MapPose(0.0, 0.0, 35.0, 0.0, pitch, 0.0), speed=5.0)
        assert watch.share == pytest.approx(share)


def test_a_drone_that_only_hovers_shows_nothing_of_its_lean() -> None:
    watch = LeanObserver(PathPlanSettings())
    for _ in range(200):
        watch.take(MapPose(0.0, 0.0, 35.0, 0.0, 0.0, 0.0), speed=0.3)
    assert watch.share == 1.0


def test_without_lean_a_leg_shows_what_a_level_picture_does() -> None:
    swath = Swath(40.0, 24.0, 35.0)
    level = Footprint.of(swath, PathPlanSettings(), leans=0.0)
    plain = Footprint(40.0, 24.0, level.turned, level.spun)
    for before in (NORTH, NOWHERE):
        there = corners(before=before, turned=PICTURE.turned, last=True)
        begin, end = np.zeros((1, 2)), np.array([[20.0, 7.0]])
        assert (level.shown(CELLS, begin, end, there) == plain.shown(CELLS, begin, end, there)).all()
