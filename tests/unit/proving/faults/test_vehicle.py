from __future__ import annotations

import asyncio
import socket
import struct
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.launch import SimulationAddress, SimulationError, SimulationOptions
from proving.faults.fault import Drone
from proving.faults.gnss_error import GnssError
from proving.faults.observer import SYSTEM, Observer
from proving.faults.proxy import HOST, packed
from proving.faults.rig import WELL
from proving.faults.run import ALL
from proving.faults.table_vehicle import VEHICLE
from proving.faults.vehicle import (
    ArduCopter,
    Ports,
    UnknownFaultError,
    VehiclePrograms,
    VehicleStack,
    can_be_given,
    simulation_parameters,
)

HOME = (43.2609, -79.9192, 100.0)
NORTH_DEG = 1.0 / 111_195.0
SIM_STATE = dict.fromkeys(mavlink.MAVLink_sim_state_message.fieldnames, 0.0)
BATTERY = {
    **dict.fromkeys(("id", "battery_function", "type", "temperature", "current_battery", "energy_consumed"), 0),
    "voltages": [0] * 10,
    "current_consumed": 0,
}
BEAT = {"type": 2, "autopilot": 3, "custom_mode": 6, "system_status": 4, "mavlink_version": 3}


def test_the_command_line_has_three_links_and_the_place_of_the_start(tmp_path: Path) -> None:
    copter = ArduCopter(tmp_path / "arducopter", tmp_path / "copter.parm", instance=7)
    command = copter.command((43.26090004, -79.5, 100.0), Ports(daemon=1001, camera=1002, observer=1003, radio=1004))
    assert command == [
        f"{tmp_path}/arducopter",
        "--model=quad",
        "--speedup=1",
        "--home=43.2609000,-79.5000000,100.0,0",
        "--instance=7",
        "--rc-in-port=1004",
        f"--defaults={tmp_path}/copter.parm",
        "--serial0=udpclient:127.0.0.1:1001",
        "--serial1=udpclient:127.0.0.1:1002",
        "--serial2=udpclient:127.0.0.1:1003",
        *(f"--serial{number}=none:0" for number in (5, 6, 7, 8)),
    ]


def test_the_program_is_found_from_another_folder() -> None:
    command = ArduCopter(Path("bin/arducopter"), Path("copter.parm")).command(HOME, Ports(1, 2, 3, 4))
    assert Path(command[0]) == Path.cwd() / "bin/arducopter"
    assert f"--defaults={Path.cwd()}/copter.parm" in command


@pytest.mark.parametrize(
    ("fault", "parameters"),
    [
        (WELL, {"SIM_GPS1_ENABLE": 1.0, "SIM_RC_FAIL": 0.0, "SIM_WIND_T": 1.0, "SIM_WIND_SPD": 0.0}),
        ({"gps": "lost", "radio": "lost"}, {"SIM_GPS1_ENABLE": 0.0, "SIM_RC_FAIL": 1.0}),
        ({"wind": 16.0, "wind_heading_deg": 90.0}, {"SIM_WIND_T": 1.0, "SIM_WIND_SPD": 16.0, "SIM_WIND_DIR": 270.0}),
        ({"battery": 20.0, "stick": 0.5, "camera": "dark"}, {}),
        ({"baro_drift": 0.5}, {"SIM_BARO_DRIFT": 0.5}),
        ({"compass": "lost"}, {f"SIM_MAG{number}_FAIL": 1.0 for number in (1, 2, 3)}),
        ({"battery_rest_v": 10.3}, {"SIM_BATT_VOLTAGE": 10.3}),
        ({"battery_rest_v": 0.0}, {"SIM_BATT_VOLTAGE": 12.6}),
        ({"gps_walk": (0.7, 0.0), "gps_glitch": (0.0, 25.0, 0.0), "motors": "off"}, {}),
    ],
)
def test_faults_of_the_simulated_drone_are_parameters_of_ardupilots_simulation(
    fault: dict[str, Any], parameters: dict[str, float]
) -> None:
    assert simulation_parameters(fault) == parameters


@pytest.mark.parametrize("fault", [{"link": "cut"}, {"ekf_shift": (1.0, 0.0, 0.0)}, {"gps": "odd"}])
def test_a_fault_that_a_real_vehicle_cannot_have_is_named(fault: dict[str, Any]) -> None:
    with pytest.raises(UnknownFaultError, match=next(iter(fault))):
        simulation_parameters(fault)


@pytest.mark.slow
async def test_gnss_of_a_real_vehicle_is_off_by_glitch_and_walk() -> None:
    put: dict[str, float] = {}
    gnss = GnssError(put.__setitem__)
    gnss.take({"gps_glitch": (30.0, 0.0, -4.0)}, 60.0)
    assert put["SIM_GPS1_GLTCH_X"] == pytest.approx(30.0 * NORTH_DEG)
    assert put["SIM_GPS1_GLTCH_Z"] == pytest.approx(4.0)
    gnss.take({"gps_glitch": (0.0, 10.0, 0.0), "gps_walk": (50.0, 0.0)}, 60.0)
    assert put["SIM_GPS1_GLTCH_Y"] == pytest.approx(10.0 * NORTH_DEG * 2.0)
    async with asyncio.timeout(20):
        while put["SIM_GPS1_GLTCH_X"] < 5.0 * NORTH_DEG:  # noqa: ASYNC110 - the walk's own steps are real time
            await asyncio.sleep(0.02)
    gnss.take({"gps_walk": (0.0, 0.0)}, 60.0)
    stopped = put["SIM_GPS1_GLTCH_X"]
    await asyncio.sleep(0.3)
    assert put["SIM_GPS1_GLTCH_X"] == stopped
    gnss.stop()


def test_every_flight_of_the_table_can_be_given_its_faults() -> None:
    given = [step.values for flight in VEHICLE for step in flight.steps if isinstance(step, Drone)]
    assert given
    for values in given:
        simulation_parameters(values)


def test_faults_of_the_link_and_of_the_programs_can_be_given_and_a_broken_estimate_cannot() -> None:
    given = {fault.name: can_be_given(fault) for fault in ALL}
    assert given["GNSS is lost"]
    assert given["the link is cut in both directions"]
    assert given["the battery falls to 15 %"]
    assert not given["the estimate of the position jumps by 25 m"]
    assert not given["the autopilot boots on the ground"]


def test_the_stick_moves_the_throttle_channel_alone(tmp_path: Path) -> None:
    programs = VehiclePrograms(ArduCopter(tmp_path, tmp_path), SimulationOptions(), tmp_path)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind((HOST, 0))
        receiver.settimeout(5.0)
        programs._radio = receiver.getsockname()[1]
        programs.move_stick(0.5)
        pulses = struct.unpack("<16H", receiver.recv(100))
    assert pulses == (0, 0, 1500, *(0,) * 13)


async def test_a_program_that_cannot_be_started_is_named(tmp_path: Path) -> None:
    programs = VehiclePrograms(ArduCopter(tmp_path, tmp_path), SimulationOptions(), tmp_path)
    with pytest.raises(SimulationError, match=r"no-such-program cannot be started: No such file"):
        await programs._spawn([str(tmp_path / "no-such-program")])


def test_the_daemon_keeps_real_time_and_knows_whose_pictures_it_gets(tmp_path: Path) -> None:
    stack = VehicleStack(ArduCopter(tmp_path, tmp_path), SimulationOptions(), tmp_path, None)
    stack.address = SimulationAddress("http://127.0.0.1:1", "udpin://127.0.0.1:2")
    assert stack._attached() == ["--attach-sim", "http://127.0.0.1:1"]


class Autopilot(asyncio.DatagramProtocol):
    """Says what a test lets it say; repeats a parameter after it was set ``deaf`` times."""

    def __init__(self, port: int, deaf: int = 0) -> None:
        self._to = (HOST, port)
        self._deaf = deaf
        self._resets = 0
        self.heard: list[Any] = []
        self.transport: Any = None

    def connection_made(self, transport: Any) -> None:
        self.transport = transport

    def datagram_received(self, data: bytes, _: Any) -> None:
        for found in mavlink.MAVLink(None).parse_buffer(data):
            self.heard.append(found)
            if found.get_type() == "PARAM_SET" and sum(m.get_type() == "PARAM_SET" for m in self.heard) > self._deaf:
                values = {"param_type": 9, "param_count": 1, "param_index": 0}
                self.say("PARAM_VALUE", param_id=found.param_id.encode(), param_value=found.param_value, **values)

            if found.get_type() == "COMMAND_LONG" and found.command == mavlink.MAV_CMD_BATTERY_RESET:
                self._resets += 1
                self.say("BATTERY_STATUS", **BATTERY, battery_remaining=int(found.param2) if self._resets > 1 else 80)

    def say(self, kind: str, **fields: Any) -> None:
        self.transport.sendto(packed(kind, fields, 1), self._to)

    def stand(self, *, north: float = 0.0, height: float = 0.0, armed: bool = False, landed: int = 1) -> None:
        """Say everything of a vehicle at this place, metres from home."""
        latitude = HOME[0] + north * NORTH_DEG
        place = {"lat": latitude, "lon": HOME[1], "lat_int": round(latitude * 1e7), "lon_int": round(HOME[1] * 1e7)}
        self.say("ATTITUDE", time_boot_ms=12_500, roll=0, pitch=0, yaw=0, rollspeed=0, pitchspeed=0, yawspeed=0)
        self.say("SIM_STATE", **(SIM_STATE | place | {"alt": HOME[2] + height}))
        self.say("HEARTBEAT", **BEAT, base_mode=209 if armed else 81)
        self.say("EXTENDED_SYS_STATE", vtol_state=0, landed_state=landed)


@pytest.fixture
async def observed() -> AsyncIterator[tuple[Observer, Autopilot]]:
    observer = Observer()
    autopilot = Autopilot(await observer.open(HOST), deaf=1)
    await asyncio.get_running_loop().create_datagram_endpoint(lambda: autopilot, local_addr=(HOST, 0))
    autopilot.stand()
    await observer.wait_until_heard(HOME, 5.0)
    yield observer, autopilot
    observer.close()
    autopilot.transport.close()


async def until(observer: Observer, **wanted: Any) -> dict[str, Any]:
    for _ in range(500):
        if all(observer.status()[name] == value for name, value in wanted.items()):
            return observer.status()
        await asyncio.sleep(0.01)
    raise AssertionError(f"{wanted} does not come: {observer.status()}")


async def test_nothing_is_said_of_a_vehicle_that_is_not_heard() -> None:
    observer = Observer()
    await observer.open(HOST)
    with pytest.raises(TimeoutError):
        await observer.wait_until_heard(HOME, 0.01)
    observer.close()


async def test_the_truth_is_under_the_names_of_the_simulated_drone(observed: tuple[Observer, Autopilot]) -> None:
    observer, autopilot = observed
    seen = observer.status()
    assert (seen["mode"], seen["landed"], seen["disarmed"], seen["time"]) == ("RTL", True, True, 12.5)
    autopilot.stand(north=30.0, height=20.0, armed=True, landed=2)
    seen = await until(observer, landed=False, disarmed=False)
    assert seen["position"]["height"] == pytest.approx(20.0, abs=0.01)
    assert not seen["crashed"]


async def test_the_farthest_place_outside_the_fence_is_kept(observed: tuple[Observer, Autopilot]) -> None:
    observer, autopilot = observed
    side = 10.0 * NORTH_DEG
    corners = [(HOME[0] + north * side, HOME[1] + east * side) for north, east in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
    observer.watch_fence(corners)
    assert observer.status()["outside"] == 0.0
    autopilot.stand(north=17.0, landed=2)
    assert (await until(observer, landed=False))["outside"] == pytest.approx(7.0, abs=0.1)
    autopilot.stand(north=2.0, landed=1)
    seen = await until(observer, landed=True)
    assert seen["outside"] == 0.0
    assert seen["farthest_outside"] == pytest.approx(7.0, abs=0.1)
    observer.watch_fence(corners)
    assert observer.status()["farthest_outside"] == 0.0


@pytest.mark.parametrize(
    ("text", "crashed"),
    [
        ("SIM Hit ground at 0.531000 m/s", False),
        ("SIM Hit ground at 11.200000 m/s", True),
        ("Crash: Disarming: AngErr=56>30, Accel=1.0<3.0", True),
        ("Landing", False),
    ],
)
async def test_a_hard_landing_is_a_crash(observed: tuple[Observer, Autopilot], text: str, crashed: bool) -> None:
    observer, autopilot = observed
    autopilot.say("STATUSTEXT", severity=4, text=text.encode())
    autopilot.stand(landed=2)
    assert (await until(observer, landed=False))["crashed"] is crashed


@pytest.mark.slow
async def test_a_parameter_is_set_again_until_the_autopilot_repeats_it(observed: tuple[Observer, Autopilot]) -> None:
    observer, autopilot = observed
    await observer.set_parameter("SIM_WIND_SPD", 16.0)
    sets = [found for found in autopilot.heard if found.get_type() == "PARAM_SET"]
    assert [(found.param_id, found.param_value) for found in sets] == [("SIM_WIND_SPD", 16.0)] * 2
    assert {found.get_srcSystem() for found in sets} == {SYSTEM}


@pytest.mark.slow
async def test_the_charge_is_set_again_until_the_autopilot_says_so(observed: tuple[Observer, Autopilot]) -> None:
    observer, autopilot = observed
    await observer.set_charge(21.0)
    resets = [found for found in autopilot.heard if found.get_type() == "COMMAND_LONG" and found.command == 42651]
    assert [(found.param1, found.param2) for found in resets] == [(1.0, 21.0)] * 2
