"""The disagreement of camera and position by values, and each limit of the place's witness on both its sides."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.ddc.witnesses.place import (
    PATH_SHARE,
    STILL_GAP_M,
    PlaceReading,
)
from hawk.model.pictures import GroundAgain, GroundStep
from tests.unit.ddc.witnesses.place_steps import STEP_S, Flight, again, held, step

# -- the disagreement, by values ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("flown", "hidden"), [(5.0, 1.2), (10.0, 1.5), (20.0, 1.5)])
def test_a_gap_hides_more_the_more_it_flies_up_to_ten_metres(flown: float, hidden: float) -> None:
    """The camera was not seen to agree yet: 12 % of the path is no disagreement. It flies on in a gap, unseen."""
    beyond = 0.3 * flown
    for gap, allowed in ((0.0, 0.0), (0.5, hidden)):
        reading = PlaceReading()
        reading.note(step(0.0, 1.0, 0.0, 0.0))
        reading.note(step(1.0 + gap, 2.0 + gap, flown, beyond))
        path = flown * (1.0 + gap)
        whole = 1.0 + (1.0 - min(1.0, path / 10.0)) * gap / 2.0
        assert reading.facts(3.0).apart == pytest.approx(max(0.0, beyond * whole - 0.12 * path - allowed))


@pytest.mark.parametrize(("height", "shown", "is_doubted"), [(60.0, 0.0, False), (60.0, 1.0, True), (30.0, 0.0, True)])
def test_from_high_above_an_earlier_picture_denies_a_walk_of_the_steps(
    height: float, shown: float, is_doubted: bool
) -> None:
    """The steps see 0.4 m/s; the picture of 1 s shows the share ``shown`` of it."""
    reading = PlaceReading()
    for k in range(100):
        now = 1.0 + k * STEP_S
        off = max(0.0, 0.4 * (now - 20.0))
        pace = 0.4 * STEP_S if now > 20.0 else 0.0
        seen = GroundAgain(1.0, (off * shown, 0.0), (0.0, 0.0), 0.0)
        reading.note(GroundStep(now, now + STEP_S, (pace, 0.0), (0.0, 0.0), 0.0, 0.0, height, again=seen))
        if reading.facts(now).is_doubted:
            break
    assert reading.facts(now).is_doubted is is_doubted


def test_gaps_leave_sways_that_do_not_add_up_and_no_more_than_double_what_was_seen() -> None:
    """Four gaps hide twice as much as one; 1 s of steps among 10 s of gaps counts twice."""
    reading = PlaceReading()
    for k in range(5):
        reading.note(step(k * 2.0, k * 2.0 + 0.2, 0.0, 0.8))
    assert reading.facts(9.0).apart == pytest.approx(2.0 * 4.0 - 2.0 * STILL_GAP_M)


def test_what_the_camera_was_off_before_the_window_is_taken_off() -> None:
    """20 m of which it saw 19: a share of 20 / (400 + 40) against the prior. Then 10 m of which it sees 8."""
    reading = PlaceReading()
    reading.note(step(0.0, 1.0, 20.0, -1.0))
    reading.note(step(1.0, 12.0, 10.0, -2.0))
    assert reading.facts(12.0).apart == pytest.approx(2.0 - 10.0 * 20.0 / 440.0 - PATH_SHARE * 10.0, abs=1e-9)


def test_what_agrees_is_no_less_than_none_and_a_leap_begins_again() -> None:
    reading = PlaceReading()
    reading.note(step(0.0, 1.0, 10.0, 0.0))
    assert reading.facts(1.0).apart == 0.0
    reading.note(step(1.0, 2.0, 10.0, 5.0))
    assert reading.facts(2.0).apart == pytest.approx(5.0 - 0.12 * 20.0)
    reading.lose()
    assert reading.facts(2.0).apart == 0.0
    reading.note(step(2.0, 3.0, 10.0, 0.0))
    assert reading.facts(3.0).apart == 0.0


# -- limits ------------------------------------------------------------------------------------------------------------


def noted(*steps: GroundStep, accuracy: float | None = None) -> PlaceReading:
    reading = PlaceReading()
    for each in steps:
        reading.note(each, accuracy)
    return reading


def seen(k: int, beyond: float = 0.0, *, picture: float | None = None, since: float = 0.0) -> GroundStep:
    """Return the step ``k``, from 1, of a drone that holds; it is compared with the picture of ``since`` if given."""
    again = None if picture is None else GroundAgain(since, (picture, 0.0), (0.0, 0.0), 0.0)
    return GroundStep((k - 1) * STEP_S, k * STEP_S, (beyond, 0.0), (0.0, 0.0), 0.0, 0.0, 25.0, again)


@pytest.mark.parametrize(("seconds", "apart"), [(9.5, 3.0), (10.5, 1.5)])
def test_what_adds_up_within_ten_seconds_is_a_disagreement(seconds: float, apart: float) -> None:
    reading = PlaceReading()
    for now, until, beyond in ((0.0, 0.4, 1.5), (0.4, seconds, 0.0), (seconds, 0.4 + seconds, 1.5)):
        reading.note(step(now, until, 0.0, beyond))
    assert reading.facts(20.0).apart == pytest.approx(apart)


@pytest.mark.parametrize(("gap", "is_followed"), [(4.5, True), (5.5, False)])
def test_a_gap_of_up_to_five_seconds_is_bridged(gap: float, is_followed: bool) -> None:
    flight = Flight()
    flight.fly(20.0)
    flight.doubted_after(10.0, walk=0.7)
    flight.now += gap
    assert flight.fly(STEP_S, walk=0.7).is_followed is is_followed


@pytest.mark.parametrize(("silent", "is_followed"), [(4.5, True), (5.5, False)])
def test_a_camera_follows_for_five_seconds_without_a_comparison(silent: float, is_followed: bool) -> None:
    flight = Flight()
    flight.fly(20.0)
    flight.doubted_after(10.0, walk=0.7)
    assert flight.reading.facts(flight.now + silent).is_followed is is_followed


def test_one_comparison_that_is_missing_in_a_doubt_leaves_no_hole_in_what_is_off() -> None:
    flight = Flight()
    flight.fly(20.0)
    flight.doubted_after(10.0, walk=0.7)
    flight.fly(8.0, walk=0.7)
    before = flight.facts().off[0]
    flight.now += 2 * STEP_S
    assert flight.fly(STEP_S, walk=0.7).off[0] == pytest.approx(before + 3 * STEP_S * 0.7, abs=0.15)


def test_a_step_that_begins_before_the_end_of_the_last_one_is_ignored() -> None:
    reading = noted(step(0.0, 1.0, 0.0, 0.0))
    reading.note(step(0.5, 1.5, 0.0, 2.0))
    assert reading.facts(1.5).apart == 0.0
    assert reading.facts(1.5).camera_age == 0.5


@pytest.mark.parametrize(("flown", "share"), [(14.9, 0.12), (15.0, PATH_SHARE)])
def test_a_camera_is_believed_once_it_agreed_for_fifteen_metres(flown: float, share: float) -> None:
    reading = noted(step(0.0, 1.0, flown, 0.0), step(1.0, 12.0, 10.0, 2.0))
    assert reading.facts(12.0).apart == pytest.approx(2.0 - share * 10.0)


def test_what_was_learned_about_the_camera_long_ago_is_forgotten() -> None:
    """It was off by a tenth for 100 m, and agreed for a kilometre then: 1.5 m of ten are a disagreement."""
    steps = [step(0.0, 11.0, 100.0, 10.0)]
    steps += [step(11.0 * k, 11.0 * (k + 1), 100.0, 0.0) for k in range(1, 11)]
    reading = noted(*steps, step(121.0, 132.0, 10.0, 1.5))
    assert reading.facts(132.0).apart == pytest.approx(1.5 - PATH_SHARE * 10.0, abs=0.05)


def test_a_picture_that_shows_a_tenth_of_the_path_does_not_stand_still() -> None:
    flown = step(0.0, 1.0, 20.0, 0.0)
    assert noted(flown, step(1.0, 12.0, 10.0, -9.1)).facts(12.0).apart == 0.0
    assert noted(flown, step(1.0, 12.0, 10.0, -9.0)).facts(12.0).apart == pytest.approx(8.4)


def test_what_stretch_would_make_worse_counts_as_it_was_seen() -> None:
    """The camera is known to see too little: 20 m of path as 19."""
    reading = noted(step(0.0, 1.0, 20.0, -1.0))
    reading.note(GroundStep(1.0, 12.0, (8.0, 0.0), (10.0, 0.0), 0.5, 0.0, 25.0))
    assert reading.facts(12.0).apart == pytest.approx(2.0 - 10.0 * 20.0 / 440.0 - PATH_SHARE * 10.0)


@pytest.mark.parametrize(("beyond", "is_doubted"), [(2.75, False), (2.76, True)])
def test_a_disagreement_beyond_the_limit_is_a_doubt_and_one_of_the_limit_is_none(
    beyond: float, is_doubted: bool
) -> None:
    reading = noted(seen(1, beyond), seen(2), seen(3))
    assert reading.facts(1.2).is_doubted is is_doubted


@pytest.mark.parametrize(("beyond", "is_doubted"), [(2.75, False), (2.76, True)])
def test_a_window_at_its_limit_confirms_no_walk_that_pictures_begin_to_show(beyond: float, is_doubted: bool) -> None:
    reading = noted(seen(1, beyond), *(seen(k, picture=6.0) for k in (2, 3, 4)))
    assert reading.facts(1.6).is_doubted is is_doubted
    reading.note(seen(5, picture=6.0))
    assert reading.facts(2.0).is_doubted


def test_a_disagreement_that_grows_confirms_itself_while_the_record_of_the_steps_shows_no_walk() -> None:
    """At 38 m the floor of the record is 2.3 m, and a receiver of 6 m may wander by 0.8 m in two steps."""
    reading = PlaceReading()
    for k, beyond in ((1, 0.0), (2, 2.2), (3, 0.6)):
        reading.note(replace(seen(k, beyond), height=38.0), 6.0)
    assert reading.facts(1.2).is_doubted


def test_a_leap_that_steps_and_pictures_show_at_once_is_doubted_at_once() -> None:
    reading = noted(*(seen(k, picture=0.0) for k in range(1, 11)))
    for k, beyond in ((11, 0.0), (12, 0.0), (13, 6.0)):
        assert not reading.facts(STEP_S * k).is_doubted
        reading.note(seen(k, beyond, picture=6.0))
    assert reading.facts(5.2).is_doubted


@pytest.mark.parametrize(("since", "is_witness"), [(0.3, True), (0.4, False), (0.5, False)])
def test_the_picture_of_the_moment_at_which_a_walk_began_is_no_witness_of_it(since: float, is_witness: bool) -> None:
    """Seen twice alike in the doubt, a witness moves the drone that is off; another only goes along with it."""
    reading = noted(seen(1, 3.0), seen(2), seen(3))
    assert reading.facts(1.2).is_doubted
    for k in (4, 5):
        reading.note(seen(k, picture=9.0, since=since))
    assert reading.facts(2.0).off == pytest.approx((-9.0 if is_witness else -3.0, 0.0))


@pytest.mark.parametrize(("later", "is_witness"), [(-0.1, False), (0.0, False), (0.1, True)])
def test_the_picture_of_the_moment_at_which_a_doubt_ended_is_no_witness(later: float, is_witness: bool) -> None:
    reading, k = noted(seen(1, 3.0), seen(2), seen(3), seen(4, -3.0)), 4
    while reading.facts(k * STEP_S).is_doubted:
        k += 1
        reading.note(seen(k))
    for after in range(1, 7):
        reading.note(seen(k + after, picture=9.0, since=k * STEP_S + later))
    assert reading.facts((k + 6) * STEP_S).is_doubted is is_witness


def test_pictures_in_a_doubt_count_from_what_they_showed_before_the_walk() -> None:
    """The position walks at 0.25 m/s from 20 s on; the picture of 1 s was off by 1 m before."""
    reading, k, off = PlaceReading(), 0, 0.0
    while (reading.facts(k * STEP_S).doubted_s or 0.0) < 2.0:
        k += 1
        pace = 0.25 * STEP_S if k > 50 else 0.0
        off += pace
        reading.note(seen(k, pace, picture=1.0 + off, since=1.0))
        assert off < 6.0
    assert reading.facts(k * STEP_S).off[0] == pytest.approx(-off, abs=0.4)


@pytest.mark.parametrize(("second", "off"), [(-12.0, 12.0), (-13.0, 13.0), (-13.1, 6.0), (-17.0, 6.0)])
def test_two_pictures_that_show_the_same_within_a_metre_are_taken(second: float, off: float) -> None:
    reading = PlaceReading()
    held(reading, 0.0, 20.0, beyond=0j)
    held(reading, 80.0, 84.0, beyond=-6 + 0j)
    reading.note(again(86.0, 1.0, -12 + 0j))
    assert reading.facts(86.0).off == pytest.approx((6.0, 0.0))
    reading.note(again(88.0, 1.0, second + 0j))
    assert reading.facts(88.0).off == pytest.approx((off, 0.0))


def test_a_picture_denies_a_walk_of_the_steps_for_two_seconds() -> None:
    """From 60 m the steps see a walk; a picture denies it once, and no other one is recognised."""
    reading, height = PlaceReading(), 60.0
    for k in range(1, 6):
        reading.note(GroundStep(k - 1.0, float(k), (0.0, 0.0), (0.0, 0.0), 0.0, 0.0, height))
    for k in range(5, 20):
        now = 5.5 + 0.5 * (k - 5)
        beyond = 8.0 if k == 5 else 0.0
        denies = GroundAgain(1.0, (0.0, 0.0), (0.0, 0.0), 0.0) if k == 5 else None
        reading.note(GroundStep(now - 0.5, now, (beyond, 0.0), (0.0, 0.0), 0.0, 0.0, height, denies))
        assert reading.facts(now).is_doubted is (now > 8.0), now
        if now > 8.0:
            break
