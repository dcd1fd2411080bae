"""The autopilot's changes by facts alone: which state stands for them, and what is answered."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.ddc.acts import STAY, Ask, CountStart, ForgetAskedModes, ForgetHeldFence, Log, SetArmed, SettleMode, Step
from hawk.ddc.facts import Facts
from hawk.ddc.orders import (
    Cause,
    CauseKind,
    ToArm,
    ToCommunicationLost,
    ToExplore,
    ToHover,
    ToIdle,
    ToLand,
    ToManual,
    ToReturn,
    Transition,
)
from hawk.ddc.readings.link import VehicleEvent
from hawk.ddc.rules.follower import VehicleFollower, forgotten, state_from_autopilot
from hawk.ddc.states.base import State
from hawk.ddc.states.factory import make_state
from hawk.model.operation import StateName
from hawk.model.vehicle import CopterMode, LandedState
from tests.unit.ddc.written_facts import SETTINGS, flying, on_ground, without_link

S = StateName
M = CopterMode
GIVEN_UP = ToIdle("Arming took too long.", gave_up_arming=True)


def made(transition: Transition) -> State:
    return make_state(transition, flying(0.0), SETTINGS)[0]


def landed(facts: Facts, state: LandedState) -> Facts:
    return replace(facts, vehicle=replace(facts.vehicle, landed=state))


def jumped(frame: float, estimate: float) -> Facts:
    facts = flying(1.0)
    return replace(facts, position=replace(facts.position, jump_m=frame, estimate_jump_m=estimate))


def texts(step: Step) -> list[str]:
    return [act.text for act in step.acts if isinstance(act, Log)]


@pytest.mark.parametrize(
    ("armed", "where", "mode", "at_start", "state"),
    [
        (False, LandedState.IN_AIR, M.GUIDED, False, S.IDLE),
        (True, LandedState.ON_GROUND, M.GUIDED, False, S.ARM),
        (True, LandedState.ON_GROUND, M.RTL, False, S.MANUAL),
        (True, LandedState.IN_AIR, M.RTL, False, S.RETURN_TO_LAUNCH),
        (True, LandedState.UNDEFINED, M.SMART_RTL, True, S.RETURN_TO_LAUNCH),
        (True, LandedState.LANDING, M.LAND, False, S.LAND),
        (True, LandedState.IN_AIR, M.GUIDED, False, S.HOVER),
        (True, LandedState.TAKING_OFF, M.BRAKE, True, S.COMMUNICATION_LOST),
        (True, LandedState.IN_AIR, M.LOITER, True, S.MANUAL),
        (True, LandedState.IN_AIR, None, False, S.MANUAL),
    ],
)
def test_the_state_that_stands_for_the_autopilot(
    armed: bool, where: LandedState, mode: int | None, at_start: bool, state: StateName
) -> None:
    assert state_from_autopilot(armed, where, mode, at_start) is state


WHO = "Another station asked for it, or the autopilot itself began it."


@pytest.mark.parametrize(
    ("mode", "where", "following"),
    [
        (M.RTL, LandedState.IN_AIR, ToReturn(Cause(WHO, CauseKind.ALWAYS), by_autopilot=True)),
        (M.LAND, LandedState.UNDEFINED, ToLand(Cause(WHO, CauseKind.ALWAYS), by_autopilot=True)),
        (M.LOITER, LandedState.IN_AIR, ToManual()),
        (M.GUIDED, LandedState.IN_AIR, ToHover("Somebody else took off.", passive=True, level="warning")),
        (M.GUIDED, LandedState.UNDEFINED, ToHover("Not known to stand on the ground.", passive=True, level="warning")),
    ],
)
def test_a_drone_that_left_the_ground_without_us_is_followed(
    mode: CopterMode, where: LandedState, following: Transition
) -> None:
    facts = landed(flying(1.0, mode), where)
    assert VehicleFollower().follow(facts, made(ToIdle())).transition == following


def test_motors_that_stopped_in_the_air_are_a_landing_and_on_the_ground_nothing() -> None:
    assert VehicleFollower().follow(on_ground(flying(1.0)), made(ToHover())).transition == ToIdle("Landed. Motors off.")
    assert VehicleFollower().follow(on_ground(flying(1.0)), made(ToIdle())) == STAY
    assert VehicleFollower().follow(without_link(on_ground(flying(1.0))), made(ToHover())) == STAY


def armed_on_ground(now: float) -> Facts:
    return landed(flying(now), LandedState.ON_GROUND)


def test_an_arming_that_was_given_up_is_answered_by_a_disarm_for_fifteen_seconds_every_two() -> None:
    follower, idle = VehicleFollower(), made(ToIdle())
    follower.note(GIVEN_UP, 10.0)
    first = follower.follow(armed_on_ground(11.0), idle)
    assert Ask(SetArmed(False), 11.0) in first.acts
    assert follower.follow(armed_on_ground(12.99), idle) == STAY
    assert follower.follow(armed_on_ground(13.0), idle).acts
    assert follower.follow(armed_on_ground(25.0), idle).acts
    late = follower.follow(armed_on_ground(25.01), idle)
    assert late.acts == ()
    assert late.transition is not None


def test_an_arming_that_was_asked_for_again_is_not_given_up() -> None:
    follower = VehicleFollower()
    follower.note(GIVEN_UP, 10.0)
    follower.note(ToArm(), 10.5)
    assert follower.follow(armed_on_ground(11.0), made(ToIdle())).acts == ()


@pytest.mark.parametrize(("frame", "estimate"), [(1.5, 0.0), (0.0, 2.0), (1.5, 2.0)])
def test_a_jump_ends_a_task_and_makes_a_hold_form_its_goal_again(frame: float, estimate: float) -> None:
    follower = VehicleFollower()
    task = follower.follow_jump(jumped(frame, estimate), made(ToExplore()))
    assert task.transition == ToHover("The position jumped.", level="warning")
    hold = follower.follow_jump(jumped(frame, estimate), made(ToHover()))
    assert (hold.transition, hold.restarts) == (None, True)
    words = "The position estimate jumped by 2 m" if estimate else "The position jumped by 1.5 m."
    assert texts(hold)[0].startswith(words)


def test_without_a_jump_and_on_the_ground_nothing_follows() -> None:
    follower = VehicleFollower()
    assert follower.follow_jump(jumped(0.0, 0.0), made(ToExplore())) == STAY
    assert follower.follow_jump(jumped(5.0, 5.0), made(ToIdle())) == STAY
    assert not follower.follow_jump(jumped(5.0, 0.0), made(ToManual())).restarts


@pytest.mark.parametrize("transition", [ToReturn(), ToLand(), ToCommunicationLost()])
def test_a_link_that_is_back_does_not_lower_the_rank(transition: Transition) -> None:
    step = VehicleFollower().adopt(flying(1.0), made(transition), keeps_rank=True)
    assert step.transition is None
    assert step.restarts


@pytest.mark.parametrize(
    ("mode", "following"), [(M.LOITER, ToManual), (M.LAND, ToLand)], ids=["a pilot", "the autopilot lands"]
)
def test_a_link_that_is_back_shows_what_outranks_the_state(mode: CopterMode, following: type) -> None:
    step = VehicleFollower().adopt(flying(1.0, mode), made(ToReturn()), keeps_rank=True)
    assert isinstance(step.transition, following)


def test_a_foreign_mode_counts_only_while_armed() -> None:
    armed = VehicleFollower().answer(VehicleEvent.FOREIGN_MODE, flying(1.0, M.LOITER), made(ToExplore()))
    assert armed.transition == ToManual()
    assert ForgetAskedModes() in armed.acts
    off = VehicleFollower().answer(VehicleEvent.FOREIGN_MODE, on_ground(flying(1.0, M.LOITER)), made(ToIdle()))
    assert off.transition is None
    assert ForgetAskedModes() not in off.acts


def counted(starts: int) -> Facts:
    return replace(flying(1.0), starts_in_air=starts)


@pytest.mark.parametrize(("starts", "returns"), [(1, False), (2, True)])
def test_the_second_start_in_the_air_returns_home_once(starts: int, returns: bool) -> None:
    follower = VehicleFollower()
    step = follower.answer(VehicleEvent.FOUND, flying(0.5), made(ToIdle()))
    assert CountStart() in step.acts
    assert follower.started_in_air
    assert follower.follow(flying(0.9), made(ToHover())) == STAY, "the count is not known yet"
    counting = follower.follow(counted(starts), made(ToHover()))
    assert isinstance(counting.transition, ToReturn) is returns
    assert follower.follow(counted(starts), made(ToHover())) == STAY


def test_the_second_start_leaves_a_pilot_alone() -> None:
    follower = VehicleFollower()
    follower.answer(VehicleEvent.FOUND, flying(0.5, M.LOITER), made(ToIdle()))
    assert follower.follow(counted(2), made(ToManual())).transition is None


def test_a_drone_that_is_found_on_the_ground_is_no_start_in_the_air() -> None:
    follower = VehicleFollower()
    step = follower.answer(VehicleEvent.FOUND, on_ground(flying(0.5)), made(ToIdle("Looking for the autopilot.")))
    assert step.transition == ToIdle()
    assert CountStart() not in step.acts
    assert not follower.started_in_air


def test_a_doubt_is_reported_with_what_follows_from_it() -> None:
    facts = flying(1.0)
    facts = replace(facts, ground=replace(facts.ground, doubt="It says both."))
    assert texts(VehicleFollower().answer(VehicleEvent.DOUBTED, facts, made(ToHover()))) == [
        "It says both. It counts as in the air."
    ]
    assert texts(VehicleFollower().answer(VehicleEvent.DOUBTED, on_ground(facts), made(ToIdle()))) == ["It says both."]


def test_an_arming_that_was_given_up_at_time_zero_counts_too() -> None:
    follower = VehicleFollower()
    follower.note(GIVEN_UP, 0.0)
    assert Ask(SetArmed(False), 0.5) in follower.follow(armed_on_ground(0.5), made(ToIdle())).acts


def test_a_drone_that_is_armed_in_arm_is_not_disarmed_and_not_adopted() -> None:
    follower = VehicleFollower()
    follower.note(GIVEN_UP, 10.0)
    assert follower.follow(armed_on_ground(10.5), made(ToArm(armed=True))) == STAY


def test_a_new_mode_is_settled_and_a_lost_link_forgets_the_fence_that_is_held() -> None:
    facts = flying(1.0)
    assert forgotten(facts) == ()
    changed = replace(facts, link=replace(facts.link, new_mode=CopterMode.LOITER))
    assert forgotten(changed) == (SettleMode(CopterMode.LOITER),)
    for mode, acts in ((None, (ForgetHeldFence(),)), (CopterMode.RTL, (SettleMode(CopterMode.RTL), ForgetHeldFence()))):
        events = (VehicleEvent.LINK_LOST, VehicleEvent.LINK_BACK)
        assert forgotten(replace(facts, link=replace(facts.link, events=events, new_mode=mode))) == acts
    back = replace(facts, link=replace(facts.link, events=(VehicleEvent.LINK_BACK,)))
    assert forgotten(back) == ()


def test_a_link_that_is_lost_forgets_the_modes_that_were_asked_for() -> None:
    step = VehicleFollower().answer(VehicleEvent.LINK_LOST, without_link(flying(1.0)), made(ToExplore()))
    assert step.transition is None
    assert ForgetAskedModes() in step.acts
    assert texts(step) == ["No word from the autopilot."]


def test_a_link_that_is_back_is_reported_and_the_state_goes_on_from_where_the_drone_is() -> None:
    step = VehicleFollower().answer(VehicleEvent.LINK_BACK, flying(1.0), made(ToHover()))
    assert (step.transition, step.restarts) == (None, True)
    assert texts(step) == ["The autopilot is heard again."]
    task = VehicleFollower().answer(VehicleEvent.LINK_BACK, flying(1.0), made(ToExplore()))
    assert isinstance(task.transition, ToHover), "a task does not go on by itself"


@pytest.mark.parametrize(("mode", "same"), [(M.RTL, ToReturn()), (M.LOITER, ToManual())])
def test_a_link_that_is_back_keeps_the_state_that_the_autopilot_is_in(mode: CopterMode, same: Transition) -> None:
    step = VehicleFollower().adopt(flying(1.0, mode), made(same), keeps_rank=True)
    assert step.transition is None
    assert step.restarts is isinstance(same, ToReturn)


@pytest.mark.parametrize("transition", [ToManual(), ToExplore(), ToHover()])
def test_only_what_ranks_between_a_lost_operator_and_a_landing_outlasts_a_hold(transition: Transition) -> None:
    facts = flying(1.0)
    step = VehicleFollower().adopt(facts, made(transition), keeps_rank=True)
    assert isinstance(step.transition, ToHover) is not isinstance(transition, ToHover)


def test_a_mode_of_somebody_else_replaces_the_state_whatever_its_rank() -> None:
    step = VehicleFollower().answer(VehicleEvent.FOREIGN_MODE, flying(1.0), made(ToReturn()))
    assert isinstance(step.transition, ToHover)


def test_arm_goes_on_where_the_autopilot_stands_armed_in_guided() -> None:
    assert VehicleFollower().adopt(armed_on_ground(1.0), made(ToArm())) == STAY
    assert VehicleFollower().adopt(armed_on_ground(1.0), made(ToIdle())).transition == ToArm(armed=True)


def test_a_start_with_an_armed_drone_on_the_ground_is_no_start_in_the_air() -> None:
    follower = VehicleFollower()
    step = follower.answer(VehicleEvent.FOUND, armed_on_ground(0.5), made(ToIdle()))
    assert step.transition == ToArm(armed=True)
    assert CountStart() not in step.acts
    assert not follower.started_in_air
    assert not VehicleFollower().started_in_air


def test_a_count_of_starts_that_nobody_awaits_returns_nobody() -> None:
    assert VehicleFollower().follow(counted(5), made(ToHover())) == STAY
