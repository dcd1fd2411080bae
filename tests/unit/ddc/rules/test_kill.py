from __future__ import annotations

from typing import Any

import pytest

from hawk.comm.protocol.commands import (
    Ack,
    Arm,
    ClearKill,
    Command,
    Hold,
    Kill,
    KillRequest,
    KillToken,
    Land,
    ReturnToLaunch,
)
from hawk.ddc.acts import Acts, Ask, CutMotors
from hawk.ddc.facts import Facts
from hawk.ddc.readings.link import LinkFacts
from hawk.ddc.rules import command_desk
from hawk.ddc.rules.kill import KillSwitch, KillTokens
from hawk.model.operation import StateName
from hawk.model.vehicle import CopterMode, VehicleState
from tests.manual_clock import ManualClock
from tests.unit.ddc.fakes import Rig


class Bench:
    """Tokens and switch on a clock that is moved by hand, and the times of the commands."""

    def __init__(self) -> None:
        self.clock = ManualClock(0.0)
        self.sent: list[float] = []
        self.tokens = KillTokens()
        self.switch = KillSwitch()

    def request(self, client: str) -> str:
        return self.tokens.issue(client, self.clock())

    def kill(self, client: str, token: str, armed: bool) -> str:
        """Confirm a Kill; return what is wrong with the token."""
        problem = self.tokens.redeem(client, token, self.clock())
        if not problem:
            self._note(self.switch.begin(self._facts(armed, self.clock(), connected=True), client))
        return problem

    def tick(self, armed: bool, heard: float, connected: bool) -> bool:
        """Run a tick; return whether the sending ended in it."""
        was_sending = self.switch.is_sending
        self._note(self.switch.tick(self._facts(armed, heard, connected)))
        return was_sending and not self.switch.is_sending

    def _note(self, acts: Acts) -> None:
        self.sent += [act.at for act in acts if isinstance(act, Ask) and act.request == CutMotors()]

    def _facts(self, armed: bool, heard: float, connected: bool) -> Facts:
        vehicle = VehicleState(connected=connected, armed=armed, time=heard)
        return Facts(self.clock(), vehicle=vehicle, link=LinkFacts(is_up=connected))


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_the_first_command_goes_out_in_the_call(bench: Bench) -> None:
    bench.kill("ana", bench.request("ana"), armed=True)
    assert bench.sent == [0.0]
    assert bench.switch.state == "sending"


def test_a_token_serves_once(bench: Bench) -> None:
    token = bench.request("ana")
    bench.kill("ana", token, armed=True)
    assert "used already" in bench.kill("ana", token, armed=True)


def test_a_token_of_another_client_an_older_one_and_a_made_up_one_are_refused(bench: Bench) -> None:
    older = bench.request("ana")
    assert "not valid" in bench.kill("eve", bench.request("ana"), armed=True)
    newer = bench.request("ana")
    assert "not valid" in bench.kill("ana", older, armed=True)
    assert "not valid" in bench.kill("ana", newer, armed=True)  # a wrong guess voids the token too
    assert "not valid" in bench.kill("ana", "x" * 32, armed=True)
    assert bench.sent == []
    assert not bench.switch.is_killed


def test_a_token_is_void_after_ten_seconds(bench: Bench) -> None:
    token = bench.request("ana")
    bench.clock.advance(10.1)
    assert "older than 10 s" in bench.kill("ana", token, armed=True)


def test_a_token_serves_for_ten_seconds(bench: Bench) -> None:
    token = bench.request("ana")
    bench.clock.advance(10.0)
    assert bench.kill("ana", token, armed=True) == ""


def test_tokens_cannot_be_guessed(bench: Bench) -> None:
    tokens = {bench.request("ana") for _ in range(100)}
    assert len(tokens) == 100
    assert min(map(len, tokens)) >= 32


def test_it_is_sent_every_200_ms_for_five_seconds_at_most(bench: Bench) -> None:
    bench.kill("ana", bench.request("ana"), armed=True)
    ended = False
    while not ended:
        bench.clock.advance(0.05)
        ended = bench.tick(armed=True, heard=bench.clock(), connected=True)
    assert bench.clock() == pytest.approx(5.0)
    assert len(bench.sent) == pytest.approx(25, abs=1)
    assert max(b - a for a, b in zip(bench.sent, bench.sent[1:], strict=False)) < 0.21
    assert bench.switch.state == "not confirmed"
    bench.clock.advance(1)
    assert not bench.tick(armed=True, heard=bench.clock(), connected=True)
    assert len(bench.sent) == pytest.approx(25, abs=1)


def test_it_ends_when_disarmed_is_seen(bench: Bench) -> None:
    bench.kill("ana", bench.request("ana"), armed=True)
    bench.clock.advance(0.05)
    assert bench.tick(armed=False, heard=bench.clock(), connected=True)
    assert bench.switch.state == "confirmed"
    assert len(bench.sent) == 1


def test_a_drone_that_did_not_seem_armed_is_not_taken_as_cut_before_armed_would_show(bench: Bench) -> None:
    bench.kill("ana", bench.request("ana"), armed=False)
    for _ in range(19):
        bench.clock.advance(0.05)
        assert not bench.tick(armed=False, heard=bench.clock(), connected=True)
    bench.clock.advance(0.2)
    assert not bench.tick(armed=False, heard=0.9, connected=True), "heard too early to show it"
    assert len(bench.sent) >= 5
    assert bench.tick(armed=False, heard=bench.clock(), connected=True)
    assert bench.switch.state == "confirmed"


def test_a_second_kill_takes_nothing_from_who_gave_the_first(bench: Bench) -> None:
    bench.kill("ana", bench.request("ana"), armed=True)
    bench.kill("eve", bench.request("eve"), armed=True)
    assert bench.switch.killer == "ana"


def test_a_disarmed_heard_a_second_after_the_beginning_confirms(bench: Bench) -> None:
    bench.clock.advance(7.0)
    bench.kill("ana", bench.request("ana"), armed=False)
    bench.clock.advance(1.0)
    assert not bench.tick(armed=False, heard=7.99, connected=True)
    assert bench.tick(armed=False, heard=8.0, connected=True)
    assert (bench.switch.state, bench.switch.is_killed) == ("confirmed", True)
    bench.switch.clear()
    assert (bench.switch.state, bench.switch.is_killed) == ("none", False)


def test_without_a_kill_nothing_is_sent(bench: Bench) -> None:
    assert not bench.tick(armed=True, heard=0.0, connected=True)
    assert bench.sent == []
    assert (bench.switch.state, bench.switch.is_killed, bench.switch.is_sending) == ("none", False, False)


def test_armed_that_shows_late_is_cut_too(bench: Bench) -> None:
    bench.kill("ana", bench.request("ana"), armed=False)
    bench.clock.advance(0.3)
    assert not bench.tick(armed=True, heard=0.3, connected=True)
    bench.clock.advance(0.3)
    assert bench.tick(armed=False, heard=0.6, connected=True)
    assert len(bench.sent) == 2
    assert bench.switch.state == "confirmed"


@pytest.mark.fault("downlink dead, the operator gives Kill")
def test_it_is_repeated_for_its_time_on_a_link_that_seems_dead(bench: Bench) -> None:
    bench.kill("ana", bench.request("ana"), armed=True)
    ended = False
    while not ended:
        bench.clock.advance(0.05)
        ended = bench.tick(armed=True, heard=0.0, connected=False)
    assert bench.clock() == pytest.approx(5.0)
    assert len(bench.sent) == pytest.approx(25, abs=1)
    assert bench.switch.state == "not confirmed"


def test_an_old_disarmed_of_a_lost_link_confirms_nothing(bench: Bench) -> None:
    bench.kill("ana", bench.request("ana"), armed=True)
    bench.clock.advance(2.0)
    assert not bench.tick(armed=False, heard=0.0, connected=False)
    assert bench.switch.state == "sending"


# -- in the operations manager ---------------------------------------------------------------------------------------


def token_of(rig: Rig, client: str = "ana") -> str:
    answer = rig.manager.handle_now(client, KillRequest())
    assert isinstance(answer, KillToken)
    return answer.token


async def test_it_cuts_confirms_and_locks_arm_until_it_is_cleared(flying: Rig) -> None:
    answer = flying.manager.handle_now("ana", Kill(token=token_of(flying)))
    assert isinstance(answer, Ack)
    assert answer.accepted
    assert flying.command(Arm()).reason == "The motors are being cut."
    await flying.tick(2)
    flying.expect(StateName.IDLE)
    assert flying.log[-2:] == ["Motors are being cut by Ana.", "Motors cut. Arm is locked until you clear it."]
    await flying.run(2.0)
    assert flying.autopilot.count("kill") == 1
    assert flying.manager.status.value is not None
    assert flying.manager.status.value.operation.killed
    assert flying.manager.status.value.operation.kill_state == "confirmed"
    assert flying.command(Arm()).reason == "The motors were cut: clear it first."
    flying.order(ClearKill())
    await flying.tick()
    flying.order(Arm())


async def test_nothing_else_is_sent_while_it_is_being_sent(flying: Rig) -> None:
    flying.autopilot.silent.add("kill")
    flying.manager.handle_now("ana", Kill(token=token_of(flying)))
    targets = len(flying.autopilot.targets)
    await flying.tick(90)
    assert flying.autopilot.count("kill") == pytest.approx(23, abs=1)
    assert len(flying.autopilot.targets) == targets
    assert flying.autopilot.count("set_mode") == 0


@pytest.mark.parametrize(
    ("command", "state", "mode"),
    [
        (Hold(), StateName.HOVER, None),
        (ReturnToLaunch(), StateName.RETURN_TO_LAUNCH, CopterMode.RTL),
        (Land(), StateName.LAND, CopterMode.LAND),
    ],
)
async def test_a_kill_that_the_wire_swallowed_is_replaced_by_what_who_has_control_wants_now(
    flying: Rig, command: Command, state: StateName, mode: CopterMode | None
) -> None:
    flying.autopilot.silent.add("kill")
    flying.manager.handle_now("ana", Kill(token=token_of(flying)))
    await flying.tick(4)
    refused = flying.manager.handle_now("eve", command)
    assert isinstance(refused, Ack)
    assert not refused.accepted, "who may not cut the motors undoes no cut"
    sent = flying.autopilot.count("kill")
    await flying.tick(8)
    assert flying.autopilot.count("kill") > sent
    accepted = flying.manager.handle_now("ana", command)
    assert isinstance(accepted, Ack)
    assert accepted.accepted
    flying.expect(state)
    assert f"{command.type} came first: the motors are cut no more." in flying.log
    sent = flying.autopilot.count("kill")
    await flying.tick(20)
    assert flying.autopilot.count("kill") == sent
    assert mode is None or flying.autopilot.mode == mode
    assert flying.manager.status.value is not None
    operation = flying.manager.status.value.operation
    assert (operation.kill_state, operation.killed) == ("none", True)


def shown_kill(rig: Rig) -> tuple[str, bool]:
    assert rig.manager.status.value is not None
    operation = rig.manager.status.value.operation
    return operation.kill_state, operation.killed


@pytest.mark.parametrize("command", [Hold(), ReturnToLaunch(), Land()])
async def test_a_kill_that_was_replaced_while_the_drone_fell_already_is_said_to_be_done(
    flying: Rig, command: Command
) -> None:
    flying.manager.handle_now("ana", Kill(token=token_of(flying)))
    await flying.autopilot.kill()  # its HEARTBEAT is yet to come
    flying.manager.handle_now("ana", command)
    await flying.run(1.0)
    flying.expect(StateName.IDLE)
    assert flying.log[-1] == "Motors cut. Arm is locked until you clear it."
    assert "Landed. Motors off." not in flying.log
    assert shown_kill(flying) == ("confirmed", True)
    assert flying.command(Arm()).reason == "The motors were cut: clear it first."


async def test_hold_is_refused_once_the_autopilot_says_that_the_motors_are_off(flying: Rig) -> None:
    flying.autopilot.silent.add("kill")
    flying.manager.handle_now("ana", Kill(token=token_of(flying)))
    flying.autopilot.armed, flying.autopilot.height = False, 20.0  # in the air, so that it is not believed yet
    await flying.tick(2)
    refused = flying.manager.handle_now("ana", Hold())
    assert isinstance(refused, Ack)
    assert (refused.accepted, refused.reason) == (False, "The motors are being cut.")
    sent = flying.autopilot.count("kill")
    await flying.tick(8)
    assert flying.autopilot.count("kill") > sent


@pytest.mark.parametrize("command", [Hold(), ReturnToLaunch(), Land()])
async def test_a_kill_goes_on_when_what_would_replace_it_fails(
    flying: Rig, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    flying.autopilot.silent.add("kill")
    flying.manager.handle_now("ana", Kill(token=token_of(flying)))
    await flying.tick(2)
    monkeypatch.setattr(flying.manager.state, "transition_next_state", _fail)
    refused = flying.manager.handle_now("ana", command)
    assert isinstance(refused, Ack)
    assert not refused.accepted
    sent = flying.autopilot.count("kill")
    await flying.tick(20)
    assert flying.autopilot.count("kill") >= sent + 4
    assert shown_kill(flying) == ("sending", True)
    assert not any("came first" in text for text in flying.log)


async def test_land_that_replaced_a_kill_ends_in_a_landing(flying: Rig) -> None:
    flying.autopilot.silent.add("kill")
    flying.manager.handle_now("ana", Kill(token=token_of(flying)))
    await flying.tick(2)
    flying.manager.handle_now("ana", Land())
    await flying.until(StateName.IDLE)
    assert flying.log[-1] == "Landed. Motors off."
    assert shown_kill(flying)[1], "Arm stays locked"


async def test_motors_that_stop_after_all_leave_arm_locked(flying: Rig) -> None:
    flying.autopilot.silent.add("kill")
    flying.manager.handle_now("ana", Kill(token=token_of(flying)))
    await flying.tick(4)
    flying.manager.handle_now("ana", Land())
    flying.autopilot.silent.clear()
    await flying.autopilot.kill()  # the cut that was under way
    await flying.run(2.0)
    flying.expect(StateName.IDLE)
    assert flying.command(Arm()).reason == "The motors were cut: clear it first."


@pytest.mark.slow
async def test_not_confirmed_it_takes_the_state_from_the_autopilot_and_wants_a_new_confirmation(flying: Rig) -> None:
    flying.autopilot.refuse["kill"] = "denied"
    flying.manager.handle_now("ana", Kill(token=token_of(flying)))
    await flying.run(5.5)
    sent = flying.autopilot.count("kill")
    flying.expect(StateName.HOVER)
    assert any("not confirmed" in text for text in flying.log)
    await flying.run(2.0)
    assert flying.autopilot.count("kill") == sent
    flying.manager.handle_now("ana", Kill(token=token_of(flying)))
    await flying.tick()
    assert flying.autopilot.count("kill") > sent


async def test_only_the_operator_in_control_gets_a_token_or_uses_one(flying: Rig) -> None:
    refused = flying.manager.handle_now("eve", KillRequest())
    assert isinstance(refused, Ack)
    assert not refused.accepted
    token = token_of(flying)
    flying.desk.client = "eve"
    for client in ("ana", "eve"):
        answer = flying.manager.handle_now(client, Kill(token=token))
        assert isinstance(answer, Ack)
        assert not answer.accepted
    await flying.tick()
    assert flying.autopilot.count("kill") == 0


@pytest.mark.fault(
    "the operator in control is lost, another client cuts the motors",
    "done, in the same two steps; refused when the operator came back in between",
)
async def test_anyone_cuts_the_motors_in_two_steps_when_the_one_in_control_is_lost(flying: Rig) -> None:
    flying.desk.present = False
    refused = flying.manager.handle_now("eve", Kill(token="g" * 32))
    assert isinstance(refused, Ack)
    assert "Kill Request" in refused.reason
    given = flying.manager.handle_now("eve", KillRequest())
    assert isinstance(given, KillToken)
    answer = flying.manager.handle_now("eve", Kill(token=given.token))
    assert isinstance(answer, Ack)
    assert answer.accepted
    await flying.tick(2)
    assert not flying.autopilot.armed


async def test_a_token_given_while_the_operator_was_lost_is_refused_when_it_is_back(flying: Rig) -> None:
    flying.desk.present = False
    given = flying.manager.handle_now("eve", KillRequest())
    assert isinstance(given, KillToken)
    flying.desk.present = True
    answer = flying.manager.handle_now("eve", Kill(token=given.token))
    assert isinstance(answer, Ack)
    assert answer.reason == "Someone else has control."


async def test_a_kill_outranks_what_the_pilot_flies(flying: Rig) -> None:
    flying.autopilot.change_mode(CopterMode.LOITER)
    await flying.tick()
    flying.expect(StateName.MANUAL)
    flying.manager.handle_now("ana", Kill(token=token_of(flying)))
    await flying.tick(2)
    assert not flying.autopilot.armed


async def test_a_token_is_never_recorded(flying: Rig) -> None:
    token = token_of(flying)
    flying.manager.handle_now("ana", Kill(token=token))
    assert token not in repr(flying.records)


async def test_a_kill_while_it_arms_is_sent_until_armed_would_have_shown(rig: Rig) -> None:
    rig.order(Arm())
    rig.manager.handle_now("ana", Kill(token=token_of(rig)))
    await rig.run(0.8)
    assert rig.autopilot.count("kill") >= 4
    assert "Motors cut. Arm is locked until you clear it." not in rig.log
    assert not rig.autopilot.armed
    await rig.run(0.5)
    assert "Motors cut. Arm is locked until you clear it." in rig.log
    rig.expect(StateName.IDLE)


async def test_a_fault_while_it_is_repeated_stops_neither_the_kill_nor_the_ticks(flying: Rig) -> None:
    flying.autopilot.silent.add("kill")
    flying.manager.handle_now("ana", Kill(token=token_of(flying)))
    kill, faults = flying.service.kill, iter([ValueError("broken")])

    def broken() -> Any:
        for fault in faults:
            raise fault
        return kill()

    flying.service.kill = broken  # type: ignore[method-assign]
    ticks = flying.manager.ticks
    await flying.tick(20)
    assert flying.manager.ticks - ticks == pytest.approx(20, abs=1)
    assert flying.autopilot.count("kill") >= 4
    assert "broken" in flying.manager.own_health.reason


async def test_a_fault_behind_hold_refuses_it_and_is_visible(flying: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command_desk, "refusal", _fail)
    answer = flying.manager.handle_now("ana", Hold())
    assert isinstance(answer, Ack)
    assert not answer.accepted
    assert "broken" in answer.reason
    assert "broken" in flying.manager.own_health.reason


def _fail(*_: object) -> None:
    raise ValueError("broken")
