"""Disagreement between camera and report that adds up, by values."""

from __future__ import annotations

import cmath
import math
from itertools import pairwise

import pytest

from hawk.ddc.witnesses.walk import (
    AGAIN_FLOOR,
    AGAIN_SHARE,
    FLOOR_M,
    MOVING_M,
    NET_SHARE,
    NOTHING,
    PATH_SHARE,
    RECORDS,
    SIGMA_M,
    SIGMAS,
    TILT,
    TIME_S,
    WORST_SIGMA_M,
    Found,
    Odometer,
    Record,
    Sample,
    Scale,
    SlowWalk,
    floor,
)
from hawk.ddc.witnesses.walk import wander as wandered
from hawk.model.pictures import GroundAgain, GroundStep

PROVEN = Scale(0j, is_proven=True)


def test_an_honest_receiver_wanders_some_metres_in_ten_minutes() -> None:
    assert wandered(0.0) == 0.0
    assert wandered(-1.0) == 0.0
    assert wandered(600.0) == pytest.approx(SIGMAS * SIGMA_M * math.sqrt(2 * (1 - math.exp(-600.0 / TIME_S))))
    assert wandered(600.0) == pytest.approx(9.0, abs=0.1)
    assert wandered(1e9) == pytest.approx(SIGMAS * SIGMA_M * math.sqrt(2))


@pytest.mark.parametrize(("height", "metres"), [(0.0, FLOOR_M), (25.0, FLOOR_M), (60.0, 2.4 * FLOOR_M)])
def test_the_cameras_own_error_grows_with_the_height(height: float, metres: float) -> None:
    assert floor(height) == pytest.approx(metres)


@pytest.mark.parametrize(
    ("accuracy", "sigma"),
    [(None, SIGMA_M), (1.0, SIGMA_M), (2.9, SIGMA_M), (4.23, 3.0), (5.7, 4.0), (50.0, WORST_SIGMA_M)],
)
def test_a_receiver_that_says_that_it_is_worse_may_wander_more_up_to_a_limit(
    accuracy: float | None, sigma: float
) -> None:
    expected = SIGMAS * sigma * math.sqrt(2 * (1 - math.exp(-0.5)))
    assert wandered(300.0, accuracy) == pytest.approx(expected, rel=0.02)


def test_sways_below_two_metres_are_no_path() -> None:
    odometer = Odometer()
    for k in range(8):
        odometer.move(1.9 * (-1) ** k + 0j)
    assert (odometer.flown, odometer.place) == (0.0, 0j)
    odometer.move(2 + 0j)
    odometer.move(1j)
    odometer.move(1j)
    assert (odometer.flown, odometer.place) == (4.0, 2 + 2j)


@pytest.mark.parametrize(
    ("off", "moved", "is_proven", "allowed"),
    [
        (5.0, 10.0, True, 0.6),
        (4.0, 10.0, False, 1.2),
        (4.1, 10.0, False, 19.0),
        (3.0, 0.5, False, 0.5),
        (3.0, 1.0, False, 1.0),
        (3.0, 2.0, False, 3.0),
    ],
)
def test_a_scale_explains_a_share_of_the_movement(off: float, moved: float, is_proven: bool, allowed: float) -> None:
    assert Scale(0j, is_proven).allowed(off, moved, 0.06) == pytest.approx(allowed)


def looked(before: Sample, now: Sample, scale: Scale = PROVEN, share: float = NET_SHARE) -> Found:
    return Record(share, before).look(now, scale)


def test_a_record_takes_off_what_the_scale_the_path_and_the_gaps_explain() -> None:
    before = Sample(10.0, 1 + 0j, 2 + 0j, flown=5.0, noise=1.0)

    def wander(seconds: float, accuracy: float | None = None) -> float:
        return FLOOR_M + wandered(seconds, accuracy)

    still = looked(before, Sample(20.0, 9 + 0j, 2 + 0j, flown=5.0, noise=1.0))
    assert still.beyond == pytest.approx(8.0 - wander(10.0))
    assert (still.off, still.since) == (8 + 0j, 10.0)
    moved = looked(before, Sample(20.0, 9 + 0j, 12 + 0j, flown=5.0, noise=1.0))
    assert moved.beyond == pytest.approx(8.0 - wander(10.0) - NET_SHARE * 10.0)
    learned = looked(before, Sample(20.0, 9 + 0j, 12 + 0j, flown=5.0, noise=1.0), Scale(0.1 + 0j, True))
    assert learned.beyond == pytest.approx(7.0 - wander(10.0) - NET_SHARE * 10.0)
    assert learned.off == 7 + 0j
    flown = looked(before, Sample(20.0, 9 + 0j, 2 + 0j, flown=10.0, noise=5.0))
    assert flown.beyond == pytest.approx(8.0 - wander(10.0) - PATH_SHARE * 5.0 - MOVING_M / 2 - 2.0)
    far = looked(before, Sample(20.0, 9 + 0j, 2 + 0j, flown=105.0, noise=1.0))
    assert far.beyond == pytest.approx(8.0 - wander(10.0) - PATH_SHARE * 100.0 - MOVING_M)
    tilted = looked(Sample(10.0, 0j, 0j, tilt=1 + 0j), Sample(20.0, 8 + 0j, 0j, tilt=1j))
    assert tilted.beyond == pytest.approx(8.0 - wander(10.0) - math.sqrt(2.0))
    worse = looked(before, Sample(20.0, 9 + 0j, 2 + 0j, flown=5.0, noise=1.0), Scale(0j, is_proven=True, accuracy=5.0))
    assert worse.beyond == pytest.approx(8.0 - wander(10.0, 5.0))
    high = looked(before, Sample(20.0, 9 + 0j, 2 + 0j, flown=105.0, noise=1.0, height=50.0))
    assert high.beyond == pytest.approx(8.0 - wander(10.0) - PATH_SHARE * 100.0 - 2 * MOVING_M - FLOOR_M)


def test_a_small_disagreement_is_nothing_and_so_is_a_picture_that_stands_still() -> None:
    assert looked(Sample(0.0, 0j, 0j), Sample(9.0, complex(FLOOR_M - 0.01), 0j)).beyond < 0.0
    assert looked(Sample(0.0, 0j, 0j), Sample(9.0, -9.5 + 0j, 10 + 0j)) is NOTHING
    assert looked(Sample(0.0, 0j, 0j), Sample(9.0, -8.5 + 0j, 10 + 0j)) is not NOTHING
    assert looked(Sample(0.0, 0j, 0j), Sample(9.0, -9 + 0j, 10 + 0j)) is not NOTHING, "a tenth of the path is seen"
    assert looked(Sample(0.0, 0j, 0j), Sample(9.0, -2.9 + 0j, 2.9 + 0j)) is not NOTHING


def test_what_stretch_and_turn_explain_is_no_disagreement() -> None:
    """The picture was turned by 90° already: 10 m north, seen as 10 m east, are 10 m north by it."""
    before = Sample(0.0, 0j, 0j, eased=3 + 0j, warp=-1j)
    now = Sample(9.0, -10 + 10j, 10 + 0j, eased=3 + 10j * -1j, warp=-1j)
    assert now.off_since(before) == pytest.approx(10j * -1j / -1j - 10)
    assert Sample(9.0, 1j, 10 + 0j, eased=20 + 0j).off_since(Sample(0.0, 0j, 0j, eased=0j)) == 1j
    assert Sample(9.0, 10j, 10 + 0j, eased=11 + 0j).off_since(Sample(0.0, 0j, 0j, eased=0j)) == 1 + 0j
    assert Sample(9.0, 10j, 10 + 0j, eased=11 + 0j).off_since(Sample(0.0, 0j, 0j)) == 10j


def test_a_record_keeps_a_moment_of_two_seconds_the_first_and_few_of_the_old_ones() -> None:
    record, compared = Record(NET_SHARE), []
    for k in range(3000):
        compared.append(len(record._samples))
        record.keep(Sample(k * 0.4, 0j, 0j))
    times = [each.time for each in record._samples]
    assert times[0] == 0.0
    assert times[-1] >= 3000 * 0.4 - 2.8
    assert max(compared) < 60
    assert all(after - before <= 0.3 * (1200.0 - before) + 4.0 for before, after in pairwise(times))


# -- both records ------------------------------------------------------------------------------------------------------


def step(now: float, beyond: complex = 0j, reported: complex = 0j, again: GroundAgain | None = None) -> GroundStep:
    seen = reported + beyond
    return GroundStep(now - 0.4, now, (seen.real, seen.imag), (reported.real, reported.imag), 0.0, 0.0, 20.0, again)


def test_the_sum_of_the_steps_goes_on_over_a_gap_and_begins_again_after_a_long_one() -> None:
    walk = SlowWalk()
    walk.look(step(0.4), PROVEN, False)
    walk.bridge(3 + 0j, 0.5)
    walk.bridge(2 + 0j, 0.5)
    found = walk.look(step(10.0, 1 + 0j), PROVEN, False)
    assert (found.off, found.since) == (6 + 0j, 0.4)
    assert found.beyond == pytest.approx(6.0 - FLOOR_M - wandered(9.6) - math.sqrt(0.5))
    walk.forget_steps()
    assert walk.look(step(10.8), PROVEN, False).beyond <= 0.0
    assert walk.look(step(11.2, 1 + 0j), PROVEN, False).beyond <= 0.0


def test_an_earlier_picture_counts_from_its_own_moment_and_only_where_it_counts() -> None:
    walk = SlowWalk()
    again = GroundAgain(5.0, (0.0, 9.0), (1.0, 0.0), math.pi)
    assert walk.look(step(20.0, again=again), PROVEN, False).beyond <= 0.0
    for now in (20.4, 20.8):
        assert walk.look(step(now, again=again), PROVEN, True).beyond <= 0.0, "a match alone may be a wrong one"
    found = walk.look(step(21.2, again=again), PROVEN, True)
    assert (found.off, found.since) == (9j, 5.0)
    assert found.beyond == pytest.approx(
        9.0 - AGAIN_FLOOR * FLOOR_M - wandered(16.2) - AGAIN_SHARE * 1.0 - 2 * TILT * 20.0
    )
    assert walk.look(step(21.6), PROVEN, True) is found, "the last word of the pictures stands"
    assert bool(walk.is_sure) is False
    assert walk.look(step(22.0, 9 + 0j), PROVEN, True).beyond > 0.0
    assert bool(walk.is_sure) is True
    walk.look(step(23.3), PROVEN, True)
    assert bool(walk.is_sure) is False, "it is old"


@pytest.mark.parametrize("size", [3.0, 6.0, 12.0])
def test_a_wrong_match_shows_no_walk_and_neither_do_the_right_ones_after_it(size: float) -> None:
    walk = SlowWalk()
    for k in range(200):
        off = size if k % 10 == 5 else 0.0
        again = GroundAgain(0.0, (off, 0.0), (0.0, 0.0), 0.0)
        assert walk.look(step(10.0 + 0.5 * k, again=again), PROVEN, True).beyond <= 0.0


def test_matches_that_differ_or_lie_apart_in_time_confirm_nothing() -> None:
    walk = SlowWalk()
    for k in range(20):
        again = GroundAgain(0.0, (8.0 + 1.1 * (k % 2), 0.0), (0.0, 0.0), 0.0)
        assert walk.look(step(10.0 + 0.5 * k, again=again), PROVEN, True).beyond <= 0.0
    again = GroundAgain(0.0, (8.0, 0.0), (0.0, 0.0), 0.0)
    for k in range(20):
        assert walk.look(step(30.0 + 2.1 * k, again=again), PROVEN, True).beyond <= 0.0


def test_the_comparisons_of_the_last_pictures_are_kept() -> None:
    walk = SlowWalk()
    for k in range(RECORDS + 5):
        walk.look(step(200.0 + k, again=GroundAgain(float(k), (0.0, 0.0), (0.0, 0.0), 0.0)), PROVEN, True)
    assert len(walk._pictures) == RECORDS
    assert min(walk._pictures) == 5.0


# -- limits ------------------------------------------------------------------------------------------------------------


def test_no_receiver_is_allowed_for_more_than_four_metres() -> None:
    assert wandered(300.0, 50.0) == pytest.approx(SIGMAS * 4.0 * math.sqrt(2 * (1 - math.exp(-0.5))))


def test_a_camera_that_is_known_to_be_off_hides_no_walk_against_its_error() -> None:
    """It sees 10 % more than 50 m; it saw 5 m less: the position has walked by 10 m."""
    found = looked(Sample(0.0, 0j, 0j), Sample(9.0, -5 + 0j, 50 + 0j), Scale(0.1 + 0j, True))
    assert found.off == pytest.approx(-10 + 0j)
    assert found.beyond > 0.0


def test_what_a_moment_does_not_say_adds_nothing() -> None:
    """It has no noise of its own, and the other moment's height counts."""
    bare = looked(Sample(0.0, 0j, 0j), Sample(9.0, 8 + 0j, 0j))
    assert bare.beyond == pytest.approx(8.0 - FLOOR_M - wandered(9.0))
    noisy = looked(Sample(0.0, 0j, 0j), Sample(9.0, 8 + 0j, 0j, noise=1.0))
    assert noisy.beyond == pytest.approx(bare.beyond - 1.0)


def test_a_record_without_a_moment_until_then_says_zero() -> None:
    record = Record(NET_SHARE, Sample(10.0, 3 + 0j, 4 + 0j))
    assert record.last(10.0) == (3 + 0j, 4 + 0j)
    assert record.last(9.9) == (0j, 0j)


@pytest.mark.parametrize(("off", "is_walk"), [(3.5, False), (4.0, True)])
def test_a_flight_of_ten_metres_allows_for_a_metre_and_a_half_more(off: float, is_walk: bool) -> None:
    """There and back: 1.5 m of floor, 1.5 m of sways, 3 % of ten metres, and what the receiver may wander in 1 s."""
    walk = SlowWalk()
    walk.look(step(0.4), PROVEN, False)
    walk.look(step(0.8, reported=5 + 0j), PROVEN, False)
    found = walk.look(step(1.4, complex(0.0, off), -5 + 0j), PROVEN, False)
    assert (found.beyond > 0.0) is is_walk


def test_ground_that_grows_and_turns_as_the_steps_say_is_no_walk() -> None:
    """Each picture shows 4 m as 6 % longer, and turned by 0.04 rad more against the clock, than the one before."""
    walk, seen = SlowWalk(), 4 + 0j
    walk.look(step(0.0), PROVEN, False)
    for k in range(1, 10):
        seen *= cmath.exp(complex(0.06, -0.04))
        until = 0.2 * k
        turned = GroundStep(until - 0.2, until, (seen.real, seen.imag), (4.0, 0.0), 0.06, 0.04, 20.0)
        assert walk.look(turned, PROVEN, False).beyond < 0.0


def matched(walk: SlowWalk, now: float, off: float, reported: float = 0.0, since: float = 0.0) -> Found:
    """Look at a step that is compared with the picture of ``since``, which shows ``off`` metres east."""
    return walk.look(step(now, again=GroundAgain(since, (0.0, off), (reported, 0.0), 0.0)), PROVEN, True)


def test_an_earlier_picture_shows_a_walk_from_far_as_well() -> None:
    """20 m away it may be off by 2.4 m more."""
    walk = SlowWalk()
    found = [matched(walk, 10.0 + 0.4 * k, 9.0, 20.0).beyond for k in range(3)]
    assert found[-1] > 0.0


@pytest.mark.parametrize(("apart", "is_walk"), [(0.9, True), (1.0, True), (1.1, False)])
def test_matches_that_differ_by_up_to_a_metre_confirm_each_other(apart: float, is_walk: bool) -> None:
    walk = SlowWalk()
    found = [matched(walk, 10.0 + 0.4 * k, 8.0 + apart * (k % 2)) for k in range(4)]
    assert (found[-1].beyond > 0.0) is is_walk


@pytest.mark.parametrize(("every", "is_walk"), [(2.0, True), (2.1, False)])
def test_matches_up_to_two_seconds_apart_confirm_each_other(every: float, is_walk: bool) -> None:
    walk = SlowWalk()
    found = [matched(walk, 10.0 + every * k, 8.0) for k in range(4)]
    assert (found[-1].beyond > 0.0) is is_walk


def test_matches_that_show_no_walk_confirm_none() -> None:
    """3 m are less than the floor of 2.25 m, and what the receiver may wander in 10 s: 1.45 m; 3.9 m are more."""
    walk = SlowWalk()
    for k in range(5):
        assert matched(walk, 10.0 + 0.1 * k, 3.0).beyond < 0.0
    assert matched(walk, 10.5, 3.9).beyond < 0.0
    assert matched(walk, 10.6, 3.9).beyond < 0.0
    assert matched(walk, 10.7, 3.9).beyond > 0.0


def test_how_far_the_drone_is_off_counts_from_what_the_picture_showed_last_while_the_report_was_right() -> None:
    """It was off by 1 m before the walk, and by 2 m in it: the whole of 5 m beyond the first is the walk's."""
    walk = SlowWalk()
    matched(walk, 10.0, 1.0, 10.0)
    matched(walk, 20.0, 2.0, 10.0)
    again = GroundAgain(0.0, (0.0, 6.0), (20.0, 0.0), 0.0)
    assert walk.off_by(again, 0j, 15.0) == 5j
    assert walk.off_by(again, 0j, 25.0) == 4j
    assert walk.off_by(again, 0.1 + 0j, 15.0) == pytest.approx(5j - 1.0)
    assert walk.off_by(GroundAgain(5.0, (0.0, 6.0), (20.0, 0.0), 0.0), 0.1 + 0j, 15.0) == 6j - 2.0, "never looked at"


def test_a_movement_that_is_seen_stretched_and_turned_since_an_earlier_moment_agrees_with_the_report() -> None:
    warp = cmath.exp(complex(-0.5, 0.3))
    before = Sample(0.0, 0j, 0j, 3 + 1j, warp)
    now = Sample(9.0, 5 + 0j, 8 + 2j, 3 + 1j + warp * (8 + 2j), warp)
    assert abs(now.off_since(before)) == pytest.approx(0.0, abs=1e-9)


def test_a_gap_is_bridged_in_the_ground_as_it_was_seen_at_its_begin() -> None:
    """Each picture shows the ground 5 % larger: after 20 of them a metre of the gap is .37 m of the first picture."""
    walk, seen = SlowWalk(), 1 + 0j
    walk.look(step(0.0), PROVEN, False)
    for k in range(1, 21):
        seen *= math.exp(0.05)
        grown = GroundStep(0.05 * k - 0.05, 0.05 * k, (seen.real, 0.0), (1.0, 0.0), 0.05, 0.0, 20.0)
        assert walk.look(grown, PROVEN, False).beyond < 0.0
    walk.bridge(9j, 0.0)
    found = walk.look(step(1.4), PROVEN, False)
    assert abs(found.off) == pytest.approx(9.0 * math.exp(-1.0), rel=0.1)
