"""The checks before flight: each alone keeps the drone on the ground, with its remedy."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest

from hawk.comm.protocol.commands import Arm, Configure, SetFailsafes
from hawk.comm.protocol.heartbeat import CheckItem
from hawk.config.sections import FenceSettings, HeightSettings
from hawk.ddc.parameters.failsafes import watched_names
from hawk.ddc.settings import DdcSettings
from hawk.model.operation import Health, StateName
from hawk.model.plans import HeightParameters
from hawk.model.vehicle import BatteryInfo, Diagnostics
from tests.unit.ddc.fakes import DEFAULT_PARAMETERS, PLACE, SAFE_PARAMETERS, Rig


def check(rig: Rig, name: str) -> CheckItem:
    return next(item for item in rig.manager.situation().checks if item.name == name)


async def test_a_drone_that_is_well_passes_everything(rig: Rig) -> None:
    assert all(item.passed for item in rig.manager.situation().checks)
    assert [item.name for item in rig.manager.situation().checks] == [
        "Motors",
        "Link",
        "Autopilot",
        "GPS",
        "Battery",
        "Survey",
        "Remote control",
        "Camera",
        "Recording",
        "Heights",
        "Fence",
        "Home",
        "Return height",
        "Ground-station failsafe",
        "Pilot keeps control",
        "Remote-control failsafe",
        "Position failsafe",
        "Fence in the autopilot",
        "Autopilot's return",
        "Battery failsafe",
        "Battery thresholds",
    ]
    assert check(rig, "GPS").value == "16 satellites, ±0.9 m"
    assert check(rig, "Fence").value == "290 × 290 m, drone and home inside"
    assert check(rig, "Return height").value == "15 m, ceiling 97 m"


def low_battery(rig: Rig) -> None:
    rig.autopilot.battery = 29.0


def unknown_battery(rig: Rig) -> None:
    rig.autopilot.battery = None


def bad_position(rig: Rig) -> None:
    rig.autopilot.position_good = False


def no_pose(rig: Rig) -> None:
    rig.autopilot.pose_flows = False


def blind(rig: Rig) -> None:
    rig.sight.healthy = False


def high_return(rig: Rig) -> None:
    rig.autopilot.values["RTL_ALT"] = 12_000


def second_sender(rig: Rig) -> None:
    rig.inputs.second_sender.publish("10.0.0.6:5 (system 1) sends, too.")


BREAK: dict[str, Callable[[Rig], None]] = {
    "Battery:29": low_battery,
    "Battery:not known": unknown_battery,
    "Autopilot": bad_position,
    "GPS": no_pose,
    "Camera": blind,
    "Return height:120 m": high_return,
    "Link:10.0.0.6:5 (system 1) sends, too.": second_sender,
}


@pytest.mark.parametrize("what", BREAK)
async def test_one_failed_check_refuses_arm_with_reason_and_remedy(fresh: Rig, what: str) -> None:
    BREAK[what](fresh)
    await fresh.run(6.0)
    name, _, value = what.partition(":")
    failed = check(fresh, name)
    assert not failed.passed
    assert value in failed.value
    assert failed.consequence
    assert failed.remedy
    answer = fresh.command(Arm())
    assert not answer.accepted
    assert answer.reason.startswith(f"{name}: ")
    fresh.expect(StateName.IDLE)
    assert fresh.autopilot.count("arm") == 0


@pytest.mark.parametrize(("name", "value"), [(n, v) for n, v in DEFAULT_PARAMETERS.items() if SAFE_PARAMETERS[n] != v])
@pytest.mark.nightly
async def test_each_failsafe_parameter_alone_refuses_arm(tmp_path: Path, name: str, value: float) -> None:
    rig = Rig(tmp_path, parameters={**SAFE_PARAMETERS, name: value})
    await rig.run(2)
    assert not rig.command(Arm()).accepted
    assert sum(item.remedy_command == "Set Failsafes" for item in rig.manager.situation().checks) == 1
    await rig.close()


@pytest.mark.parametrize(
    "parameters",
    [
        DEFAULT_PARAMETERS,
        {**{n: v for n, v in DEFAULT_PARAMETERS.items() if n != "SYSID_MYGCS"}, "MAV_GCS_SYSID": 255},
        {
            **{n: v for n, v in DEFAULT_PARAMETERS.items() if n not in ("RTL_ALT", "RTL_ALT_FINAL", "RTL_CLIMB_MIN")},
            "RTL_ALT_M": 30,
            "RTL_ALT_FINAL_M": 2,
            "RTL_CLIMB_MIN_M": 0,
        },
    ],
    ids=["before 4.7", "4.7", "metres"],
)
@pytest.mark.nightly
async def test_set_failsafes_makes_the_defaults_safe_and_arm_possible(
    tmp_path: Path, parameters: dict[str, float]
) -> None:
    rig = Rig(tmp_path, parameters=parameters)
    await rig.run(2)
    assert not rig.command(Arm()).accepted
    rig.order(SetFailsafes())
    assert rig.command(SetFailsafes()).reason == "Being set: wait a moment."
    await rig.run(2)
    assert "Failsafes set and read back." in rig.log
    assert rig.first_failed is None
    watched = "MAV_GCS_SYSID" if "MAV_GCS_SYSID" in parameters else "SYSID_MYGCS"
    assert rig.autopilot.values[watched] == 245
    assert rig.autopilot.values["FS_OPTIONS"] == 16
    rig.order(Arm())
    await rig.close()


async def test_a_refused_failsafe_is_reported_in_the_autopilots_words(tmp_path: Path) -> None:
    rig = Rig(tmp_path, parameters=DEFAULT_PARAMETERS)
    await rig.run(2)
    rig.autopilot.refuse["set_parameter"] = "WRONG_TYPE"
    rig.order(SetFailsafes())
    await rig.run(0.5)
    assert (rig.manager.log.entries[-1].text, rig.manager.log.entries[-1].details) == (
        "The failsafes were not set.",
        "WRONG_TYPE",
    )
    assert not rig.command(Arm()).accepted
    await rig.close()


async def test_parameters_that_do_not_answer_have_not_passed(fresh: Rig) -> None:
    fresh.autopilot.refuse["get_parameter"] = "timeout"
    await fresh.run(5)
    assert check(fresh, "Ground-station failsafe").value == "not read yet"
    assert not fresh.command(Arm()).accepted
    asked = Counter(fresh.autopilot.asked("get_parameter"))
    assert set(asked) == set(watched_names({}))
    assert max(asked.values()) <= 2


@pytest.mark.nightly
async def test_a_parameter_that_somebody_changes_is_noticed(rig: Rig) -> None:
    rig.autopilot.values["FENCE_ENABLE"] = 0
    await rig.run(25)
    assert not check(rig, "Fence in the autopilot").passed


async def test_parameters_are_read_again_after_a_lost_link(rig: Rig) -> None:
    rig.autopilot.values["FS_GCS_ENABLE"] = 0
    rig.autopilot.connected = False
    await rig.run(4)
    rig.autopilot.connected = True
    await rig.tick()
    assert not rig.command(Arm()).accepted
    await rig.run(2)
    assert check(rig, "Ground-station failsafe").value == "off (FS_GCS_ENABLE 0)"


@pytest.mark.nightly
async def test_after_a_flight_the_checks_pass_at_once(rig: Rig) -> None:
    rig.order(Arm())
    await rig.run(0.5)
    await rig.run(70)
    rig.autopilot.armed = False
    await rig.tick()
    assert rig.first_failed is None
    before = rig.autopilot.count("get_parameter")
    await rig.run(25)
    assert rig.autopilot.count("get_parameter") > before


async def test_stale_telemetry_does_not_pass(rig: Rig) -> None:
    rig.autopilot.topics.battery.publish(BatteryInfo(90, 16, 1, rig.clock()))
    rig.clock.advance(5.1)
    assert check(rig, "Battery").value == "not known"
    assert not check(rig, "Autopilot").passed
    assert not check(rig, "GPS").passed
    assert not check(rig, "Link").passed


async def test_a_poor_fix_does_not_pass(rig: Rig) -> None:
    rig.autopilot.topics.diagnostics.publish(Diagnostics(True, True, True, True, 3, 6, 3.1, rig.clock()))
    assert check(rig, "GPS").value == "6 satellites, ±3.1 m"
    assert not check(rig, "GPS").passed
    rig.autopilot.topics.diagnostics.publish(Diagnostics(True, True, True, True, 2, 6, 1.0, rig.clock()))
    assert check(rig, "GPS").value.startswith("no fix")


@pytest.mark.fault(
    "a link of MAVLink 1, which has no accuracy of the position",
    "GPS fails with this cause and its remedy (SERIALn_PROTOCOL 2); 255 satellites are an unknown number",
)
async def test_an_accuracy_that_a_link_of_mavlink_1_cannot_send_is_no_poor_fix(rig: Rig) -> None:
    rig.autopilot.topics.diagnostics.publish(
        Diagnostics(True, True, True, True, 3, 10, None, rig.clock(), is_mavlink_1=True)
    )
    found = check(rig, "GPS")
    assert not found.passed
    assert found.value == "10 satellites, accuracy unknown: the link speaks MAVLink 1, which has none"
    assert "SERIALn_PROTOCOL" in found.remedy
    rig.autopilot.topics.diagnostics.publish(Diagnostics(True, True, True, True, 3, 10, None, rig.clock()))
    assert check(rig, "GPS").value == "10 satellites, accuracy unknown"


async def test_an_estimator_that_is_not_well_does_not_pass(rig: Rig) -> None:
    await rig.run(1)
    assert check(rig, "GPS").passed
    rig.autopilot.estimator_fault = "GPS glitch"
    await rig.run(0.2)
    assert not check(rig, "GPS").passed
    assert check(rig, "GPS").value == "16 satellites, ±0.9 m, GPS glitch"


async def test_a_full_disk_does_not_pass(rig: Rig) -> None:
    rig.inputs.recording_health.publish(Health.bad("disk full"))
    assert check(rig, "Recording").value == "disk full"


async def test_heights_above_the_ceiling_do_not_pass(tmp_path: Path) -> None:
    heights = HeightSettings(minimum_m=15, desired_m=35, maximum_m=99, ceiling_m=100)
    rig = Rig(tmp_path, settings=DdcSettings(heights=heights))
    await rig.run(2)
    assert "ceiling" in check(rig, "Heights").consequence
    assert not rig.command(Arm()).accepted
    await rig.close()


async def test_heights_too_low_over_the_declared_obstacle_are_refused_and_do_not_pass(tmp_path: Path) -> None:
    rig = Rig(tmp_path, settings=DdcSettings(heights=HeightSettings(minimum_m=17, highest_obstacle_m=12)))
    await rig.run(2)
    found = check(rig, "Heights")
    assert found.passed
    assert found.value.endswith("highest obstacle 12 m")
    refused = rig.command(Configure(min=16.9, des=20, max=30))
    assert not refused.accepted
    assert refused.reason.startswith("Min: 16.9 m is too low over the highest obstacle")
    rig.topics.heights_pub.publish(HeightParameters(16.9, 20, 30))
    assert not check(rig, "Heights").passed
    assert not rig.command(Arm()).accepted
    await rig.close()


async def test_an_obstacle_that_nobody_declared_is_reported(rig: Rig) -> None:
    assert check(rig, "Heights").value.endswith("no obstacle declared")


def square(path: Path, north: float) -> Path:
    lat, lon, side = PLACE.latitude + north / 111_000, PLACE.longitude, 0.0005
    ring = [[lon - side, lat - side], [lon + side, lat - side], [lon + side, lat + side], [lon - side, lat + side]]
    path.write_text(json.dumps({"type": "Polygon", "coordinates": [[*ring, ring[0]]]}))
    return path


@pytest.mark.parametrize(("north", "passes"), [(0, True), (80, False)])
async def test_the_drone_must_stand_inside_its_fence(tmp_path: Path, north: float, passes: bool) -> None:
    fence = FenceSettings(file=square(tmp_path / "f.geojson", north))
    rig = Rig(tmp_path, settings=DdcSettings(fence=fence))
    await rig.run(2)
    assert check(rig, "Fence").passed is passes
    assert rig.command(Arm()).accepted is passes
    if passes:
        await rig.run(0.5)
        uploaded = rig.autopilot.asked("upload_fence")[0]
        assert len(uploaded.polygon) == 4
        assert uploaded.autopilot_ceiling == 100
    await rig.close()


async def test_checks_are_shown_on_the_ground_only(fresh: Rig) -> None:
    await fresh.run(1)
    assert fresh.manager.status.value is not None
    assert len(fresh.manager.status.value.operation.checks) == len(fresh.manager.situation().checks)
    await fresh.enter(StateName.HOVER)
    assert fresh.manager.status.value.operation.checks == ()
