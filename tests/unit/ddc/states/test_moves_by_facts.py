"""The moves by facts alone: arrival, progress, routes, and the verdict on the place."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.ddc.acts import (
    STAY,
    Desire,
)
from hawk.ddc.facts import Facts
from hawk.ddc.motion import Goal
from hawk.ddc.orders import (
    MoveOrder,
    ToHover,
    ToMove,
)
from hawk.model.plans import DesiredPose, Inbound, Route, Verdict
from hawk.model.poses import MapPoint
from tests.unit.ddc.by_facts import (
    LOT_MOVE,
    MOVE,
    STRAIGHT,
    at,
    made,
    targets,
    texts,
    without_pose,
)
from tests.unit.ddc.written_facts import flying, of_kind


@pytest.mark.parametrize("order", [MOVE, LOT_MOVE], ids=["compulsive", "autonomous"])
def test_a_move_has_neither_arrived_nor_got_stuck_before_its_first_pose(order: MoveOrder) -> None:
    state = made(ToMove(order))
    assert state.transition_next_state(flying(0.0)) == STAY
    blind = without_pose(flying(0.05))
    assert targets(state.process(blind)) == []
    assert state.transition_next_state(blind) == STAY


def test_a_move_says_how_far_it_is_as_far_as_that_is_known() -> None:
    state = made(ToMove(MOVE))
    assert state.detail(at(flying(0.05), 10.0)) == "Moving, 30 m to go."
    assert state.detail(without_pose(at(flying(0.05), 10.0))) == "Moving, 30 m to go.", "the latest is shown"
    lost = replace(flying(0.05), position=replace(flying(0.05).position, pose=None))
    assert state.detail(lost) == "Moving."


def test_a_new_place_in_flight_is_not_the_one_that_was_reached() -> None:
    state = made(ToMove(MOVE))
    state.process(at(flying(0.05), 39.0))
    assert state.transition_next_state(flying(0.05), replace(MOVE, place=MapPoint(80.0, 0.0))) == STAY
    assert state.transition_next_state(flying(0.1)) == STAY
    assert state.goal == Goal(80.0, 0.0, 30.0, 0.0)


def test_a_move_of_the_other_kind_begins_again() -> None:
    for first, second in ((MOVE, LOT_MOVE), (LOT_MOVE, MOVE)):
        assert made(ToMove(first)).transition_next_state(flying(0.05), second).transition == ToMove(second)


def test_a_move_without_progress_for_ten_seconds_holds_with_what_hinders() -> None:
    state = made(ToMove(MOVE))
    state.process(flying(0.0))
    state.process(replace(flying(9.99), target_refusal="too high"))
    assert state.transition_next_state(flying(9.99)) == STAY
    state.process(replace(flying(10.0), target_refusal="too high"))
    step = state.transition_next_state(flying(10.0))
    assert step.transition == ToHover("No progress for 10 s. too high.", level="warning")


def judged(facts: Facts, number: int = 3, inbound: Inbound = Inbound.INSIDE, route: Route = STRAIGHT) -> Facts:
    desired = DesiredPose(number, 40.0, 0.0)
    sight = replace(facts.sight, desired=desired, desired_count=number, verdict=Verdict(number, inbound, route))
    return replace(facts, sight=sight)


def around(east: float) -> Route:
    return Route((MapPoint(0.0, 0.0), MapPoint(20.0, east), MapPoint(40.0, 0.0)), (0.0, 0.0, 0.0))


def test_every_change_of_the_route_in_flight_is_reported() -> None:
    state = made(ToMove(LOT_MOVE))
    reported = ["The map changed in flight. Another route there was found."]
    assert texts(state.process(judged(flying(0.05)))) == [], "the same route"
    assert texts(state.process(judged(flying(0.1), route=around(10.0)))) == reported
    assert state.route(flying(0.1))[1:] == around(10.0).points[1:]
    assert texts(state.process(judged(flying(0.15), route=around(20.0)))) == reported


def test_a_place_that_is_judged_again_has_the_next_number_and_its_route_is_no_change_of_the_map() -> None:
    state = made(ToMove(LOT_MOVE))
    facts = flying(0.05)
    (desire,) = of_kind(state.process(replace(facts, sight=replace(facts.sight, desired_count=5))), Desire)
    assert desire == Desire(DesiredPose(6, 40.0, 0.0))
    assert texts(state.process(judged(flying(0.1), 6, route=around(10.0)))) == []
    assert texts(state.process(judged(flying(0.15), 6, route=around(20.0)))) != []
    assert state.leave(judged(flying(0.2), 6)) == (Desire(None),)
    assert state.leave(judged(flying(0.2), 7)) == (), "a newer place is judged"
    assert state.leave(flying(0.2)) == ()


def test_a_new_place_brings_its_own_route_without_a_message_of_the_map() -> None:
    state = made(ToMove(LOT_MOVE))
    state.process(flying(0.05))
    state.transition_next_state(flying(0.05), replace(LOT_MOVE, number=4, route=around(10.0)))
    assert state.route(flying(0.1))[1:] == around(10.0).points[1:]
    assert texts(state.process(judged(flying(0.1), 4, route=around(20.0)))) != []


@pytest.mark.parametrize(("inbound", "now"), [(Inbound.UNKNOWN, 1.0), (Inbound.INSIDE, 30.0)])
def test_an_autonomous_move_goes_on_for_a_second_without_a_confirmation(inbound: Inbound, now: float) -> None:
    state = made(ToMove(LOT_MOVE))
    state.process(judged(flying(now - 1.0) if inbound is Inbound.INSIDE else flying(0.0), inbound=inbound))
    waiting = judged(flying(now), inbound=Inbound.UNKNOWN)
    assert state.transition_next_state(waiting) == STAY
    late = state.transition_next_state(replace(waiting, now=now + 0.05))
    assert late.transition == ToHover("The place is not confirmed as inside the lot any longer.", level="warning")


def test_an_autonomous_move_stops_at_a_place_outside_and_at_a_route_that_is_refused() -> None:
    state = made(ToMove(LOT_MOVE))
    outside = state.transition_next_state(judged(flying(0.05), inbound=Inbound.OUTSIDE))
    assert outside.transition == ToHover("The place turned out to be outside the lot.", level="warning")
    refused = state.transition_next_state(judged(flying(0.05), route=Route(refused="a zone bars the path")))
    assert refused.transition == ToHover("Held: a zone bars the path.", level="warning")
    assert state.transition_next_state(judged(flying(0.05), number=9, inbound=Inbound.OUTSIDE)) == STAY
