"""The reported position against the camera's motion over ground, by values."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hawk.ddc.witnesses.place import (
    CONFIRM_S,
    GAP_M,
    LIMIT_HEIGHT_M,
    LIMIT_M,
    LOST_S,
    PATH_SHARE,
    STILL_GAP_M,
    PlaceFacts,
    PlaceReading,
)
from hawk.model.pictures import GroundAgain, GroundStep
from tests.unit.ddc.witnesses.place_steps import STEP_S, Flight, again, held, step


def test_before_the_first_step_nothing_is_said() -> None:
    facts = Flight().facts()
    assert facts == PlaceFacts()
    assert (facts.is_doubted, facts.words, facts.off_m, facts.is_followed) == (False, "", 0.0, False)


def test_a_walk_while_it_holds_is_doubted_before_three_metres() -> None:
    flight = Flight()
    flight.fly(20.0)
    after = flight.doubted_after(10.0, walk=0.7)
    assert 2.0 < after * 0.7 < LIMIT_M + CONFIRM_S
    facts = flight.facts()
    assert facts.doubted_s == 0.0
    assert facts.off == pytest.approx((after * 0.7, 0.0), abs=0.3)
    assert facts.is_followed
    assert facts.words == "The camera sees the drone move 3 m that the position does not show."
    assert flight.fly(10.0, walk=0.7).off == pytest.approx((facts.off[0] + 7.0, 0.0), abs=0.01)
    assert flight.facts().doubted_s == pytest.approx(10.0, abs=0.01)


def test_a_disagreement_that_grows_is_doubted_by_the_first_look_beyond_the_limit() -> None:
    flight = Flight()
    flight.fly(20.0)
    assert LIMIT_M < flight.doubted_after(10.0, walk=1.4) * 1.4 < LIMIT_M + 1.4 * STEP_S


def test_high_above_it_must_last_since_one_look_may_err_as_the_one_before() -> None:
    flight = Flight()
    flight.height = 60.0
    flight.fly(20.0)
    limit = LIMIT_M * flight.height / LIMIT_HEIGHT_M
    assert limit + 1.4 * STEP_S < flight.doubted_after(10.0, walk=1.4) * 1.4 < limit + 2 * 1.4 * STEP_S


def test_one_wrong_look_is_not_doubted() -> None:
    flight = Flight()
    flight.fly(20.0)
    assert not flight.fly(STEP_S, walk=1.3 * LIMIT_M / STEP_S).is_doubted
    assert not flight.fly(STEP_S, walk=-1.3 * LIMIT_M / STEP_S).is_doubted
    assert not flight.fly(10.0).is_doubted


@pytest.mark.fault("GNSS walks away and takes the estimate with it, all flags good (0.7 m/s), in a task")
@pytest.mark.parametrize("walk", [0.7 + 0j, -0.7 + 0j, 0.7j, 0.5 - 0.5j])
@pytest.mark.parametrize("reported", [4 + 0j, 4j])
def test_a_walk_while_it_flies_is_doubted_too(reported: complex, walk: complex) -> None:
    flight = Flight()
    flight.fly(30.0, reported, camera=1.04)
    assert flight.doubted_after(14.0, reported, walk=walk) <= 10.5


def test_a_walk_in_fast_straight_flight_is_doubted_at_its_turn() -> None:
    """Along a straight line a walk looks like a wrong height or heading; at 8 m/s the share of the path hides it."""
    flight = Flight()
    flight.fly(30.0, 8 + 0j)
    flight.fly(12.0, 8 + 0j, walk=0.7)
    assert flight.doubted_after(10.0, -8 + 0j, walk=0.7) <= 8.0


@pytest.mark.fault("GNSS wanders by 0.5 m within minutes; a height or a compass that is off by 10 % or 5°", "no alarm")
@pytest.mark.slow
def test_a_slow_wander_of_gnss_is_none() -> None:
    """Half a metre to and fro within minutes: 0.26 m in ten seconds at most."""
    flight = Flight()
    for k in range(300):
        facts = flight.fly(2.0, 4 + 0j, walk=complex(0.5 * math.tau / 120 * math.cos(math.tau * k * 2 / 120)))
        assert not facts.is_doubted
    assert facts.apart < 1.0


@pytest.mark.fault("GNSS wanders by 0.5 m within minutes; a height or a compass that is off by 10 % or 5°")
@pytest.mark.parametrize("camera", [1.1, 0.9, complex(math.cos(0.08), math.sin(0.08))])
def test_a_wrong_scale_or_compass_is_no_walk(camera: complex) -> None:
    flight = Flight()
    for reported in (4 + 0j, 4j, -4 + 0j, 8j, -4 - 2j):
        assert not flight.fly(30.0, reported, camera=camera).is_doubted


@pytest.mark.fault("a camera that is turned, or frozen, contradicts the position", "the position is not doubted for it")
def test_a_camera_that_never_agreed_is_believed_only_while_the_drone_holds() -> None:
    turned = Flight()
    assert not turned.fly(40.0, 4 + 0j, camera=1j).is_doubted
    assert turned.fly(14.0, camera=1j).apart < LIMIT_M
    assert turned.fly(10.0, walk=0.7, camera=1j).is_doubted


@pytest.mark.parametrize("walk", [1.4 + 0j, -1.0 + 1.0j])
def test_a_walk_from_the_first_metre_on_is_doubted(walk: complex) -> None:
    assert Flight().doubted_after(10.0, 4 + 0j, walk=walk) <= 10.0


@pytest.mark.parametrize("camera", [1.1, 0.9, complex(math.cos(0.1), math.sin(0.1)), 1j, -1.0, 1.8])
def test_a_wrong_scale_or_mount_is_no_walk_before_the_camera_was_seen_to_agree(camera: complex) -> None:
    flight = Flight()
    for _ in range(30):
        assert not flight.fly(STEP_S, 4 + 0j, camera=camera).is_doubted


def test_a_camera_is_believed_in_flight_after_it_agreed_for_fifteen_metres() -> None:
    flight = Flight()
    assert not flight.fly(10.0, 4 + 0j, walk=2.0).is_doubted
    proven = Flight()
    proven.fly(14.4, 4 + 0j)
    assert proven.fly(10.0, 4 + 0j, walk=2.0).is_doubted


@pytest.mark.fault("a camera that is turned, or frozen, contradicts the position")
def test_a_picture_that_stands_still_is_the_cameras_fault() -> None:
    flight = Flight()
    flight.fly(30.0, 2 + 0j)
    flight.reading.lose()
    assert not flight.fly(12.0, 2 + 0j, camera=0.05).is_doubted
    slow = Flight()
    slow.fly(30.0, 2 + 0j)
    slow.reading.lose()
    assert slow.fly(12.0, 2 + 0j, camera=0.2).is_doubted


def test_a_height_that_is_wrong_more_and_more_is_no_walk() -> None:
    """The barometer drifts: the ground grows, and the camera sees every metre as more."""
    flight = Flight()
    flight.fly(30.0, 4 + 0j)
    factor = 1.0
    for _ in range(25):
        factor *= math.exp(0.03 * STEP_S)
        assert not flight.fly(STEP_S, 4 + 0j, camera=factor, stretch=0.03).is_doubted
    ignorant = Flight()
    ignorant.fly(30.0, 4 + 0j)
    assert ignorant.fly(10.0, 4 + 0j, camera=1.3).is_doubted, "the same without the growth"


def test_a_heading_that_goes_wrong_is_no_walk() -> None:
    flight = Flight()
    flight.fly(30.0, 4 + 0j)
    wrong = 0.0
    for _ in range(25):
        wrong += 0.04 * STEP_S
        camera = complex(math.cos(-wrong), math.sin(-wrong))
        assert not flight.fly(STEP_S, 4 + 0j, camera=camera, turn=0.04).is_doubted


def test_a_doubt_ends_when_the_position_is_back_and_agrees() -> None:
    flight = Flight()
    flight.fly(20.0)
    flight.fly(10.0, walk=0.7)
    assert flight.fly(10.0, walk=-0.7).is_doubted
    assert flight.fly(14.0).is_doubted
    facts = flight.fly(8.0)
    assert (facts.is_doubted, facts.off) == (False, (0.0, 0.0))
    assert flight.doubted_after(10.0, walk=0.7) < 6.0, "the next one is seen as well"


def test_a_doubt_stays_while_the_position_is_off() -> None:
    flight = Flight()
    flight.fly(20.0)
    flight.fly(10.0, walk=0.7)
    assert flight.fly(120.0).is_doubted
    assert flight.facts().off == pytest.approx((7.0, 0.0), abs=0.3)


def test_an_agreement_that_is_broken_begins_again() -> None:
    flight = Flight()
    flight.fly(20.0)
    flight.fly(6.0, walk=0.7)
    flight.fly(6.0, walk=-0.7)
    flight.fly(14.0)
    assert flight.fly(2.4, walk=1.0).is_doubted
    assert flight.fly(4.0, walk=-0.6).is_doubted
    assert flight.fly(14.0).is_doubted
    assert not flight.fly(9.0).is_doubted


def test_a_short_gap_is_bridged_and_a_long_one_is_not() -> None:
    flight = Flight()
    flight.fly(20.0)
    flight.doubted_after(10.0, walk=0.7)
    before = flight.facts().off[0]
    flight.now += 1.6
    facts = flight.fly(STEP_S, walk=0.7)
    assert facts.is_followed
    assert facts.off[0] == pytest.approx(before + 2.0 * 0.7, abs=0.8)
    assert facts.off[0] > before + 0.6
    flight.now += 5.4
    assert not flight.fly(60.0).is_followed
    assert flight.facts().is_doubted, "what happened meanwhile is not known"


def test_a_gap_before_the_doubt_leaves_what_follows_known() -> None:
    flight = Flight()
    flight.fly(20.0)
    flight.now += 30.0
    flight.doubted_after(10.0, walk=0.7)
    assert flight.facts().is_followed
    flight.reading.lose()
    assert not flight.facts().is_followed
    flight.reading.reset()
    assert flight.facts() == PlaceFacts()


def test_a_camera_that_is_silent_follows_no_more() -> None:
    flight = Flight()
    flight.fly(20.0)
    flight.doubted_after(10.0, walk=0.7)
    assert flight.reading.facts(flight.now + LOST_S).is_followed
    late = flight.reading.facts(flight.now + LOST_S + 0.1)
    assert not late.is_followed
    assert late.camera_age == pytest.approx(LOST_S + 0.1)


def test_a_step_of_before_the_last_one_is_ignored() -> None:
    flight = Flight()
    flight.fly(20.0)
    known = flight.facts()
    flight.reading.note(GroundStep(5.0, 5.4, (9.0, 0.0), (0.0, 0.0), 0.0, 0.0, 25.0))
    assert flight.facts() == known


@pytest.mark.parametrize(("reported", "hidden"), [(0j, STILL_GAP_M), (2 + 0j, STILL_GAP_M + GAP_M + PATH_SHARE * 20.0)])
def test_a_missing_comparison_allows_for_half_a_sway_and_for_less_while_it_holds(
    reported: complex, hidden: float
) -> None:
    """The time of one that is missing counts at the pace that was seen: 1.4 m/s for 0.4 s."""
    flight = Flight()
    flight.fly(30.0, reported)
    flight.now += STEP_S
    assert flight.fly((LIMIT_M + hidden) / 1.4 / 2, reported, walk=1.4j).apart < LIMIT_M
    assert flight.doubted_after(5.0, reported, walk=1.4j) <= 5.0


@pytest.mark.fault(
    "one comparison of the camera in four is missing while GNSS walks, all flags good", "doubted as without gaps"
)
@pytest.mark.parametrize("walk", [0.35, 0.7, 1.4])
def test_comparisons_that_are_missing_again_and_again_hide_no_walk(walk: float) -> None:
    flight = Flight()
    flight.fly(20.0)
    began = flight.now
    while not flight.facts().is_doubted and flight.now - began < 60.0:
        flight.fly(3 * STEP_S, walk=walk)
        flight.now += STEP_S
    assert (flight.now - began) * walk <= 5.5


# -- a slow walk ------------------------------------------------------------------------------------------------------


@pytest.mark.fault(
    "GNSS walks away slowly and takes the estimate with it, all flags good (0.1 to 0.3 m/s)",
    "doubted within 8 m, as GNSS that walks faster",
)
@pytest.mark.parametrize(("walk", "late"), [(0.1, 6.0), (0.25, 4.5), (0.3, 4.0), (0.35, 4.0), (0.7, 4.0)])
@pytest.mark.parametrize("before", [0.0, 20.0, 200.0])
@pytest.mark.slow
def test_a_slow_walk_adds_up_however_long_the_drone_has_held(walk: float, late: float, before: float) -> None:
    flight = Flight()
    flight.fly(before)
    assert flight.doubted_after(100.0, walk=walk) * walk <= late
    assert flight.facts().off[0] == pytest.approx((flight.now - before) * walk, abs=0.5)


@pytest.mark.fault("an honest receiver wanders by metres within ten minutes", "no alarm")
@pytest.mark.slow
def test_what_an_honest_receiver_wanders_is_no_walk() -> None:
    """Gauss-Markov of 2.1 m and 600 s, for ten minutes."""
    rng, farthest = np.random.default_rng(1), []
    for _ in range(4):
        flight, error, most = Flight(), 0j, 0.0
        keep = math.exp(-STEP_S / 600.0)
        for _ in range(1500):
            fresh = 2.1 * math.sqrt(1 - keep * keep) * complex(*rng.standard_normal(2))
            walk, error = (error * keep + fresh - error) / STEP_S, error * keep + fresh
            assert not flight.fly(STEP_S, walk=walk).is_doubted
            most = max(most, abs(error))
        farthest.append(most)
    assert sum(each > 3.0 for each in farthest) >= 2


@pytest.mark.fault(
    "GNSS walks away in a flight's first hover, in wind, all flags good", "doubted as in any other hover"
)
def test_sways_of_a_first_hover_are_no_path() -> None:
    """A camera that was not seen to agree yet: 1.2 m to and fro every 4 s hides no walk of 0.7 m/s."""
    flight, began = Flight(), 10.0
    while not flight.facts().is_doubted:
        sway = 1.2 * math.tau / 4.0 * math.cos(math.tau * flight.now / 4.0)
        flight.fly(STEP_S, sway + 0j, walk=0.7 if flight.now >= began else 0.0)
        assert flight.now - began < 10.0
    assert flight.now > began


@pytest.mark.slow
def test_a_doubt_of_a_slow_walk_ends_when_the_position_is_back() -> None:
    flight = Flight()
    flight.fly(60.0)
    flight.doubted_after(60.0, walk=0.2)
    gone = flight.facts().off[0]
    assert flight.fly(20.0).is_doubted
    flight.fly(gone / 0.2, walk=-0.2)
    assert not flight.fly(20.0).is_doubted
    assert not flight.fly(120.0).is_doubted, "what was wrong meanwhile is forgotten"
    assert flight.doubted_after(60.0, walk=0.2) * 0.2 < 5.0, "the next one is seen as well"


# -- earlier pictures --------------------------------------------------------------------------------------------------


def test_an_earlier_picture_shows_a_walk_that_no_step_has_seen() -> None:
    """Blind for 60 s: then the picture of the hover's beginning is 6 m away."""
    reading = PlaceReading()
    assert not held(reading, 0.0, 20.0, beyond=0j).is_doubted
    facts = held(reading, 80.0, 84.0, beyond=-6 + 0j)
    assert facts.is_doubted
    assert facts.is_followed
    assert facts.off == pytest.approx((6.0, 0.0))
    assert held(reading, 84.0, 92.0, beyond=-7 + 1j).off == pytest.approx((7.0, -1.0)), "nothing adds up in it"


def test_an_earlier_picture_bridges_what_was_not_seen_in_a_doubt() -> None:
    reading = PlaceReading()
    held(reading, 0.0, 20.0, beyond=0j)
    held(reading, 80.0, 84.0, beyond=-6 + 0j)
    reading.note(step(100.0, 100.4, 0.0, 0.0))
    assert not reading.facts(100.4).is_followed
    facts = held(reading, 100.4, 102.4, beyond=-9 + 0j)
    assert facts.is_followed
    assert facts.off == pytest.approx((9.0, 0.0))


@pytest.mark.parametrize(("height", "is_doubted"), [(40.0, True), (60.0, False)])
def test_the_limit_of_the_window_grows_with_the_height(height: float, is_doubted: bool) -> None:
    reading = PlaceReading()
    for k in range(12):
        beyond = 3.8 if k == 8 else 0.0
        reading.note(GroundStep(float(k), k + 1.0, (beyond, 0.0), (0.0, 0.0), 0.0, 0.0, height))
    assert reading.facts(12.0).is_doubted is is_doubted


@pytest.mark.parametrize("size", [2.0, 6.0, 12.0])
@pytest.mark.parametrize("step_s", [0.25, 0.4, 0.5])
def test_a_wrong_match_with_an_earlier_picture_is_no_doubt(size: float, step_s: float) -> None:
    reading, every = PlaceReading(), 7
    for k in range(400):
        off = size if k % every == 0 else 0.0
        seen = GroundAgain(1.0, (off, 0.0), (0.0, 0.0), 0.0)
        begin = 10.0 + k * step_s
        reading.note(GroundStep(begin, begin + step_s, (0.0, 0.0), (0.0, 0.0), 0.0, 0.0, 25.0, seen))
        assert not reading.facts(begin + step_s).is_doubted


def test_wrong_matches_in_a_row_are_a_doubt_that_ends_by_the_right_ones() -> None:
    reading = PlaceReading()
    held(reading, 0.0, 20.0, beyond=0j)
    assert held(reading, 20.0, 26.0, beyond=6 + 0j).is_doubted
    facts = held(reading, 26.0, 28.0, beyond=0j)
    assert facts.off == pytest.approx((0.0, 0.0))
    assert not held(reading, 28.0, 42.0, beyond=0j).is_doubted


def test_one_wrong_match_moves_no_drone_that_holds_by_the_camera() -> None:
    flight = Flight()
    flight.fly(60.0)
    flight.doubted_after(60.0, walk=0.5)
    before = flight.facts().off
    flight.now += STEP_S
    flight.reading.note(again(flight.now, 30.0, -20 + 0j))
    assert flight.facts().off == pytest.approx(before)


@pytest.mark.parametrize(("begin", "is_doubted"), [(40.0, True), (700.0, False)])
def test_the_longer_ago_the_more_may_an_honest_receiver_have_wandered(begin: float, is_doubted: bool) -> None:
    reading = PlaceReading()
    held(reading, 0.0, 4.0, beyond=0j)
    assert held(reading, begin, begin + 2.0, beyond=6 + 0j).is_doubted is is_doubted


def test_pictures_of_before_the_flight_or_a_leap_are_no_witnesses() -> None:
    reading = PlaceReading()
    for k in range(10):
        reading.note(again(10.0 + k * STEP_S, 1.0, 20 + 0j))
    assert not reading.facts(14.0).is_doubted, "this flight began at 9.6 s"
    reading.lose()
    for k in range(10):
        reading.note(again(14.0 + k * STEP_S, 12.0, 20 + 0j))
    assert not reading.facts(18.0).is_doubted
    for k in range(10):
        reading.note(again(22.0 + k * STEP_S, 16.0, 20 + 0j))
    assert reading.facts(26.0).is_doubted


def test_a_picture_of_the_time_of_a_doubt_is_no_witness_of_what_comes_after() -> None:
    flight = Flight()
    flight.fly(60.0)
    flight.doubted_after(60.0, walk=0.5)
    during = flight.now
    gone = flight.facts().off[0]
    flight.fly(gone / 0.5, walk=-0.5)
    flight.fly(20.0)
    for since, is_doubted in ((during, False), (30.0, True)):
        for _ in range(6):
            flight.now += STEP_S
            flight.reading.note(again(flight.now, since, -8 + 0j))
        assert flight.facts().is_doubted is is_doubted
