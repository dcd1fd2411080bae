"""The real MAVSDK 4.1 flies hawk-sim, four times as fast as real."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from mavsdk.plugins.action import ActionError
from mavsdk.plugins.geofence import FenceType, GeofenceData, Point, Polygon
from mavsdk.plugins.offboard import Offboard, OffboardError
from mavsdk.plugins.param import ParamError
from mavsdk.plugins.telemetry import TelemetryError

from tests.integration.sim_support import Pilot, free_udp_port, get_json, simulation, small_picture
from tests.pace import speed_here

pytestmark = pytest.mark.integration
SPEED = speed_here(4.0)


@dataclass(frozen=True, slots=True)
class Flight:
    pilot: Pilot
    http: str


@pytest.fixture
def flight(tmp_path: Path) -> Iterator[Flight]:
    port = free_udp_port()
    with simulation(
        f"--world={small_picture(tmp_path)}",
        "--metres-per-pixel=0.5",
        f"--speed={SPEED}",
        "--gnss-sigma=0",
        "--gnss-wait=2",
        f"--mavlink=udpout:127.0.0.1:{port}",
    ) as ready:
        pilot = Pilot(f"udpin://127.0.0.1:{port}")
        try:
            yield Flight(pilot, ready["http"])
        finally:
            pilot.close()


def test_a_whole_flight(flight: Flight) -> None:
    pilot = flight.pilot
    assert not pilot.telemetry.health_all_ok()
    pilot.ready()
    pilot.parameters.set_param_int("RTL_ALT", 700)
    pilot.take_off(7.0)
    assert pilot.messages["HEARTBEAT"]["custom_mode"] == 4
    x, y, z = pilot.local
    pilot.target(x + 15.0, y - 8.0, z, 0.5)
    taken = pilot.wait(lambda: math.dist(pilot.local, (x + 15.0, y - 8.0, z)) < 0.3, 10.0)
    assert taken * SPEED < 12.0
    pilot.action.return_to_launch()
    pilot.wait(lambda: not pilot.messages["HEARTBEAT"]["base_mode"] & 128, 40.0)
    assert math.hypot(*pilot.local[:2]) < 1.0
    pilot.wait(lambda: pilot.landed == [1, 3, 2, 4, 1], 5.0)
    status = get_json(f"{flight.http}/status")
    assert (status["landed"], status["disarmed"], status["crashed"]) == (True, True, False)
    assert 30.0 < status["distance_flown_m"] < 45.0


def test_arming_again_after_the_return_needs_guided_first(flight: Flight) -> None:
    pilot = flight.pilot
    pilot.ready()
    pilot.take_off(5.0)
    pilot.action.hold()
    assert pilot.wait(lambda: pilot.messages["HEARTBEAT"]["custom_mode"] == 17, 3.0) < 2.0
    pilot.action.land()
    pilot.wait(lambda: not pilot.messages["HEARTBEAT"]["base_mode"] & 128, 20.0)
    pilot.action.hold()
    pilot.wait(lambda: pilot.telemetry.flight_mode().name == "HOLD", 3.0)
    with pytest.raises(ActionError, match="FAILED"):
        pilot.action.arm()
    pilot.wait(lambda: "Arm: BRAKE mode not armable" in pilot.texts, 2.0)
    pilot.guided()
    pilot.action.arm()
    pilot.wait(lambda: bool(pilot.messages["HEARTBEAT"]["base_mode"] & 128), 2.0)


def test_the_fence_is_uploaded_read_back_and_keeps_the_drone_in(flight: Flight) -> None:
    pilot = flight.pilot
    pilot.ready()
    home = pilot.telemetry.home()
    north, east = 20.0 / 111_100.0, 20.0 / 81_100.0
    corners = [
        Point(home.latitude_deg + a * north, home.longitude_deg + b * east)
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    pilot.geofence.upload_geofence(GeofenceData([Polygon(corners, FenceType.INCLUSION)], []))
    assert len(pilot.geofence.download_geofence().polygons[0].points) == 4
    assert pilot.parameters.get_param_int("FENCE_ENABLE") == 0
    pilot.parameters.set_param_int("FENCE_ENABLE", 1)
    pilot.take_off(8.0)
    altitude = home.absolute_altitude_m + 8.0
    with pytest.raises(ActionError, match="FAILED"):
        pilot.action.goto_location(home.latitude_deg + 2 * north, home.longitude_deg, altitude, 0.0)
    pilot.target(40.0, 0.0, -8.0)
    seen = pilot.counts["LOCAL_POSITION_NED"]
    pilot.wait(lambda: pilot.counts["LOCAL_POSITION_NED"] > seen + 80)
    assert math.hypot(*pilot.local[:2]) < 0.5
    pilot.action.goto_location(home.latitude_deg + north / 2, home.longitude_deg, altitude, 0.0)
    pilot.wait(lambda: abs(pilot.local[0] - 10.0) < 0.5, 10.0)


def test_parameters_are_strict_about_types(flight: Flight) -> None:
    pilot = flight.pilot
    assert pilot.parameters.get_param_int("RTL_ALT") == 1500
    with pytest.raises(ParamError, match="WRONG_TYPE"):
        pilot.parameters.set_param_float("RTL_ALT", 3000.0)
    assert pilot.parameters.get_param_int("RTL_ALT") == 3000
    with pytest.raises(ParamError, match="TIMEOUT"):
        pilot.parameters.get_param_float("RTL_ALT_M")
    pilot.action.set_return_to_launch_altitude(25.0)
    assert pilot.parameters.get_param_int("RTL_ALT") == 2500


def test_refusals(flight: Flight) -> None:
    pilot = flight.pilot
    pilot.ready()
    with pytest.raises(TelemetryError, match="COMMAND_DENIED"):
        pilot.telemetry.set_rate_altitude(5.0)
    with pytest.raises(ActionError, match="FAILED"):
        pilot.action.takeoff()
    with pytest.raises(OffboardError, match="NO_SETPOINT_SET"):
        Offboard(pilot.system).start()
    assert pilot.command(176, 1, 99) == 4
    pilot.action.arm_force()
    pilot.forget()
    pilot.wait(lambda: pilot.counts.get("HEARTBEAT", 0) >= 2)
    assert not pilot.messages["HEARTBEAT"]["base_mode"] & 128
    pilot.take_off(5.0)
    with pytest.raises(ActionError, match="FAILED"):
        pilot.action.disarm()
    with pytest.raises(ActionError, match="FAILED"):
        pilot.action.takeoff()


@pytest.mark.parametrize("how", ["kill", "terminate"])
def test_kill_cuts_the_motors(flight: Flight, how: str) -> None:
    pilot = flight.pilot
    pilot.ready()
    pilot.take_off(10.0)
    getattr(pilot.action, how)()
    pilot.wait(lambda: not pilot.messages["HEARTBEAT"]["base_mode"] & 128, 2.0)
    pilot.wait(lambda: get_json(f"{flight.http}/status")["crashed"], 5.0)
    assert get_json(f"{flight.http}/status")["disarmed"]


def test_a_silent_link_is_noticed_and_comes_back(flight: Flight) -> None:
    pilot = flight.pilot
    pilot.ready()
    get_json(f"{flight.http}/fault", {"link": "cut"})
    # MAVSDK notices the silence after about 2.6 s
    assert 1.5 < pilot.wait(lambda: pilot.connected == [False], 8.0) < 5.0
    get_json(f"{flight.http}/fault", {"link": "ok"})
    pilot.wait(lambda: pilot.connected == [False, True], 5.0)
    pilot.guided()


def test_a_reboot_loses_the_rates_and_mavsdk_stays_connected(flight: Flight) -> None:
    pilot = flight.pilot
    pilot.ready()
    pilot.action.reboot()
    pilot.forget()
    pilot.wait(lambda: pilot.counts.get("HEARTBEAT", 0) > 4)
    assert pilot.system.is_connected()
    assert "ATTITUDE" not in pilot.messages
    assert "LOCAL_POSITION_NED" not in pilot.messages
    pilot.ready()
    assert pilot.messages["LOCAL_POSITION_NED"]["time_boot_ms"] < 60_000


def test_the_ground_station_failsafe_brings_it_home_when_mavsdk_dies(flight: Flight) -> None:
    pilot = flight.pilot
    pilot.ready()
    pilot.parameters.set_param_int("FS_GCS_ENABLE", 1)
    pilot.parameters.set_param_int("SYSID_MYGCS", 245)
    pilot.take_off(8.0)
    get_json(f"{flight.http}/fault", {"link": "cut"})
    cut = time.monotonic()
    while get_json(f"{flight.http}/status")["mode"] != "RTL":
        assert time.monotonic() - cut < 7.0
        pilot.pause(0.1)
    assert time.monotonic() - cut > 3.5
