from __future__ import annotations

import json
import math

import pytest

from hawk.comm.autopilot import commands
from hawk.comm.autopilot.mavlink_link import command_fields, require_finite
from hawk.comm.autopilot.streams import Stream
from hawk.comm.autopilot.vehicle import AutopilotError
from hawk.model.poses import GlobalPose
from hawk.model.vehicle import CopterMode
from tests.manual_clock import ManualClock
from tests.unit.comm.fakes import FakeLink


@pytest.fixture
def link() -> FakeLink:
    return FakeLink("udpin://127.0.0.1:1", 245, ManualClock(), lambda _: None)


def test_arm_and_disarm_are_never_forced(link: FakeLink) -> None:
    commands.arm(link)
    commands.disarm(link)
    assert link.commanded == [(400, [1.0]), (400, [0.0])]


def test_a_mode_is_asked_for_by_its_number(link: FakeLink) -> None:
    commands.set_mode(link, CopterMode.GUIDED)
    assert link.commanded == [(176, [1.0, 4.0])]


def test_a_takeoff_of_less_than_a_metre_is_sent(link: FakeLink) -> None:
    commands.takeoff(link, 0.5)
    assert link.commanded == [(22, [0, 0, 0, 0, 0, 0, 0.5])]


def test_takeoff_carries_the_height_in_its_seventh_parameter(link: FakeLink) -> None:
    commands.takeoff(link, 35.0)
    assert link.commanded == [(22, [0, 0, 0, 0, 0, 0, 35.0])]


@pytest.mark.parametrize("height", [0.0, -5.0, math.nan, math.inf])
def test_a_takeoff_to_nowhere_is_not_sent(link: FakeLink, height: float) -> None:
    with pytest.raises(AutopilotError, match="Takeoff height"):
        commands.takeoff(link, height)
    assert link.commanded == []


@pytest.mark.parametrize(
    ("result", "words"),
    [
        (1, "temporarily rejected"),
        (2, "denied"),
        (3, "unsupported"),
        (4, "failed"),
        (5, "in progress"),
        (6, "cancelled"),
        (77, "77"),
    ],
)
def test_every_answer_but_accepted_is_a_refusal(link: FakeLink, result: int, words: str) -> None:
    link.results[400] = result
    with pytest.raises(commands.NotAcceptedError, match=f"Arm refused: {words}"):
        commands.arm(link)


def test_a_mode_may_be_sent_without_waiting(link: FakeLink) -> None:
    commands.send_mode(link, CopterMode.RTL)
    assert link.commanded == []
    assert link.named("COMMAND_LONG") == [command_fields(176, [1, 6])]


def test_the_fence_is_switched_on(link: FakeLink) -> None:
    commands.enable_fence(link)
    assert link.commanded == [(207, [1.0])]


def test_home_is_sent_to_the_centimetre(link: FakeLink) -> None:
    commands.set_home(link, GlobalPose(43.26091234, -79.91920006, 101.25))
    assert link.commanded == []
    assert link.sent == [
        (
            "COMMAND_INT",
            {
                "frame": 0,
                "command": 179,
                "current": 0,
                "autocontinue": 0,
                "param1": 0.0,
                "param2": 0.0,
                "param3": 0.0,
                "param4": 0.0,
                "x": 432609123,
                "y": -799192001,
                "z": 101.25,
            },
        )
    ]


def test_kill_is_one_message_and_waits_for_nothing(link: FakeLink) -> None:
    commands.kill(link)
    assert link.commanded == []
    assert len(link.sent) == 1
    name, fields = link.sent[0]
    assert (name, fields["command"], fields["param1"], fields["confirmation"]) == ("COMMAND_LONG", 185, 1.0, 0)


def test_a_rate_is_asked_for_in_microseconds(link: FakeLink) -> None:
    commands.ask_rate(link, Stream(32, 20.0))
    fields = link.named("COMMAND_LONG")[0]
    assert (fields["command"], fields["param1"], fields["param2"]) == (511, 32.0, 50_000.0)


def test_a_target_is_position_and_yaw_in_local_ned() -> None:
    fields = commands.position_target(5000, (1.0, -2.0, -30.0), 0.5)
    assert (fields["time_boot_ms"], fields["type_mask"], fields["coordinate_frame"]) == (5000, 2552, 1)
    assert (fields["x"], fields["y"], fields["z"], fields["yaw"]) == (1.0, -2.0, -30.0, 0.5)
    json.dumps(fields, allow_nan=False)


@pytest.mark.parametrize("name", ["x", "y", "z", "yaw"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_target_that_is_not_finite_is_refused_by_its_field(name: str, value: float) -> None:
    numbers = {"x": 1.0, "y": 2.0, "z": -3.0, "yaw": 0.1} | {name: value}
    with pytest.raises(AutopilotError, match=f"^{name} is"):
        commands.position_target(0, (numbers["x"], numbers["y"], numbers["z"]), numbers["yaw"])


def test_what_a_command_does_not_say_is_zero() -> None:
    assert command_fields(400, [1]) == {
        "command": 400, "confirmation": 0, "param1": 1.0,
        "param2": 0.0, "param3": 0.0, "param4": 0.0, "param5": 0.0, "param6": 0.0, "param7": 0.0,
    }  # fmt: skip


def test_whole_numbers_and_names_are_always_finite() -> None:
    require_finite({"a": 1, "b": "nan", "c": 2.5})
