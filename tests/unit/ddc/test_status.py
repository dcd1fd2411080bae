"""Reports to the operator: heartbeat, log, trail, records."""

from __future__ import annotations

import itertools
import json
import math

import pytest

from hawk.comm.protocol.commands import (
    Ack,
    Arm,
    AutonomousExplore,
    CompulsiveMove,
    Control,
    Hold,
    MapResync,
    OperatorHeartbeat,
)
from hawk.comm.protocol.heartbeat import DroneStatus
from hawk.ddc import status as status_room
from hawk.ddc.facts import Facts
from hawk.ddc.requests.flight_log import MAXIMUM_POINTS, Trail
from hawk.ddc.rules import command_desk
from hawk.model.lot_map import Counts, OccupancyMap
from hawk.model.operation import Health, HealthStatus, StateName
from hawk.model.pictures import GroundStep
from hawk.model.poses import MapPose
from hawk.specification.access_programs import DdcAccess
from hawk.store.frame_codec import to_json
from tests.unit.ddc.fakes import Rig

S = StateName


def status(rig: Rig) -> DroneStatus:
    found = rig.manager.status.value
    assert found is not None
    return found


@pytest.mark.nightly
async def test_five_heartbeats_a_second(rig: Rig) -> None:
    times: list[float] = []
    rig.manager.status.listen(lambda s: times.append(s.stamp.time))
    await rig.tick(200)
    assert len(times) == 50
    gaps = [b - a for a, b in itertools.pairwise(times)]
    assert gaps == pytest.approx([0.2] * 49)


async def test_heartbeats_go_on_in_communication_lost(fresh: Rig) -> None:
    await fresh.enter(S.COMMUNICATION_LOST)
    before = status(fresh).stamp.sequence
    await fresh.run(2)
    assert status(fresh).stamp.sequence == before + 10


async def test_what_is_not_known_is_none(fresh: Rig) -> None:
    fresh.manager.process()
    reported = status(fresh)
    assert reported.vehicle.armed is None
    assert reported.pose.latitude is None
    assert reported.vehicle.battery_percentage is None
    assert reported.vehicle.link_age is None
    assert reported.parts.health_status is HealthStatus.UNHEALTHY
    assert {item.name for item in reported.parts.health} == {
        "link",
        "position",
        "ground",
        "camera",
        "vision",
        "mapper",
        "planner",
        "recording",
        "requests",
        "tasks",
        "loop",
        "home",
        "remote control",
        "remote id",
    }


async def test_no_number_is_ever_nan(flying: Rig) -> None:
    flying.autopilot.height = math.nan
    flying.autopilot.battery = math.nan
    flying.autopilot.velocity = (math.nan, math.inf, 0.0)
    flying.autopilot.publish()
    flying.clock.advance(0.2)
    flying.manager.process()
    numbers = [v for v in json.loads(status(flying).shared_json).values() if isinstance(v, float)]
    assert all(math.isfinite(v) for v in numbers)


async def test_local_position_x_is_north_and_y_is_east(flying: Rig) -> None:
    flying.order(CompulsiveMove(x=20, y=-10))
    await flying.run(3)
    found = status(flying).pose
    assert found.local_position_x == pytest.approx(flying.autopilot.north, abs=1.0)
    assert found.local_position_y == pytest.approx(flying.autopilot.east, abs=1.0)
    assert flying.autopilot.north > 5
    assert flying.autopilot.east < -2


def camera_agrees(flying: Rig) -> None:
    now = flying.clock()
    flying.inputs.ground_step.publish(GroundStep(now - 0.4, now, (0.0, 0.0), (0.0, 0.0), 0.0, 0.0, 35.0))


async def test_a_flight_is_reported(flying: Rig) -> None:
    flying.inputs.occupancy_map.publish(OccupancyMap(counts=Counts(3, 2, 1), lot_area_m2=900.0))
    flying.order(CompulsiveMove(x=20, y=0))
    camera_agrees(flying)
    await flying.tick(60)
    reported = status(flying)
    assert reported.operation.state is S.COMPULSIVE_MOVE
    assert reported.vehicle.ardupilot_state == "GUIDED"
    seen = reported.perception
    assert (seen.free, seen.taken, seen.unknown, seen.lot_area) == (3, 2, 1, 900.0)
    assert (seen.explored, seen.free_range) == (0.4, None), "nothing is said of ground where it was not looked"
    assert reported.travel.target is not None
    assert reported.travel.target.north == pytest.approx(20, abs=0.1)
    assert reported.site.home is not None
    assert reported.site.fence
    assert reported.site.ceiling == 97
    assert reported.site.heights == pytest.approx((15, 35, 60))
    assert reported.pose.speed == pytest.approx(4, abs=1.5)
    assert reported.vehicle.battery_time_left is not None
    assert reported.vehicle.battery_time_left > 60
    # up to the return height of 60 m at 2 m/s, 10 m home at 4 m/s, down at 1.5 m/s, the last 10 m at 0.5 m/s
    assert reported.vehicle.time_home == pytest.approx(25 / 2 + 10 / 4 + 50 / 1.5 + 10 / 0.5, abs=4)
    assert reported.vehicle.survey_time_left is not None
    assert reported.travel.distance_flown == pytest.approx(10, abs=3)
    assert reported.travel.flight_time == pytest.approx(3.1, abs=0.3)
    assert len(reported.trail) >= 8
    assert reported.parts.health_status is HealthStatus.HEALTHY


async def test_loop_lag_is_shown_and_is_no_health_of_the_drone(flying: Rig) -> None:
    flying.inputs.loop_lag.publish(0.25)
    camera_agrees(flying)
    await flying.run(0.3)
    reported = status(flying)
    assert {item.name: item.reason for item in reported.parts.health}["loop"] == "The program is 250 ms late."
    assert reported.parts.health_status is HealthStatus.HEALTHY


@pytest.mark.parametrize("part", ["camera", "recording", "requests", "tasks"])
async def test_an_unhealthy_part_makes_health_status_one(flying: Rig, part: str) -> None:
    flying.see = lambda: getattr(flying.inputs, f"{part}_health").publish(Health.bad("gone"))  # type: ignore[method-assign]
    await flying.run(0.3)
    assert status(flying).parts.health_status is HealthStatus.UNHEALTHY
    assert DdcAccess(flying.topics).get_health_status().reason == f"{part}: gone"


# -- the message list -------------------------------------------------------------------------------------------------


async def test_words_of_the_autopilot_are_the_message(rig: Rig) -> None:
    for severity, level, lead in (
        (2, "error", "The autopilot reports a fault"),
        (4, "warning", "The autopilot warns"),
        (6, "info", "The autopilot"),
    ):
        rig.autopilot.say(f"severity {severity}", severity)
        entry = rig.manager.log.entries[-1]
        assert (entry.level, entry.text, entry.details) == (level, f"{lead}: severity {severity}", "")


async def test_the_same_words_are_reported_once_in_ten_seconds_and_debug_never(rig: Rig) -> None:
    before = len(rig.manager.log.entries)
    for _ in range(5):
        rig.autopilot.say("PreArm: Compass", 4)
    rig.autopilot.say("debug", 7)
    assert len(rig.manager.log.entries) == before + 1
    rig.clock.advance(10.1)
    rig.autopilot.say("PreArm: Compass", 4)
    assert len(rig.manager.log.entries) == before + 2


async def test_entries_are_numbered_timed_and_bounded(rig: Rig) -> None:
    for number in range(300):
        rig.manager.log.add("info", f"entry {number}")
    entries = rig.manager.log.entries
    assert len(entries) == 200
    assert [e.number for e in entries] == list(range(entries[0].number, entries[0].number + 200))
    assert entries[-1].time.endswith("Z")
    await rig.run(0.3)
    assert status(rig).log == entries


# -- the trail --------------------------------------------------------------------------------------------------------


def pose(north: float) -> MapPose:
    return MapPose(north, 0, 30, 0, 0, 0)


def test_the_trail_grows_at_its_end_only() -> None:
    trail = Trail()
    former = trail.points
    for step in range(100):
        trail.update(pose(step * 0.4), True, step * 0.1)
        assert trail.points[: len(former)] == former
        former = trail.points
    assert len(trail.points) == 34
    assert trail.distance == pytest.approx(39.6)
    assert trail.flight_time(20.0) == 20.0


@pytest.mark.slow
def test_a_trail_that_grows_too_long_is_thinned_under_a_new_identity() -> None:
    trail = Trail()
    for step in range(MAXIMUM_POINTS + 10):
        trail.update(pose(step * 1.0), True, 0.0)
    assert trail.identity == 1
    assert len(trail.points) < MAXIMUM_POINTS


def test_the_ground_and_what_is_not_finite_leave_no_trail() -> None:
    trail = Trail()
    trail.update(pose(1), False, 0)
    trail.update(pose(math.nan), True, 0)
    trail.update(None, True, 0)
    assert trail.points == ()
    assert trail.flight_time(5) == 5
    trail.update(pose(1), False, 6)
    assert trail.flight_time(7) is None


# -- records, faults, odds and ends ------------------------------------------------------------------------------------


async def test_everything_is_recorded_as_plain_json(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.order(Hold())
    await fresh.run(1)
    kinds = {kind for kind, _ in fresh.records}
    assert kinds >= {"tick", "command", "answer to operator", "state", "target", "vehicle", "start in the air"}
    for _, payload in fresh.records:
        json.loads(to_json(payload), parse_constant=pytest.fail)
    ticks = sum(kind == "tick" for kind, _ in fresh.records)
    assert ticks == fresh.manager.ticks


async def test_a_fault_in_a_task_holds_the_drone_and_is_shown(fresh: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)

    def fail(_: object, __: Facts) -> None:
        raise RuntimeError("boom")

    monkeypatch.setattr(type(fresh.manager.state), "process", fail)
    await fresh.run(0.5)
    fresh.expect(S.HOVER)
    assert fresh.manager.own_health.reason == "Fault in the program: RuntimeError: boom"
    assert status(fresh).parts.health_status is HealthStatus.UNHEALTHY
    targets = len(fresh.autopilot.targets)
    await fresh.run(0.5)
    assert len(fresh.autopilot.targets) > targets


async def test_a_fault_in_the_status_does_not_stop_the_ticks(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(status_room, "options", lambda _: 1 / 0)
    before = rig.manager.ticks
    await rig.tick(20)
    assert rig.manager.ticks == before + 20
    assert not rig.manager.own_health.is_healthy


async def test_a_tick_without_facts_is_no_progress_and_the_next_one_goes_on(
    flying: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = flying.manager.ticks
    with monkeypatch.context() as broken:
        broken.setattr(flying.topics, "get_part_healths", lambda: 1 / 0)
        await flying.run(0.25)
        assert flying.manager.ticks == before
        assert not flying.command(Hold()).accepted
    assert not flying.manager.own_health.is_healthy
    await flying.run(0.5)
    assert flying.manager.ticks == before + 10


async def test_a_fault_while_a_command_is_handled_refuses_it(flying: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command_desk, "refusal", lambda *_: 1 / 0)
    flying.socket.waiting = [("ana", Hold(id=7)), ("ana", OperatorHeartbeat(id=8))]
    before = flying.manager.ticks
    await flying.tick()
    answers = [(a.id, a.accepted) for _, a in flying.socket.replies if isinstance(a, Ack)]
    assert answers == [(7, False), (8, True)]
    assert flying.manager.ticks == before + 1


async def test_a_recording_that_fails_does_not_stop_the_ticks(flying: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(kind: str, payload: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(flying, "record", fail)
    before = flying.manager.ticks
    await flying.run(0.5)
    assert flying.manager.ticks == before + 10
    assert "disk full" in flying.manager.own_health.reason


async def test_commands_through_the_socket_are_answered_to_their_sender(flying: Rig) -> None:
    flying.socket.waiting = [("eve", Arm(id=1)), ("ana", Hold(id="x")), ("ana", OperatorHeartbeat())]
    await flying.tick()
    answers = [(client, a.id, a.accepted) for client, a in flying.socket.replies if isinstance(a, Ack)]
    assert answers == [("eve", 1, False), ("ana", "x", True), ("ana", None, True)]


async def test_the_web_servers_own_commands_are_sent_back(rig: Rig) -> None:
    assert not rig.command(Control(action="Request")).accepted
    assert not rig.command(MapResync()).accepted


async def test_a_command_that_must_wait_does_not_pass_the_queue(flying: Rig) -> None:
    from hawk.comm.protocol.commands import AutonomousMove

    with pytest.raises(ValueError, match="Autonomous Move"):
        flying.manager.handle_now("ana", AutonomousMove(x=1, y=1))


async def test_a_user_error_stays_until_the_next_accepted_command(flying: Rig) -> None:
    flying.sight.lot = False
    await flying.tick()
    flying.command(AutonomousExplore())
    await flying.run(0.3)
    assert status(flying).operation.user_error == 2
    flying.command(Arm())
    await flying.run(0.3)
    assert status(flying).operation.user_error == 2
    flying.order(Hold())
    await flying.run(0.3)
    assert status(flying).operation.user_error == 0


async def test_closing_cancels_what_is_under_way(rig: Rig) -> None:
    rig.autopilot.silent.add("upload_fence")
    rig.order(Arm())
    await rig.tick(2)
    assert rig.manager.requests.is_busy
    await rig.close()
    assert not rig.manager.requests.is_busy
