"""One vehicle for the whole suite: MAVSDK, a relay that can cut the link, and faults of hawk-sim or ArduCopter."""

from __future__ import annotations

import contextlib
import math
import select
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Protocol
from urllib.parse import urlsplit

from mavsdk.plugins.action import ActionError
from mavsdk.plugins.param import ParamError

from tests.integration.sim_support import Pilot, free_udp_port, get_json

ARMED = 128
STABILIZE, GUIDED, LOITER, RTL, LAND, POSHOLD, BRAKE, SMART_RTL = 0, 4, 5, 6, 9, 16, 17, 21
ON_GROUND, IN_AIR, TAKING_OFF, LANDING = 1, 2, 3, 4
"""LANDED_STATE of MAVSDK and MAVLink."""
SLACK_S = 10.0
"""Real seconds that a wait may take beyond its own: other programs use the machine, too."""
HEIGHT = 10.0
METRES_A_DEGREE = 111_100.0
ASK_AGAIN_S = 8.0
STREAMS = {"HEARTBEAT", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "ATTITUDE", "EXTENDED_SYS_STATE"}


class Relay:
    """Passes datagrams between the vehicle and MAVSDK, each at a port of its own. Each direction can be cut."""

    def __init__(self, host: str, port: int) -> None:
        self.uplink = True
        """To the vehicle."""
        self.downlink = True
        self.on_downlink: Callable[[bytes], None] = lambda _: None
        """Gets every datagram of the vehicle, on the relay's thread."""
        self._outside = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._outside.bind((host, port))
        self._inside = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._inside.bind(("127.0.0.1", 0))
        self._mavsdk = ("127.0.0.1", free_udp_port())
        self.url = f"udpin://127.0.0.1:{self._mavsdk[1]}"
        self.port = int(self._outside.getsockname()[1])
        self._vehicle: Any = None
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="relay", daemon=True)
        self._thread.start()

    def write(self, data: bytes) -> None:
        """Send a datagram to the vehicle on the same link, as another component behind it would."""
        if self._vehicle is not None:
            self._outside.sendto(data, self._vehicle)

    def close(self) -> None:
        """End the thread and close the sockets."""
        self._ended.set()
        self._thread.join()
        self._outside.close()
        self._inside.close()

    def _run(self) -> None:
        while not self._ended.is_set():
            for ready in select.select([self._outside, self._inside], [], [], 0.1)[0]:
                with contextlib.suppress(ConnectionError):
                    data, sender = ready.recvfrom(65535)
                    if ready is self._outside:
                        self._vehicle = sender
                        self.on_downlink(data)
                    target = self._mavsdk if ready is self._outside else self._vehicle
                    is_open = self.downlink if ready is self._outside else self.uplink
                    if target is not None and is_open:
                        (self._inside if ready is self._outside else self._outside).sendto(data, target)


class Faults(Protocol):
    """Faults of a vehicle."""

    def radio(self, present: bool) -> None:
        """Switch the remote control on or off."""

    def mode_switch(self, pulse: int) -> None:
        """Move the pilot's mode switch: a pulse of channel 5, microseconds."""

    def gps(self, receiving: bool) -> None:
        """Let the GPS receive or not."""

    def battery_low(self, low: bool) -> None:
        """Make the battery's voltage low, or as it was."""

    def barometer_rises(self, speed: float) -> None:
        """Let the barometer's height rise by itself, m/s."""

    def compasses(self, work: bool) -> None:
        """Let all compasses work or fail."""

    def repair(self) -> None:
        """Put a crashed vehicle back on its feet."""


class SimulatedFaults:
    """Faults of hawk-sim."""

    def __init__(self, http: str) -> None:
        self._http = http

    def radio(self, present: bool) -> None:
        """Switch the remote control on or off."""
        self._fault(radio="ok" if present else "lost")

    def mode_switch(self, pulse: int) -> None:
        """Move the pilot's mode switch to the position of a pulse."""
        self._fault(mode_switch=1 + sum(pulse > last for last in (1230, 1360, 1490, 1620, 1749)))

    def gps(self, receiving: bool) -> None:
        """Let the GPS receive or not."""
        self._fault(gps="ok" if receiving else "lost")

    def battery_low(self, low: bool) -> None:
        """Make the battery's charge low, or full."""
        self._fault(battery=15.0 if low else 100.0)

    def barometer_rises(self, speed: float) -> None:
        """Let the barometer's height rise by itself, m/s."""
        self._fault(baro_drift=speed)

    def compasses(self, work: bool) -> None:
        """Let all compasses work or fail."""
        self._fault(compass="ok" if work else "lost")

    def repair(self) -> None:
        """Put a crashed vehicle back on its feet."""
        self._fault(repair=True)

    def _fault(self, **fields: Any) -> None:
        answer = get_json(f"{self._http}/fault", fields)
        assert not answer.get("problems"), answer


class ArduPilotFaults:
    """Faults of ArduPilot's own simulation, by its SIM parameters."""

    def __init__(self, set_parameter: Callable[[str, float], None], rc_input: str) -> None:
        """``rc_input``: HOST:PORT (UDP) that takes 16 pulses as little-endian unsigned shorts; 5501 + 10 * instance."""
        self._set = set_parameter
        host, _, port = rc_input.rpartition(":")
        self._rc_input = (host, int(port))

    def radio(self, present: bool) -> None:
        """Switch the remote control on or off."""
        self._set("SIM_RC_FAIL", 0 if present else 1)

    def mode_switch(self, pulse: int) -> None:
        """Move the pilot's mode switch to a pulse."""
        pulses = (1500, 1500, 1000, 1500, pulse, 1000, 1000, 1800, *(0,) * 8)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.sendto(struct.pack("<16H", *pulses), self._rc_input)

    def gps(self, receiving: bool) -> None:
        """Let the GPS receive or not."""
        self._set("SIM_GPS1_ENABLE", int(receiving))

    def battery_low(self, low: bool) -> None:
        """Make the battery's voltage low, or as it was."""
        self._set("SIM_BATT_VOLTAGE", 10.4 if low else 12.6)

    def barometer_rises(self, speed: float) -> None:
        """Let the barometer's height rise by itself, m/s."""
        self._set("SIM_BARO_DRIFT", speed)

    def compasses(self, work: bool) -> None:
        """Let all compasses work or fail."""
        for number in (1, 2, 3):
            self._set(f"SIM_MAG{number}_FAIL", 0 if work else 1)

    def repair(self) -> None:
        """ArduPilot's vehicle stands on its feet after a fall."""


class Vehicle:
    """The vehicle of the suite and what is known of it. ``speed``: its seconds in a real one."""

    def __init__(self, relay: Relay, speed: float, faults: Callable[[Vehicle], Faults]) -> None:
        self.relay = relay
        self.speed = speed
        self.pilot = Pilot(relay.url)
        self._changed: dict[str, float] = {}
        self.faults = faults(self)

    # --- life ------------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """Disconnect."""
        self.pilot.close()
        self.relay.close()

    def connect_again(self) -> Pilot:
        """Replace MAVSDK by one that has heard nothing yet."""
        self.pilot.close()
        self.pilot = Pilot(self.relay.url)
        return self.pilot

    # --- time ------------------------------------------------------------------------------------------------------

    def wait(self, condition: Callable[[], bool], seconds: float = 30.0) -> float:
        """Wait until something holds; return the vehicle's seconds that it took."""
        return self.pilot.wait(condition, seconds / self.speed + SLACK_S) * self.speed

    def let_pass(self, seconds: float) -> None:
        """Let the vehicle's seconds pass."""
        self.pilot.pause(seconds / self.speed)

    # --- what is heard ---------------------------------------------------------------------------------------------

    @property
    def mode(self) -> int:
        """``custom_mode`` of the last HEARTBEAT."""
        return int(self.pilot.messages["HEARTBEAT"]["custom_mode"])

    @property
    def armed(self) -> bool:
        """The armed bit of the last HEARTBEAT."""
        return bool(self.pilot.messages["HEARTBEAT"]["base_mode"] & ARMED)

    @property
    def landed(self) -> int:
        """LANDED_STATE."""
        return int(self.pilot.messages.get("EXTENDED_SYS_STATE", {}).get("landed_state", 0))

    @property
    def place(self) -> tuple[float, float, float]:
        """EKF-local, metres: north, east, down."""
        return self.pilot.local

    @property
    def from_home(self) -> tuple[float, float]:
        """Metres north and east of home. Home is where the vehicle was armed: a flight before may have ended there."""
        home, here = self.pilot.telemetry.home(), self.pilot.telemetry.position()
        shrunk = math.cos(math.radians(home.latitude_deg))
        north, east = here.latitude_deg - home.latitude_deg, (here.longitude_deg - home.longitude_deg) * shrunk
        return north * METRES_A_DEGREE, east * METRES_A_DEGREE

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Metres per second: north, east, down."""
        message = self.pilot.messages["LOCAL_POSITION_NED"]
        return message["vx"], message["vy"], message["vz"]

    @property
    def seconds(self) -> float:
        """The vehicle's own clock."""
        return float(self.pilot.messages["LOCAL_POSITION_NED"]["time_boot_ms"]) / 1000.0

    def said(self, words: str) -> bool:
        """Return True when the vehicle said these words in a STATUSTEXT."""
        return any(words.lower() in text.lower() for text in list(self.pilot.texts))

    # --- what is done ----------------------------------------------------------------------------------------------

    def ready(self, timeout_s: float = 120.0) -> None:
        """Ask for the streams until they come, and wait until the vehicle is healthy and can be armed; real seconds."""
        deadline = time.monotonic() + timeout_s
        while True:
            self.ask_for_streams()
            try:
                self.pilot.wait(self.is_ready, ASK_AGAIN_S)
            except TimeoutError:
                if time.monotonic() > deadline:
                    raise
            else:
                return

    def ask_for_streams(self) -> None:
        """Ask for the messages that the suite looks at: a vehicle forgets it when it boots."""
        telemetry = self.pilot.telemetry
        telemetry.set_rate_health(5.0)
        telemetry.set_rate_position(5.0)
        telemetry.set_rate_battery(2.0)
        telemetry.set_rate_position_velocity_ned(20.0)
        telemetry.set_rate_attitude_euler(20.0)
        telemetry.set_rate_landed_state(5.0)

    def is_ready(self) -> bool:
        """Return True when all is heard and the vehicle can be armed."""
        telemetry = self.pilot.telemetry
        return set(self.pilot.messages) >= STREAMS and telemetry.health_all_ok() and telemetry.health().is_armable

    def reboot(self) -> None:
        """Boot the vehicle and wait until it can be armed."""
        heard = self.pilot.counts["HEARTBEAT"]
        self.pilot.action.reboot()
        self.pilot.pause(1.0)
        self.wait(lambda: self.pilot.counts["HEARTBEAT"] > heard + 3, 60.0)
        self.pilot.messages.clear()
        self.ready()
        self.wait(lambda: self.landed == ON_GROUND, 10.0)

    def stream(self, message_id: int, hertz: float) -> None:
        """Ask for a message by SET_MESSAGE_INTERVAL."""
        assert self.pilot.command(511, message_id, 1e6 / hertz) == 0

    def set_mode(self, mode: int) -> None:
        """Set a mode by DO_SET_MODE and see it."""
        assert self.pilot.command(176, 1, mode) == 0, f"mode {mode} refused: {self.pilot.texts[-3:]}"
        self.wait(lambda: self.mode == mode, 5.0)

    def land(self) -> None:
        """Land, if it flies, and see the motors off."""
        if self.armed:
            if self.mode not in (LAND, RTL):
                self.set_mode(LAND)
            self.wait(lambda: not self.armed, 120.0)
        self.wait(lambda: self.landed == ON_GROUND, 10.0)

    def fly(self) -> None:
        """Be in the air in GUIDED, still, at 10 m over home."""
        if not (self.armed and self.landed == IN_AIR):
            self.land()
            self.wait(lambda: self.pilot.telemetry.health().is_armable, 60.0)
            self.set_mode(GUIDED)
            self.arm()
            self.pilot.action.set_takeoff_altitude(HEIGHT)
            self.pilot.action.takeoff()
            self.wait(lambda: self.place[2] < 1.0 - HEIGHT and self.landed == IN_AIR, 60.0)
        self.set_mode(GUIDED)  # always: the last HEARTBEAT may be older than the end of an Offboard stream
        self.go(0.0, 0.0, -HEIGHT)

    def arm(self) -> None:
        """Arm, again while the position is still settling after a lost GPS (30 s)."""
        for attempts_left in reversed(range(10)):
            try:
                self.pilot.action.arm()
                return
            except ActionError:
                if not attempts_left:
                    raise
            self.let_pass(3.0)

    def go(self, north: float, east: float, down: float) -> None:
        """Fly to a place in EKF-local, metres, and stand there.

        A set-point of MAVSDK's Offboard that arrives after its end takes the place of a target: that is sent again.
        """
        for attempts_left in reversed(range(3)):
            self.pilot.target(north, east, down)
            try:
                self.wait(lambda: self._stands_at(north, east, down), 40.0)
            except TimeoutError:
                if not attempts_left:
                    raise
            else:
                return

    def _stands_at(self, north: float, east: float, down: float) -> bool:
        return math.dist(self.place, (north, east, down)) < 0.7 and math.hypot(*self.velocity) < 0.3

    # --- parameters ------------------------------------------------------------------------------------------------

    def parameter(self, name: str) -> float:
        """Return a parameter of either type."""
        try:
            return float(self.pilot.parameters.get_param_int(name))
        except ParamError as error:
            if "WRONG_TYPE" not in str(error):
                raise
            return float(self.pilot.parameters.get_param_float(name))

    def knows(self, name: str) -> bool:
        """Return True when there is a parameter of that name."""
        try:
            self.parameter(name)
        except ParamError:
            return False
        return True

    def write(self, name: str, value: float) -> None:
        """Set a parameter of either type."""
        try:
            self.pilot.parameters.set_param_int(name, int(value))
        except ParamError as error:
            if "WRONG_TYPE" not in str(error):
                raise
            self.pilot.parameters.set_param_float(name, float(value))

    def set(self, values: Mapping[str, float]) -> None:
        """Set parameters; `restore` puts them back."""
        for name, value in values.items():
            self._changed.setdefault(name, self.parameter(name))
            self.write(name, value)

    def restore(self) -> None:
        """Mend the link and the vehicle, and put every parameter back."""
        self.relay.uplink = self.relay.downlink = True
        self.wait(self.pilot.system.is_connected, 20.0)
        while self._changed:
            self.write(*self._changed.popitem())

    @property
    def gcs_parameter(self) -> str:
        """Name of the parameter with the ground station's system id."""
        return "MAV_GCS_SYSID" if self.knows("MAV_GCS_SYSID") else "SYSID_MYGCS"

    @contextlib.contextmanager
    def cut(self) -> Iterator[None]:
        """Cut the link in both directions."""
        self.relay.uplink = self.relay.downlink = False
        try:
            yield
        finally:
            self.relay.uplink = self.relay.downlink = True


def relay_for(url: str) -> Relay:
    """Return a relay at a ``udpin://HOST:PORT``. Raises ValueError for another URL."""
    place = urlsplit(url)
    if place.scheme != "udpin" or not place.hostname or place.port is None:
        raise ValueError(f"--autopilot must be udpin://HOST:PORT, not {url!r}: the suite cuts the link to the vehicle")
    return Relay(place.hostname, place.port)
