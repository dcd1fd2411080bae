"""The gate: each condition of design section 6 alone keeps a target from the wire."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from types import SimpleNamespace

import pytest

from hawk.comm.autopilot.vehicle import AutopilotError
from hawk.ddc.fence.geometry import polygon_fence
from hawk.ddc.motion import Goal, maximum_target_distance
from hawk.ddc.requests.service_interface import ReqFailed, TargetRefused
from hawk.model.operation import StateName
from hawk.model.plans import HeightParameters
from hawk.model.poses import GlobalPose
from hawk.model.vehicle import CopterMode
from tests.unit.ddc.fakes import COMMANDING_STATES, PLACE, Rig, sender

GOOD = Goal(3.0, 2.0, 31.0, 0.5)
HEIGHTS = HeightParameters(15, 35, 60)


def send(rig: Rig, goal: Goal = GOOD, state: StateName = StateName.COMPULSIVE_MOVE) -> None:
    rig.service.send_target(goal, sender(state), HEIGHTS, rig.fence)


def refused(rig: Rig, words: str, goal: Goal = GOOD, state: StateName = StateName.COMPULSIVE_MOVE) -> None:
    before = len(rig.autopilot.targets)
    with pytest.raises(TargetRefused, match=words):
        send(rig, goal, state)
    assert len(rig.autopilot.targets) == before


async def test_a_good_target_goes_out(flying: Rig) -> None:
    send(flying)
    sent = flying.autopilot.targets[-1]
    assert (sent.north, sent.east, sent.height, sent.yaw) == (3.0, 2.0, 31.0, 0.5)


@pytest.mark.parametrize("state", sorted(set(StateName) - COMMANDING_STATES))
async def test_only_commanding_states_send(flying: Rig, state: StateName) -> None:
    refused(flying, "sends no targets", state=state)


@pytest.mark.nightly
@pytest.mark.parametrize("mode", sorted(set(CopterMode) - {CopterMode.GUIDED}))
async def test_only_in_guided(flying: Rig, mode: CopterMode) -> None:
    flying.autopilot.mode = mode
    flying.autopilot.publish()
    refused(flying, "GUIDED")


async def test_not_disarmed(flying: Rig) -> None:
    flying.autopilot.armed = False
    flying.autopilot.publish()
    refused(flying, "armed")


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("field", ["north", "east", "height", "yaw"])
async def test_nothing_that_is_not_finite(flying: Rig, field: str, number: float) -> None:
    values = {"north": 3.0, "east": 2.0, "height": 31.0, "yaw": 0.5, field: number}
    refused(flying, "finite", Goal(**values))


async def test_not_on_an_old_pose(flying: Rig) -> None:
    flying.clock.advance(0.49)
    send(flying)
    flying.clock.advance(0.02)
    refused(flying, "older than 0.5 s")


async def test_not_on_a_pose_that_is_not_finite(flying: Rig) -> None:
    flying.autopilot.height = math.nan
    flying.autopilot.publish()
    refused(flying, "pose")


async def test_not_without_a_link(flying: Rig) -> None:
    flying.autopilot.connected = False
    flying.autopilot.publish()
    refused(flying, "link")


async def test_not_when_heartbeats_stopped(flying: Rig) -> None:
    flying.clock.advance(3.1)
    refused(flying, "link")


async def test_not_outside_the_fence(flying: Rig) -> None:
    flying.autopilot.north = 143.0
    flying.autopilot.publish()
    refused(flying, "fence", Goal(146.0, 0, 31, 0))
    send(flying, Goal(143.0, 0, 31, 0))


U_SHAPE = polygon_fence(((-20, -40), (40, -40), (40, -6), (10, -6), (10, 6), (40, 6), (40, 40), (-20, 40)), 1, 100, 3)
"""Two arms to the north, the gap between them 14 m wide."""


@pytest.mark.parametrize(
    ("state", "east", "to_east", "allowed"),
    [
        (StateName.COMPULSIVE_MOVE, -8.0, 3.0, False),
        (StateName.COMPULSIVE_MOVE, -8.0, 7.5, False),
        (StateName.HOVER, -8.0, 7.5, False),
        (StateName.COMPULSIVE_MOVE, -8.0, -20.0, True),
        (StateName.AUTONOMOUS_MOVE, 0.0, 8.0, True),
        (StateName.HOVER, 0.0, 8.0, True),
        (StateName.AUTONOMOUS_EXPLORE, -8.0, 7.5, False),
    ],
    ids=[
        "into the gap",
        "over it",
        "over it, holding",
        "inside",
        "out of it",
        "out of it, holding",
        "exploring over it",
    ],
)
async def test_the_straight_path_to_the_target_stays_inside_a_concave_fence(
    flying: Rig, state: StateName, east: float, to_east: float, allowed: bool
) -> None:
    flying.autopilot.north, flying.autopilot.east = 30.0, east
    flying.autopilot.publish()
    before = len(flying.autopilot.targets)
    goal = Goal(30.0, to_east, 31, 0)
    if allowed:
        flying.service.send_target(goal, sender(state), HEIGHTS, U_SHAPE)
    else:
        with pytest.raises(TargetRefused, match="fence"):
            flying.service.send_target(goal, sender(state), HEIGHTS, U_SHAPE)
    assert len(flying.autopilot.targets) == before + allowed


async def test_a_drone_outside_that_holds_is_led_back_through_another_arm(flying: Rig) -> None:
    flying.autopilot.north, flying.autopilot.east = 42.0, -8.0
    flying.autopilot.publish()
    back = Goal(30.0, -8.0, 31, 0)
    flying.service.send_target(back, sender(StateName.HOVER), HEIGHTS, U_SHAPE)
    flying.service.send_target(back, sender(StateName.COMPULSIVE_MOVE), HEIGHTS, U_SHAPE)
    flying.autopilot.north, flying.autopilot.east = 39.3, -8.9
    flying.autopilot.publish()
    through = Goal(34.0, 7.2, 31, 0)  # cuts the corner of one arm, crosses the gap, ends in the other
    flying.service.send_target(through, sender(StateName.HOVER), HEIGHTS, U_SHAPE)
    with pytest.raises(TargetRefused, match="straight path"):
        flying.service.send_target(through, sender(StateName.COMPULSIVE_MOVE), HEIGHTS, U_SHAPE)


async def test_not_without_a_fence(flying: Rig) -> None:
    with pytest.raises(TargetRefused, match="fence"):
        flying.service.send_target(GOOD, sender(StateName.HOVER), HEIGHTS, None)


async def test_no_farther_than_three_seconds_and_the_stopping_distance(flying: Rig) -> None:
    limit = maximum_target_distance(4.0)
    send(flying, Goal(limit - 0.01, 0, 31, 0))
    refused(flying, "away", Goal(limit + 0.01, 0, 31, 0))
    refused(flying, "away", Goal(0, 0, 30 + limit + 0.1, 0))


@pytest.mark.parametrize(
    ("height", "goal", "words"),
    [
        (30, Goal(0, 0, 14.9, 0), "below Min"),
        (10, Goal(0, 0, 9.9, 0), "below Min"),
        (10, Goal(3, 0, 14, 0), "below Min"),
        (10, Goal(0, 0, 12, 0), ""),
        (59, Goal(0, 0, 60.1, 0), "above Max"),
        (80, Goal(3, 0, 79, 0), "above Max"),
        (80, Goal(0, 0, 79, 0), ""),
        (96, Goal(0, 0, 97.1, 0), "ceiling"),
    ],
)
async def test_heights_are_bounded_and_only_the_straight_path_back_is_free(
    flying: Rig, height: float, goal: Goal, words: str
) -> None:
    flying.autopilot.height = height
    flying.autopilot.publish()
    if words:
        refused(flying, words, goal)
    else:
        send(flying, goal)


async def test_holding_above_max_is_holding_no_travel(flying: Rig) -> None:
    flying.autopilot.height = 80
    flying.autopilot.publish()
    send(flying, Goal(4, 0, 80, 0), StateName.HOVER)
    refused(flying, "above Max", Goal(4, 0, 80, 0))


async def test_what_the_autopilot_boundary_refuses_is_a_refused_target(
    flying: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: float) -> None:
        raise AutopilotError("no arm place")

    monkeypatch.setattr(flying.autopilot, "send_target", fail)
    with pytest.raises(TargetRefused, match="no arm place"):
        send(flying)


# -- requests ---------------------------------------------------------------------------------------------------------

REQUESTS: dict[str, Callable[[Rig], object]] = {
    "arm": lambda rig: rig.service.set_arm(True),
    "disarm": lambda rig: rig.service.set_arm(False),
    "set_mode": lambda rig: rig.service.set_mode(CopterMode.RTL),
    "takeoff": lambda rig: rig.service.send_takeoff_cmd(20.0),
    "set_rtl_altitude": lambda rig: rig.service.set_rtl_alt(20),
    "get_parameter": lambda rig: rig.service.get_parameter("RTL_ALT"),
    "set_parameter": lambda rig: rig.service.set_parameter("RTL_ALT", 1),
    "set_home": lambda rig: rig.service.set_home(PLACE),
    "kill": lambda rig: rig.service.kill(),
}


@pytest.mark.parametrize("name", REQUESTS)
async def test_a_refusal_carries_the_autopilots_own_words(rig: Rig, name: str) -> None:
    rig.autopilot.refuse[name] = "Arm: Compass not calibrated"
    with pytest.raises(ReqFailed, match=r"^Arm: Compass not calibrated$"):
        await REQUESTS[name](rig)  # type: ignore[misc]


async def test_takeoff_takes_a_height_or_a_global_pose(flying: Rig) -> None:
    await flying.service.send_takeoff_cmd(20.0)
    await flying.service.send_takeoff_cmd(GlobalPose(0, 0, PLACE.altitude + 25))
    assert flying.autopilot.asked("takeoff") == [20.0, 25.0]


async def test_takeoff_to_a_global_pose_needs_an_arm_place(rig: Rig) -> None:
    with pytest.raises(ReqFailed, match="arm place"):
        await rig.service.send_takeoff_cmd(PLACE)


async def test_a_return_altitude_that_reads_back_wrong_is_a_failure(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    async def other(_: float) -> float:
        return 15.0

    monkeypatch.setattr(rig.autopilot, "set_rtl_altitude", other)
    with pytest.raises(ReqFailed, match="asked for 60 m, the autopilot says 15 m"):
        await rig.service.set_rtl_alt(60)


async def test_failsafes_are_read_back(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    async def forget(name: str, value: float) -> None:
        """Take a value and keep the old one."""

    monkeypatch.setattr(rig.autopilot, "set_parameter", forget)
    monkeypatch.setattr("hawk.ddc.requests.service_interface.READ_BACK_S", 0.0)
    with pytest.raises(ReqFailed, match="FENCE_ACTION: set to 3, the autopilot says 1"):
        await rig.service.set_failsafes({"FENCE_ACTION": 3})


async def test_a_failsafe_is_read_five_times_a_second_for_three_seconds(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    pauses: list[float] = []

    async def forget(name: str, value: float) -> None:
        """Take a value and keep the old one."""

    async def sleep(seconds: float) -> None:
        pauses.append(seconds)

    monkeypatch.setattr(rig.autopilot, "set_parameter", forget)
    monkeypatch.setattr(
        "hawk.ddc.requests.service_interface.time", SimpleNamespace(monotonic=lambda: 0.2 * len(pauses))
    )
    monkeypatch.setattr("hawk.ddc.requests.service_interface.asyncio", SimpleNamespace(sleep=sleep))
    with pytest.raises(ReqFailed, match="FENCE_ACTION: set to 3"):
        await rig.service.set_failsafes({"FENCE_ACTION": 3})
    assert pauses == [0.2] * 15


@pytest.mark.parametrize(("found", "passes"), [(60.5, True), (59.5, True), (60.51, False), (59.49, False)])
async def test_a_return_altitude_may_read_back_half_a_metre_off(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, found: float, passes: bool
) -> None:
    async def other(_: float) -> float:
        return found

    monkeypatch.setattr(rig.autopilot, "set_rtl_altitude", other)
    if passes:
        await rig.service.set_rtl_alt(60.0)
    else:
        with pytest.raises(ReqFailed, match="return altitude"):
            await rig.service.set_rtl_alt(60.0)


@pytest.mark.fault("a parameter is confirmed and reads as its old value")
async def test_a_failsafe_that_reads_as_the_old_value_for_a_moment_is_read_again(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    read, stale = rig.autopilot.get_parameter, [1, 1]

    async def late(name: str) -> float | int:
        found = await read(name)
        return stale.pop() if stale else found

    monkeypatch.setattr(rig.autopilot, "get_parameter", late)
    monkeypatch.setattr("hawk.ddc.requests.service_interface.READ_BACK_PAUSE_S", 0.0)
    await rig.service.set_failsafes({"FENCE_ACTION": 3})
    assert stale == []
    assert rig.autopilot.values["FENCE_ACTION"] == 3


async def test_a_parameter_is_put_back_and_read_back_as_single_precision(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    await rig.service.put_back("FENCE_ACTION", 3)
    assert rig.autopilot.asked("set_parameter") == [("FENCE_ACTION", 3)]

    async def rounded(name: str) -> float:
        return 0.800000011920929

    monkeypatch.setattr(rig.autopilot, "get_parameter", rounded)
    await rig.service.put_back("FS_EKF_THRESH", 0.8)
    rig.autopilot.refuse["clear_rally_points"] = "busy"
    with pytest.raises(ReqFailed, match="busy"):
        await rig.service.put_back("RALLY_TOTAL", 0)


async def test_rally_points_are_cleared_as_a_mission_and_not_by_their_count(rig: Rig) -> None:
    rig.autopilot.values["RALLY_TOTAL"] = 2
    rig.autopilot.calls.clear()
    await rig.service.put_back("RALLY_TOTAL", 0)
    assert rig.autopilot.values["RALLY_TOTAL"] == 0
    assert [name for name, _ in rig.autopilot.calls] == ["clear_rally_points", "get_parameter"]


async def test_a_held_fence_stays_held_while_it_is_read_and_where_it_cannot_be_read(rig: Rig) -> None:
    fence = rig.manager.fences.build(PLACE, PLACE)
    await rig.service.upload_fence(fence)
    rig.autopilot.silent.add("compare_fence")
    reading = asyncio.create_task(rig.service.compare_fence(fence))
    await asyncio.sleep(0)
    assert rig.service.held_fence == fence
    reading.cancel()
    rig.autopilot.silent.clear()
    rig.autopilot.refuse["compare_fence"] = "no answer"
    with pytest.raises(ReqFailed, match="no answer"):
        await rig.service.compare_fence(fence)
    assert rig.service.held_fence == fence
    rig.autopilot.refuse.clear()
    rig.autopilot.held_fence = None
    with pytest.raises(ReqFailed, match="another one"):
        await rig.service.compare_fence(fence)
    assert rig.service.held_fence is None


async def test_a_comparison_that_the_link_outlived_says_nothing(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    fence = rig.manager.fences.build(PLACE, PLACE)
    await rig.service.upload_fence(fence)

    async def lost_meanwhile(_: object) -> None:
        rig.service.forget_held_fence()

    monkeypatch.setattr(rig.autopilot, "compare_fence", lost_meanwhile)
    await rig.service.compare_fence(fence)
    assert rig.service.held_fence is None


async def test_the_fence_is_switched_on_by_command(rig: Rig) -> None:
    await rig.service.enable_fence()
    assert rig.autopilot.count("enable_fence") == 1


async def test_a_mode_is_ours_for_two_seconds_after_the_request(rig: Rig) -> None:
    assert not rig.service.asked_for(CopterMode.RTL)
    await rig.service.set_mode(CopterMode.RTL)
    assert rig.service.asked_for(CopterMode.RTL)
    assert not rig.service.asked_for(CopterMode.LAND)
    assert not rig.service.asked_for(None)
    asked = rig.clock()
    rig.clock.now = asked + 2.0
    assert rig.service.asked_for(CopterMode.RTL)
    rig.clock.now = asked + 2.01
    assert not rig.service.asked_for(CopterMode.RTL)
    await rig.service.set_mode(CopterMode.RTL)
    rig.service.forget_asked_modes()
    assert not rig.service.asked_for(CopterMode.RTL)


@pytest.mark.parametrize(
    ("seen", "still_ours"),
    [
        (CopterMode.BRAKE, {CopterMode.BRAKE}),
        (CopterMode.GUIDED, {CopterMode.GUIDED, CopterMode.BRAKE}),
        (CopterMode.LOITER, {CopterMode.GUIDED, CopterMode.BRAKE}),
        (None, {CopterMode.GUIDED, CopterMode.BRAKE}),
    ],
)
async def test_once_the_last_mode_is_seen_an_earlier_one_is_not_ours(
    rig: Rig, seen: CopterMode | None, still_ours: set[CopterMode]
) -> None:
    await rig.service.set_mode(CopterMode.GUIDED)
    await rig.service.set_mode(CopterMode.BRAKE)
    rig.service.settle_mode(seen)
    assert {mode for mode in CopterMode if rig.service.asked_for(mode)} == still_ours


async def test_arm_and_disarm_return_success(rig: Rig) -> None:
    assert await rig.service.set_arm(True) is True
    assert [rig.autopilot.count("arm"), rig.autopilot.count("disarm")] == [1, 0]
    assert await rig.service.set_arm(False) is True
    assert [rig.autopilot.count("arm"), rig.autopilot.count("disarm")] == [1, 1]
    assert [payload["name"] for kind, payload in rig.records if kind == "request"][-2:] == ["arm", "disarm"]
    rig.autopilot.refuse["disarm"] = "Disarm: flying"
    with pytest.raises(ReqFailed, match="flying"):
        await rig.service.set_arm(False)
    rig.autopilot.refuse["arm"] = "Arm: Throttle too high"
    with pytest.raises(ReqFailed, match="Throttle"):
        await rig.service.set_arm(True)


async def test_a_datum_is_recorded_where_it_is_set_and_where_it_is_given_up(flying: Rig) -> None:
    flying.service.set_datum(GlobalPose(43.0, -79.0, 90.0))
    flying.service.set_datum(None)
    recorded = [payload["datum"] for _, payload in flying.records if payload.get("name") == "set datum"]
    assert recorded[-2:] == [{"latitude": 43.0, "longitude": -79.0, "altitude": 90.0}, None]
    assert flying.service.datum is None
