"""Single states by facts alone: limits at their very value, orders that do not fit, and what is missing."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.comm.messages import Disarm, Hold, Takeoff
from hawk.ddc.acts import (
    STAY,
    Acts,
    Ask,
    Desire,
    Log,
    PutFenceInForce,
    SendTarget,
    SetArmed,
    SetDatum,
    SetMode,
    SetReturnAltitude,
    StoreFence,
    UploadFence,
    UseHeights,
)
from hawk.ddc.facts import Answer, Facts, HomeFacts
from hawk.ddc.fence import FencePlan
from hawk.ddc.geofence import contains, polygon_fence
from hawk.ddc.motion import Goal
from hawk.ddc.orders import (
    Cause,
    CauseKind,
    ConfigureOrder,
    FenceOrder,
    MoveOrder,
    Rank,
    ToArm,
    ToCommunicationLost,
    ToConfigure,
    ToExplore,
    ToHover,
    ToIdle,
    ToLand,
    ToManual,
    ToMove,
    ToReturn,
    ToTakeoff,
    Transition,
)
from hawk.ddc.outline import OutlineFacts
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import MODE_RETRY_S, ModeKeeper, State
from hawk.ddc.states.explore import Travelling, outline_words
from hawk.ddc.states.factory import adopted, make_state
from hawk.ddc.states.hover import CommunicationLost, Holding, Hover
from hawk.model import (
    CopterMode,
    DesiredPose,
    ExploreStatus,
    HeightParameters,
    Inbound,
    LandedState,
    MapPoint,
    PathPlan,
    Route,
    StateName,
    UserError,
    Verdict,
)
from tests.unit.ddc.written_facts import FENCE, SETTINGS, flying, of_kind, on_ground, pose

HEIGHTS = HeightParameters(15, 35, 60)
MOVE = MoveOrder(MapPoint(40.0, 0.0), 30.0, 0.0, False, 0)
STRAIGHT = Route((MapPoint(0.0, 0.0), MapPoint(40.0, 0.0)), (0.0, 0.0))
LOT_MOVE = replace(MOVE, autonomous=True, number=3, route=STRAIGHT)
IN_THE_AIR: tuple[Transition, ...] = (
    ToTakeoff(),
    ToHover(),
    ToExplore(),
    ToMove(MOVE),
    ToReturn(),
    ToLand(),
    ToCommunicationLost(),
    ToManual(),
)


def made(transition: Transition, now: float = 0.0, settings: DdcSettings = SETTINGS) -> State:
    return make_state(transition, flying(now), settings)[0]


def standing(now: float, armed: bool = False, mode: int = CopterMode.GUIDED) -> Facts:
    facts = on_ground(flying(now, mode))
    return replace(facts, vehicle=replace(facts.vehicle, armed=armed))


def answered(facts: Facts, *answers: tuple[str, float, str], words: str = "") -> Facts:
    """Write answers down: name, time of the request, status."""
    given = tuple(Answer(name, at, status, words) for name, at, status in answers)  # type: ignore[arg-type]
    return replace(facts, answers=given)


def at(facts: Facts, north: float = 0.0, east: float = 0.0, height: float = 30.0) -> Facts:
    return replace(facts, position=replace(facts.position, pose=pose(facts.now, north, east, height)))


def without_pose(facts: Facts) -> Facts:
    return replace(facts, position=replace(facts.position, age=0.6))


def without_operator(facts: Facts) -> Facts:
    return replace(facts, operator=replace(facts.operator, is_present=False))


def requests(acts: Acts) -> list[object]:
    return [act.request for act in acts if isinstance(act, Ask)]


def targets(acts: Acts) -> list[Goal]:
    return [act.goal for act in acts if isinstance(act, SendTarget)]


def texts(acts: Acts) -> list[str]:
    return [act.text for act in acts if isinstance(act, Log)]


# -- what the states share ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("transition", IN_THE_AIR, ids=lambda each: type(each).__name__)
def test_orders_of_the_ground_change_no_state_in_the_air(transition: Transition) -> None:
    state = made(transition)
    for order in (Takeoff(), Disarm(), ConfigureOrder(HEIGHTS), FenceOrder(None)):
        assert state.transition_next_state(flying(0.05), order) == STAY


@pytest.mark.parametrize("transition", [ToIdle(), *IN_THE_AIR], ids=lambda each: type(each).__name__)
def test_only_arm_lets_the_drone_take_off(transition: Transition) -> None:
    assert not made(transition).may_take_off
    assert made(ToArm(armed=True)).may_take_off
    assert not made(ToArm()).may_take_off


def test_every_state_says_what_it_does() -> None:
    on_the_ground = (ToIdle(), ToArm(), ToConfigure(ConfigureOrder(HEIGHTS)), ToConfigure(FenceOrder(None)))
    for resting in on_the_ground:
        assert made(resting).detail(standing(0.05)).endswith(".")
    for transition in IN_THE_AIR:
        assert made(transition).detail(flying(0.05))


def test_a_mode_is_asked_for_again_after_two_seconds_and_not_while_an_answer_waits_or_nobody_hears() -> None:
    keeper = ModeKeeper(CopterMode.RTL)
    assert requests(keeper.reach(flying(10.0))) == [SetMode(CopterMode.RTL)]
    done = ("mode RTL", 10.0, "done")
    assert keeper.reach(answered(flying(10.0 + MODE_RETRY_S - 0.01), done)) == ()
    pending = answered(flying(10.0 + MODE_RETRY_S), ("mode RTL", 10.0, "pending"))
    fresh = ModeKeeper(CopterMode.RTL)
    fresh.reach(flying(10.0))
    assert fresh.reach(pending) == ()
    deaf = answered(flying(10.0 + MODE_RETRY_S), done)
    assert keeper.reach(replace(deaf, link=replace(deaf.link, is_up=False))) == ()
    assert requests(keeper.reach(deaf)) == [SetMode(CopterMode.RTL)]
    assert (keeper.attempts, keeper.refusals, keeper.is_reached) == (2, 0, False)


def test_a_refused_mode_is_counted_with_its_words_until_it_is_seen_and_never_asked_for_again() -> None:
    keeper = ModeKeeper(CopterMode.RTL)
    keeper.reach(flying(10.0))
    assert keeper.reach(answered(flying(10.1), ("mode RTL", 10.0, "failed"), words="EKF variance")) == ()
    assert (keeper.refusals, keeper.reason) == (1, "EKF variance")
    assert keeper.reach(flying(12.1, CopterMode.RTL)) == ()
    assert (keeper.is_reached, keeper.reason) == (True, "")
    assert keeper.reach(flying(60.0, CopterMode.LOITER)) == (), "somebody else changed it"


def test_anything_that_no_state_in_the_air_stands_for_is_adopted_as_the_ground() -> None:
    assert adopted(StateName.IDLE, flying(1.0)) == ToIdle()
    assert adopted(StateName.ARM, flying(1.0)) == ToArm(armed=True)


def test_a_move_without_any_position_is_reported_without_a_distance() -> None:
    facts = flying(1.0)
    lost = replace(facts, position=replace(facts.position, pose=None))
    assert make_state(ToMove(MOVE), lost, SETTINGS)[1] == ()
    assert texts(make_state(ToMove(MOVE), facts, SETTINGS)[1]) == ["Moving 40 m north."]


@pytest.mark.parametrize(
    ("north", "east", "words"), [(50.0, 0.0, "Moving 10 m south."), (40.0, 60.0, "Moving 60 m west.")]
)
def test_the_direction_of_a_move_is_that_from_the_drone(north: float, east: float, words: str) -> None:
    assert texts(make_state(ToMove(MOVE), at(flying(1.0), north, east), SETTINGS)[1]) == [words]


def said(transition: Transition, facts: Facts) -> list[tuple[str, str]]:
    return [(act.text, act.details) for act in make_state(transition, facts, SETTINGS)[1] if isinstance(act, Log)]


def test_what_begins_is_reported_with_who_or_what_began_it() -> None:
    facts = flying(1.0)
    outlined = replace(facts, limits=replace(facts.limits, outline=OutlineFacts(900.0, 0.0)))
    assert said(ToExplore(), facts) == [("Lot found. Exploring.", "")]
    assert said(ToExplore(), outlined) == [("Exploring the outline.", "")]
    assert said(ToReturn(), facts) == [("Returning home.", "")]
    assert said(ToLand(by="Ana"), facts) == [("Landing, asked by Ana.", "")]
    cause = Cause("The wind is too strong.", CauseKind.WIND, "gusts")
    assert said(ToReturn(cause), facts) == [("The wind is too strong. Returning home.", "")]
    assert said(ToReturn(cause, by_autopilot=True), facts) == [("The autopilot returns home by itself.", "gusts")]
    assert said(ToLand(by_autopilot=True), facts) == [("The autopilot lands by itself.", "")]


@pytest.mark.parametrize(("mode", "words"), [(CopterMode.LOITER, "LOITER"), (None, "an unknown mode")])
def test_a_mode_that_is_not_known_is_called_unknown(mode: CopterMode | None, words: str) -> None:
    facts = flying(1.0)
    facts = replace(facts, vehicle=replace(facts.vehicle, custom_mode=mode))
    assert texts(make_state(ToManual(), facts, SETTINGS)[1]) == [f"Someone else flies, in {words}."]
    assert made(ToManual()).detail(facts) == f"Someone else flies, in {words}."
    hold = adopted(StateName.HOVER, facts)
    assert hold == ToHover(f"The autopilot went to {words} by itself.", passive=True, level="warning")


@pytest.mark.parametrize("name", [StateName.HOVER, StateName.COMMUNICATION_LOST])
def test_adopting_a_hold_sends_nothing(name: StateName) -> None:
    assert made(adopted(name, flying(0.0))).process(flying(0.05)) == ()


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


# -- Return To Launch and Land -----------------------------------------------------------------------------------------


def test_a_refused_disarm_in_land_is_reported_once() -> None:
    state = made(ToLand())
    landed = replace(
        flying(5.0, CopterMode.LAND), vehicle=replace(flying(5.0).vehicle, landed=LandedState.ON_GROUND, custom_mode=9)
    )
    assert requests(state.transition_next_state(landed, Disarm()).acts) == [SetArmed(False)]
    refused = answered(replace(landed, now=5.1), ("disarm", 5.0, "failed"), words="not landed")
    assert state.process(refused) == (Log("error", "Disarm was refused.", "not landed"),)
    assert state.process(replace(refused, now=5.2)) == ()


def test_hold_is_refused_while_the_cause_lasts_and_when_the_autopilot_returns_by_itself() -> None:
    cause = Cause("The operator is lost.", CauseKind.OPERATOR)
    assert made(ToReturn(cause)).hold_refusal(flying(1.0)) == ""
    assert "The operator is lost." in made(ToReturn(cause)).hold_refusal(without_operator(flying(1.0)))
    own = Cause("", CauseKind.ALWAYS, "Battery failsafe")
    assert made(ToReturn(own, by_autopilot=True)).hold_refusal(flying(1.0)).endswith("Battery failsafe")


def home_at(facts: Facts, away: float, moved_s: float | None, inside: bool = True) -> Facts:
    home = HomeFacts(facts.position.datum, 0.1, away, moved_s, is_inside=inside)
    return replace(facts, position=replace(facts.position, autopilot_home=home))


def test_a_return_that_began_with_home_in_its_place_goes_on_when_home_is_moved_and_set_back() -> None:
    state = made(ToReturn())
    state.process(flying(0.05))
    for now, away in ((1.0, 0.0), (1.05, 60.0), (1.1, 60.0), (1.15, 0.0), (1.2, 0.0)):
        moved = None if away == 0.0 and now < 1.1 else 0.1
        assert state.process(home_at(flying(now, CopterMode.RTL), away, moved)) == ()


def test_a_return_that_began_with_a_moved_home_begins_again_when_home_is_back() -> None:
    state = made(ToReturn(Cause("", CauseKind.ALWAYS), by_autopilot=True))
    assert state.process(home_at(flying(1.0, CopterMode.RTL), 60.0, 0.5)) == ()
    acts = state.process(home_at(flying(2.0, CopterMode.RTL), 0.0, 1.5))
    assert texts(acts) == ["Home is back: the return begins again."]
    assert requests(acts) == [SetMode(CopterMode.BRAKE)]
    assert "set back first" in state.detail(flying(2.0))
    state.process(home_at(flying(2.5, CopterMode.BRAKE), 0.0, 2.0))
    again = state.process(home_at(flying(2.55, CopterMode.BRAKE), 0.0, 2.05))
    assert requests(again) == [SetMode(CopterMode.RTL)]


def test_our_own_return_that_began_with_a_moved_home_begins_again_too() -> None:
    state = made(ToReturn())
    state.process(home_at(flying(1.0, CopterMode.RTL), 60.0, 0.5))
    acts = state.process(home_at(flying(2.0, CopterMode.RTL), 0.0, 1.5))
    assert texts(acts) == ["Home is back: the return begins again."]


def test_a_return_waits_three_seconds_for_a_moved_home_and_then_flies_to_it_inside_the_fence() -> None:
    state = made(ToReturn())
    assert state.process(home_at(flying(0.05), 60.0, 0.05)) == ()
    assert "set back first" in state.detail(home_at(flying(0.05), 60.0, 0.05))
    assert state.process(home_at(flying(2.99), 60.0, 2.99)) == ()
    assert requests(state.process(home_at(flying(3.0), 60.0, 3.0))) == [SetMode(CopterMode.RTL)]


@pytest.mark.parametrize(
    ("cause", "following"),
    [(None, ToHover), (Cause("The wind is too strong.", CauseKind.WIND), ToLand)],
    ids=["asked for", "by itself"],
)
def test_a_return_to_a_home_that_stays_outside_holds_or_lands(cause: Cause | None, following: type) -> None:
    state = made(ToReturn(cause))
    early = home_at(flying(2.99), 300.0, 2.99, inside=False)
    assert state.process(early) == ()
    assert state.transition_next_state(early) == STAY
    late = home_at(flying(3.0), 300.0, 3.0, inside=False)
    assert state.process(late) == ()
    assert isinstance(state.transition_next_state(late).transition, following)


def test_a_return_that_starts_over_reports_no_refusal_that_there_was_not() -> None:
    state = made(ToReturn())
    state.process(flying(0.05))
    state.restart()
    acts = state.process(flying(5.0))
    assert texts(acts) == []
    assert requests(acts) == [SetMode(CopterMode.RTL)]
    refused = state.process(answered(flying(5.1), ("mode RTL", 5.0, "failed"), words="EKF variance"))
    assert refused == (Log("error", "Returning home was refused. Trying again.", "EKF variance"),)
    assert "EKF variance" in state.detail(flying(5.1))


# -- Hover -------------------------------------------------------------------------------------------------------------


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
def test_a_hold_outside_the_fence_leads_inside_before_the_breach_is_told_too(
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
    [Holding(SETTINGS), Hover(0.0, SETTINGS), CommunicationLost(0.0, SETTINGS)],
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


def test_control_that_was_given_back_is_told_and_who_took_it() -> None:
    state = made(ToCommunicationLost(given_back_by="Ana"))
    hold = SETTINGS.operator.operator_hold_s
    assert state.detail(flying(1.0)) == f"Control was given back by Ana. Returns home in {hold - 1.0:.0f} s."
    late = state.transition_next_state(without_operator(flying(hold)))
    assert late.transition == ToReturn(Cause("Nobody took control.", CauseKind.OPERATOR))
    taken = replace(flying(1.0), operator=replace(flying(1.0).operator, controller="Ben"))
    assert state.transition_next_state(taken).transition == ToHover("Ben has taken control.")
    nameless = replace(flying(1.0), operator=replace(flying(1.0).operator, controller=""))
    assert state.transition_next_state(nameless).transition == ToHover("Someone has taken control.")


# -- Moves -------------------------------------------------------------------------------------------------------------


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


def test_a_new_place_on_the_way_is_not_the_one_that_was_reached() -> None:
    state = made(ToMove(MOVE))
    state.process(at(flying(0.05), 39.0))
    assert state.transition_next_state(flying(0.05), replace(MOVE, place=MapPoint(80.0, 0.0))) == STAY
    assert state.transition_next_state(flying(0.1)) == STAY
    assert state.goal == Goal(80.0, 0.0, 30.0, 0.0)


def test_a_move_of_the_other_kind_begins_anew() -> None:
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


def test_every_change_of_the_route_on_the_way_is_reported() -> None:
    state = made(ToMove(LOT_MOVE))
    told = ["The map changed on the way. Another way there was found."]
    assert texts(state.process(judged(flying(0.05)))) == [], "the same route"
    assert texts(state.process(judged(flying(0.1), route=around(10.0)))) == told
    assert state.route(flying(0.1))[1:] == around(10.0).points[1:]
    assert texts(state.process(judged(flying(0.15), route=around(20.0)))) == told


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


def test_an_autonomous_move_stops_at_a_place_outside_and_at_a_way_that_is_refused() -> None:
    state = made(ToMove(LOT_MOVE))
    outside = state.transition_next_state(judged(flying(0.05), inbound=Inbound.OUTSIDE))
    assert outside.transition == ToHover("The place turned out to be outside the lot.", level="warning")
    refused = state.transition_next_state(judged(flying(0.05), route=Route(refused="a zone is in the way")))
    assert refused.transition == ToHover("Held: a zone is in the way.", level="warning")
    assert state.transition_next_state(judged(flying(0.05), number=9, inbound=Inbound.OUTSIDE)) == STAY


# -- Explore -----------------------------------------------------------------------------------------------------------


def planned(facts: Facts, north: float = 30.0, done: bool = False, time: float = 5.0, known: bool = True) -> Facts:
    plan = PathPlan(MapPoint(north, 0.0), 35.0, 0.0, explore=ExploreStatus(done, 0.5, lot_known=known))
    return replace(facts, sight=replace(facts.sight, plan=plan, plan_time=time))


def test_explore_sends_nothing_without_a_young_position() -> None:
    state = made(ToExplore())
    assert state.process(without_pose(planned(flying(0.05)))) == ()
    assert state.goal is None


def test_a_lot_may_be_out_of_sight_for_the_limit() -> None:
    state = made(ToExplore())
    unseen = planned(flying(SETTINGS.flight.explore_lost_lot_s))
    unseen = replace(unseen, sight=replace(unseen.sight, lot=False))
    assert state.transition_next_state(unseen) == STAY
    step = state.transition_next_state(replace(unseen, now=unseen.now + 0.05))
    assert isinstance(step.transition, ToHover)
    assert [act.error for act in step.acts if hasattr(act, "error")] == [UserError.NO_LOT_DETECTED]


@pytest.mark.parametrize(("time", "ends"), [(0.49, False), (0.5, True)])
def test_done_counts_from_half_a_second_after_the_beginning(time: float, ends: bool) -> None:
    step = made(ToExplore()).transition_next_state(planned(flying(1.0), done=True, time=time))
    assert (step.transition is not None) is ends


def test_the_next_place_is_reported_when_it_is_far_and_not_too_often() -> None:
    state = made(ToExplore())
    assert texts(state.process(planned(flying(0.05), 30.0))) == ["Next: to the north, 30 m away."]
    assert texts(state.process(planned(flying(4.0), 60.0))) == []
    assert texts(state.process(planned(flying(5.1), 37.9))) == []
    assert texts(state.process(planned(flying(5.1), 60.0))) == ["Next: to the north, 60 m away."]
    assert texts(state.process(planned(flying(20.0), 7.9))) == [], "it is there already"


def test_hold_ends_explore() -> None:
    assert made(ToExplore()).transition_next_state(flying(0.1), Hold()).transition == ToHover(
        "Stopped by the operator."
    )


PLACE = Goal(30.0, 0.0, 30.0, 0.0)


def test_the_refusal_of_a_target_of_before_hinders_nothing_and_one_of_its_own_is_told() -> None:
    travelling = Travelling(SETTINGS)
    assert len(targets(travelling.process(replace(flying(0.05), target_refusal="too high"), PLACE))) == 1
    assert travelling.obstacle == ""
    travelling.process(replace(flying(0.1), target_refusal="too far"), PLACE)
    assert travelling.obstacle == "too far"
    travelling.process(flying(0.15), PLACE)
    assert travelling.obstacle == ""


def test_no_target_is_sent_without_guided_a_place_and_a_free_way_and_the_reason_is_told() -> None:
    travelling = Travelling(SETTINGS)
    assert requests(travelling.process(flying(0.0, CopterMode.LOITER), PLACE)) == [SetMode(CopterMode.GUIDED)]
    assert (travelling.obstacle, travelling.refusal) == ("Waiting for GUIDED.", "")
    refused = answered(flying(0.1, CopterMode.LOITER), ("mode GUIDED", 0.0, "failed"), words="no GPS")
    assert travelling.process(refused, PLACE) == ()
    assert (travelling.obstacle, travelling.refusal) == ("no GPS", "no GPS")
    assert travelling.process(without_pose(flying(0.2)), PLACE) == ()
    assert (travelling.obstacle, travelling.refusal) == ("The position is too old.", "")
    facts = flying(0.3)
    assert travelling.process(replace(facts, limits=replace(facts.limits, fence=None)), PLACE) == ()
    assert travelling.obstacle == "The way there leaves the fence."
    assert travelling.process(facts, replace(PLACE, north=200.0)) == ()
    assert travelling.obstacle == "The way there leaves the fence."
    assert len(targets(travelling.process(facts, PLACE))) == 1


def test_guided_that_is_not_answered_counts_as_refused() -> None:
    travelling = Travelling(SETTINGS)
    travelling.process(flying(0.0, CopterMode.LOITER), PLACE)
    travelling.process(answered(flying(0.1, CopterMode.LOITER), ("mode GUIDED", 0.0, "failed")), PLACE)
    assert travelling.refusal == "no answer"


@pytest.mark.parametrize(
    ("north", "east", "height", "there"),
    [
        (40.0, 20.0, 30.0, True),
        (41.5, 20.0, 30.0, True),
        (40.0, 18.5, 31.5, True),
        (41.51, 20.0, 30.0, False),
        (40.0, 21.51, 30.0, False),
        (40.0, 20.0, 28.49, False),
        (40.0, 20.0, 31.51, False),
    ],
)
def test_the_place_is_reached_within_the_radius_across_and_in_height(
    north: float, east: float, height: float, there: bool
) -> None:
    here = pose(0.0, north, east, height).map
    assert here is not None
    assert Travelling(SETTINGS).has_arrived(Goal(40.0, 20.0, 30.0, 0.0), here) is there


@pytest.mark.parametrize(
    ("unseen", "outside", "words"),
    [
        (0.0, None, "Explored: the outline is seen whole."),
        (None, 0.99, "Explored: the outline is seen whole."),
        (0.0, 1.0, "Explored: the outline is seen whole. 1 m² outside the fence were left out."),
        (0.6, None, "Explored: the rest cannot be reached. 899 m² of 900 m² seen, 1 m² not reached."),
        (
            100.0,
            50.0,
            "Explored: the rest cannot be reached. 800 m² of 900 m² seen, 100 m² not reached. "
            "50 m² outside the fence were left out.",
        ),
    ],
)
def test_what_was_seen_of_an_outline_is_told_with_what_was_left_out(
    unseen: float | None, outside: float | None, words: str
) -> None:
    explore = ExploreStatus(done=True, asked_m2=900.0, unseen_m2=unseen)
    assert outline_words(explore, None if outside is None else OutlineFacts(900.0, outside)) == words


def test_explore_shows_the_planners_route_and_what_was_seen() -> None:
    state, facts = made(ToExplore()), flying(0.05)
    assert state.route(facts) == ()
    assert state.detail(facts) == "Waiting for a plan."
    route = (MapPoint(1.0, 2.0), MapPoint(3.0, 4.0))

    def shown(explore: ExploreStatus) -> Facts:
        return replace(facts, sight=replace(facts.sight, plan=PathPlan(route=route, explore=explore)))

    assert state.route(shown(ExploreStatus())) == route
    assert state.detail(shown(ExploreStatus(seen=0.5))) == "50 % seen of the lot found so far."
    assert state.detail(shown(ExploreStatus(seen=0.5, asked_m2=900.0))) == "50 % seen of the outline."
    assert state.detail(shown(ExploreStatus(lot_known=False))) == "Looking for the lot."


def unseen(facts: Facts, lot: bool | None = False) -> Facts:
    return replace(facts, sight=replace(facts.sight, lot=lot))


def test_the_time_out_of_sight_counts_from_when_the_lot_was_last_seen_and_not_over_an_outline() -> None:
    state, limit = made(ToExplore()), SETTINGS.flight.explore_lost_lot_s
    state.process(flying(5.0))
    state.process(unseen(flying(6.0)))
    assert state.transition_next_state(unseen(flying(5.0 + limit))) == STAY
    assert state.transition_next_state(unseen(flying(5.05 + limit))).transition is not None
    outlined = unseen(at(flying(20.0), 50.0))
    state.process(replace(outlined, limits=replace(outlined.limits, outline=OutlineFacts(900.0, 0.0))))
    assert state.transition_next_state(unseen(flying(20.0 + limit))) == STAY


@pytest.mark.parametrize(
    ("explore", "words", "level"),
    [
        (ExploreStatus(True, asked_m2=9.0), "Explored: the outline is seen whole.", "ok"),
        (ExploreStatus(True, lot_known=True), "Explored. Nothing left to see.", "ok"),
        (ExploreStatus(True, lot_known=False), "No lot was found here.", "warning"),
    ],
)
def test_explore_ends_with_what_was_found(explore: ExploreStatus, words: str, level: str) -> None:
    facts = flying(1.0)
    facts = replace(facts, sight=replace(facts.sight, plan=PathPlan(explore=explore), plan_time=1.0))
    following = made(ToExplore()).transition_next_state(facts).transition
    assert isinstance(following, ToHover)
    assert (following.reason, following.level) == (words, level)


def test_explore_that_gets_nowhere_for_ten_seconds_holds() -> None:
    state = made(ToExplore())
    state.process(flying(0.0))
    state.process(flying(9.99))
    assert state.transition_next_state(flying(9.99)) == STAY
    state.process(flying(10.0))
    step = state.transition_next_state(flying(10.0))
    assert step.transition == ToHover("No progress for 10 s. The planner gives no way on.", level="warning")


@pytest.mark.parametrize(
    ("plan", "goal"),
    [
        (PathPlan(), None),
        (PathPlan(MapPoint(30.0, 1.0)), Goal(30.0, 1.0, 35.0, 0.7)),
        (PathPlan(MapPoint(30.0, 1.0), 40.0, 0.5), Goal(30.0, 1.0, 40.0, 0.5)),
        (PathPlan(MapPoint(30.0, 1.0), 14.0, 0.5), Goal(30.0, 1.0, 15.0, 0.5)),
        (PathPlan(MapPoint(30.0, 1.0), float("inf")), None),
        (PathPlan(MapPoint(float("nan"), 1.0)), None),
        (PathPlan(MapPoint(30.0, 1.0), 40.0, float("inf")), None),
    ],
)
def test_explore_goes_to_a_whole_plan_alone_between_min_and_max(plan: PathPlan, goal: Goal | None) -> None:
    facts = flying(0.05)
    here = pose(0.05)
    assert here.map is not None
    here = replace(here, map=replace(here.map, yaw=0.7))
    facts = replace(facts, position=replace(facts.position, pose=here), sight=replace(facts.sight, plan=plan))
    state = made(ToExplore())
    assert len(targets(state.process(facts))) == (goal is not None)
    assert state.goal == goal


@pytest.mark.parametrize(
    ("speed", "told"), [(None, 0), (-0.5, 0), (0.0, 0), (0.5, 1), (3.99, 1), (4.0, 0), (float("nan"), 0)]
)
def test_a_plan_that_makes_the_drone_slower_is_reported_once(speed: float | None, told: int) -> None:
    state, facts = made(ToExplore()), flying(0.05)
    plan = PathPlan(MapPoint(30.0, 0.0), speed=speed)
    for _ in range(3):
        texts_of_tick = texts(state.process(replace(facts, sight=replace(facts.sight, plan=plan))))
        assert sum("Slower" in text for text in texts_of_tick) == told
        told = 0


def test_the_next_place_is_reported_from_eight_metres_and_five_seconds_on() -> None:
    state = made(ToExplore())
    assert texts(state.process(planned(flying(0.0), 30.0))) == ["Next: to the north, 30 m away."]
    assert texts(state.process(planned(flying(4.99), 38.0))) == []
    assert texts(state.process(planned(flying(5.0), 37.99))) == []
    assert texts(state.process(planned(flying(5.0), 38.0))) == ["Next: to the north, 38 m away."]
    assert texts(state.process(planned(flying(10.0), 8.0))) == ["Next: to the north, 8 m away."]


@pytest.mark.parametrize(("north", "east", "words"), [(40.0, 0.0, "south, 10 m"), (30.0, 20.0, "west, 20 m")])
def test_the_next_place_is_told_as_seen_from_the_drone(north: float, east: float, words: str) -> None:
    assert texts(made(ToExplore()).process(at(planned(flying(0.05)), north, east))) == [f"Next: to the {words} away."]
