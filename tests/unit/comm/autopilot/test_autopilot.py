from __future__ import annotations

import asyncio
import math
import threading
import time
from collections.abc import AsyncIterator, Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import pytest

from hawk.comm.autopilot.autopilot import MavsdkAutopilot, expected_autopilot
from hawk.comm.autopilot.mavlink_link import FOREIGN_WRITE, Message, OnMessage
from hawk.comm.autopilot.vehicle import Autopilot, AutopilotError, Corners, FenceRings, OtherFenceError, VehicleTopics
from hawk.comm.clock import Clock
from hawk.comm.mavlink.peer import Expected
from hawk.comm.mavlink.udp_gate import NOBODY, Hearing
from hawk.config.sections import AutopilotSettings
from hawk.model.frames import offset_ned
from hawk.model.moment import this_moment
from hawk.model.plans import Fence
from hawk.model.poses import ArmPlace, GlobalPose
from hawk.model.vehicle import CopterMode, ForeignWrite
from hawk.runtime.supervision import Supervisor
from tests.manual_clock import ManualClock
from tests.unit.comm.fakes import ALTITUDE, LATITUDE, LONGITUDE, FakeLink, Memory, Said
from tests.unit.comm.waiting import until

FENCE = Fence(((0.0, 0.0),), ((-50.0, -50.0), (-50.0, 50.0), (50.0, 50.0), (50.0, -50.0)), 97.0, 100.0)
ZONED = replace(
    FENCE,
    autopilot_zones=(
        ((10.0, 10.0), (20.0, 10.0), (10.0, 20.0)),
        ((-20.0, -9.0), (-9.0, -9.0), (-9.0, 9.0), (-20.0, 9.0)),
    ),
)
PARAMETERS: dict[str, tuple[float, int]] = {
    "RTL_ALT": (1500, 4), "FENCE_ENABLE": (0, 2), "FENCE_ACTION": (0, 2), "FENCE_TYPE": (7, 2),
    "FENCE_ALT_MAX": (120.0, 9),
}  # fmt: skip


class FastClock(ManualClock):
    """A hand-moved clock of a simulation at speed 4."""

    def __init__(self, now: float) -> None:
        super().__init__(now)
        self.speed = 4.0


class Rig:
    """The real facade over a link without an autopilot."""

    def __init__(
        self, clock: ManualClock | None = None, supervisor: Supervisor | None = None, *, has_gimbal: bool = False
    ) -> None:
        self.clock = clock or ManualClock(50.0)
        self.topics = VehicleTopics.create(self.clock)
        self.said = Said()
        self.link: FakeLink = FakeLink("", 0, self.clock, lambda _: None)
        self.memory = Memory(PARAMETERS)
        settings = AutopilotSettings(url="udpin://127.0.0.1:14550", system_id=245, connect_timeout_s=0.01)
        self.autopilot = MavsdkAutopilot(
            settings, self.clock, self.topics, this_moment, self._make, 0.01, supervisor, has_gimbal=has_gimbal
        )

    def _make(self, url: str, system_id: int, clock: Clock, on_message: OnMessage, expected: Expected) -> FakeLink:
        self.link = FakeLink(url, system_id, clock, on_message, expected)
        self.link.answer = self._answer
        return self.link

    def _answer(self, name: str, fields: Mapping[str, Any]) -> None:
        answer = self.memory.answer(name, fields)
        if answer is not None:
            self.link.on_message(Message("PARAM_VALUE", answer, self.clock()))

    async def say(self, *messages: tuple[str, dict[str, Any]]) -> None:
        for message in messages:
            self.link.say(message)
        await asyncio.sleep(0)
        await asyncio.sleep(0)

    async def connect(self) -> None:
        await self.autopilot.start()
        await until(lambda: self.link.found)
        await self.say(self.said.heartbeat(), self.said.landed(1))

    async def stand(self, rounds: int) -> None:
        for _ in range(rounds):
            self.clock.advance(0.05)
            self.said.boot += 0.05
            await self.say(self.said.attitude(), self.said.local(2.0, 1.0, -0.5), self.said.world())

    async def boot(self) -> None:
        """Let the autopilot boot, and its new clock be believed."""
        self.said.boot = 1.0
        self.clock.advance(3.0)
        await self.say(self.said.heartbeat())
        await self.stand(12)

    async def arm_here(self) -> None:
        await self.say(self.said.heartbeat(armed=True))
        await self.stand(3)
        assert self.topics.arm_place.value is not None


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """The link is tended without the pauses, real seconds, that spare a real one."""
    for name in ("_WATCH_S", "_RETRY_S"):
        monkeypatch.setattr(f"hawk.comm.autopilot.autopilot.{name}", 0.005)


@pytest.fixture
async def rig() -> AsyncIterator[Rig]:
    rig = Rig()
    yield rig
    await rig.autopilot.close()


async def test_the_expected_autopilot_is_that_of_the_settings(rig: Rig) -> None:
    assert rig.link.expected == Expected(wait_s=1.5)
    named = {"vehicle_system_id": 3, "vehicle_address": "[fe80::1]:14555"}
    assert expected_autopilot(AutopilotSettings.model_validate(named)) == Expected(3, "fe80::1", 14555)
    assert expected_autopilot(AutopilotSettings(vehicle_address="10.0.0.7")) == Expected(None, "10.0.0.7", None, 1.5)
    rig.link.heard = Hearing("10.0.0.7:5", "10.0.0.8:6 (system 1) sends", 12)
    assert rig.autopilot.hearing == rig.link.heard


def test_it_is_what_the_rest_of_the_daemon_expects() -> None:
    rig = Rig()
    autopilot: Autopilot = rig.autopilot
    assert autopilot.topics is rig.topics
    assert (rig.link.url, rig.link.system_id) == ("udpin://127.0.0.1:14550", 245)


async def test_before_an_autopilot_is_found_it_is_not_connected(rig: Rig) -> None:
    await rig.autopilot.start()
    state = rig.topics.state.value
    assert state is not None
    assert (state.connected, state.armed, state.custom_mode) == (False, False, None)


async def test_an_absent_autopilot_is_waited_for_and_found(rig: Rig) -> None:
    rig.link.appears = False
    await rig.autopilot.start()
    await until(lambda: rig.link.opened >= 2)
    assert not rig.link.found
    rig.link.appears = True
    await until(lambda: rig.link.found)
    await rig.say(rig.said.heartbeat())
    assert rig.topics.state.value is not None
    assert rig.topics.state.value.connected


async def test_a_link_that_cannot_be_opened_says_why_and_is_tried_again(rig: Rig) -> None:
    rig.link.problems = ["autopilot.url 'serial://x' cannot be opened"] * 3
    await rig.autopilot.start()
    await until(lambda: bool(rig.autopilot.problem))
    assert "autopilot.url" in rig.autopilot.problem
    await until(lambda: rig.autopilot.problem == "")  # the loop hears of the open link a moment after the thread
    assert rig.link.found


@pytest.mark.parametrize(
    ("heard", "words"),
    [
        (NOBODY, "No autopilot is heard at autopilot.url 'udpin://127.0.0.1:14550': is it on and sending here?"),
        (
            Hearing(heard="antenna tracker (ArduPilot), system 2"),
            "No copter is heard at autopilot.url 'udpin://127.0.0.1:14550': is it on? "
            "Heard there: antenna tracker (ArduPilot), system 2",
        ),
        (
            Hearing(second_sender="10.0.0.6:5 (system 2) sends."),
            "No copter is heard at autopilot.url 'udpin://127.0.0.1:14550': is it on? "
            "Heard there: 10.0.0.6:5 (system 2) sends.",
        ),
    ],
)
async def test_who_is_heard_in_place_of_a_copter_is_named(rig: Rig, heard: Hearing, words: str) -> None:
    rig.link.appears, rig.link.heard = False, heard
    await rig.autopilot.start()
    await until(lambda: bool(rig.autopilot.problem))
    assert rig.autopilot.problem == words


async def test_the_link_looks_around_for_others_once_a_second(rig: Rig) -> None:
    await rig.connect()
    await until(lambda: rig.link.looked >= 1)
    assert rig.link.looked <= 2


@pytest.mark.parametrize("part", ["open", "find"])
async def test_an_error_that_nobody_expected_does_not_end_the_link(part: str) -> None:
    reported: list[tuple[str, str]] = []
    rig = Rig(supervisor=Supervisor(lambda name, words: reported.append((name, words)), 0.0))
    whole, faults = getattr(rig.link, part), [ValueError("broken")]

    def broken(*arguments: Any) -> Any:
        for fault in faults:
            faults.clear()
            raise fault
        return whole(*arguments)

    setattr(rig.link, part, broken)
    await rig.connect()
    assert reported == [("autopilot-link", "ValueError: broken")]
    assert rig.topics.state.value is not None
    assert rig.topics.state.value.connected
    await rig.autopilot.close()


async def test_after_the_configured_time_silence_is_reported(rig: Rig) -> None:
    rig.link.appears = False
    await rig.autopilot.start()
    await until(lambda: "No autopilot is heard" in rig.autopilot.problem)
    assert "udpin://127.0.0.1:14550" in rig.autopilot.problem
    rig.link.appears = True
    await until(lambda: rig.link.found and rig.autopilot.problem == "")


async def test_rates_are_asked_for_when_the_autopilot_is_found(rig: Rig) -> None:
    await rig.connect()
    await until(lambda: len(rig.link.named("COMMAND_LONG")) >= 6)
    asked = {(fields["command"], fields["param1"]) for fields in rig.link.named("COMMAND_LONG")}
    assert {(511, 30.0), (511, 32.0), (511, 33.0), (511, 1.0)} <= asked


@pytest.mark.parametrize("has_gimbal", [True, False])
async def test_the_gimbal_s_attitude_is_asked_for_where_the_camera_hangs_on_one(has_gimbal: bool) -> None:
    rig = Rig(has_gimbal=has_gimbal)
    try:
        await rig.connect()
        expected = 10 + has_gimbal  # all but EXTENDED_SYS_STATE, which came already
        await until(lambda: len(rig.link.named("COMMAND_LONG")) >= expected)
        asked = {fields["param1"] for fields in rig.link.named("COMMAND_LONG")}
        assert (285.0 in asked) is has_gimbal
    finally:
        await rig.autopilot.close()


async def test_rates_are_asked_for_again_after_a_boot(rig: Rig) -> None:
    await rig.connect()
    await rig.stand(1)
    await until(lambda: len(rig.link.named("COMMAND_LONG")) >= 4)
    rig.link.sent.clear()
    await rig.boot()
    await until(
        lambda: {fields["param1"] for fields in rig.link.named("COMMAND_LONG")} >= {1.0, 2.0, 24.0, 242.0, 245.0}
    )


async def test_a_fast_simulation_hears_more_heartbeats() -> None:
    rig = Rig(FastClock(50.0))
    await rig.connect()
    await until(lambda: len(rig.link.named("HEARTBEAT")) == 1)
    rig.clock.advance(1.0)
    await rig.say(rig.said.heartbeat())
    await until(lambda: len(rig.link.named("HEARTBEAT")) == 2)
    assert rig.link.named("HEARTBEAT")[0] == {
        "type": 6,
        "autopilot": 8,
        "base_mode": 0,
        "custom_mode": 0,
        "system_status": 4,
        "mavlink_version": 3,
    }, "an active ground station"
    await rig.autopilot.close()


async def test_at_speed_one_mavsdk_alone_sends_heartbeats(rig: Rig) -> None:
    await rig.connect()
    await until(lambda: len(rig.link.named("COMMAND_LONG")) >= 5)
    assert rig.link.named("HEARTBEAT") == []


async def test_five_seconds_of_silence_open_the_link_again(rig: Rig) -> None:
    await rig.connect()
    rig.clock.advance(6.0)
    await until(lambda: rig.link.reopened == 1)
    state = rig.topics.state.value
    await until(lambda: rig.topics.state.value is not None and not rig.topics.state.value.connected)
    assert state is not None
    await rig.say(rig.said.heartbeat())
    assert rig.topics.state.value is not None
    assert rig.topics.state.value.connected


class TestCommands:
    async def test_home_is_sent_as_whole_numbers_and_not_waited_for(self, rig: Rig) -> None:
        """A COMMAND_LONG carries degrees as a 32-bit float: half a metre."""
        await rig.connect()
        await rig.autopilot.set_home(GlobalPose(LATITUDE, LONGITUDE, 123.4))
        fields = next(fields for name, fields in rig.link.sent if name == "COMMAND_INT")
        assert (fields["command"], fields["frame"], fields["param1"]) == (179, 0, 0.0)
        assert (fields["x"], fields["y"], fields["z"]) == (round(LATITUDE * 1e7), round(LONGITUDE * 1e7), 123.4)

    async def test_a_home_that_is_not_finite_is_not_sent(self, rig: Rig) -> None:
        await rig.connect()
        with pytest.raises(AutopilotError, match="not finite"):
            await rig.autopilot.set_home(GlobalPose(LATITUDE, math.nan, 100.0))

    async def test_without_a_link_nothing_is_sent(self, rig: Rig) -> None:
        await rig.autopilot.start()
        calls: list[Callable[[], Any]] = [
            rig.autopilot.arm,
            rig.autopilot.disarm,
            lambda: rig.autopilot.set_mode(CopterMode.GUIDED),
            lambda: rig.autopilot.takeoff(20.0),
            lambda: rig.autopilot.set_rtl_altitude(20.0),
            lambda: rig.autopilot.get_parameter("RTL_ALT"),
            lambda: rig.autopilot.set_parameter("RTL_ALT", 1),
            lambda: rig.autopilot.upload_fence(FENCE),
            lambda: rig.autopilot.compare_fence(FENCE),
            lambda: rig.autopilot.set_home(GlobalPose(LATITUDE, LONGITUDE, ALTITUDE)),
        ]
        for call in calls:
            with pytest.raises(AutopilotError, match="No link to the autopilot"):
                await call()
        assert rig.link.commanded == []

    async def test_commands_reach_the_link(self, rig: Rig) -> None:
        await rig.connect()
        await rig.autopilot.set_mode(CopterMode.GUIDED)
        await rig.autopilot.arm()
        await rig.autopilot.takeoff(20.0)
        await rig.autopilot.disarm()
        assert [command for command, _ in rig.link.commanded] == [176, 400, 22, 400]

    async def test_a_refusal_carries_the_autopilots_own_words(self, rig: Rig) -> None:
        await rig.connect()
        rig.link.results[400] = 4
        rig.link.before_ack = lambda: rig.link.say(rig.said.text("Arm: BRAKE mode not armable"))
        with pytest.raises(AutopilotError, match=r"^Arm: BRAKE mode not armable$"):
            await rig.autopilot.arm()

    async def test_words_that_come_after_the_answer_are_waited_for(self, rig: Rig) -> None:
        await rig.connect()
        rig.link.results[400] = 4
        arming = asyncio.create_task(rig.autopilot.arm())
        await until(lambda: bool(rig.link.commanded))
        await asyncio.sleep(0.02)
        await rig.say(rig.said.text("PreArm: GPS 1: Bad fix"))
        with pytest.raises(AutopilotError, match="PreArm: GPS 1: Bad fix"):
            await arming

    @pytest.mark.slow
    async def test_without_words_the_result_is_reported(self, rig: Rig) -> None:
        await rig.connect()
        rig.link.results[176] = 4
        with pytest.raises(AutopilotError, match="Mode RTL refused: failed"):
            await rig.autopilot.set_mode(CopterMode.RTL)

    @pytest.mark.slow
    async def test_words_on_an_earlier_command_are_no_reason(self, rig: Rig) -> None:
        await rig.connect()
        await rig.say(rig.said.text("Arm: Throttle too high"))
        rig.clock.advance(0.1)
        rig.link.results[400] = 4
        with pytest.raises(AutopilotError, match="Arm refused: failed"):
            await rig.autopilot.arm()


class TestKill:
    async def test_it_is_sent_at_once_while_everything_else_hangs(self, rig: Rig) -> None:
        await rig.connect()
        await rig.arm_here()
        release = threading.Event()
        rig.link.before_ack = lambda: (release.wait(10), None)[1]
        hanging = [asyncio.create_task(rig.autopilot.disarm()) for _ in range(6)]
        loop = asyncio.get_running_loop()
        default = ThreadPoolExecutor(2)
        loop.set_default_executor(default)
        for _ in range(8):
            loop.run_in_executor(None, release.wait, 10)
        await until(lambda: len(rig.link.commanded) >= 2)
        for _ in range(20):
            await rig.autopilot.kill()
        assert not any(each.done() for each in hanging), "Kill waited for another command"
        release.set()
        await asyncio.gather(*hanging)
        default.shutdown()
        kills = [fields for fields in rig.link.named("COMMAND_LONG") if fields["command"] == 185]
        assert len(kills) == 20

    async def test_it_is_tried_on_a_link_that_seems_dead(self, rig: Rig) -> None:
        await rig.connect()
        rig.clock.advance(4.0)
        await until(lambda: rig.topics.state.value is not None and not rig.topics.state.value.connected)
        await rig.autopilot.kill()
        assert any(fields["command"] == 185 for fields in rig.link.named("COMMAND_LONG"))

    @pytest.mark.fault("a Kill hangs", "the next one, 0.2 s later, has a thread of its own and goes out")
    async def test_a_kill_that_hangs_stops_no_later_one(self, rig: Rig) -> None:
        rig.autopilot.calls.deadline_s = 0.01
        await rig.connect()
        release = threading.Event()
        send = rig.link.send
        rig.link.send = lambda name, fields: release.wait(30.0)  # type: ignore[assignment,method-assign]
        with pytest.raises(AutopilotError, match=r"kill: MAVSDK did not return within 0\.01 s"):
            await rig.autopilot.kill()
        rig.link.send = send  # type: ignore[method-assign]
        rig.autopilot.calls.deadline_s = 10.0
        await rig.autopilot.kill()
        assert any(fields["command"] == 185 for fields in rig.link.named("COMMAND_LONG"))
        release.set()

    async def test_a_refusal_is_shown(self, rig: Rig) -> None:
        await rig.connect()
        await rig.say(("COMMAND_ACK", {"command": 185, "result": 2}))
        text = rig.topics.status_text.value
        assert text is not None
        assert "Kill refused" in text.text
        await rig.say(("COMMAND_ACK", {"command": 185, "result": 0}), ("COMMAND_ACK", {"command": 400, "result": 4}))
        assert rig.topics.status_text.value is text


class TestSilence:
    async def test_a_mode_is_sent_on_a_link_that_seems_dead_and_no_answer_is_waited_for(self, rig: Rig) -> None:
        await rig.connect()
        rig.clock.advance(4.0)
        await until(lambda: rig.topics.state.value is not None and not rig.topics.state.value.connected)
        await rig.autopilot.send_mode(CopterMode.RTL)
        assert rig.link.commanded == []
        (sent,) = [fields for fields in rig.link.named("COMMAND_LONG") if fields["command"] == 176]
        assert (sent["param1"], sent["param2"]) == (1.0, 6.0)

    async def test_heartbeats_are_switched_on_the_link(self, rig: Rig) -> None:
        await rig.connect()
        rig.autopilot.set_voice(False)
        rig.autopilot.set_voice(True)
        assert rig.link.voices == [False, True]

    async def test_silent_a_fast_simulation_hears_no_heartbeat_of_ours(self) -> None:
        rig = Rig(FastClock(50.0))
        rig.autopilot.set_voice(False)
        await rig.connect()
        await until(lambda: len(rig.link.named("COMMAND_LONG")) >= 5)
        assert rig.link.named("HEARTBEAT") == []
        rig.autopilot.set_voice(True)
        await until(lambda: len(rig.link.named("HEARTBEAT")) == 1)
        await rig.autopilot.close()

    async def test_a_silent_peer_hears_of_us_by_a_request_for_a_rate(self, rig: Rig) -> None:
        await rig.connect()
        await until(lambda: len(rig.link.named("COMMAND_LONG")) >= 5)
        rig.autopilot.set_voice(False)
        rig.clock.advance(4.0)
        await until(lambda: rig.topics.state.value is not None and not rig.topics.state.value.connected)
        await until(lambda: bool(rig.link.named("COMMAND_LONG")))
        rig.link.sent.clear()
        rig.clock.advance(5.1)
        await until(lambda: [fields["command"] for fields in rig.link.named("COMMAND_LONG")] == [511])


class TestHanging:
    async def test_a_command_that_hangs_fails_in_time_and_the_next_one_is_sent(self, rig: Rig) -> None:
        rig.autopilot.calls.deadline_s = 0.01
        await rig.connect()
        release = threading.Event()
        rig.link.before_ack = lambda: (release.wait(30.0), None)[1]
        for _ in range(3):
            with pytest.raises(AutopilotError, match=r"set_mode: MAVSDK did not return within 0\.01 s"):
                await rig.autopilot.set_mode(CopterMode.RTL)
        assert rig.autopilot.calls.overdue == 3
        rig.autopilot.calls.deadline_s = 10.0
        rig.link.before_ack = lambda: None
        await rig.autopilot.set_mode(CopterMode.RTL)
        release.set()

    @pytest.mark.fault("a target hangs in MAVSDK", "after 3 s a new sender takes over, the hang is counted")
    async def test_a_target_that_hangs_is_counted_and_later_ones_go_out(self, rig: Rig) -> None:
        await rig.connect()
        await rig.arm_here()
        entered, release = threading.Event(), threading.Event()

        def hang(name: str, _fields: Mapping[str, Any]) -> None:
            if name == "SET_POSITION_TARGET_LOCAL_NED":  # others ask for streams meanwhile
                entered.set()
                release.wait(30.0)

        rig.link.answer = hang
        rig.autopilot.send_target(10.0, -5.0, 30.0, 0.0)
        await until(entered.is_set)
        rig.link.answer = lambda _name, _fields: None
        rig.autopilot.calls.deadline_s = 0.0
        rig.autopilot.send_target(11.0, -5.0, 30.0, 0.0)
        assert rig.autopilot.calls.overdue == 1
        assert "target" in rig.autopilot.calls.health.reason
        await until(lambda: len(rig.link.named("SET_POSITION_TARGET_LOCAL_NED")) == 2)
        release.set()

    async def test_a_link_that_hangs_while_it_opens_is_reported(
        self, rig: Rig, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("hawk.comm.autopilot.autopilot._OPEN_S", 0.01)
        release = threading.Event()
        rig.link.open = lambda: (release.wait(30.0), None)[1]  # type: ignore[method-assign]
        await rig.autopilot.start()
        await until(lambda: "open: MAVSDK did not return" in rig.autopilot.problem)
        release.set()


class TestTarget:
    async def test_it_goes_out_in_ekf_local(self, rig: Rig) -> None:
        await rig.connect()
        await rig.arm_here()
        rig.autopilot.send_target(10.0, -5.0, 30.0, 7.0)
        await until(lambda: bool(rig.link.named("SET_POSITION_TARGET_LOCAL_NED")))
        sent = rig.link.named("SET_POSITION_TARGET_LOCAL_NED")[0]
        assert (sent["x"], sent["y"], sent["z"]) == pytest.approx((12.0, -4.0, -30.5), abs=0.02)
        assert sent["yaw"] == pytest.approx(7.0 - 2 * math.pi)
        assert sent["time_boot_ms"] == rig.said.ms
        assert (sent["type_mask"], sent["coordinate_frame"]) == (2552, 1)

    @pytest.mark.parametrize("index", range(4))
    @pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
    async def test_what_is_not_finite_never_reaches_the_link(self, rig: Rig, index: int, value: float) -> None:
        await rig.connect()
        await rig.arm_here()
        numbers = [1.0, 2.0, 30.0, 0.0]
        numbers[index] = value
        with pytest.raises(AutopilotError, match="not finite"):
            rig.autopilot.send_target(numbers[0], numbers[1], numbers[2], numbers[3])
        await asyncio.sleep(0.01)
        assert rig.link.named("SET_POSITION_TARGET_LOCAL_NED") == []

    async def test_while_the_position_leaps_none_is_sent(self, rig: Rig) -> None:
        await rig.connect()
        await rig.arm_here()
        rig.clock.advance(0.05)
        rig.said.boot += 0.05
        await rig.say(rig.said.local(40.0, 1.0, -0.5))
        with pytest.raises(AutopilotError, match="position leapt"):
            rig.autopilot.send_target(1.0, 2.0, 30.0, 0.0)
        for _ in range(3):
            rig.clock.advance(0.05)
            rig.said.boot += 0.05
            await rig.say(rig.said.attitude(), rig.said.local(40.0, 1.0, -0.5), rig.said.world())
        rig.autopilot.send_target(0.0, 0.0, 30.0, 0.0)
        await until(lambda: bool(rig.link.named("SET_POSITION_TARGET_LOCAL_NED")))
        (sent,) = rig.link.named("SET_POSITION_TARGET_LOCAL_NED")
        assert (sent["x"], sent["y"]) == pytest.approx((40.0, 1.0), abs=0.05)

    async def test_before_the_first_arm_there_is_nowhere_to_send_it(self, rig: Rig) -> None:
        await rig.connect()
        with pytest.raises(AutopilotError, match="No arm place"):
            rig.autopilot.send_target(1.0, 2.0, 30.0, 0.0)

    async def test_a_dead_link_gets_none(self, rig: Rig) -> None:
        await rig.connect()
        await rig.arm_here()
        rig.clock.advance(3.0)
        await until(lambda: rig.topics.state.value is not None and not rig.topics.state.value.connected)
        with pytest.raises(AutopilotError, match="No link"):
            rig.autopilot.send_target(1.0, 2.0, 30.0, 0.0)

    async def test_after_a_boot_the_old_map_is_not_flown(self, rig: Rig) -> None:
        await rig.connect()
        await rig.arm_here()
        await rig.boot()
        with pytest.raises(AutopilotError, match="No arm place"):
            rig.autopilot.send_target(1.0, 2.0, 30.0, 0.0)


class TestRtlAltitude:
    async def test_centimetres_where_there_are_no_metres(self, rig: Rig) -> None:
        await rig.connect()
        assert await rig.autopilot.set_rtl_altitude(42.5) == 42.5
        assert rig.memory.values["RTL_ALT"] == (4250.0, 4)

    async def test_metres_where_the_autopilot_knows_them(self, rig: Rig) -> None:
        rig.memory.values["RTL_ALT_M"] = (15.0, 9)
        await rig.connect()
        assert await rig.autopilot.set_rtl_altitude(42.5) == 42.5
        assert rig.memory.values["RTL_ALT_M"] == (42.5, 9)
        assert rig.memory.values["RTL_ALT"] == (1500, 4)

    async def test_what_is_absent_is_asked_for_once_a_boot(self, rig: Rig) -> None:
        await rig.connect()
        await rig.autopilot.set_rtl_altitude(30.0)
        asked = len(rig.memory.asked)
        await rig.autopilot.set_rtl_altitude(31.0)
        assert all(name == "RTL_ALT" for _, name in rig.memory.asked[asked:])

    async def test_a_missing_parameter_of_the_return_altitude_is_an_error(self, rig: Rig) -> None:
        rig.memory.values.clear()
        await rig.connect()
        with pytest.raises(AutopilotError, match="Neither RTL_ALT_M nor RTL_ALT"):
            await rig.autopilot.set_rtl_altitude(30.0)

    @pytest.mark.parametrize("metres", [0.0, -1.0, math.nan, math.inf])
    async def test_a_height_that_is_none_is_not_sent(self, rig: Rig, metres: float) -> None:
        await rig.connect()
        with pytest.raises(AutopilotError, match="Return altitude"):
            await rig.autopilot.set_rtl_altitude(metres)
        assert rig.memory.asked == []


def moved(ring: Corners) -> Corners:
    """Move the first corner by two decimetres."""
    return ((ring[0][0] + 2e-6, ring[0][1]), *ring[1:])


class TestFence:
    async def test_it_is_uploaded_and_enabled_last(self, rig: Rig) -> None:
        await rig.connect()
        rig.autopilot.set_datum(GlobalPose(LATITUDE, LONGITUDE, ALTITUDE))
        await rig.autopilot.upload_fence(FENCE)
        corners = [
            offset_ned(GlobalPose(lat, lon, ALTITUDE), GlobalPose(LATITUDE, LONGITUDE, ALTITUDE))[:2]
            for lat, lon in rig.link.fences[0].inclusion
        ]
        for corner, expected in zip(corners, FENCE.autopilot_polygon, strict=True):
            assert corner == pytest.approx(expected, abs=0.01)
        sets = [name for kind, name in rig.memory.asked if kind == "PARAM_SET"]
        assert sets == ["FENCE_ALT_MAX", "FENCE_TYPE", "FENCE_ACTION", "FENCE_ENABLE"]
        values = {name: value for name, (value, _) in rig.memory.values.items()}
        assert (values["FENCE_ALT_MAX"], values["FENCE_TYPE"], values["FENCE_ACTION"]) == (100.0, 5.0, 1.0)
        assert values["FENCE_ENABLE"] == 1.0

    @pytest.mark.fault(
        "the autopilot had another kind of fence on (FENCE_TYPE 7) when ours is uploaded before Arm",
        "it is switched off for the upload, so that SYS_STATUS shows later that a command switched ours off",
    )
    @pytest.mark.parametrize("armed", [False, True])
    async def test_one_of_other_kinds_is_off_before_it_is_uploaded_on_the_ground_and_never_in_flight(
        self, rig: Rig, monkeypatch: pytest.MonkeyPatch, armed: bool
    ) -> None:
        """Else a circle stays on, and SYS_STATUS shows a fence after a command that switched the others off."""
        monkeypatch.setattr("hawk.comm.autopilot.autopilot._FENCE_NOTICED_S", 0.0)
        rig.memory.values |= {"FENCE_ENABLE": (1, 2), "FENCE_TYPE": (7, 2)}
        await rig.connect()
        await rig.say(rig.said.heartbeat(armed=armed))
        rig.autopilot.set_datum(GlobalPose(LATITUDE, LONGITUDE, ALTITUDE))
        await rig.autopilot.upload_fence(FENCE)
        sets = [name for kind, name in rig.memory.asked if kind == "PARAM_SET"]
        assert sets == [
            *([] if armed else ["FENCE_ENABLE"]),
            "FENCE_ALT_MAX",
            "FENCE_TYPE",
            "FENCE_ACTION",
            "FENCE_ENABLE",
        ]
        assert rig.memory.values["FENCE_ENABLE"][0] == 1
        enables = [each for each in rig.link.named("PARAM_SET") if each["param_id"] == "FENCE_ENABLE"]
        assert [each["param_value"] for each in enables] == ([1.0] if armed else [0.0, 1.0])

    @pytest.mark.slow
    async def test_it_is_shown_before_the_upload_ends(self, rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("hawk.comm.autopilot.autopilot._FENCE_NOTICED_S", 0.0)
        rig.memory.values |= {"FENCE_ENABLE": (1, 2), "FENCE_TYPE": (7, 2)}
        await rig.connect()
        kind, fields = rig.said.system()
        await rig.say((kind, {**fields, "onboard_control_sensors_enabled": 0}))
        rig.autopilot.set_datum(GlobalPose(LATITUDE, LONGITUDE, ALTITUDE))
        upload = asyncio.create_task(rig.autopilot.upload_fence(FENCE))
        await asyncio.sleep(0.3)
        assert not upload.done()
        await rig.say((kind, {**fields, "onboard_control_sensors_enabled": 1 << 20}))
        await upload

    async def test_an_action_of_the_users_own_is_kept(self, rig: Rig) -> None:
        rig.memory.values["FENCE_ACTION"] = (4, 2)
        await rig.connect()
        rig.autopilot.set_datum(GlobalPose(LATITUDE, LONGITUDE, ALTITUDE))
        await rig.autopilot.upload_fence(FENCE)
        assert rig.memory.values["FENCE_ACTION"] == (4, 2)

    async def test_before_the_first_arm_it_lies_about_the_drone(self, rig: Rig) -> None:
        await rig.connect()
        await rig.stand(1)
        await rig.say(rig.said.attitude(), rig.said.world(20.0))
        origin = rig.autopilot.telemetry.tie.fence_origin
        assert origin is not None
        await rig.autopilot.upload_fence(FENCE)
        middle = sum(latitude for latitude, _ in rig.link.fences[0].inclusion) / 4
        assert middle == pytest.approx(origin.latitude, abs=1e-6)

    async def test_zones_go_with_it_in_their_order(self, rig: Rig) -> None:
        await rig.connect()
        rig.autopilot.set_datum(GlobalPose(LATITUDE, LONGITUDE, ALTITUDE))
        await rig.autopilot.upload_fence(ZONED)
        (sent,) = rig.link.fences
        assert [len(ring) for ring in sent] == [4, 3, 4]
        for ring, expected in zip(sent.exclusions, ZONED.autopilot_zones, strict=True):
            for (lat, lon), corner in zip(ring, expected, strict=True):
                datum = GlobalPose(LATITUDE, LONGITUDE, ALTITUDE)
                assert offset_ned(GlobalPose(lat, lon, ALTITUDE), datum)[:2] == pytest.approx(corner, abs=0.01)
        await rig.autopilot.compare_fence(ZONED)
        with pytest.raises(AutopilotError, match="another one: it has 2 exclusion zones, ours has 0"):
            await rig.autopilot.compare_fence(FENCE)

    @pytest.mark.fault("the upload is acknowledged but another fence is held", "the upload has failed")
    @pytest.mark.parametrize(
        ("change", "words"),
        [
            (lambda held: replace(held, inclusion=held.inclusion[:-1]), "its polygon is another one"),
            (lambda held: replace(held, inclusion=(*held.inclusion, held.inclusion[0])), "its polygon"),
            (lambda held: replace(held, inclusion=moved(held.inclusion)), "its polygon"),
            (lambda held: replace(held, inclusion=(*held.inclusion[1:], held.inclusion[0])), "its polygon"),
            (lambda held: replace(held, exclusions=held.exclusions[:1]), "it has 1 exclusion zones, ours has 2"),
            (lambda held: replace(held, exclusions=()), "it has 0 exclusion zones, ours has 2"),
            (lambda held: replace(held, exclusions=(*held.exclusions, held.inclusion)), "it has 3 exclusion zones"),
            (lambda held: replace(held, exclusions=held.exclusions[::-1]), "its zone 1 is another one"),
            (lambda held: replace(held, exclusions=(held.exclusions[0], moved(held.exclusions[1]))), "its zone 2 is"),
            (lambda held: replace(held, exclusions=(held.exclusions[0], held.exclusions[1][1:])), "its zone 2 is"),
        ],
        ids=["a corner less", "a corner more", "a corner moved", "turned", "a zone less", "no zone", "a zone more",
             "zones in another order", "a zone's corner moved", "a zone's corner less"],
    )  # fmt: skip
    async def test_an_upload_that_reads_back_as_another_fence_has_failed(
        self, rig: Rig, change: Callable[[FenceRings], FenceRings], words: str
    ) -> None:
        await rig.connect()
        rig.autopilot.set_datum(GlobalPose(LATITUDE, LONGITUDE, ALTITUDE))
        await rig.autopilot.upload_fence(ZONED)
        await rig.autopilot.compare_fence(ZONED)
        assert rig.link.held is not None
        rig.link.keeps = change(rig.link.held)
        with pytest.raises(AutopilotError, match=f"holds is another one: {words}"):
            await rig.autopilot.upload_fence(ZONED)
        with pytest.raises(AutopilotError, match=f"holds is another one: {words}"):
            await rig.autopilot.compare_fence(ZONED)

    async def test_rounding_on_the_wire_is_no_other_fence(self, rig: Rig) -> None:
        await rig.connect()
        rig.autopilot.set_datum(GlobalPose(LATITUDE, LONGITUDE, ALTITUDE))
        await rig.autopilot.upload_fence(ZONED)
        assert rig.link.held is not None
        first, *others = (tuple((round(lat, 7), round(lon, 7)) for lat, lon in ring) for ring in rig.link.held)
        rig.link.held = FenceRings(first, tuple(others))
        await rig.autopilot.compare_fence(ZONED)

    async def test_a_comparison_writes_nothing_and_finds_what_differs(self, rig: Rig) -> None:
        await rig.connect()
        rig.autopilot.set_datum(GlobalPose(LATITUDE, LONGITUDE, ALTITUDE))
        with pytest.raises(AutopilotError, match="FENCE_ENABLE"):
            await rig.autopilot.compare_fence(FENCE)
        rig.memory.values["FENCE_ENABLE"] = (1, 2)
        with pytest.raises(AutopilotError, match="its ceiling is 120 m, ours is 100 m"):
            await rig.autopilot.compare_fence(FENCE)
        rig.memory.values["FENCE_ALT_MAX"] = (100, 9)
        with pytest.raises(AutopilotError, match="0 inclusion polygons"):
            await rig.autopilot.compare_fence(FENCE)
        assert rig.link.fences == []
        assert all(kind == "PARAM_REQUEST_READ" for kind, _ in rig.memory.asked)

    @pytest.mark.parametrize(("ceiling", "same"), [(97.0, False), (97.1, True), (100.1, True), (100.2, False)])
    async def test_a_ceiling_between_ours_and_that_of_the_upload_is_no_other_fence(
        self, rig: Rig, ceiling: float, same: bool
    ) -> None:
        await rig.connect()
        rig.autopilot.set_datum(GlobalPose(LATITUDE, LONGITUDE, ALTITUDE))
        fence = replace(FENCE, ceiling=97.0, autopilot_ceiling=100.0)
        await rig.autopilot.upload_fence(fence)
        rig.memory.values["FENCE_ALT_MAX"] = (ceiling, 9)
        if same:
            await rig.autopilot.compare_fence(fence)
        else:
            with pytest.raises(OtherFenceError, match="FENCE_ALT_MAX"):
                await rig.autopilot.compare_fence(fence)

    async def test_the_fence_is_switched_on_and_rally_points_are_cleared(self, rig: Rig) -> None:
        with pytest.raises(AutopilotError, match="No link"):
            await rig.autopilot.clear_rally_points()
        await rig.connect()
        await rig.autopilot.enable_fence()
        assert rig.link.commanded[-1] == (207, [1.0])
        await rig.autopilot.clear_rally_points()
        assert rig.link.named("MISSION_CLEAR_ALL") == [{"mission_type": 2}]

    async def test_what_another_station_writes_is_published(self, rig: Rig) -> None:
        await rig.connect()
        rig.link.on_message(Message(FOREIGN_WRITE, {"subjects": ("fence", "rally")}, 7.0, (254, 190)))
        await until(lambda: rig.topics.foreign_write.value is not None)
        assert rig.topics.foreign_write.value == ForeignWrite(7.0, 254, 190, "rally")

    @pytest.mark.fault(
        "a fence that fills the autopilot's memory, which ends ArduCopter's program",
        "not sent; refused while it is drawn",
    )
    @pytest.mark.parametrize(("corners", "zones"), [(70, 0), (66, 1), (57, 4), (31, 12)])
    async def test_a_fence_that_fills_the_autopilots_memory_is_not_sent(
        self, rig: Rig, corners: int, zones: int
    ) -> None:
        """66 corners and a zone of 3 fill it to the last byte, which ends ArduCopter's program."""
        await rig.connect()
        rig.autopilot.set_datum(GlobalPose(LATITUDE, LONGITUDE, ALTITUDE))
        ring = tuple((float(k), float(k * k)) for k in range(corners))
        triangle = ((1.0, 1.0), (2.0, 1.0), (1.0, 2.0))
        fits = replace(FENCE, autopilot_polygon=ring[:-1], autopilot_zones=(triangle,) * zones)
        await rig.autopilot.upload_fence(fits)
        rig.link.fences.clear()
        with pytest.raises(AutopilotError, match="bytes, the autopilot has 560: leave out corners"):
            await rig.autopilot.upload_fence(replace(fits, autopilot_polygon=ring))
        assert rig.link.fences == []

    async def test_without_a_place_the_fence_cannot_be_placed(self, rig: Rig) -> None:
        await rig.connect()
        with pytest.raises(AutopilotError, match="does not know where it is"):
            await rig.autopilot.upload_fence(FENCE)

    @pytest.mark.parametrize("as_zone", [False, True], ids=["fence", "zone"])
    @pytest.mark.parametrize(
        ("corners", "words"),
        [(((0.0, 0.0), (1.0, 1.0)), "at least 3"), (((0.0, 0.0), (1.0, math.nan), (2.0, 0.0)), "not finite")],
    )
    async def test_a_fence_that_is_none_is_not_sent(
        self, rig: Rig, corners: tuple[tuple[float, float], ...], words: str, as_zone: bool
    ) -> None:
        await rig.connect()
        rig.autopilot.set_datum(GlobalPose(LATITUDE, LONGITUDE, ALTITUDE))
        bad = replace(FENCE, autopilot_zones=(corners,)) if as_zone else replace(FENCE, autopilot_polygon=corners)
        with pytest.raises(AutopilotError, match=words):
            await rig.autopilot.upload_fence(bad)
        assert rig.link.fences == []
        assert rig.memory.asked == []


async def test_parameters_are_read_kept_and_set(rig: Rig) -> None:
    await rig.connect()
    assert await rig.autopilot.get_parameter("FENCE_ENABLE") == 0
    with pytest.raises(AutopilotError, match="MAV_GCS_SYSID"):
        await rig.autopilot.get_parameter("MAV_GCS_SYSID")
    assert rig.autopilot.parameters == {"FENCE_ENABLE": 0}
    await rig.autopilot.set_parameter("FENCE_ENABLE", 1)
    assert await rig.autopilot.get_parameter("FENCE_ENABLE") == 1


async def test_an_arm_place_that_was_kept_makes_a_map_at_once(rig: Rig) -> None:
    rig.autopilot.set_datum(GlobalPose(LATITUDE, LONGITUDE, ALTITUDE))
    rig.autopilot.telemetry.restore_arm_place(
        ArmPlace(LATITUDE, LONGITUDE, ALTITUDE, 0.0, 0.0, 0.0, this_moment().before(100.0))
    )
    await rig.connect()
    for _ in range(2):
        rig.clock.advance(0.05)
        rig.said.boot += 0.05
        await rig.say(rig.said.world(3.0, 20.0), rig.said.attitude(), rig.said.local(3.0, 0.0, -20.0))
    pose = rig.autopilot.telemetry.pose_at(rig.clock())
    assert pose is not None
    assert pose.map is not None
    assert (pose.map.north, pose.map.east, pose.map.height) == pytest.approx((3.0, 0.0, 20.0), abs=0.01)


async def test_closing_does_not_wait_for_a_command_that_hangs(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hawk.comm.autopilot.autopilot._COMMAND_S", 0.05)
    await rig.connect()
    release = threading.Event()
    rig.link.before_ack = lambda: (release.wait(10), None)[1]
    hanging = asyncio.create_task(rig.autopilot.arm())
    await until(lambda: bool(rig.link.commanded))
    before = time.perf_counter()
    await rig.autopilot.close()
    assert time.perf_counter() - before < 5.0
    release.set()
    await asyncio.gather(hanging, return_exceptions=True)
    assert rig.link.closed
    assert not [task for task in asyncio.all_tasks() if task.get_name().startswith("autopilot")]


async def test_a_command_under_way_ends_before_the_link_does(rig: Rig) -> None:
    await rig.connect()
    asked, answered = threading.Event(), threading.Event()
    link_was_open: list[bool] = []

    def answer_late() -> None:
        asked.set()
        answered.wait(5.0)
        link_was_open.append(not rig.link.closed)

    rig.link.before_ack = answer_late
    command = asyncio.create_task(rig.autopilot.set_mode(CopterMode.RTL))
    await until(asked.is_set)
    closing = asyncio.create_task(rig.autopilot.close())
    await asyncio.sleep(0.05)
    assert not closing.done()
    answered.set()
    await closing
    await command
    assert link_was_open == [True]
    assert rig.link.closed


async def test_it_can_be_closed_before_it_was_started_and_twice() -> None:
    rig = Rig()
    await rig.autopilot.close()
    await rig.autopilot.close()
    assert rig.link.closed


@pytest.mark.parametrize(
    ("named", "flown", "in_flight", "expected"),
    [
        (None, None, False, Expected(wait_s=1.5)),
        (None, None, True, Expected()),
        (None, 7, True, Expected(7)),
        (3, 7, True, Expected(3)),
        (3, None, False, Expected(3)),
    ],
)
def test_the_expected_vehicle_is_the_named_one_else_that_of_the_flight(
    named: int | None, flown: int | None, in_flight: bool, expected: Expected
) -> None:
    assert expected_autopilot(AutopilotSettings(vehicle_system_id=named), flown, in_flight=in_flight) == expected


async def test_of_several_copters_the_problem_names_them(rig: Rig) -> None:
    words = "Several copters are heard: system 1, system 3. Name yours."
    rig.link.appears, rig.link.heard = False, Hearing(second_sender=words)
    await rig.autopilot.start()
    await until(lambda: bool(rig.autopilot.problem))
    assert rig.autopilot.problem == f"autopilot.url 'udpin://127.0.0.1:14550': {words}"
