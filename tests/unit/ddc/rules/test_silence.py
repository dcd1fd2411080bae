"""An autopilot that is not heard in the air: Return To Launch is sent, and our heartbeats are held back."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.comm.protocol.commands import (
    Ack,
    Arm,
    AutonomousExplore,
    Hold,
    Kill,
    KillRequest,
    KillToken,
    Land,
    ReturnToLaunch,
)
from hawk.ddc.acts import STAY, Acts, Ask, SendMode, SetVoice
from hawk.ddc.facts import Facts
from hawk.ddc.orders import ToReturn
from hawk.ddc.readings.link import LinkFacts
from hawk.ddc.rules.silence import SENDINGS, SILENCE_S, SilenceRule
from hawk.ddc.states.base import State
from hawk.ddc.states.ground import ArmState
from hawk.ddc.states.hover import HoverState, ManualState
from hawk.ddc.states.rtl_and_land import LandState, ReturnToLaunchState
from hawk.model.operation import StateName
from hawk.model.vehicle import CopterMode, LandedState
from tests.unit.ddc.fakes import Rig
from tests.unit.ddc.written_facts import SETTINGS
from tests.unit.ddc.written_facts import flying as flying_facts

UNHEARD = "Sent without an answer: no word from the autopilot."


def returning(by_autopilot: bool = False) -> ReturnToLaunchState:
    return ReturnToLaunchState(0.0, SETTINGS, None, by_autopilot, "")


async def lose_downlink(rig: Rig, seconds: float = SILENCE_S + 0.2) -> None:
    """Hear nothing any more; what is sent still arrives. The rig's link counts as lost at once."""
    rig.autopilot.connected = False
    await rig.run(seconds)


def unheard(now: float, age: float) -> Facts:
    return replace(flying_facts(now), link=LinkFacts(is_up=False, age=age))


def reported(acts: Acts) -> list[CopterMode]:
    return [act.request.mode for act in acts if isinstance(act, Ask) and isinstance(act.request, SendMode)]


# -- by itself --------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.fault(
    "downlink dead, uplink alive, in the air",
    "Return To Launch is sent without an answer after 3 s (real ArduCopter: RTL 2.9 s after the cut), 6 "
    "times, 0.5 s apart",
)
async def test_after_three_seconds_it_is_commanded_to_return_and_our_heartbeats_end(flying: Rig) -> None:
    await lose_downlink(flying, SILENCE_S - 0.2)
    assert flying.autopilot.count("send_mode") == 0
    await flying.run(0.4)
    flying.expect(StateName.RETURN_TO_LAUNCH)
    assert flying.autopilot.asked("send_mode") == [CopterMode.RTL]
    assert flying.autopilot.asked("set_voice") == [False]
    assert flying.autopilot.mode == CopterMode.RTL
    assert "no word from the autopilot" in flying.detail
    await flying.run(10.0)
    assert flying.autopilot.asked("send_mode") == [CopterMode.RTL] * SENDINGS
    assert flying.autopilot.asked("set_voice") == [False]


async def test_a_return_begun_before_the_silence_is_reported_again(flying: Rig) -> None:
    flying.order(ReturnToLaunch())
    await flying.tick()
    await lose_downlink(flying)
    assert flying.autopilot.asked("send_mode")[0] == CopterMode.RTL
    flying.expect(StateName.RETURN_TO_LAUNCH)


async def test_a_landing_stays_a_landing(flying: Rig) -> None:
    flying.order(Land())
    await flying.tick()
    await lose_downlink(flying)
    assert set(flying.autopilot.asked("send_mode")) == {CopterMode.LAND}
    flying.expect(StateName.LAND)


@pytest.mark.fault("downlink dead while a pilot flies", "nothing is sent; our heartbeats are held back")
async def test_while_a_pilot_flies_nothing_is_reported(flying: Rig) -> None:
    flying.autopilot.change_mode(CopterMode.LOITER)
    await flying.tick(2)
    flying.expect(StateName.MANUAL)
    await lose_downlink(flying, 10.0)
    assert flying.autopilot.count("send_mode") == 0
    flying.expect(StateName.MANUAL)


async def test_what_the_autopilot_began_itself_is_left_to_it(flying: Rig) -> None:
    flying.autopilot.change_mode(CopterMode.LAND)
    await flying.tick(2)
    flying.expect(StateName.LAND)
    await lose_downlink(flying, 10.0)
    assert flying.autopilot.count("send_mode") == 0


@pytest.mark.slow
@pytest.mark.fault("downlink dead in the climb, landed state late", "Return To Launch is sent after 3 s")
async def test_a_climb_whose_landed_state_is_late_counts_as_flight(rig: Rig) -> None:
    await rig.enter(StateName.TAKEOFF)
    state = rig.topics.vehicle.state.value
    assert state is not None
    rig.topics.vehicle.state.publish(replace(state, landed=LandedState.ON_GROUND))
    await lose_downlink(rig)
    assert CopterMode.RTL in rig.autopilot.asked("send_mode")


@pytest.mark.nightly
@pytest.mark.parametrize("state", [StateName.IDLE, StateName.ARM])
async def test_on_the_ground_nothing_is_reported_and_heartbeats_go_on(fresh: Rig, state: StateName) -> None:
    await fresh.enter(state)
    await lose_downlink(fresh, 10.0)
    assert fresh.autopilot.count("send_mode") == fresh.autopilot.count("set_voice") == 0


@pytest.mark.fault(
    "the link comes back",
    "heartbeats begin at the next tick, RTL is asked for with an answer, Hold is possible",
)
async def test_heard_again_it_speaks_again_returns_and_can_be_held(flying: Rig) -> None:
    flying.autopilot.uplink = False
    await lose_downlink(flying)
    assert flying.autopilot.mode == CopterMode.GUIDED
    flying.autopilot.connected = True
    await flying.run(0.5)
    assert flying.autopilot.asked("set_voice") == [False, True]
    flying.expect(StateName.RETURN_TO_LAUNCH)
    assert flying.autopilot.mode == CopterMode.RTL, "asked for again, with an answer"
    flying.order(Hold())
    await flying.tick(2)
    flying.expect(StateName.HOVER)
    await lose_downlink(flying)
    assert flying.autopilot.asked("set_voice") == [False, True, False], "the next silence is one again"


@pytest.mark.fault("a gap of 2 s in the downlink", "nothing changes")
async def test_a_short_gap_changes_nothing(flying: Rig) -> None:
    await lose_downlink(flying, 2.0)
    flying.autopilot.connected = True
    await flying.run(1.0)
    assert flying.autopilot.count("send_mode") == flying.autopilot.count("set_voice") == 0
    flying.expect(StateName.HOVER)


@pytest.mark.parametrize(
    ("state", "mode"),
    [
        (returning(), CopterMode.RTL),
        (LandState(0.0, None, False), CopterMode.LAND),
        (returning(by_autopilot=True), None),
        (ManualState(0.0), None),
    ],
    ids=["return", "landing", "the autopilot's own", "pilot"],
)
def test_what_is_sent_is_the_states_mode_a_few_times(state: State, mode: CopterMode | None) -> None:
    rule, modes, voices = SilenceRule(), [], []
    for tick in range(200):
        step = rule.tick(unheard(tick * 0.05, SILENCE_S + tick * 0.05), state)
        assert step.transition is None
        modes += reported(step.acts)
        voices += [act.speaks for act in step.acts if isinstance(act, SetVoice)]
    assert modes == ([] if mode is None else [mode] * SENDINGS)
    assert voices == [False]


@pytest.mark.parametrize("state", [ArmState(0.0, SETTINGS, True, "", 0), returning()], ids=["ground", "air"])
@pytest.mark.parametrize("armed", [True, False])
def test_a_drone_that_stands_or_was_disarmed_is_sent_nothing_however_long_it_is_silent(
    state: State, armed: bool
) -> None:
    facts = unheard(99.0, 99.0)
    step = SilenceRule().tick(replace(facts, vehicle=replace(facts.vehicle, armed=armed)), state)
    assert (step == STAY) is (state.on_ground or not armed)


@pytest.mark.parametrize(("age", "voices"), [(2.99, []), (3.0, [False])])
def test_our_heartbeats_are_held_back_after_three_seconds(age: float, voices: list[bool]) -> None:
    step = SilenceRule().tick(unheard(9.0, age), returning())
    assert [act.speaks for act in step.acts if isinstance(act, SetVoice)] == voices
    assert reported(step.acts) == [CopterMode.RTL], "the state's mode is reported from the beginning"


@pytest.mark.parametrize(("age", "returns"), [(2.99, False), (3.0, True)])
def test_a_task_becomes_a_return_after_three_seconds(age: float, returns: bool) -> None:
    step = SilenceRule().tick(unheard(9.0, age), HoverState(0.0, SETTINGS))
    assert isinstance(step.transition, ToReturn) is returns
    assert reported(step.acts) == []


def test_a_mode_is_sent_six_times_half_a_second_apart_and_again_in_the_next_silence() -> None:
    rule, state, times = SilenceRule(), returning(), list[float]()

    def silence(begin: float) -> None:
        for tick in range(80):
            now = begin + tick * 0.125
            if reported(rule.tick(unheard(now, SILENCE_S + tick * 0.125), state).acts):
                times.append(now - begin)

    silence(10.0)
    assert times == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]
    heard = rule.tick(flying_facts(30.0), state)
    assert heard.acts == (SetVoice(True),)
    assert rule.tick(flying_facts(30.1), state) == STAY, "it is reported once that it speaks again"
    times.clear()
    silence(40.0)
    assert times == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]


def test_each_state_of_one_silence_sends_its_own_mode_at_once() -> None:
    rule = SilenceRule()
    assert reported(rule.tick(unheard(9.0, 4.0), returning()).acts) == [CopterMode.RTL]
    assert reported(rule.tick(unheard(9.1, 4.1), LandState(9.1, None, False)).acts) == [CopterMode.LAND]


# -- the operator's commands ------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.fault(
    "downlink dead, the operator gives Return To Launch or Land",
    "sent at once in every armed state, without an answer, 6 times; also 20 s after we fell silent (real "
    "ArduCopter: on the wire)",
)
@pytest.mark.parametrize("state", sorted(set(StateName) - {StateName.IDLE, StateName.CONFIGURE}))
@pytest.mark.parametrize(
    ("command", "mode", "leads_to"),
    [
        (ReturnToLaunch(confirmed=True), CopterMode.RTL, StateName.RETURN_TO_LAUNCH),
        (Land(confirmed=True), CopterMode.LAND, StateName.LAND),
    ],
    ids=["return", "land"],
)
async def test_return_and_land_are_sent_in_every_state_that_is_armed(
    fresh: Rig, state: StateName, command: ReturnToLaunch | Land, mode: CopterMode, leads_to: StateName
) -> None:
    await fresh.enter(state)
    await lose_downlink(fresh, 0.1)
    before = fresh.autopilot.count("send_mode")
    answer = fresh.command(command)
    assert answer.accepted
    assert answer.reason == UNHEARD
    await fresh.tick()
    fresh.expect(leads_to)
    await fresh.run(1.0)
    assert fresh.autopilot.asked("send_mode")[before:] == [mode] * 3
    assert fresh.autopilot.mode == mode


@pytest.mark.slow
@pytest.mark.fault("downlink dead, the operator gives Return To Launch or Land")
async def test_they_are_sent_after_we_fell_silent_too_and_as_often_as_they_are_given(flying: Rig) -> None:
    flying.autopilot.uplink = False
    await lose_downlink(flying, 20.0)
    for command, mode in ((Land(), CopterMode.LAND), (ReturnToLaunch(), CopterMode.RTL), (Land(), CopterMode.LAND)):
        before = flying.autopilot.count("send_mode")
        flying.order(command)
        await flying.tick()
        assert flying.autopilot.asked("send_mode")[before:] == [mode]
    assert flying.autopilot.asked("set_voice") == [False]


@pytest.mark.slow
async def test_disarmed_by_the_last_word_they_are_refused(rig: Rig) -> None:
    await lose_downlink(rig)
    assert not rig.command(ReturnToLaunch()).accepted
    assert not rig.command(Land()).accepted
    assert rig.autopilot.count("send_mode") == 0


async def test_what_must_be_answered_is_refused_still(flying: Rig) -> None:
    await lose_downlink(flying, 0.1)
    for command in (Hold(), AutonomousExplore(), Arm()):
        assert not flying.command(command).accepted


async def test_a_pilot_is_overruled_by_a_confirmed_command_only(fresh: Rig) -> None:
    await fresh.enter(StateName.MANUAL)
    await lose_downlink(fresh, 0.1)
    assert fresh.command(Land()).reason.startswith("Confirmed: ")
    assert fresh.autopilot.count("send_mode") == 0


async def test_someone_without_control_cannot_send_them(flying: Rig) -> None:
    await lose_downlink(flying, 0.1)
    assert flying.command(Land(), client="eve").reason == "Someone else has control."


@pytest.mark.slow
@pytest.mark.fault(
    "downlink dead, the operator gives Kill",
    'sent every 0.2 s for 5 s; an old "disarmed" confirms nothing',
)
async def test_a_kill_is_repeated_for_its_five_seconds(flying: Rig) -> None:
    await lose_downlink(flying, 0.1)
    token = flying.manager.handle_now("ana", KillRequest())
    assert isinstance(token, KillToken)
    flying.autopilot.silent.add("kill")
    answer = flying.manager.handle_now("ana", Kill(token=token.token))
    assert isinstance(answer, Ack)
    assert answer.accepted
    assert answer.reason == UNHEARD
    await flying.tick(120)
    assert flying.autopilot.count("kill") == pytest.approx(25, abs=1)
    assert flying.shown.operation.kill_state == "not confirmed"
