"""Hover and Communication Lost by facts alone: goals, brakes, breaches, and what is reported."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.ddc.acts import (
    STAY,
    Log,
    SetMode,
)
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import contains, polygon_fence
from hawk.ddc.motion import Goal, maximum_target_distance
from hawk.ddc.orders import (
    Cause,
    CauseKind,
    Rank,
    ToCommunicationLost,
    ToExplore,
    ToHover,
    ToLand,
    ToManual,
    ToMove,
    ToReturn,
    ToTakeoff,
    Transition,
)
from hawk.ddc.rules.guard import reaction
from hawk.ddc.states.base import State
from hawk.ddc.states.factory import make_state
from hawk.ddc.states.hover import CommunicationLostState, Holding, HoverState
from hawk.model.poses import MapPoint
from hawk.model.vehicle import CopterMode
from tests.unit.ddc.by_facts import (
    LOT_MOVE,
    MOVE,
    answered,
    at,
    made,
    requests,
    targets,
    without_operator,
    without_pose,
)
from tests.unit.ddc.written_facts import FENCE, SETTINGS, flying, pose


def test_a_hold_sends_nothing_while_the_position_is_old_and_goes_on_when_it_is_back() -> None:
    state = made(ToHover())
    assert len(targets(state.process(flying(0.05)))) == 1
    assert state.process(without_pose(flying(0.1))) == ()
    assert len(targets(state.process(flying(0.15)))) == 1


def test_a_breach_without_a_known_place_leads_nowhere() -> None:
    state = made(ToHover(passive=True))
    breached = replace(flying(0.05), limits=replace(flying(0.05).limits, breached_s=1.0))
    assert state.process(without_pose(breached)) == ()
    unfenced = replace(breached, limits=replace(breached.limits, fence=None))
    assert state.process(unfenced) == ()
    assert len(targets(state.process(breached))) == 1


@pytest.mark.parametrize("change", [without_pose, lambda facts: at(facts, height=0.9 * 15 - 0.01)])
def test_a_hold_that_can_form_no_goal_brakes(change: object) -> None:
    assert callable(change)
    acts = made(ToHover()).process(change(flying(0.05)))
    assert requests(acts) == [SetMode(CopterMode.BRAKE)]
    assert targets(acts) == []


def test_a_hold_without_a_fence_in_force_brakes() -> None:
    facts = flying(0.05)
    assert requests(made(ToHover()).process(replace(facts, limits=replace(facts.limits, fence=None)))) == [
        SetMode(CopterMode.BRAKE)
    ]


def test_a_hold_at_nine_tenths_of_min_climbs_to_min() -> None:
    (goal,) = targets(made(ToHover()).process(at(flying(0.05), height=0.9 * 15)))
    assert goal.height == 15


def test_the_stopping_point_across_a_gap_of_the_fence_becomes_the_last_place_before_it() -> None:
    fence = polygon_fence(((-20, -40), (40, -40), (40, -6), (10, -6), (10, 6), (40, 6), (40, 40), (-20, 40)), 1, 100, 3)
    facts = flying(0.05)
    flown = replace(pose(0.05, 30.0, -10.0), velocity=(0.0, 15.0, 0.0))
    facts = replace(
        facts,
        position=replace(facts.position, pose=flown),
        limits=replace(facts.limits, fence=fence),
    )
    (goal,) = targets(made(ToHover()).process(facts))
    assert -10.0 < goal.east < -6.0
    assert goal.north == pytest.approx(30.0, abs=0.5)


def test_a_lost_operator_brings_the_drone_home_when_the_time_is_over_and_not_before() -> None:
    hold = SETTINGS.operator.operator_hold_s
    state = made(ToCommunicationLost())
    assert state.transition_next_state(without_operator(flying(hold - 0.01))) == STAY
    step = state.transition_next_state(without_operator(flying(hold)))
    assert step.transition == ToReturn(Cause("The operator is lost.", CauseKind.OPERATOR))
    assert state.transition_next_state(flying(hold)).transition == ToHover("The operator is back.")


@pytest.mark.parametrize(("north", "breached_s"), [(160.0, None), (155.0, None), (160.0, 0.1)])
def test_a_hold_outside_the_fence_leads_inside_before_the_breach_is_reported_too(
    north: float, breached_s: float | None
) -> None:
    facts = at(flying(0.05), north, 5.0)
    facts = replace(facts, limits=replace(facts.limits, breached_s=breached_s))
    state = Holding(SETTINGS)
    state.process(facts)
    assert state._goal is not None
    assert contains(FENCE, state._goal.point)
    assert state.is_recovering is (breached_s is not None)


def test_a_stopping_point_near_the_edge_but_inside_stays() -> None:
    facts = at(flying(0.05), 144.8, 0.0)
    assert contains(FENCE, MapPoint(144.8, 0.0))
    (goal,) = targets(made(ToHover()).process(facts))
    assert (goal.north, goal.east) == (144.8, 0.0)


@pytest.mark.parametrize(
    "hold",
    [Holding(SETTINGS), HoverState(0.0, SETTINGS), CommunicationLostState(0.0, SETTINGS)],
    ids=lambda hold: type(hold).__name__,
)
def test_a_hold_sends_its_target_unless_it_is_said_that_the_autopilot_holds(hold: Holding | State) -> None:
    assert len(targets(hold.process(flying(0.05)))) == 1


def test_a_hold_brakes_after_the_fourth_request_for_guided_that_did_not_help() -> None:
    holding = Holding(SETTINGS)
    asked = []
    for now in (0.0, 2.0, 4.0, 6.0, 6.05):
        facts = flying(now, CopterMode.LOITER)
        asked += requests(holding.process(answered(facts, *(("mode GUIDED", now - 2.0, "done"),))))
    assert asked == [SetMode(CopterMode.GUIDED)] * 4 + [SetMode(CopterMode.BRAKE)]


@pytest.mark.parametrize(("height", "held"), [(13.5, 15.0), (15.0, 15.0), (60.0, 60.0), (75.9, 75.9), (96.9, 96.9)])
def test_a_hold_stays_at_its_height_above_max_as_well(height: float, held: float) -> None:
    (goal,) = targets(made(ToHover()).process(at(flying(0.05), height=height)))
    assert goal.height == pytest.approx(held, abs=1.0)


def test_a_hold_says_its_reason_and_its_height() -> None:
    state = made(ToHover("There."))
    assert state.detail(flying(0.05)) == "There. Holding at 30 m."
    assert state.detail(replace(flying(0.05), position=replace(flying(0.05).position, age=1.1))) == "There. Holding."
    ranks = [state.rank]
    breached = at(replace(flying(0.05), limits=replace(flying(0.05).limits, breached_s=0.1)), 160.0)
    state.process(breached)
    ranks.append(state.rank)
    assert ranks == [Rank.TASK, Rank.FENCE]
    assert state.detail(breached) == "Outside the fence: going back inside."


def test_control_that_was_given_back_is_reported_and_who_took_it() -> None:
    state = made(ToCommunicationLost(given_back_by="Ana"))
    hold = SETTINGS.operator.operator_hold_s
    assert state.detail(flying(1.0)) == f"Control was given back by Ana. Returns home in {hold - 1.0:.0f} s."
    late = state.transition_next_state(without_operator(flying(hold)))
    assert late.transition == ToReturn(Cause("Nobody took control.", CauseKind.OPERATOR))
    taken = replace(flying(1.0), operator=replace(flying(1.0).operator, controller="Ben"))
    assert state.transition_next_state(taken).transition == ToHover("Ben has taken control.")
    nameless = replace(flying(1.0), operator=replace(flying(1.0).operator, controller=""))
    assert state.transition_next_state(nameless).transition == ToHover("Someone has taken control.")


# -- Back into the fence -----------------------------------------------------------------------------------------------

SQUARE = polygon_fence(((-20, -100), (160, -100), (160, 100), (-20, 100)), 5.0, 100.0, 3.0)
"""Our own limit lies at 155 m north; a drone outside is led to 153 m."""


def outside(now: float, north: float, east: float = 0.0, height: float = 30.0) -> Facts:
    facts = at(flying(now), north, east, height)
    return replace(facts, limits=replace(facts.limits, fence=SQUARE, breached_s=0.1))


def led_to(holding: Holding) -> Goal:
    assert holding._goal is not None
    return holding._goal


@pytest.mark.parametrize(("east", "is_new"), [(4.9, False), (5.2, True)])
def test_a_drone_that_drifts_outside_is_led_to_another_place_that_is_nearer_by_more_than_a_metre(
    east: float, is_new: bool
) -> None:
    """The next place is 12 m away; 5 m aside of it, the old one is 13 m away."""
    holding = Holding(SETTINGS)
    holding.process(outside(0.05, 165.0))
    first = led_to(holding)
    assert (first.north, first.east) == pytest.approx((153.0, 0.0), abs=0.01)
    holding.process(outside(0.1, 165.0, east))
    assert led_to(holding).east == pytest.approx(east if is_new else 0.0, abs=0.01)


@pytest.mark.parametrize("is_new_position", [False, True])
def test_a_drone_that_is_back_inside_recovers_no_longer(is_new_position: bool) -> None:
    state = made(ToHover())
    state.process(outside(0.05, 165.0))
    ranks = [state.rank]
    if is_new_position:
        state.restart()
    else:
        state.process(flying(0.1))
    assert [*ranks, state.rank] == [Rank.FENCE, Rank.TASK]


def test_a_drone_that_left_again_after_a_restart_is_led_to_the_place_nearest_then() -> None:
    holding = Holding(SETTINGS)
    holding.process(outside(0.05, 165.0))
    holding.restart()
    holding.process(outside(0.1, 165.0, 0.5))
    assert led_to(holding).east == pytest.approx(0.5, abs=0.01)


REACH = maximum_target_distance(SETTINGS.flight.speed_m_s)


@pytest.mark.parametrize(("north", "whole"), [(REACH, True), (REACH + 0.01, False)])
def test_a_goal_within_reach_is_sent_as_it_is_and_one_beyond_in_steps(north: float, whole: bool) -> None:
    goal = Goal(north, 0.0, 30.0, 0.0)
    (sent,) = targets(Holding(SETTINGS, goal).process(flying(0.05)))
    assert (sent == goal) is whole


@pytest.mark.parametrize(("height", "whole"), [(0.9 * 15, True), (0.9 * 15 - 0.01, False)])
def test_a_drone_below_nine_tenths_of_min_climbs_in_steps_to_a_goal_within_reach(height: float, whole: bool) -> None:
    goal = Goal(0.0, 0.0, 15.0, 0.0)
    (sent,) = targets(Holding(SETTINGS, goal).process(at(flying(0.05), height=height)))
    assert (sent == goal) is whole


def test_steps_to_a_goal_far_away_stay_below_the_ceiling_of_the_fence_in_force() -> None:
    """The planned fence ends lower: it is not the one that the drone flies in, and stops nothing across."""
    goal = Goal(0.0, 60.0, 90.0, 0.0)
    low = replace(flying(0.0).limits, planned_ceiling=40.0)
    holding = Holding(SETTINGS, goal)
    for now in (0.05, 0.55):
        (sent,) = targets(holding.process(replace(at(flying(now), height=90.0), limits=low)))
    assert sent.east > 0.0


@pytest.mark.parametrize(
    ("north", "height", "fence_on", "whole"),
    [
        (190.0, 30.0, True, True),
        (190.0, 30.0, False, False),
        (190.0, 30.0, None, False),
        (190.0, 100.0, True, True),
        (190.0, 100.01, True, False),
        (158.0, 30.0, True, True),
    ],
)
def test_outside_the_autopilots_own_fence_the_place_inside_is_sent_at_once(
    north: float, height: float, fence_on: bool | None, whole: bool
) -> None:
    """ArduCopter takes no target outside its fence; above the fence's ceiling it takes none at all."""
    facts = outside(0.05, north, height=height)
    facts = replace(facts, diagnostics=replace(facts.diagnostics, fence_on=fence_on))
    (sent,) = targets(Holding(SETTINGS).process(facts))
    assert (sent.north == pytest.approx(153.0, abs=0.01)) is whole


@pytest.mark.parametrize(("now", "left"), [(0.0, 60.0), (59.0, 1.0), (60.0, 0.0), (65.0, 0.0)])
def test_the_time_until_the_return_ends_at_zero(now: float, left: float) -> None:
    settings = replace(SETTINGS, operator=SETTINGS.operator.model_copy(update={"operator_hold_s": 60.0}))
    assert CommunicationLostState(0.0, settings).return_in(flying(now)) == left


# -- a page that nobody looks at --------------------------------------------------------------------------------------


def hidden_for(facts: Facts, seconds: float | None) -> Facts:
    return replace(facts, operator=replace(facts.operator, hidden_s=seconds))


@pytest.mark.parametrize("task", [ToExplore(), ToMove(MOVE), ToMove(LOT_MOVE)])
def test_a_task_before_a_hidden_page_ends_after_30_s_of_both(task: Transition) -> None:
    state = made(task)
    assert reaction(hidden_for(flying(40.0), 29.9), state) is None
    assert reaction(hidden_for(flying(29.9), 300.0), state) is None, "the task is younger"
    assert reaction(hidden_for(flying(40.0), None), state) is None, "a program says nothing of a page"
    found = reaction(hidden_for(flying(30.0), 30.0), state)
    assert found is not None
    assert found.transition == ToCommunicationLost(is_hidden=True)
    (log,) = make_state(found.transition, flying(30.0), SETTINGS)[1]
    assert isinstance(log, Log)
    assert log.text.startswith("The page of the operator in control is hidden. Holds for")


@pytest.mark.parametrize("transition", [ToHover(), ToReturn(), ToLand(), ToTakeoff(), ToManual()])
def test_a_hidden_page_ends_nothing_else(transition: Transition) -> None:
    assert reaction(hidden_for(flying(400.0), 300.0), made(transition)) is None


def test_until_somebody_looks_again_it_holds_and_returns_as_for_a_lost_operator() -> None:
    state = made(ToCommunicationLost(is_hidden=True))
    hold = SETTINGS.operator.operator_hold_s
    away = hidden_for(flying(hold - 0.1), 60.0)
    assert state.transition_next_state(away) == STAY
    assert state.detail(away).startswith("The page of the operator in control is hidden.")
    back = state.transition_next_state(hidden_for(flying(hold - 0.1), None))
    assert isinstance(back.transition, ToHover)
    home = state.transition_next_state(hidden_for(flying(hold), 60.0))
    assert isinstance(home.transition, ToReturn)
