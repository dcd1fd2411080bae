from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hawk.check.autopilot import look_at_autopilot, not_found_remedy
from hawk.check.result import CheckResult, Outcome, all_passed
from hawk.comm.autopilot import commands
from hawk.comm.autopilot.commands import MavCommand
from hawk.comm.autopilot.mavlink_link import SensorHealth
from hawk.comm.autopilot.vehicle import AutopilotError, FenceRings
from hawk.comm.clock import Clock
from hawk.comm.mavlink.udp_gate import Hearing
from hawk.config.sections import AutopilotSettings, Config
from hawk.model.poses import GlobalPose
from hawk.model.vehicle import CopterMode
from tests.unit.check.fakes import GOOD, FakeReadingLink, FakeVehicle, write_process
from tests.unit.comm.autopilot.test_gimbal import status
from tests.unit.comm.fakes import Said

RC_CHANNELS, GIMBAL_STATUS = 65, 285  # message ids
CONFIG = Config.model_validate({"remote_control": {"required": False}})


async def look(vehicle: FakeVehicle, proc: Path, config: Config = CONFIG) -> dict[str, CheckResult]:
    found = await look_at_autopilot(config, Clock(), vehicle.tools(proc))
    assert all(each.remedy for each in found if each.outcome is not Outcome.PASSED)
    assert all(link.closed for link in vehicle.links)
    return {each.name: each for each in found}


def with_url(url: str) -> Config:
    return Config.model_validate({"autopilot": {"url": url}, "remote_control": {"required": False}})


async def test_an_autopilot_whose_failsafes_are_right_passes(tmp_path: Path) -> None:
    found = await look(FakeVehicle(GOOD), tmp_path)
    assert all_passed(list(found.values())), found
    assert "ArduCopter, quadrotor, mode GUIDED" in found["Autopilot"].value
    assert found["Parameters"].outcome is Outcome.PASSED
    assert found["Ground-station failsafe"].outcome is Outcome.PASSED


@pytest.mark.nightly
async def test_it_only_reads(tmp_path: Path) -> None:
    """Neither a right autopilot nor one whose failsafes are all wrong gets anything but requests."""
    for values in (GOOD, dict.fromkeys(GOOD, 0.0)):
        vehicle = FakeVehicle(values)
        vehicle.settle_s = 1.0  # time to ask for the streams
        await look(vehicle, tmp_path)
        assert {name for name, _ in vehicle.link.sent} == {"PARAM_REQUEST_READ", "COMMAND_LONG"}
        rates = vehicle.link.named("COMMAND_LONG")
        assert {fields["command"] for fields in rates} == {int(MavCommand.SET_MESSAGE_INTERVAL)}
        assert RC_CHANNELS in {fields["param1"] for fields in rates}
        assert (vehicle.link.commanded, vehicle.link.fences) == ([], [])


@pytest.mark.parametrize(
    "act",
    [
        commands.arm,
        commands.disarm,
        commands.kill,
        lambda link: commands.set_mode(link, CopterMode.GUIDED),
        lambda link: commands.send_mode(link, CopterMode.RTL),
        lambda link: commands.takeoff(link, 5.0),
        lambda link: commands.set_home(link, GlobalPose(43.0, -79.0, 100.0)),
        lambda link: link.send("PARAM_SET", {"param_id": "FENCE_ENABLE", "param_value": 0.0, "param_type": 2}),
        lambda link: link.send("SET_POSITION_TARGET_LOCAL_NED", {"x": 0.0}),
        lambda link: link.send("HEARTBEAT", {"type": 6}),
        lambda link: link.upload_fence(FenceRings(((0.0, 0.0), (0.0, 1.0), (1.0, 0.0)), ())),
    ],
)
def test_its_link_refuses_whatever_changes_something(act: Callable[[Any], None]) -> None:
    link = FakeReadingLink("", 245, Clock(), lambda _: None)
    with pytest.raises(AutopilotError, match="only reads"):
        act(link)
    assert (link.sent, link.commanded, link.fences) == ([], [], [])


@pytest.mark.parametrize(("url", "first"), [("udpin://127.0.0.1:14550", False), ("udpout://127.0.0.1:14550", True)])
async def test_our_heartbeats_are_held_back(tmp_path: Path, url: str, first: bool) -> None:
    """An autopilot in the air would miss the station that the check was; a listening peer must hear us once."""
    vehicle = FakeVehicle(GOOD)
    await look(vehicle, tmp_path, with_url(url))
    assert vehicle.link.voices == [first, False]


def gimbal(pitch_deg: float) -> list[tuple[str, dict[str, Any]]]:
    """Messages that show the boot clock, and the gimbal's attitude among them."""
    said = Said()
    own = ("GIMBAL_DEVICE_ATTITUDE_STATUS", status(math.radians(pitch_deg), time_boot_ms=said.ms))
    return [said.attitude(), said.system_time(), said.attitude(), said.system_time(), own]


@pytest.mark.parametrize(
    ("pitch_deg", "outcome", "words"),
    [
        (-87.0, Outcome.PASSED, "looks 3° off straight down"),
        (-60.0, Outcome.WARNING, "looks 30° off straight down"),
        (None, Outcome.FAILED, "not reported"),
    ],
)
async def test_a_gimbal_is_heard_and_points_down(
    tmp_path: Path, pitch_deg: float | None, outcome: Outcome, words: str
) -> None:
    vehicle = FakeVehicle(GOOD)
    vehicle.others = [] if pitch_deg is None else gimbal(pitch_deg)
    config = Config.model_validate({"camera": {"gimbal": True}, "remote_control": {"required": False}})
    found = (await look(vehicle, tmp_path, config))["Gimbal"]
    assert (found.outcome, words in found.value) == (outcome, True), found
    assert "Gimbal" not in await look(vehicle, tmp_path)


@pytest.mark.nightly
async def test_the_attitude_of_a_gimbal_is_asked_for(tmp_path: Path) -> None:
    vehicle = FakeVehicle(GOOD)
    vehicle.settle_s = 1.0
    await look(vehicle, tmp_path, Config.model_validate({"camera": {"gimbal": True}}))
    assert GIMBAL_STATUS in {fields["param1"] for fields in vehicle.link.named("COMMAND_LONG")}


async def test_an_armed_drone_is_left_alone(tmp_path: Path) -> None:
    vehicle = FakeVehicle(GOOD, is_armed=True)
    found = await look(vehicle, tmp_path)
    assert found["Motors"].outcome is Outcome.FAILED
    assert vehicle.link.named("PARAM_REQUEST_READ") == []


async def test_no_answer_to_any_request_points_at_signing(tmp_path: Path) -> None:
    found = await look(FakeVehicle({}), tmp_path)
    assert found["Autopilot"].outcome is Outcome.PASSED
    assert found["Parameters"].outcome is Outcome.FAILED
    assert "signing" in found["Parameters"].remedy
    assert "Ground-station failsafe" not in found


async def test_what_was_not_read_has_not_passed(tmp_path: Path) -> None:
    values = {name: value for name, value in GOOD.items() if name != "FS_EKF_ACTION"}
    found = await look(FakeVehicle(values), tmp_path)
    assert found["Position failsafe"].outcome is Outcome.NOT_LOOKED_AT
    assert found["Parameters"].outcome is Outcome.NOT_LOOKED_AT
    assert "FS_EKF_ACTION" in found["Parameters"].value
    assert not all_passed(list(found.values()))


async def test_an_older_autopilot_lacks_parameters_and_passes(tmp_path: Path) -> None:
    old = {name: value for name, value in GOOD.items() if not name.startswith(("MAV_GCS", "RTL", "RALLY"))}
    old |= {
        "FENCE_ALT_MAX": 100,
        "SYSID_MYGCS": 245,
        "RTL_ALT": 2000,
        "RTL_ALT_FINAL": 0,
        "RTL_CLIMB_MIN": 0,
        "RTL_ALT_TYPE": 0,
    }
    found = await look(FakeVehicle(old), tmp_path)
    assert found["Parameters"].outcome is Outcome.PASSED, found
    assert found["Ground-station failsafe"].outcome is Outcome.PASSED


async def test_what_the_page_sets_is_a_warning_and_what_a_person_must_set_has_failed(tmp_path: Path) -> None:
    found = await look(FakeVehicle({**GOOD, "FS_GCS_ENABLE": 0, "BATT_LOW_VOLT": 0}), tmp_path)
    assert found["Ground-station failsafe"].outcome is Outcome.WARNING
    assert found["Battery thresholds"].outcome is Outcome.FAILED


async def test_a_remote_control_that_is_not_heard_is_a_warning(tmp_path: Path) -> None:
    found = await look(FakeVehicle(GOOD), tmp_path, Config())
    assert found["Remote control"].outcome is Outcome.WARNING


async def test_a_second_sender_fails(tmp_path: Path) -> None:
    vehicle = FakeVehicle(GOOD)
    vehicle.hearing = Hearing("10.0.0.1:5", "10.0.0.9:7 (system 255) sends to the autopilot's port, too.", 3)
    assert (await look(vehicle, tmp_path))["Second sender"].outcome is Outcome.FAILED


@pytest.mark.parametrize(
    ("beat", "words"), [({"autopilot": 12}, "no ArduPilot"), ({"type": 1}, "no copter"), ({"type": 10}, "no copter")]
)
async def test_another_vehicle_fails(tmp_path: Path, beat: dict[str, int], words: str) -> None:
    found = await look(FakeVehicle(GOOD, beat=beat), tmp_path)
    assert found["Autopilot"].outcome is Outcome.FAILED
    assert words in found["Autopilot"].value


@pytest.mark.parametrize(
    ("version", "outcome"), [((4, 6, 2), Outcome.PASSED), ((4, 3, 8), Outcome.WARNING), ((4, 8, 0), Outcome.WARNING)]
)
async def test_the_firmware_is_compared(tmp_path: Path, version: tuple[int, int, int], outcome: Outcome) -> None:
    vehicle = FakeVehicle(GOOD)
    number = version[0] << 24 | version[1] << 16 | version[2] << 8 | 255
    vehicle.others = [("AUTOPILOT_VERSION", {"flight_sw_version": number})]
    found = (await look(vehicle, tmp_path))["Autopilot"]
    assert found.outcome is outcome
    assert "ArduCopter " + ".".join(map(str, version)) in found.value


@pytest.mark.slow
@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("udpin://10.1.2.3:14550", "send to 10.1.2.3:14550"),
        ("udpout://10.1.2.3:14550", "listen at 10.1.2.3:14550"),
        ("tcpout://10.1.2.3:5760", "listen at 10.1.2.3:5760"),
        ("serial:///dev/null:921600", "SERIALn_BAUD"),
    ],
)
async def test_an_autopilot_that_is_not_heard_fails_with_the_remedy_of_its_link(
    tmp_path: Path, url: str, words: str
) -> None:
    found = (await look(FakeVehicle(GOOD, is_heard=False), tmp_path, with_url(url)))["Autopilot"]
    assert found.outcome is Outcome.FAILED
    assert words in found.remedy == not_found_remedy(url)


@pytest.mark.slow
async def test_who_is_heard_in_place_of_a_copter_is_named(tmp_path: Path) -> None:
    vehicle = FakeVehicle(GOOD, is_heard=False)
    vehicle.hearing = Hearing(heard="antenna tracker (ArduPilot), system 2")
    found = (await look(vehicle, tmp_path))["Autopilot"]
    assert found.outcome is Outcome.FAILED
    assert "No copter is heard at" in found.value
    assert "antenna tracker (ArduPilot), system 2" in found.value


@pytest.mark.fault("a second copter on the link")
async def test_another_copter_is_a_warning_until_ours_is_named(tmp_path: Path) -> None:
    vehicle = FakeVehicle(GOOD)
    vehicle.hearing = Hearing(other_vehicles="hexarotor (ArduPilot), system 3")
    found = (await look(vehicle, tmp_path))["Second copter"]
    assert found.outcome is Outcome.WARNING
    assert "hexarotor (ArduPilot), system 3" in found.value
    named = Config(autopilot=AutopilotSettings(vehicle_system_id=1))
    assert "Second copter" not in await look(vehicle, tmp_path, named)


async def test_a_link_of_mavlink_1_fails_with_its_remedy(tmp_path: Path) -> None:
    vehicle = FakeVehicle(GOOD)
    vehicle.health = SensorHealth(True, True, True, True, is_mavlink_1=True)
    found = (await look(vehicle, tmp_path))["MAVLink"]
    assert found.outcome is Outcome.FAILED
    assert "SERIALn_PROTOCOL" in found.remedy


@pytest.mark.slow
async def test_an_unexpected_autopilot_is_named(tmp_path: Path) -> None:
    vehicle = FakeVehicle(GOOD, is_heard=False)
    vehicle.hearing = Hearing("", "10.0.0.9:7 (system 3) sends to the port, but is not the expected autopilot.", 3)
    found = (await look(vehicle, tmp_path))["Autopilot"]
    assert "system 3" in found.value
    assert "vehicle_system_id" in found.remedy


async def test_a_device_that_is_missing_is_named_and_nothing_is_opened(tmp_path: Path) -> None:
    vehicle = FakeVehicle(GOOD)
    found = (await look(vehicle, tmp_path, with_url(f"serial://{tmp_path}/ttyACM0:115200")))["Autopilot"]
    assert found.outcome is Outcome.FAILED
    assert "ttyACM0" in found.value
    assert vehicle.links == []


async def test_a_device_without_permission_names_the_group(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hawk.check.autopilot.os.access", lambda *_: False)  # root may open every device
    device = tmp_path / "ttyAMA0"
    device.touch()
    found = (await look(FakeVehicle(GOOD), tmp_path, with_url(f"serial://{device}:921600")))["Autopilot"]
    assert found.outcome is Outcome.FAILED
    assert "dialout" in found.remedy


async def test_a_device_in_use_is_not_opened(tmp_path: Path) -> None:
    device = tmp_path / "ttyAMA0"
    device.touch()
    write_process(tmp_path, 77, ["mavproxy.py"], [str(device)])
    vehicle = FakeVehicle(GOOD)
    found = (await look(vehicle, tmp_path, with_url(f"serial://{device}:921600")))["Autopilot"]
    assert found.outcome is Outcome.NOT_LOOKED_AT
    assert "mavproxy.py (process 77)" in found.value
    assert vehicle.links == []


async def test_a_running_daemon_keeps_its_autopilot(tmp_path: Path) -> None:
    write_process(tmp_path, 78, ["/opt/python3", "/opt/hawk/.venv/bin/hawk-drone", "--config", "/etc/hawk/config.toml"])
    vehicle = FakeVehicle(GOOD)
    found = (await look(vehicle, tmp_path))["Autopilot"]
    assert found.outcome is Outcome.NOT_LOOKED_AT
    assert "stop hawk-drone" in found.remedy
    assert vehicle.links == []
