"""``--autopilot udpin://HOST:PORT``: the vehicle that sends there; without it, hawk-sim is started."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field

import pytest

from tests.contract.vehicle import ArduPilotFaults, Relay, SimulatedFaults, Vehicle, relay_for
from tests.integration.sim_support import simulation, small_picture

SPEED = 4.0
"""hawk-sim's seconds in a real one: MAVSDK's heartbeat, once a real second, must not seem lost."""
SAME_DEG = 1e-4
SIM_GNSS_WAIT_S = 24.0


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--autopilot", metavar="URL", help="udpin://HOST:PORT to which a vehicle sends; default: hawk-sim")
    parser.addoption(
        "--rc-input",
        metavar="HOST:PORT",
        default="127.0.0.1:5501",
        help="where that vehicle's simulation takes RC input",
    )


@dataclass(slots=True)
class Boot:
    """Observations of a boot. Seconds are the vehicle's, since it was heard again."""

    connected_through: bool = False
    cached_health: bool = False
    cached_position: bool = False
    first_messages: set[str] = field(default_factory=set)
    all_ok_at_first: bool = True
    armable_at: float = 0.0
    all_ok_at: float = 0.0


@pytest.fixture(scope="package")
def connected(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Vehicle]:
    """The vehicle, ready to arm. It ends with the last test of this folder, not of the session."""
    url = request.config.getoption("--autopilot", None)
    rc_input = request.config.getoption("--rc-input", "")
    with contextlib.ExitStack() as stack:
        if url is not None:
            vehicle = Vehicle(relay_for(url), 1.0, lambda made: ArduPilotFaults(made.write, rc_input))
        else:
            relay = Relay("127.0.0.1", 0)
            world = small_picture(tmp_path_factory.mktemp("contract"))
            ready = stack.enter_context(
                simulation(
                    f"--world={world}",
                    "--metres-per-pixel=0.5",
                    f"--speed={SPEED}",
                    "--gnss-sigma=0",
                    f"--gnss-wait={SIM_GNSS_WAIT_S}",
                    f"--mavlink=udpout:127.0.0.1:{relay.port}",
                )
            )
            vehicle = Vehicle(relay, SPEED, lambda _: SimulatedFaults(ready["http"]))
        stack.callback(vehicle.close)
        try:
            vehicle.ready(60.0)
        except TimeoutError:  # a failsafe of an earlier run forbids to arm until it boots
            vehicle.reboot()
        yield vehicle


def watched_boot(vehicle: Vehicle) -> Boot:
    """Boot the vehicle, first under the eyes of a MAVSDK that knows it, then of a new one."""
    boot = Boot()
    old = vehicle.pilot
    before = old.telemetry.position()
    connected = len(old.connected)
    old.action.reboot()
    old.pause(1.0)  # what the old program sent has come
    old.forget()
    old.wait(lambda: old.counts.get("HEARTBEAT", 0) >= 3, 60.0)
    boot.connected_through = old.system.is_connected() and old.connected[connected:] == []
    boot.cached_health = old.telemetry.health_all_ok()
    now = old.telemetry.position()
    boot.cached_position = abs(now.latitude_deg - before.latitude_deg) < SAME_DEG
    new = vehicle.connect_again()
    new.wait(lambda: new.counts.get("HEARTBEAT", 0) >= 2)
    boot.first_messages = set(old.messages) | set(new.messages)
    boot.all_ok_at_first = new.telemetry.health_all_ok()
    new.telemetry.set_rate_health(10.0)
    boot.armable_at = vehicle.wait(lambda: new.telemetry.health().is_armable or new.telemetry.health_all_ok(), 90.0)
    boot.all_ok_at = boot.armable_at + vehicle.wait(new.telemetry.health_all_ok, 90.0)
    vehicle.ready()
    return boot


@pytest.fixture(scope="package")
def boot(connected: Vehicle) -> Boot:
    """Observations of a boot."""
    return watched_boot(connected)


@pytest.fixture
def vehicle(connected: Vehicle) -> Iterator[Vehicle]:
    """The vehicle; afterwards its link and its parameters are as before."""
    try:
        yield connected
    finally:
        connected.restore()


@pytest.fixture
def grounded(vehicle: Vehicle) -> Vehicle:
    """The vehicle on the ground in STABILIZE, motors off, ready to arm."""
    vehicle.land()
    vehicle.wait(lambda: vehicle.pilot.telemetry.health().is_armable, 60.0)
    vehicle.set_mode(0)
    return vehicle


@pytest.fixture
def flying(vehicle: Vehicle) -> Vehicle:
    """The vehicle in the air in GUIDED, 10 m over home."""
    vehicle.fly()
    return vehicle
