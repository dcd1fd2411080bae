"""A step that raises tick after tick: the drone comes home, and the watchdog hears of no progress."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from hawk.comm.protocol.commands import Arm, Kill, KillRequest, KillToken, Takeoff
from hawk.ddc import decider as decider_room
from hawk.ddc.decider import Decider
from hawk.ddc.keeper.fence import KeptFence
from hawk.ddc.parameters.reader import ParameterReader
from hawk.ddc.requests.service_interface import ReqFailed
from hawk.ddc.rules import guard
from hawk.ddc.rules.command_desk import RouteRequests
from hawk.ddc.rules.failed_ticks import AIR_S, ASK_AGAIN_S, GROUND_S, FailingTicks
from hawk.ddc.rules.follower import VehicleFollower
from hawk.ddc.rules.kill import KillSwitch
from hawk.ddc.states.hover import CommunicationLostState, HoverState
from hawk.model.operation import StateName
from hawk.model.vehicle import CopterMode
from tests.unit.ddc.fakes import TICK_S, Rig

S = StateName
Break = Callable[[Rig, pytest.MonkeyPatch], None]


def boom(*_: object, **__: object) -> None:
    raise RuntimeError("boom")


def the_guard(_: Rig, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(guard, "reaction", boom)


def the_state(_: Rig, patch: pytest.MonkeyPatch) -> None:
    for state in (HoverState, CommunicationLostState):
        patch.setattr(state, "process", boom)


def the_transition(_: Rig, patch: pytest.MonkeyPatch) -> None:
    for state in (HoverState, CommunicationLostState):
        patch.setattr(state, "transition_next_state", boom)


def the_guard_and_every_switch(rig: Rig, patch: pytest.MonkeyPatch) -> None:
    the_guard(rig, patch)
    patch.setattr(decider_room, "make_state", boom)


def the_follower(rig: Rig, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(VehicleFollower, "follow", boom)


def the_senses(rig: Rig, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(rig.topics, "get_part_healths", boom)


def the_decider(rig: Rig, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Decider, "tick", boom)


def the_targets(rig: Rig, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(rig.service, "send_target", boom)


def every_act(rig: Rig, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(rig.manager._performer, "_perform", boom)


VITAL: list[Break] = [
    the_guard,
    the_state,
    the_transition,
    the_guard_and_every_switch,
    the_follower,
    the_senses,
    the_decider,
    the_targets,
    every_act,
]


def modes(rig: Rig) -> list[CopterMode]:
    return rig.autopilot.asked("set_mode")


@pytest.mark.fault(
    "every act (target, request) raises in every tick in the air",
    "Return To Launch is asked for within 0.5 s, past the state machine; no failed tick is progress, so the "
    "watchdog ends the process within 1.2 s",
)
@pytest.mark.fault(
    "guard, state, transition, switch, follower or gathering raises in every tick in the air",
    "Return To Launch is asked for within 0.5 s, past the state machine; no failed tick is progress, so the "
    "watchdog ends the process within 1.2 s",
)
@pytest.mark.parametrize("breaks", VITAL, ids=lambda each: each.__name__)
async def test_in_the_air_it_is_sent_home_within_a_second_and_no_progress_is_reported(
    breaks: Break, flying: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    flying.autopilot.battery = 3.0
    flying.desk.client = None
    breaks(flying, monkeypatch)
    ticks = flying.manager.ticks
    await flying.run(1.0)
    assert CopterMode.RTL in modes(flying)
    assert flying.autopilot.mode == CopterMode.RTL
    assert flying.manager.ticks == ticks
    assert not flying.manager.own_health.is_healthy
    assert any("fault in the program" in text.lower() for text in flying.log)


async def test_no_tick_is_progress_from_the_first_that_fails(flying: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    the_guard(flying, monkeypatch)
    ticks = flying.manager.ticks
    await flying.tick(3)
    assert flying.manager.ticks == ticks
    assert modes(flying) == []


async def test_a_fault_that_passes_is_shown_and_forgiven(flying: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    ticks = flying.manager.ticks
    with monkeypatch.context() as broken:
        the_guard(flying, broken)
        await flying.tick(5)
    await flying.tick(20)
    assert flying.manager.ticks == ticks + 20
    assert modes(flying) == []
    flying.expect(S.HOVER)


@pytest.mark.fault("a step fails every second tick", "Return To Launch within 4 s")
async def test_a_step_that_fails_every_second_tick_is_a_fault_too(flying: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    real, calls = guard.reaction, iter(range(10_000))
    monkeypatch.setattr(guard, "reaction", lambda *given: boom() if next(calls) % 2 else real(*given))
    await flying.run(4.0)
    assert CopterMode.RTL in modes(flying)


@pytest.mark.slow
@pytest.mark.parametrize("breaks", VITAL, ids=lambda each: each.__name__)
@pytest.mark.parametrize("mode", [CopterMode.LOITER, CopterMode.STABILIZE, CopterMode.LAND, CopterMode.RTL])
async def test_a_pilot_and_the_autopilot_itself_are_left_alone(
    mode: CopterMode, breaks: Break, flying: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    breaks(flying, monkeypatch)
    flying.autopilot.change_mode(mode)
    await flying.run(1.0)
    assert modes(flying) == []


@pytest.mark.slow
@pytest.mark.fault(
    "a tick fails all the time on the ground",
    "Arm and Takeoff are refused; the fault is shown for 10 s, then the watchdog starts the program again",
)
@pytest.mark.parametrize("breaks", [the_guard, the_senses, the_decider], ids=lambda each: each.__name__)
async def test_on_the_ground_the_fault_can_be_read_before_the_restart(
    breaks: Break, rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    breaks(rig, monkeypatch)
    ticks = rig.manager.ticks
    await rig.tick(round((GROUND_S - 0.5) / TICK_S))
    reported = rig.manager.ticks
    assert reported >= ticks + (GROUND_S - 0.5) / TICK_S - 1
    await rig.tick(20)
    later = rig.manager.ticks
    await rig.tick(20)
    assert rig.manager.ticks == later
    assert modes(rig) == []


async def test_nobody_takes_off_with_a_program_that_fails(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as broken:
        the_guard(rig, broken)
        await rig.tick(2)
        for command in (Arm(), Takeoff()):
            answer = rig.command(command)
            assert not answer.accepted
            assert "Fault in the program" in answer.reason
    await rig.run(0.5)
    assert rig.command(Arm()).accepted


async def test_a_kill_is_not_followed_by_a_return(flying: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    token = flying.manager.handle_now("ana", KillRequest())
    assert isinstance(token, KillToken)
    flying.autopilot.silent.add("kill")
    flying.manager.handle_now("ana", Kill(token=token.token))
    monkeypatch.setattr(KillSwitch, "tick", boom)
    await flying.run(1.0)
    assert modes(flying) == []


@pytest.mark.slow
async def test_return_is_asked_for_again_until_it_shows(flying: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    the_guard_and_every_switch(flying, monkeypatch)
    flying.autopilot.refuse["set_mode"] = "EKF variance"
    await flying.run(AIR_S + 0.1)
    assert modes(flying) == [CopterMode.RTL]
    await flying.run(ASK_AGAIN_S)
    assert modes(flying) == [CopterMode.RTL, CopterMode.RTL]
    flying.autopilot.refuse.clear()
    await flying.run(ASK_AGAIN_S * 2)
    assert modes(flying) == [CopterMode.RTL] * 3


async def test_a_socket_that_fails_keeps_no_tick_from_deciding(flying: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flying.socket, "receive", boom)
    ticks = flying.manager.ticks
    flying.desk.client = None
    await flying.tick(20)
    assert flying.manager.ticks == ticks + 20
    flying.expect(S.COMMUNICATION_LOST)
    assert not flying.manager.own_health.is_healthy


@pytest.mark.fault("the recording raises at every record", "shown; every request and target is sent all the same")
async def test_a_recording_that_fails_keeps_no_request_from_being_sent(
    flying: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(flying, "record", boom)
    monkeypatch.setattr(flying.service, "_record_with", boom)
    await flying.service.set_mode(CopterMode.RTL)
    assert flying.autopilot.mode == CopterMode.RTL
    flying.autopilot.refuse["set_mode"] = "no"
    with pytest.raises(ReqFailed, match="no"):
        await flying.service.set_mode(CopterMode.LAND)


@pytest.mark.fault("a fault in notices, parameter reader, routes or follower", "the guard reacts in the same tick")
@pytest.mark.parametrize(
    ("place", "name"),
    [
        (guard, "notices"),
        (ParameterReader, "tick"),
        (RouteRequests, "tick"),
        (KeptFence, "tick"),
        (VehicleFollower, "follow_jump"),
        (VehicleFollower, "answer"),
    ],
)
async def test_a_fault_in_another_step_does_not_hide_the_guard(
    place: object, name: str, flying: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(place, name, boom)
    flying.desk.client = None
    await flying.tick(2)
    flying.expect(S.COMMUNICATION_LOST)


async def test_another_state_that_works_takes_over_from_one_that_does_not(
    flying: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(HoverState, "process", boom)
    flying.desk.client = None
    ticks = flying.manager.ticks
    await flying.run(1.0)
    flying.expect(S.COMMUNICATION_LOST)
    assert flying.manager.ticks > ticks + 15


async def test_a_switch_that_fails_in_a_task_does_not_hang(fresh: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    monkeypatch.setattr(type(fresh.manager.state), "process", boom)
    monkeypatch.setattr(decider_room, "make_state", boom)
    await fresh.run(1.0)
    assert fresh.autopilot.mode == CopterMode.RTL


async def test_started_in_the_air_without_any_facts_it_comes_home_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = Rig(tmp_path)
    rig.autopilot.put_in_air()
    the_senses(rig, monkeypatch)
    await rig.run(1.0)
    assert modes(rig) == [CopterMode.RTL]
    assert rig.manager.ticks == 0
    await rig.close()


# -- the sum alone -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [0.5, 1.0, 4.0])
def test_the_times_are_real_at_every_speed(speed: float) -> None:
    ticks = FailingTicks(speed)
    ticks.note(0.0, is_sound=True, is_airborne=True)
    seen = [ticks.note(n * 0.05 * speed, is_sound=False, is_airborne=True).goes_home for n in range(1, 30)]
    assert seen.index(True) == pytest.approx(AIR_S / 0.05, abs=1)
    assert seen.count(True) == 1


def test_after_it_was_given_up_progress_is_reported_only_when_sound_ticks_have_made_up_for_it() -> None:
    ticks = FailingTicks(1.0)
    for n in range(12):
        ticks.note(n * 0.05, is_sound=False, is_airborne=True)
    reported = [ticks.note(0.6 + n * 0.05, is_sound=True, is_airborne=True).is_progress for n in range(30)]
    assert reported.index(True) == pytest.approx(2 * 0.55 / 0.05, abs=2)
    assert all(reported[reported.index(True) :])


def test_a_pause_between_two_ticks_is_no_long_fault() -> None:
    ticks = FailingTicks(1.0)
    ticks.note(0.0, is_sound=True, is_airborne=True)
    assert not ticks.note(5.0, is_sound=False, is_airborne=True).goes_home


def failed(ticks: FailingTicks, *times: float, airborne: bool = True) -> list[bool]:
    """Note failed ticks; return for each whether the drone is sent home."""
    return [ticks.note(time, is_sound=False, is_airborne=airborne).goes_home for time in times]


def test_in_the_air_it_is_sent_home_at_half_a_second_of_failed_ticks() -> None:
    ticks = FailingTicks(1.0)
    assert failed(ticks, 0.0, 0.125, 0.25, 0.375, 0.499, 0.5) == [False] * 5 + [True]


def test_return_is_asked_for_again_after_two_seconds_and_at_their_end() -> None:
    ticks = FailingTicks(1.0)
    assert failed(ticks, 0.0, 0.25, 0.5, 0.75, 2.74, 2.75, 4.74, 4.75) == [False] * 3 + [True, False, True, False, True]
    fast = FailingTicks(4.0)
    assert failed(fast, 0.0, 1.0, 2.0, 3.0, 10.99, 11.0) == [False] * 3 + [True, False, True]


def test_on_the_ground_failed_ticks_are_progress_until_ten_seconds_and_nobody_is_sent_home() -> None:
    ticks = FailingTicks(1.0)
    reported = [ticks.note(n * 0.125, is_sound=False, is_airborne=False) for n in range(90)]
    assert [verdict.is_progress for verdict in reported] == [True] * 80 + [False] * 10
    assert not any(verdict.goes_home for verdict in reported)


def test_a_pause_counts_as_a_fifth_of_a_second() -> None:
    ticks = FailingTicks(1.0)
    assert failed(ticks, 0.0, 5.0, 10.0, 15.0) == [False, False, False, True]


def test_a_sound_tick_makes_up_for_half_a_failed_one() -> None:
    ticks = FailingTicks(1.0)
    failed(ticks, 0.0, 0.125)
    states = []
    for n in range(1, 4):
        ticks.note(0.125 + n * 0.125, is_sound=True, is_airborne=True)
        states.append(ticks.is_failing)
    assert states == [True, False, False]
    assert failed(ticks, 0.625, 0.75, 0.875) == [False] * 3, "sound ticks are not saved up, failed ones begin again"
    assert failed(ticks, 1.0) == [True]


def test_a_fault_on_the_ground_is_made_up_for_in_twenty_seconds_at_most() -> None:
    ticks = FailingTicks(1.0)
    failed(ticks, *(n * 0.125 for n in range(200)), airborne=False)
    reported = [ticks.note(25.0 + n * 0.125, is_sound=True, is_airborne=False).is_progress for n in range(170)]
    assert reported.index(True) == pytest.approx(159, abs=1)


def test_a_sum_that_is_not_failing_yet_has_failed_nothing() -> None:
    ticks = FailingTicks(1.0)
    assert not ticks.is_failing
    assert ticks.note(0.0, is_sound=False, is_airborne=True).is_progress is False
    assert ticks.note(0.05, is_sound=True, is_airborne=True).is_progress is True
