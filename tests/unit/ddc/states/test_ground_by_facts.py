"""Configure, Arm and Takeoff by facts alone: limits at their very value, refusals, and what is missing."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.comm.protocol.commands import Disarm, Takeoff
from hawk.ddc.acts import (
    STAY,
    Log,
    PutFenceInForce,
    SetArmed,
    SetDatum,
    SetReturnAltitude,
    StoreFence,
    UploadFence,
    UseHeights,
)
from hawk.ddc.facts import Answer, Facts
from hawk.ddc.fence.plan import FencePlan
from hawk.ddc.motion import Goal
from hawk.ddc.orders import (
    ConfigureOrder,
    FenceOrder,
    ToArm,
    ToCommunicationLost,
    ToConfigure,
    ToHover,
    ToIdle,
    ToManual,
    ToTakeoff,
)
from hawk.ddc.states.base import State
from hawk.model.vehicle import CopterMode
from tests.unit.ddc.by_facts import (
    HEIGHTS,
    answered,
    at,
    made,
    requests,
    standing,
    texts,
    without_operator,
    without_pose,
)
from tests.unit.ddc.written_facts import DATUM, SETTINGS, flying, of_kind

# -- Configure ---------------------------------------------------------------------------------------------------------


def test_heights_are_in_force_without_the_return_altitude_where_it_is_not_ours_to_set() -> None:
    state = made(ToConfigure(ConfigureOrder(HEIGHTS)), settings=replace(SETTINGS, set_rtl_altitude=False))
    state.enter(standing(0.0))
    stored = answered(standing(0.1), ("store heights", 0.0, "done"))
    assert state.process(stored) == (UseHeights(HEIGHTS),)
    step = state.transition_next_state(stored)
    assert isinstance(step.transition, ToIdle)
    assert texts(step.acts) == ["Flies at 35 m, never below 15 m or above 60 m."]


def test_heights_are_done_only_when_the_return_altitude_is() -> None:
    state = made(ToConfigure(ConfigureOrder(HEIGHTS)))
    state.enter(standing(0.0))
    assert state.process(standing(0.0)) == ()
    stored = answered(standing(0.1), ("store heights", 0.0, "done"), ("set return altitude", 0.1, "pending"))
    assert requests(state.process(stored)) == [SetReturnAltitude(60)]
    assert state.process(stored) == (), "asked for once"
    assert state.transition_next_state(stored) == STAY
    assert state.transition_next_state(replace(stored, now=40.0)) == STAY
    late = state.transition_next_state(replace(stored, now=40.1))
    assert texts(late.acts) == ["Saving the heights took too long."]
    done = replace(stored, answers=(Answer("set return altitude", 0.1, "done"),))
    assert isinstance(state.transition_next_state(done).transition, ToIdle)


def test_a_fence_that_is_not_stored_in_ten_seconds_ends_in_idle_with_an_error() -> None:
    state = made(ToConfigure(FenceOrder(None)))
    assert requests(state.enter(standing(0.0))) == [StoreFence(None)]
    waiting = ("store fence", 0.0, "pending")
    assert state.transition_next_state(answered(standing(10.0), waiting)) == STAY
    step = state.transition_next_state(answered(standing(10.05), waiting))
    assert isinstance(step.transition, ToIdle)
    assert texts(step.acts) == ["Saving the fence took too long."]


@pytest.mark.parametrize(
    ("plan", "status", "text"),
    [
        (FencePlan("drawn", (), 100.0), "done", "The fence is saved."),
        (None, "done", "The drawn fence was removed; the standard one is used."),
        (None, "failed", "The fence was not saved."),
    ],
)
def test_the_outcome_of_storing_a_fence_is_reported(plan: FencePlan | None, status: str, text: str) -> None:
    state = made(ToConfigure(FenceOrder(plan)))
    state.enter(standing(0.0))
    step = state.transition_next_state(answered(standing(0.1), ("store fence", 0.0, status)))
    assert isinstance(step.transition, ToIdle)
    assert texts(step.acts) == [text]


# -- Arm ---------------------------------------------------------------------------------------------------------------


def test_arm_sets_the_datum_where_there_is_none_before_it_uploads_the_fence() -> None:
    facts = standing(0.0)
    assert requests(made(ToArm()).enter(facts))[0].__class__ is UploadFence
    assert of_kind(made(ToArm()).enter(facts), SetDatum) == []
    first = replace(facts, position=replace(facts.position, datum=None))
    assert isinstance(made(ToArm()).enter(first)[0], SetDatum)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda facts: replace(facts, position=replace(facts.position, pose=None)), "the position is not known"),
        (lambda facts: replace(facts, limits=replace(facts.limits, plan_problem="fence: broken")), "fence: broken"),
    ],
)
def test_arm_gives_up_without_a_fence_to_fly_in(change: object, why: str) -> None:
    assert callable(change)
    facts = change(standing(0.0))
    state = made(ToArm())
    assert state.enter(facts) == ()
    step = state.transition_next_state(facts)
    assert step.transition == ToIdle(f"There is no fence to fly in. {why}", gave_up_arming=True)


def test_arm_waits_its_whole_time_and_not_longer() -> None:
    state = made(ToArm())
    state.enter(standing(0.0))
    pending = ("upload fence", 0.0, "pending")
    assert state.transition_next_state(answered(standing(20.0), pending)) == STAY
    step = state.transition_next_state(answered(standing(20.05), pending))
    assert step.transition == ToIdle("Arming took too long.", gave_up_arming=True)


def test_an_acknowledged_arm_that_does_not_show_is_given_up_after_three_seconds() -> None:
    state = made(ToArm())
    state.enter(standing(0.0))
    fence = ("upload fence", 0.0, "done")
    assert SetArmed(True) in requests(state.process(answered(standing(1.0), fence)))
    acknowledged = answered(standing(2.0), ("arm", 1.0, "done"))
    state.process(acknowledged)
    assert state.transition_next_state(replace(acknowledged, now=5.0)) == STAY
    step = state.transition_next_state(replace(acknowledged, now=5.05))
    assert step.transition == ToIdle("Arm was taken, but the drone does not arm.", gave_up_arming=True)


def test_disarm_in_arm_is_not_sent_to_a_drone_that_is_in_the_air() -> None:
    state = made(ToArm(armed=True))
    assert state.transition_next_state(flying(0.1), Disarm()) == STAY
    assert requests(state.transition_next_state(standing(0.1, armed=True), Disarm()).acts) == [SetArmed(False)]


def test_armed_it_watches_operator_motors_and_mode() -> None:
    state = made(ToArm(armed=True))
    armed = standing(0.1, armed=True)
    assert state.transition_next_state(armed) == STAY
    assert state.transition_next_state(standing(0.1)).transition == ToIdle("Motors off.")
    assert state.transition_next_state(standing(0.1, armed=True, mode=CopterMode.LOITER)).transition == ToManual()
    lost = state.transition_next_state(without_operator(armed))
    assert lost.transition == ToIdle("The operator was lost: motors off.", gave_up_arming=True)
    assert isinstance(state.transition_next_state(armed, Takeoff()).transition, ToTakeoff)


def test_arm_says_that_it_arms_and_once_armed_when_the_motors_stop() -> None:
    assert made(ToArm()).detail(standing(4.0)) == "Arming."
    armed = made(ToArm(armed=True), 2.0)
    assert armed.detail(standing(5.0, armed=True)) == "Armed. Motors stop in 7 s without take-off."
    again = made(ToArm(armed=True, reason="It did not take off."))
    assert again.detail(standing(0.0)) == "It did not take off. Motors stop in 10 s without take-off."


def test_arm_puts_no_fence_in_force_that_is_not_taken_yet_though_the_drone_is_armed() -> None:
    state = made(ToArm())
    state.enter(standing(0.0))
    assert state.process(answered(standing(0.5, armed=True), ("upload fence", 0.0, "pending"))) == ()
    assert not state.may_take_off
    acts = state.process(answered(standing(1.0), ("upload fence", 0.0, "done")))
    assert len(of_kind(acts, PutFenceInForce)) == 1


def test_an_arm_that_begins_armed_asks_for_nothing() -> None:
    state = made(ToArm(armed=True))
    assert state.enter(standing(0.0, armed=True)) == ()
    assert state.process(standing(0.05, armed=True)) == ()


def test_armed_is_reported_with_the_checks_that_passed() -> None:
    state = made(ToArm(checks=12, by="Ana"))
    state.enter(standing(0.0))
    state.process(answered(standing(1.0), ("upload fence", 0.0, "done")))
    assert state.process(standing(1.05)) == (), "not armed yet"
    assert texts(state.process(standing(1.1, armed=True))) == ["Armed by Ana. 12 checks passed."]
    assert state.may_take_off


@pytest.mark.parametrize(
    ("request_name", "words"), [("upload fence", "The fence was not taken."), ("arm", "Arm was refused.")]
)
def test_arm_gives_up_at_a_refusal_and_says_of_what(request_name: str, words: str) -> None:
    state = made(ToArm())
    state.enter(standing(0.0))
    fence = ("upload fence", 0.0, "failed" if request_name == "upload fence" else "done")
    state.process(answered(standing(1.0), fence, words="no"))
    refused = answered(standing(1.1), fence, ("arm", 1.0, "failed"), words="no")
    assert state.transition_next_state(refused).transition == ToIdle(f"{words} no", gave_up_arming=True)


def test_a_disarm_that_was_refused_is_reported_once_and_arm_stays() -> None:
    state = made(ToArm(armed=True))
    state.transition_next_state(standing(1.0, armed=True), Disarm())
    refused = answered(standing(1.1, armed=True), ("disarm", 1.0, "failed"), words="not now")
    assert state.transition_next_state(refused).acts == (Log("error", "Disarm was refused.", "not now"),)
    assert state.transition_next_state(refused) == STAY


# -- Takeoff -----------------------------------------------------------------------------------------------------------


def climbing(height: float, now: float = 1.0) -> Facts:
    return at(flying(now), height=height)


def took_off(now: float = 0.5) -> State:
    state = made(ToTakeoff())
    state.enter(standing(0.0, armed=True))
    assert texts(state.process(climbing(1.0, now))) == ["Took off."]
    return state


def test_the_climb_is_done_at_95_percent() -> None:
    assert took_off().transition_next_state(climbing(0.95 * 35 - 0.01)) == STAY
    step = took_off().transition_next_state(climbing(0.95 * 35))
    assert step.transition == ToHover("At 35 m.", Goal(0.0, 0.0, 35, 0.0))
    lost = took_off().transition_next_state(without_operator(climbing(34.0)))
    assert lost.transition == ToCommunicationLost()


def test_at_its_height_without_a_young_position_it_holds_without_a_goal() -> None:
    assert took_off().transition_next_state(without_pose(climbing(34.0))).transition == ToHover("At 35 m.")


def test_half_a_metre_in_five_seconds_is_a_climb() -> None:
    state = took_off(1.0)
    assert state.transition_next_state(climbing(1.0, 6.0)) == STAY
    assert state.transition_next_state(climbing(1.0, 6.05)).transition == ToHover("The climb stopped.", level="warning")
    state.process(climbing(1.49, 5.0))
    assert state.transition_next_state(climbing(1.49, 6.05)).transition is not None
    state.process(climbing(1.5, 5.0))
    assert state.transition_next_state(climbing(1.5, 10.0)) == STAY


def test_a_take_off_that_stays_on_the_ground_ends_after_eight_seconds() -> None:
    state = made(ToTakeoff())
    state.enter(standing(0.0, armed=True))
    pending = ("take off", 0.0, "pending")
    assert state.transition_next_state(answered(standing(8.0, armed=True), pending)) == STAY
    late = state.transition_next_state(answered(standing(8.05, armed=True), pending))
    assert late.transition == ToArm(armed=True, reason="It did not take off.")
    off = state.transition_next_state(answered(standing(8.05), pending))
    assert off.transition == ToIdle("It did not take off.")


def test_arming_that_takes_too_long_says_why_guided_was_refused_or_what_the_link_says() -> None:
    state = made(ToArm())
    state.enter(standing(0.0))
    fence = ("upload fence", 0.0, "done")
    state.process(answered(standing(1.0, mode=CopterMode.LOITER), fence))
    refused = answered(standing(1.1, mode=CopterMode.LOITER), fence, ("mode GUIDED", 1.0, "failed"), words="no GPS")
    state.process(refused)
    late = state.transition_next_state(replace(refused, now=20.05))
    assert late.transition == ToIdle("Arming took too long. no GPS", gave_up_arming=True)
    silent = made(ToArm())
    silent.enter(standing(0.0))
    waiting = answered(standing(20.05), ("upload fence", 0.0, "pending"))
    waiting = replace(waiting, link=replace(waiting.link, words="Compass not healthy"))
    step = silent.transition_next_state(waiting)
    assert step.transition == ToIdle("Arming took too long. Compass not healthy", gave_up_arming=True)


def test_the_fence_lies_about_the_drone_on_the_map_of_the_datum() -> None:
    facts = standing(0.0)
    datum = replace(DATUM, latitude=DATUM.latitude - 0.001)
    facts = replace(facts, position=replace(facts.position, datum=datum))
    ((upload,),) = [requests(made(ToArm()).enter(facts))]
    assert isinstance(upload, UploadFence)
    norths = [north for north, _ in upload.fence.polygon]
    assert (min(norths) + max(norths)) / 2 == pytest.approx(111.1, abs=1.0), "the drone stands 0.001 degrees north"


@pytest.mark.parametrize(("controller", "words"), [("Ana", "Ana"), ("", "the operator")])
def test_the_one_who_stops_arming_or_armed_is_named(controller: str, words: str) -> None:
    facts = standing(0.1)
    facts = replace(facts, operator=replace(facts.operator, controller=controller))
    step = made(ToArm()).transition_next_state(facts, Disarm())
    assert step.transition == ToIdle(f"Arming was stopped by {words}.", gave_up_arming=True)
    state = made(ToArm(checks=3, by=controller))
    state.enter(standing(0.0))
    state.process(answered(standing(1.0), ("upload fence", 0.0, "done")))
    assert texts(state.process(standing(1.1, armed=True))) == [f"Armed by {words}. 3 checks passed."]
