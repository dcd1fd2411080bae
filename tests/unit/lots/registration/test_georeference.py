from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.lots.plan.geometry import Row, polygons, row_shapes
from hawk.lots.registration.georeference import joined, shared_area, without
from hawk.lots.registration.lot_match import NEAR_M, SAME_SHARE, Answer, Parcel, which_lot
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose
from tests.unit.lots.surveys import box

HIGH, WIDE = 40.0, 100.0
PLACES = st.builds(
    GlobalPose,
    st.floats(-80, 80),
    st.one_of(st.floats(-180, 180), st.sampled_from([179.9999, -179.9999])),
    st.just(0.0),
)


def lot(name: str, north: float, east: float, datum: GlobalPose | None = None) -> Parcel:
    return Parcel(name, box(north, east, HIGH, WIDE, datum or GlobalPose(52.0, 5.0, 0.0)))


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(datum=PLACES, east=st.floats(-1000, 1000), north=st.floats(-1500, 1500))
def test_a_lot_beside_another_is_known_asked_for_or_new_by_overlap_and_distance(
    datum: GlobalPose, east: float, north: float
) -> None:
    decision = which_lot(box(north, east, HIGH, WIDE, datum), [lot("a", 0, 0, datum)])
    overlap = max(0.0, 1 - abs(north) / HIGH) * max(0.0, 1 - abs(east) / WIDE)
    apart = math.hypot(max(0.0, abs(north) - HIGH), max(0.0, abs(east) - WIDE))
    if abs(overlap - SAME_SHARE) < 0.005 or abs(apart - NEAR_M) < 1.0:
        return  # rounding and the Earth's bend decide
    expected = Answer.KNOWN if overlap > SAME_SHARE else Answer.ASK if apart < NEAR_M else Answer.NEW
    assert decision.answer is expected
    assert decision.lot == ("a" if expected is Answer.KNOWN else None)
    assert [each.lot for each in decision.candidates] == ([] if expected is Answer.NEW else ["a"])
    for each in decision.candidates:
        assert each.overlap == pytest.approx(overlap, abs=0.005)
        assert each.distance == pytest.approx(apart, abs=1.0)


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(
    places=st.lists(st.tuples(st.floats(-500, 500), st.floats(-500, 500)), max_size=6),
    data=st.data(),
)
def test_the_order_of_the_lots_does_not_matter(places: list[tuple[float, float]], data: st.DataObject) -> None:
    lots = [lot(str(number), *place) for number, place in enumerate(places)]
    outline = box(0, 0, HIGH, WIDE)
    assert which_lot(outline, lots) == which_lot(outline, data.draw(st.permutations(lots)))


def test_half_of_a_lot_and_a_flight_far_around_it_are_that_lot() -> None:
    known = [lot("a", 0, 0)]
    assert which_lot(box(0, 0, HIGH, WIDE / 4), known).lot == "a"
    assert which_lot(box(-100, -100, 300, 400), known).lot == "a"


def test_two_lots_under_one_flight_are_a_question_the_better_one_first() -> None:
    decision = which_lot(box(0, 20, HIGH, 150), [lot("west", 0, 0), lot("east", 0, 105)])
    assert decision.answer is Answer.ASK
    assert [each.lot for each in decision.candidates] == ["west", "east"]
    assert [each.overlap for each in decision.candidates] == pytest.approx([0.8, 0.65], abs=0.01)


def test_a_lot_next_door_with_three_metres_of_gnss_error_is_a_question_and_never_that_lot() -> None:
    decision = which_lot(box(0, WIDE - 3, HIGH, WIDE), [lot("a", 0, 0)])
    assert decision.answer is Answer.ASK
    assert decision.candidates[0].overlap == pytest.approx(0.03, abs=0.005)


def test_of_outlines_that_a_person_gave_together_each_means_its_own_lot() -> None:
    whole, part, next_door = box(0, 0, HIGH, WIDE), box(0, 0, HIGH, WIDE / 5), box(0, WIDE, HIGH, WIDE)
    assert which_lot(next_door, [lot("a", 0, 0)], [whole]).answer is Answer.NEW
    assert which_lot(part, [lot("a", 0, 0)], [whole]).answer is Answer.NEW
    assert which_lot(whole, [Parcel("part", part), lot("a", 0, 0)], []).lot == "a"
    assert which_lot(whole, [Parcel("part", part), lot("a", 0, 0)], [part, next_door]).lot == "a"
    assert which_lot(part, [Parcel("part", part), lot("a", 0, 0)], [whole]).lot == "part"
    assert which_lot(box(0, 0, HIGH, 2.5 * WIDE), [lot("a", 0, 0), lot("b", 0, WIDE)], []).answer is Answer.ASK
    assert which_lot(part, [lot("a", 0, 0)], []).lot == "a"


@pytest.mark.parametrize(
    "outline", [Outline(), box(0, 0, 0, 0), Outline((((52.0, 5.0), (52.1, 5.0)),)), box(0, 0, 0.5, 0.5)]
)
def test_ground_that_is_none_is_nowhere(outline: Outline) -> None:
    assert which_lot(outline, [lot("a", 0, 0)]).answer is Answer.NOTHING


def test_a_ring_that_crosses_itself_and_a_hole_are_ground_like_others() -> None:
    (ring,) = box(0, 0, HIGH, WIDE).polygons
    crossed = Outline(((ring[0], ring[2], ring[1], ring[3]),))
    assert which_lot(crossed, [lot("a", 0, 0)]).lot == "a"
    holed = Outline((ring,), box(1, 1, HIGH - 2, WIDE - 2).polygons)
    assert which_lot(box(5, 5, 20, 20), [Parcel("a", holed)]).answer is Answer.ASK


def test_a_lot_on_the_other_side_of_the_earth_is_not_near() -> None:
    other = lot("a", 0, 0, GlobalPose(-52.0, -175.0, 0.0))
    assert which_lot(box(0, 0, HIGH, WIDE), [other]).answer is Answer.NEW


def test_outlines_are_joined_and_cut() -> None:
    both = joined([box(0, 0, HIGH, WIDE), box(0, 50, HIGH, WIDE), box(0, 300, HIGH, WIDE)])
    assert len(both.polygons) == 2
    found = which_lot(box(0, 0, HIGH, 150), [Parcel("a", both)])
    assert found.candidates[0].overlap == pytest.approx(1.0, abs=0.01)
    rest = without(both, box(-1, 200, HIGH + 2, 400))
    assert len(rest.polygons) == 1
    assert which_lot(box(0, 320, HIGH, 20), [Parcel("a", rest)]).candidates[0].overlap == 0.0
    ring_road = without(box(0, 0, HIGH, WIDE), box(10, 10, 20, 20))
    assert (len(ring_road.polygons), len(ring_road.holes)) == (1, 1)
    left = {east: len(without(box(0, 0, 40, 60), box(-1, east, 42, 40)).polygons) for east in (10, 1)}
    assert left == {10: 2, 1: 1}, "40 m2 at one end are no part of a lot"
    assert len(without(box(0, 0, 40, 60), box(-1, -1, 42, 60)).polygons) == 1, "unless nothing else is left"
    assert joined([Outline()]) == without(Outline(), both) == Outline()


@pytest.mark.slow
def test_grounds_that_touch_share_nothing() -> None:
    for heading in np.linspace(-3.0, 3.0, 200).tolist():
        along = np.array([math.cos(heading), math.sin(heading)]) * 22.5
        grounds = polygons(row_shapes(Row((0.0, 0.0), (along[0], along[1]), (-along[1], along[0]), 9)))
        assert [shared_area(*pair) for pair in pairwise(grounds)] == pytest.approx([0.0] * 8, abs=0.1)


def test_an_outline_with_a_spike_is_ground_without_it() -> None:
    ring = box(0, 0, HIGH, WIDE).polygons[0]
    middle = ((ring[0][0] + ring[1][0]) / 2, (ring[0][1] + ring[1][1]) / 2)
    beyond = (middle[0], middle[1] - 0.001)
    spiked = Outline(((ring[0], middle, beyond, middle, *ring[1:]),))
    assert which_lot(box(0, 0, HIGH, WIDE), [Parcel("a", spiked)]).candidates[0].overlap == pytest.approx(1.0, abs=0.01)
