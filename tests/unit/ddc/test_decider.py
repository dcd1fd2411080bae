"""Safety rules by facts alone: facts are written down, and the decision is looked at."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from hawk.comm.protocol.commands import (
    Ack,
    AutonomousExplore,
    CompulsiveMove,
    Hold,
    Kill,
    KillRequest,
    KillToken,
    ReturnToLaunch,
)
from hawk.ddc.acts import (
    Act,
    Ask,
    CutMotors,
    Desire,
    EnterState,
    ForgetAskedModes,
    ForgetHeldFence,
    Log,
    ReadParameter,
    SendMode,
    SendTarget,
    SetArmed,
    SetMode,
    SettleMode,
    TakeOff,
)
from hawk.ddc.battery.energy import Reserve
from hawk.ddc.decider import Decider
from hawk.ddc.facts import Facts
from hawk.ddc.orders import (
    Cause,
    CauseKind,
    MoveOrder,
    Rank,
    ToArm,
    ToCommunicationLost,
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
from hawk.ddc.readings.link import VehicleEvent
from hawk.ddc.readings.wind import Wind, WindFacts
from hawk.ddc.rules.command_desk import CommandDesk, LotCheck, RouteRequests
from hawk.ddc.rules.guard import reaction
from hawk.ddc.rules.kill import KillSwitch, KillTokens
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import State
from hawk.ddc.states.factory import make_state
from hawk.ddc.states.hover import HoverState
from hawk.model.operation import Health, StateName
from hawk.model.plans import DesiredPose, Route
from hawk.model.poses import MapPoint
from hawk.model.vehicle import CopterMode, LandedState
from tests.unit.ddc.written_facts import (
    SETTINGS,
    decider,
    flying,
    follow,
    found,
    of_kind,
    on_ground,
    pose,
    without_link,
)

S = StateName
ROUTE = Route((MapPoint(0.0, 0.0), MapPoint(40.0, 0.0)), (0.0, 0.0))
MOVE = MoveOrder(MapPoint(40.0, 0.0), 30.0, 0.0, False, 0)
LOT_MOVE = replace(MOVE, autonomous=True, number=3, route=ROUTE)
TRANSITIONS: dict[StateName, Transition] = {
    S.IDLE: ToIdle(),
    S.TAKEOFF: ToTakeoff(),
    S.HOVER: ToHover(),
    S.AUTONOMOUS_EXPLORE: ToExplore(),
    S.AUTONOMOUS_MOVE: ToMove(LOT_MOVE),
    S.COMPULSIVE_MOVE: ToMove(MOVE),
    S.RETURN_TO_LAUNCH: ToReturn(),
    S.LAND: ToLand(),
    S.COMMUNICATION_LOST: ToCommunicationLost(),
    S.MANUAL: ToManual(),
}
TASKS = (S.AUTONOMOUS_EXPLORE, S.AUTONOMOUS_MOVE, S.COMPULSIVE_MOVE)
GUARDED = (*TASKS, S.TAKEOFF, S.HOVER, S.COMMUNICATION_LOST)


def state(name: StateName, now: float = 0.0, settings: DdcSettings = SETTINGS) -> State:
    return make_state(TRANSITIONS[name], flying(now), settings)[0]


def flies(name: StateName) -> Decider:
    """A program that is in a state."""
    made = decider()
    made.tick(flying(0.0))
    follow(made, flying(0.0), TRANSITIONS[name])
    return made


# -- traits ------------------------------------------------------------------------------------------------------------


def names(trait: str) -> set[StateName]:
    return {name for name in TRANSITIONS if getattr(state(name), trait)}


def test_the_traits_of_the_states() -> None:
    assert names("on_ground") == {S.IDLE}
    assert names("is_task") == set(TASKS)
    assert names("sees") == {S.AUTONOMOUS_EXPLORE, S.AUTONOMOUS_MOVE}
    assert names("is_guarded") == set(GUARDED)
    assert names("stops_at_fence") == {*TASKS, S.TAKEOFF}
    assert names("needs_operator") == {*TASKS, S.HOVER}
    assert names("may_send_targets") == {*TASKS, S.HOVER, S.COMMUNICATION_LOST}
    assert names("holds") == {S.HOVER, S.COMMUNICATION_LOST}
    assert names("is_left_alone") == {S.RETURN_TO_LAUNCH, S.LAND, S.MANUAL}
    assert names("is_homing") == {S.RETURN_TO_LAUNCH, S.LAND}


# -- guard -------------------------------------------------------------------------------------------------------------


def reserve_reached(facts: Facts, seconds: float) -> Facts:
    battery = replace(facts.battery, reserve=Reserve(30.0, 31.0, 0.0), reached_s=seconds)
    return replace(facts, battery=battery)


def charge_unknown(facts: Facts, seconds: float) -> Facts:
    return replace(facts, battery=replace(facts.battery, info=None, unknown_s=seconds))


def strong_wind(facts: Facts, seconds: float) -> Facts:
    return replace(facts, wind=WindFacts(Wind(-11.0, 0.0), seconds))


def outside(facts: Facts, seconds: float) -> Facts:
    return replace(facts, limits=replace(facts.limits, breached_s=seconds))


def operator_lost(facts: Facts, _: float) -> Facts:
    return replace(facts, operator=replace(facts.operator, is_present=False))


def position_distrusted(facts: Facts, seconds: float) -> Facts:
    return replace(facts, position=replace(facts.position, distrusted_s=seconds))


def pose_old(facts: Facts, seconds: float) -> Facts:
    return replace(facts, position=replace(facts.position, age=seconds))


def vision_failed(facts: Facts, seconds: float) -> Facts:
    return replace(facts, sight=replace(facts.sight, fault="Vision: broken", fault_s=seconds))


@pytest.mark.parametrize(
    ("change", "limit", "states", "rank", "following"),
    [
        (reserve_reached, 3.0, GUARDED, Rank.RETURN_TO_LAUNCH, ToReturn),
        (charge_unknown, 30.0, GUARDED, Rank.RETURN_TO_LAUNCH, ToReturn),
        (outside, 10.0, GUARDED, Rank.RETURN_TO_LAUNCH, ToReturn),
        (strong_wind, 10.0, GUARDED, Rank.RETURN_TO_LAUNCH, ToReturn),
        (operator_lost, 0.0, (*TASKS, S.HOVER), Rank.COMMUNICATION_LOST, ToCommunicationLost),
        (outside, 0.0, (*TASKS, S.TAKEOFF), Rank.FENCE, ToHover),
        (position_distrusted, 2.0, TASKS, Rank.PERCEPTION, ToHover),
        (pose_old, 1.001, TASKS, Rank.PERCEPTION, ToHover),
        (vision_failed, 1.0, (S.AUTONOMOUS_EXPLORE, S.AUTONOMOUS_MOVE), Rank.PERCEPTION, ToHover),
    ],
)
def test_what_lasts_long_enough_makes_the_guard_react_in_its_states_only(
    change: Callable[[Facts, float], Facts],
    limit: float,
    states: tuple[StateName, ...],
    rank: Rank,
    following: type[Transition],
) -> None:
    for name in TRANSITIONS:
        found = reaction(change(flying(50.0), limit), state(name))
        if name in states:
            assert found is not None, name
            assert (found.rank, type(found.transition)) == (rank, following), name
        else:
            assert found is None or found.rank is not rank, name
        earlier = reaction(change(flying(50.0), limit - 0.01), state(name))
        assert limit == 0.0 or earlier is None or earlier.rank < rank, name


def test_all_well_nothing_reacts() -> None:
    assert all(reaction(flying(50.0), state(name)) is None for name in TRANSITIONS)


def test_the_higher_rank_is_answered_first() -> None:
    facts = vision_failed(operator_lost(reserve_reached(outside(flying(50.0), 0.0), 3.0), 0.0), 5.0)
    found = reaction(facts, state(S.AUTONOMOUS_EXPLORE))
    assert found is not None
    assert found.rank is Rank.RETURN_TO_LAUNCH


@pytest.mark.parametrize(
    ("kind", "change"),
    [
        (CauseKind.RESERVE, reserve_reached),
        (CauseKind.BATTERY_UNKNOWN, charge_unknown),
        (CauseKind.FENCE, outside),
        (CauseKind.WIND, strong_wind),
        (CauseKind.OPERATOR, operator_lost),
    ],
)
def test_a_cause_lasts_as_long_as_its_condition(kind: CauseKind, change: Callable[[Facts, float], Facts]) -> None:
    cause = Cause("because", kind)
    assert cause.lasts(change(flying(1.0), 0.0))
    assert not cause.lasts(flying(1.0))
    assert Cause("", CauseKind.ALWAYS).lasts(flying(1.0))
    assert not Cause("", CauseKind.NEVER).lasts(change(flying(1.0), 0.0))


# -- without a link ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [name for name in TRANSITIONS if name is not S.IDLE])
@pytest.mark.slow
def test_without_a_link_in_the_air_only_modes_are_sent_and_no_state_goes_on(name: StateName) -> None:
    program = flies(name)
    for tick in range(1, 800):
        acts = program.tick(_briefly_unheard(flying(0.05 * tick))).acts
        assert of_kind(acts, SendTarget, EnterState, Desire) == []
        assert all(isinstance(request, SendMode) for request in asked(acts))
    assert program.state.identity is name


@pytest.mark.parametrize("name", sorted(set(TRANSITIONS) - {S.IDLE}))
def test_after_the_limit_without_a_link_every_state_but_the_pilots_and_a_landing_returns(name: StateName) -> None:
    program = flies(name)
    for tick in range(1, 100):
        acts = program.tick(without_link(flying(0.05 * tick))).acts
        assert of_kind(acts, SendTarget, Desire) == []
        assert all(isinstance(request, SendMode) for request in asked(acts))
    assert program.state.identity is (name if name in (S.LAND, S.MANUAL) else S.RETURN_TO_LAUNCH)


def test_with_the_link_back_a_hold_that_ran_out_returns_home() -> None:
    program = flies(S.COMMUNICATION_LOST)
    lost = operator_lost(flying(SETTINGS.operator.operator_hold_s + 1.0), 0.0)
    states = []
    for facts in (_briefly_unheard(lost), replace(lost, now=lost.now + 0.05)):
        program.tick(facts)
        states.append(program.state.identity)
    assert states == [S.COMMUNICATION_LOST, S.RETURN_TO_LAUNCH]


def _briefly_unheard(facts: Facts) -> Facts:
    return replace(facts, link=replace(facts.link, is_up=False, age=2.7))


def test_without_a_link_a_command_that_needs_it_is_refused() -> None:
    program = flies(S.AUTONOMOUS_EXPLORE)
    for command in (Hold(), CompulsiveMove(x=1, y=1)):
        decision = program.command(without_link(flying(1.0)), "ana", command)
        assert isinstance(decision.answer, Ack)
        assert not decision.answer.accepted
        assert of_kind(decision.acts, Ask, EnterState) == []


# -- switching ---------------------------------------------------------------------------------------------------------


def test_a_fault_in_a_task_switches_to_hover_with_leave_enter_and_record(monkeypatch: pytest.MonkeyPatch) -> None:
    program = flies(S.AUTONOMOUS_MOVE)
    facts = flying(0.5)
    facts = replace(facts, sight=replace(facts.sight, desired=DesiredPose(3, 40.0, 0.0)))
    monkeypatch.setattr(type(program.state), "process", _broken)
    decision = program.tick(facts)
    assert program.state.identity is S.HOVER
    assert Desire(None) in decision.acts, "a place stays desired that nobody flies to"
    assert EnterState(S.HOVER, may_send_targets=True, holds=True) in decision.acts
    assert "boom" in decision.fault


def test_a_fault_in_leave_does_not_keep_the_next_state_from_beginning(monkeypatch: pytest.MonkeyPatch) -> None:
    program = flies(S.AUTONOMOUS_MOVE)
    monkeypatch.setattr(type(program.state), "leave", _broken)
    decision = program.command(flying(0.5), "ana", ReturnToLaunch())
    assert program.state.identity is S.RETURN_TO_LAUNCH
    assert "boom" in decision.fault
    assert asked(program.tick(flying(0.6)).acts) == [SetMode(CopterMode.RTL)]


def test_a_fault_in_one_step_does_not_keep_the_state_from_acting(monkeypatch: pytest.MonkeyPatch) -> None:
    program = flies(S.HOVER)
    monkeypatch.setattr(RouteRequests, "tick", _broken)
    decision = program.tick(flying(0.5))
    assert of_kind(decision.acts, SendTarget)
    assert "boom" in decision.fault


def test_a_pilot_takes_over_and_nothing_is_commanded_any_more() -> None:
    program = flies(S.AUTONOMOUS_EXPLORE)
    taken = flying(1.0, CopterMode.LOITER)
    decision = program.tick(replace(taken, link=replace(taken.link, events=(VehicleEvent.FOREIGN_MODE,))))
    assert program.state.identity is S.MANUAL
    assert ForgetAskedModes() in decision.acts
    assert asked(program.tick(flying(1.05, CopterMode.LOITER)).acts) == []


def test_a_change_to_another_state_keeps_the_modes_that_were_asked_for_in_mind_and_one_to_a_pilot_forgets_them() -> (
    None
):
    program = flies(S.AUTONOMOUS_EXPLORE)
    returns = follow(program, flying(1.0), ToReturn())
    assert ForgetAskedModes() not in returns.acts, "its own RTL would count as somebody else's"
    assert ForgetAskedModes() in follow(program, flying(1.1, CopterMode.LOITER), ToManual()).acts


def test_a_pilot_who_takes_over_in_the_tick_in_which_a_return_is_due_is_left_alone() -> None:
    program = flies(S.AUTONOMOUS_EXPLORE)
    facts = reserve_reached(flying(1.0, CopterMode.LOITER), 3.0)
    link = replace(facts.link, new_mode=CopterMode.LOITER, events=(VehicleEvent.FOREIGN_MODE,))
    decision = program.tick(replace(facts, link=link))
    assert decision.acts[0] == SettleMode(CopterMode.LOITER)
    assert ForgetAskedModes() in decision.acts
    assert asked(decision.acts) == []
    assert program.state.identity is S.MANUAL


def test_what_is_forgotten_comes_before_all_other_acts_of_a_tick() -> None:
    """A mode that is asked for in the tick in which another one shows stays ours."""
    program = flies(S.AUTONOMOUS_EXPLORE)
    facts = reserve_reached(flying(1.0), 3.0)
    link = replace(facts.link, new_mode=CopterMode.GUIDED, events=(VehicleEvent.LINK_LOST, VehicleEvent.LINK_BACK))
    acts = program.tick(replace(facts, link=link)).acts
    assert acts[:2] == (SettleMode(CopterMode.GUIDED), ForgetHeldFence())
    assert SetMode(CopterMode.RTL) in asked(acts + program.tick(flying(1.05)).acts)


def test_a_tick_is_unsound_when_what_is_forgotten_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    program = flies(S.HOVER)
    monkeypatch.setattr("hawk.ddc.decider.forgotten", _broken)
    decision = program.tick(flying(0.5))
    assert not decision.is_sound
    assert of_kind(decision.acts, SendTarget)


def test_an_arming_that_was_asked_for_is_not_given_up_by_one_of_before() -> None:
    armed = flying(2.0)
    armed = replace(armed, vehicle=replace(armed.vehicle, landed=LandedState.ON_GROUND))
    for begins, given_up in ((True, False), (False, True)):
        program = decider()
        follow(program, on_ground(flying(1.0)), ToIdle("Arming took too long.", gave_up_arming=True))
        if begins:
            follow(program, on_ground(flying(1.1)), ToArm())
        follow(program, on_ground(flying(1.2)), ToIdle())
        assert (SetArmed(False) in asked(program.tick(armed).acts)) is given_up


def test_only_an_arming_that_was_given_up_is_answered_by_a_disarm() -> None:
    program = decider()
    follow(program, on_ground(flying(1.0)), ToIdle("The heights were not saved."))
    armed = flying(2.0)
    armed = replace(armed, vehicle=replace(armed.vehicle, landed=LandedState.ON_GROUND))
    assert SetArmed(False) not in asked(program.tick(armed).acts)
    assert program.state.identity is S.ARM


def test_an_armed_that_comes_after_it_was_given_up_is_answered_by_a_disarm() -> None:
    program = decider()
    follow(program, on_ground(flying(1.0)), ToIdle("Arming took too long.", gave_up_arming=True))
    armed = flying(2.0)
    armed = replace(armed, vehicle=replace(armed.vehicle, landed=LandedState.ON_GROUND))
    assert SetArmed(False) in asked(program.tick(armed).acts)
    assert program.state.identity is S.IDLE


def test_the_end_of_the_program_returns_a_flying_drone_home_and_leaves_others_alone() -> None:
    cause = Cause("The program ends.", CauseKind.ALWAYS)
    assert flies(S.HOVER).leave_air(flying(1.0), cause) is not None
    for name in (S.MANUAL, S.LAND, S.RETURN_TO_LAUNCH):
        assert flies(name).leave_air(flying(1.0), cause) is None
    assert flies(S.HOVER).leave_air(without_link(flying(1.0)), cause) is None
    assert decider().leave_air(on_ground(flying(1.0)), cause) is None


def test_take_off_is_asked_for_once_and_its_refusal_ends_it() -> None:
    program = decider()
    waiting = flying(1.0)
    waiting = replace(waiting, vehicle=replace(waiting.vehicle, landed=LandedState.ON_GROUND))
    assert asked(follow(program, waiting, ToTakeoff()).acts) == [TakeOff(35.0)]
    assert asked(program.tick(replace(waiting, now=2.0)).acts) == []
    assert program.state.identity is S.ARM, "a request that nobody knows any more has failed"


# -- facts -------------------------------------------------------------------------------------------------------------


def test_an_unknown_landed_state_is_in_the_air() -> None:
    facts = flying(1.0)
    unknown = replace(facts, vehicle=replace(facts.vehicle, landed=LandedState.UNDEFINED))
    assert unknown.is_airborne
    assert not unknown.is_on_ground


def test_a_pose_that_is_old_or_not_finite_is_no_pose() -> None:
    facts = flying(1.0)
    assert facts.pose is not None
    assert pose_old(facts, 0.51).pose is None
    assert facts.position.pose is not None
    assert facts.position.pose.map is not None
    broken = replace(facts.position.pose, map=replace(facts.position.pose.map, yaw=float("nan")))
    assert replace(facts, position=replace(facts.position, pose=broken)).pose is None


def test_the_health_of_an_unknown_part_is_bad() -> None:
    assert flying(1.0).health("camera") == Health()
    assert not flying(1.0).health("propeller").is_healthy


@pytest.mark.parametrize("name", [S.RETURN_TO_LAUNCH, S.LAND])
def test_explore_is_refused_while_it_comes_down(name: StateName) -> None:
    decision = flies(name).command(flying(1.0), "ana", AutonomousExplore())
    assert isinstance(decision.answer, Ack)
    assert not decision.answer.accepted
    assert decision.answer.reason


def test_nothing_of_kill_goes_out_without_a_token() -> None:
    decision = flies(S.HOVER).command(flying(1.0), "ana", Kill(token="x" * 32))
    assert CutMotors() not in asked(decision.acts)
    assert isinstance(decision.answer, Ack)
    assert "not valid" in decision.answer.reason


def asked(acts: tuple[Act, ...]) -> list[Any]:
    """Return the requests beside the reading of parameters."""
    return [act.request for act in acts if isinstance(act, Ask) and not isinstance(act.request, ReadParameter)]


def test_a_breach_is_reported_once() -> None:
    program = flies(S.HOVER)
    texts = [log for tick in range(3) for log in of_kind(program.tick(outside(flying(tick / 20), tick / 20)).acts, Log)]
    assert [log.text for log in texts if isinstance(log, Log)] == ["Outside the fence: going back inside."]


def test_on_the_ground_without_a_fall_nothing_is_said_of_one() -> None:
    program = decider()
    for tick in range(3):
        acts = program.tick(on_ground(flying(1.0 + tick / 20))).acts
        assert of_kind(acts, EnterState) == []
        assert program.state.detail(on_ground(flying(1.0))) != "Motors off in the air."


def _broken(*_: object, **__: object) -> Any:
    raise RuntimeError("boom")


# -- sound ticks -------------------------------------------------------------------------------------------------------

VITAL = (
    "rules.follower.VehicleFollower.answer",
    "rules.follower.VehicleFollower.follow",
    "rules.follower.VehicleFollower.follow_jump",
    "rules.silence.SilenceRule.tick",
    "keeping.parameters.KeptParameters.tick",
    "keeping.fence.KeptFence.tick",
    "keeping.keeper.KeptHome.tick",
    "keeping.keeper.Keeper.kept",
    "rules.kill.KillSwitch.follow",
)
LESS_VITAL = (
    "rules.command_desk.RouteRequests.tick",
    "parameters.reader.ParameterReader.tick",
    "rules.notices.GroundNotices.tick",
    "rules.notices.WitnessNotices.tick",
    "rules.notices.SurveyNotices.tick",
)


@pytest.mark.parametrize(("where", "sound"), [*((w, False) for w in VITAL), *((w, True) for w in LESS_VITAL)])
def test_a_tick_is_unsound_when_a_step_fails_that_keeps_the_drone_safe(
    where: str, sound: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = flies(S.HOVER)
    monkeypatch.setattr(f"hawk.ddc.{where}", _broken)
    facts = flying(0.5)
    decision = program.tick(replace(facts, link=replace(facts.link, events=(VehicleEvent.FOREIGN_MODE,))))
    assert "boom" in decision.fault
    assert decision.is_sound is sound


@pytest.mark.parametrize("method", ["process", "transition_next_state"])
def test_a_tick_is_unsound_when_the_state_fails(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    program = flies(S.HOVER)
    monkeypatch.setattr(type(program.state), method, _broken)
    assert not program.tick(flying(0.5)).is_sound
    monkeypatch.undo()
    assert program.tick(flying(0.55)).is_sound, "the next tick is judged by itself"


@pytest.mark.parametrize(("function", "sound"), [("reaction", False), ("notices", True)])
def test_a_tick_is_unsound_when_the_guard_fails(function: str, sound: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    program = flies(S.HOVER)
    monkeypatch.setattr(f"hawk.ddc.rules.guard.{function}", _broken)
    decision = program.tick(flying(0.5))
    assert decision.is_sound is sound
    assert "boom" in decision.fault


def test_a_tick_is_unsound_when_kill_fails_while_it_cuts(monkeypatch: pytest.MonkeyPatch) -> None:
    program = flies(S.HOVER)
    token = program.command(flying(0.3), "ana", KillRequest()).answer
    assert isinstance(token, KillToken)
    program.command(flying(0.4), "ana", Kill(token=token.token))
    assert program.is_cutting
    monkeypatch.setattr(KillSwitch, "tick", _broken)
    assert not program.tick(flying(0.5)).is_sound


def test_a_decision_is_sound_before_the_first_tick_and_has_no_fault() -> None:
    decision = Decider(SETTINGS, KillTokens(), 0.0).command(flying(0.0), "ana", Hold())
    assert decision.is_sound
    assert decision.fault == ""


def test_a_tick_in_which_a_task_cannot_be_ended_after_a_fault_is_unsound(monkeypatch: pytest.MonkeyPatch) -> None:
    program = flies(S.AUTONOMOUS_EXPLORE)
    monkeypatch.setattr(RouteRequests, "tick", _broken)
    monkeypatch.setattr("hawk.ddc.decider.make_state", _broken)
    assert not program.tick(flying(0.5)).is_sound
    assert program.state.identity is S.AUTONOMOUS_EXPLORE


def test_a_command_that_fails_is_refused_with_the_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    program = flies(S.HOVER)
    monkeypatch.setattr(CommandDesk, "rule", _broken)
    decision = program.command(flying(0.5), "ana", ReturnToLaunch())
    assert isinstance(decision.answer, Ack)
    assert not decision.answer.accepted
    assert decision.answer.reason == "Fault in the program: RuntimeError: boom."
    assert program.state.identity is S.HOVER, "a state that is no task goes on"


def test_a_command_whose_order_the_state_fails_on_is_refused_with_the_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    program = flies(S.HOVER)
    monkeypatch.setattr(type(program.state), "transition_next_state", _broken)
    decision = program.command(flying(0.5), "ana", ReturnToLaunch())
    assert isinstance(decision.answer, Ack)
    assert not decision.answer.accepted
    assert "boom" in decision.answer.reason
    assert not decision.is_sound
    assert program.state.identity is S.HOVER


def test_a_state_that_fails_as_it_begins_stays_the_active_one(monkeypatch: pytest.MonkeyPatch) -> None:
    program = flies(S.AUTONOMOUS_EXPLORE)
    monkeypatch.setattr(HoverState, "enter", _broken)
    decision = program.command(flying(0.5), "ana", Hold())
    assert isinstance(decision.answer, Ack)
    assert not decision.answer.accepted
    assert not decision.is_sound
    assert program.state.identity is S.HOVER, "the drone is not led on by the state that was left"
    assert [act.name for act in of_kind(decision.acts, EnterState) if isinstance(act, EnterState)] == [S.HOVER]


def test_a_route_and_a_waiting_command_that_fail_leave_the_tick_sound(monkeypatch: pytest.MonkeyPatch) -> None:
    program = flies(S.HOVER)
    monkeypatch.setattr(LotCheck, "is_open", property(_broken))
    decision = program.tick(flying(0.5))
    assert decision.is_sound
    assert "boom" in decision.fault


@pytest.mark.parametrize(
    ("continues", "in_air", "reported"), [(True, True, True), (False, True, False), (True, False, False)]
)
def test_after_a_start_in_the_air_the_operator_hears_that_the_survey_goes_on(
    continues: bool, in_air: bool, reported: bool
) -> None:
    program = Decider(SETTINGS, KillTokens(), 0.0, continues_survey=continues)
    program.tick(found(flying(0.0) if in_air else on_ground(flying(0.0))))
    follow(program, flying(0.1), ToCommunicationLost())
    back = program.tick(flying(0.2))
    assert program.state.identity is S.HOVER
    texts = [act.text for act in back.acts if isinstance(act, Log)]
    assert ("Explore continues the survey." in texts) is reported
    again = [act.text for act in follow(program, flying(0.3), ToHover()).acts if isinstance(act, Log)]
    assert "Explore continues the survey." not in again


def test_a_hold_keeps_its_place_from_tick_to_tick_while_the_wind_moves_the_drone() -> None:
    held = Decider(SETTINGS, KillTokens(), 0.0)
    held.tick(found(flying(0.05)))
    held.command(flying(0.06), "ana", Hold())
    assert held.state.identity is StateName.HOVER
    goals = []
    for tick in range(2, 42):
        facts = flying(tick * 0.05)
        blown = replace(facts, position=replace(facts.position, pose=pose(facts.now, north=tick * 0.05)))
        goals += [act.goal for act in of_kind(held.tick(blown).acts, SendTarget) if isinstance(act, SendTarget)]
    assert len(goals) > 30
    assert {(goal.north, goal.east) for goal in goals[1:]} == {(goals[0].north, goals[0].east)}
