"""The MAVLink link to one autopilot. Secret: MAVSDK's native binding, its threads and its failures.

Messages go in and out by MAVSDK's ``mavlink_direct`` plugin; its other plugins drop time stamps, ``custom_mode`` and
the acknowledgement's own result. Every call of `Link` may block and belongs on a thread; ``on_message`` is
called on MAVSDK's thread.
"""

from __future__ import annotations

import errno
import json
import logging
import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from mavsdk.exceptions import MavsdkError
from mavsdk.mavsdk import Configuration, Mavsdk
from mavsdk.plugins.geofence import FenceType, Geofence, GeofenceData, Point, Polygon
from mavsdk.plugins.mavlink_direct import MavlinkDirect, MavlinkMessage
from mavsdk.plugins.telemetry import Telemetry
from mavsdk.system import Autopilot as AutopilotKind
from mavsdk.system import Vehicle as VehicleKind

from hawk.comm.autopilot.remote_id import ARM_STATUS, TRANSMITTERS
from hawk.comm.autopilot.vehicle import AutopilotError, Corners, FenceRings, OtherFenceError
from hawk.comm.mavlink.claim import Claim, ClaimedError
from hawk.comm.mavlink.foreign_writes import writes
from hawk.comm.mavlink.frames import AUTOPILOT_COMPONENT, Heartbeat, ground_station_heartbeat
from hawk.comm.mavlink.mavsdk_log import MavsdkLog
from hawk.comm.mavlink.peer import FIRST_HEARD, Expected, PeerKeeper, Roster, several_words
from hawk.comm.mavlink.udp_gate import NOBODY, Hearing, UdpGate, serves
from hawk.config.addresses import SERIAL_KINDS
from hawk.model.sentences import say, words_of
from hawk.runtime.programs import Processes

_LOG = logging.getLogger("hawk.comm.mavsdk")
GROUND_STATION_COMPONENT = 190
"""MAV_COMP_ID_MISSIONPLANNER, the id of ground stations."""

FOREIGN_WRITE = "FOREIGN WRITE"
"""Name of what is overheard."""
_BROADCAST = frozenset({"HEARTBEAT"})
"""Messages without target fields."""


@dataclass(frozen=True, slots=True)
class Message:
    """A MAVLink message of the autopilot: ``fields`` by name (None for NaN), ``arrival`` in seconds of our clock.

    ``sender``: system and component of another station that writes to the autopilot, with ``name`` `FOREIGN_WRITE` and
    the field ``subjects``; None: the autopilot's own word.
    """

    name: str
    fields: Mapping[str, Any]
    arrival: float
    sender: tuple[int, int] | None = None


@dataclass(frozen=True, slots=True)
class SensorHealth:
    """MAVSDK's summary of SYS_STATUS, and the link's protocol."""

    all_ok: bool = False
    armable: bool = False
    global_position_ok: bool = False
    home_position_ok: bool = False
    is_mavlink_1: bool | None = None
    """The autopilot sends MAVLink 1; None where its frames are not seen (serial, TCP)."""


OnMessage = Callable[[Message], None]


def require_finite(values: Mapping[str, Any]) -> None:
    """Raise AutopilotError naming the field that is not finite: a NaN in a set-point crashes ArduCopter."""
    for name, value in values.items():
        if isinstance(value, float) and not math.isfinite(value):
            raise AutopilotError(say("{name} is {value}: not sent", name=name, value=str(value)))


def _require_device(url: str) -> None:
    """Raise AutopilotError for a serial device that is not there: MAVSDK would say so with every attempt."""
    if url.startswith(SERIAL_KINDS):
        device = url.partition("://")[2].rpartition(":")[0]
        if not Path(device).exists():
            raise AutopilotError(
                say(
                    "autopilot.url: {device} is not there: plug the autopilot in, or name another "
                    "(ls /dev/hawk /dev/tty*)",
                    device=device,
                )
            )


def _polygon(corners: Corners, kind: FenceType) -> Polygon:
    return Polygon([Point(latitude, longitude) for latitude, longitude in corners], kind)


def _rings(polygons: Sequence[Polygon], circles: Sequence[Any]) -> FenceRings:
    """Return the rings of a fence that was read. Raises OtherFenceError when it has parts that ours never has."""
    inside, zones = (
        [p for p in polygons if p.fence_type == kind] for kind in (FenceType.INCLUSION, FenceType.EXCLUSION)
    )
    if len(inside) != 1 or len(inside) + len(zones) != len(polygons) or circles:
        raise OtherFenceError(
            say(
                "it has {inside} inclusion polygons, {zones} exclusion polygons and {circles} circles, ours has one "
                "inclusion polygon and no circle",
                inside=len(inside),
                zones=len(zones),
                circles=len(circles),
            )
        )
    first, *others = (
        tuple((point.latitude_deg, point.longitude_deg) for point in each.points) for each in (*inside, *zones)
    )
    return FenceRings(first, tuple(others))


def command_fields(command: int, parameters: Sequence[float]) -> dict[str, Any]:
    """Return the fields of a COMMAND_LONG; missing parameters are zero, never NaN. The link adds the target system."""
    padded = [float(value) for value in parameters] + [0.0] * (7 - len(parameters))
    fields: dict[str, Any] = {f"param{index}": value for index, value in enumerate(padded, start=1)}
    return fields | {"command": command, "confirmation": 0}


class Link:
    """One MAVSDK instance with one connection. Every method may block, except `sensor_health`, `hearing`, `set_voice`.

    UDP goes through `UdpGate`. On the other kinds the autopilot talks first, and MAVSDK's heartbeats end by themselves
    2.6 s after the last word from it.
    """

    def __init__(
        self,
        url: str,
        system_id: int,
        clock: Callable[[], float],
        on_message: OnMessage,
        expected: Expected = FIRST_HEARD,
    ) -> None:
        self._url = url
        self._expected = expected
        self._claim = Claim(url)
        self._gate: UdpGate | None = None
        self._vehicle_id: int | None = None
        self._roster = Roster(system_id)
        self._listeners: dict[int, MavlinkDirect] = {}  # by system id
        self._system_id = system_id
        self._clock = clock
        self._on_message = on_message
        self._lock = threading.Lock()
        self._mavsdk: Mavsdk | None = None
        self._mavsdk_log = MavsdkLog()
        self._connection: Any = None
        self._speaks = True
        self._system: Any = None
        self._direct: MavlinkDirect | None = None
        self._geofence: Geofence | None = None
        self._telemetry: Telemetry | None = None
        self._closed = False
        self.found = False
        """True once an autopilot was found on the link."""

    def open(self) -> None:
        """Start MAVSDK and open the connection. Raises AutopilotError with the URL when it cannot be opened."""
        with self._lock:
            if self._closed or self._connection is not None:
                return
            _require_device(self._url)
            if self._mavsdk is None:
                self._mavsdk_log.subscribe()
                always = serves(self._url)  # a listening peer hears of us by our first heartbeat
                configuration = Configuration.create_manual(self._system_id, GROUND_STATION_COMPONENT, always)
                self._mavsdk = Mavsdk(configuration)
                configuration.destroy()
            try:
                self._claim.take()
                self._connection = self._connect(self._mavsdk)
            except ClaimedError as error:
                raise AutopilotError(
                    say(
                        "autopilot.url {url} cannot be opened: {error}; two must not fly one drone. Stop one of them, "
                        "or name another autopilot",
                        url=repr(self._url),
                        error=words_of(error),
                    )
                ) from error
            except (MavsdkError, OSError, ValueError) as error:
                url, holder = repr(self._url), self._port_holder(error)
                raise AutopilotError(
                    say(
                        "autopilot.url {url} cannot be opened: {error}: by {holder}",
                        url=url,
                        error=str(error),
                        holder=holder,
                    )
                    if holder
                    else say("autopilot.url {url} cannot be opened: {error}", url=url, error=str(error))
                ) from error

    def set_voice(self, speaks: bool) -> None:
        """Let our heartbeats go out, or hold them back. Does not block."""
        self._speaks = speaks
        gate = self._gate
        if gate is not None:
            gate.speaks = speaks

    def find(self, timeout_s: float) -> bool:
        """Wait for the heartbeat of a copter and subscribe to it; return False when none came in time."""
        mavsdk = self._mavsdk
        if mavsdk is None or self._closed:
            return False
        system = self._vehicle(mavsdk, timeout_s)
        if system is None:
            return False
        with self._lock:
            if self._closed or self.found:
                return self.found
            self._system = system
            self._vehicle_id = int(system.get_system_id())
            self._telemetry = Telemetry(system)
            self._geofence = Geofence(system)
            direct = MavlinkDirect(system)
            direct.subscribe_message("", self._receive)
            self._direct = direct
            self.found = True
        return True

    def look_around(self) -> None:
        """Listen to the signs of life of every system on the link, also of those that came since."""
        with self._lock:
            if self._mavsdk is None or self._closed:
                return
            for system in self._mavsdk.get_systems():
                number = int(system.get_system_id())
                if number not in self._listeners:
                    self._listeners[number] = direct = MavlinkDirect(system)
                    direct.subscribe_message("HEARTBEAT", self._note)

    def reopen(self) -> None:
        """Remove the connection and add it again: MAVSDK's subscriptions survive it.

        The gate of a UDP port has nothing to reopen, and keeps the autopilot's address.
        """
        with self._lock:
            if self._mavsdk is not None and self._connection is not None and self._gate is None:
                self._mavsdk.remove_connection(self._connection)
                self._connection = None
        self.open()

    def close(self) -> None:
        """End MAVSDK and its threads. Closing twice is no error."""
        with self._lock:
            self._closed = True
            mavsdk, self._mavsdk = self._mavsdk, None
            gate, self._gate = self._gate, None
            self._direct = self._geofence = self._telemetry = self._system = self._connection = None
            self._listeners.clear()
            self.found = False
        if mavsdk is not None:
            mavsdk.destroy()
            self._mavsdk_log.unsubscribe()
        if gate is not None:
            gate.close()
        self._claim.release()

    @property
    def vehicle_id(self) -> int | None:
        """MAVLink system id of the autopilot that was found; None before."""
        return self._vehicle_id

    def hearing(self) -> Hearing:
        """Return who is heard. Does not block."""
        gate, now = self._gate, time.monotonic()
        found = NOBODY if gate is None else gate.hearing
        vehicle, twin = self._vehicle_id, self._roster.twin(now)
        words: str = (
            say("{twin}, has our own MAVLink id: is it another hawk-drone on this autopilot?", twin=twin)
            if twin
            else ""
        )
        others = "" if vehicle is None else self._roster.other_vehicles(vehicle, now)
        several = self._roster.several(now) if self._expected.system_id is None else ""
        words = several_words(several) if several else words
        second = found.second_sender or words
        return replace(found, second_sender=second, heard=self._roster.names(now), other_vehicles=others)

    def send(self, name: str, fields: Mapping[str, Any]) -> None:
        """Send one message and do not wait (0.2 ms over UDP). Raises AutopilotError when it could not be sent."""
        require_finite(fields)
        direct, target = self._target()
        try:
            direct.send_message(_message(name, fields, target))
        except (MavsdkError, RuntimeError) as error:
            raise AutopilotError(say("{name} was not sent: {words}", name=name, words=_words(error))) from error

    def command(self, command: int, parameters: Sequence[float] = ()) -> int:
        """Send a COMMAND_LONG, wait for its acknowledgement (2 s at most) and return its MAV_RESULT."""
        direct, target = self._target()
        fields = command_fields(command, parameters)
        require_finite(fields)
        try:
            answer = direct.send_command(_message("COMMAND_LONG", fields, target))
            return int(json.loads(answer.fields_json)["result"])
        except (MavsdkError, RuntimeError) as error:
            raise AutopilotError(say("The autopilot did not answer: {words}", words=_words(error))) from error
        except (ValueError, KeyError) as error:
            raise AutopilotError(say("The autopilot's answer cannot be read: {error}", error=str(error))) from error

    def upload_fence(self, rings: FenceRings) -> None:
        """Replace the fence by an inclusion polygon and its exclusion polygons. Raises AutopilotError."""
        geofence = self._geofence
        if geofence is None:
            raise AutopilotError(say("No autopilot found yet."))
        polygons = [_polygon(rings.inclusion, FenceType.INCLUSION)]
        polygons += [_polygon(ring, FenceType.EXCLUSION) for ring in rings.exclusions]
        try:
            geofence.upload_geofence(GeofenceData(polygons, []))
        except (MavsdkError, RuntimeError) as error:
            raise AutopilotError(say("The fence was not taken: {words}", words=_words(error))) from error

    def download_fence(self) -> FenceRings:
        """Return the inclusion polygon that the autopilot holds, with its exclusion polygons.

        Raises:
            AutopilotError: It does not answer, or its fence is anything else than one inclusion polygon with exclusion
                polygons.
        """
        geofence = self._geofence
        if geofence is None:
            raise AutopilotError(say("No autopilot found yet."))
        try:
            found = geofence.download_geofence()
        except (MavsdkError, RuntimeError) as error:
            raise AutopilotError(
                say("The fence cannot be read from the autopilot: {words}", words=_words(error))
            ) from error
        return _rings(found.polygons or [], found.circles or [])

    def sensor_health(self) -> SensorHealth:
        """Return MAVSDK's cached summary. Does not block."""
        telemetry = self._telemetry
        if telemetry is None:
            return SensorHealth()
        try:
            health = telemetry.health()
            return SensorHealth(
                all_ok=bool(telemetry.health_all_ok()),
                armable=bool(health.is_armable),
                global_position_ok=bool(health.is_global_position_ok),
                home_position_ok=bool(health.is_home_position_ok),
                is_mavlink_1=self.hearing().is_mavlink_1,
            )
        except RuntimeError:  # destroyed meanwhile
            return SensorHealth()

    def _port_holder(self, error: Exception) -> str:
        """Return words for the program that has the port, when that is the reason."""
        port = urlsplit(self._url).port if getattr(error, "errno", None) == errno.EADDRINUSE else None
        return "" if port is None else Processes().holder_of_port("udp", port)

    def _connect(self, mavsdk: Mavsdk) -> Any:
        if not serves(self._url):
            return mavsdk.add_any_connection_with_handle(self._url)
        if self._gate is None:
            greeting = ground_station_heartbeat(self._system_id, GROUND_STATION_COMPONENT)
            self._gate = UdpGate(self._url, PeerKeeper(self._expected), greeting, overhear=self._overhear)
        self._gate.speaks = self._speaks
        return self._gate.attach(mavsdk.add_any_connection_with_handle)

    def _vehicle(self, mavsdk: Mavsdk, timeout_s: float) -> Any:
        """Return the expected copter; None when it was not heard in time."""
        if mavsdk.first_autopilot(timeout_s) is None:
            return None
        self.look_around()
        gate = self._gate
        if gate is not None:
            wanted = gate.system_id  # by the type in its heartbeat, too
            fitting = [system for system in mavsdk.get_systems() if wanted in (None, system.get_system_id())]
            return next((system for system in fitting if system.has_autopilot()), None)
        wanted = self._expected.system_id
        number = self._roster.vehicle(wanted, time.monotonic(), self._expected.wait_s)
        systems = [system for system in mavsdk.get_systems() if wanted in (None, system.get_system_id())]
        if number is None and (wanted is not None or not self._expected.wait_s):
            return next(
                (system for system in systems if _is_copter(system)), None
            )  # a second before its next heartbeat
        return next((system for system in systems if system.get_system_id() == number), None)

    def _target(self) -> tuple[MavlinkDirect, int]:
        direct, system = self._direct, self._system
        if direct is None or system is None:
            raise AutopilotError(say("No autopilot found yet."))
        return direct, int(system.get_system_id())

    def _note(self, message: MavlinkMessage, _: object) -> None:
        """Note a HEARTBEAT of any system."""
        try:
            fields = json.loads(message.fields_json)
            kind, autopilot, mode = (int(fields[name]) for name in ("type", "autopilot", "base_mode"))
        except (ValueError, KeyError, TypeError):
            return
        beat = Heartbeat(int(message.system_id), int(message.component_id), kind, autopilot, mode)
        if self._gate is not None and (beat.system, beat.component) == (self._system_id, GROUND_STATION_COMPONENT):
            return  # our gate's greeting to MAVSDK
        self._roster.take(beat, time.monotonic())

    def _receive(self, message: MavlinkMessage, _: object) -> None:
        arrival = self._clock()
        if message.system_id != self._vehicle_id or not _is_its_word(message):
            return
        try:
            fields = json.loads(message.fields_json)
        except ValueError:
            _LOG.warning("%s of the autopilot cannot be read", message.message_name)
            return
        self._on_message(Message(message.message_name, fields, arrival))

    def _overhear(self, datagram: bytes) -> None:
        """Take what another station writes to the autopilot."""
        for write in writes(datagram):
            foreign = write.system not in (0, self._vehicle_id, self._system_id)
            if foreign and write.target in (0, self._vehicle_id):
                fields = {"subjects": write.subjects}
                sender = (write.system, write.component)
                self._on_message(Message(FOREIGN_WRITE, fields, self._clock(), sender))


def _is_copter(system: Any) -> bool:
    """Return True for what MAVSDK itself takes for an ArduPilot with a multicopter."""
    is_known = system.has_autopilot() and system.autopilot_type() is AutopilotKind.ARDUPILOT
    return bool(is_known and system.vehicle_type() is VehicleKind.MULTICOPTER)


def _is_its_word(message: MavlinkMessage) -> bool:
    """Return True for the autopilot's own messages, and for the Remote ID transmitter's word, which it passes on."""
    if message.component_id in TRANSMITTERS:
        return str(message.message_name) == ARM_STATUS
    return int(message.component_id) == AUTOPILOT_COMPONENT


def _message(name: str, fields: Mapping[str, Any], target: int) -> MavlinkMessage:
    address = {} if name in _BROADCAST else {"target_system": target, "target_component": AUTOPILOT_COMPONENT}
    text = json.dumps({**fields, **address}, allow_nan=False)
    return MavlinkMessage(name, 0, 0, target, AUTOPILOT_COMPONENT, text)


_RESULTS = (
    say("timeout"),
    say("busy"),
    say("no system"),
    say("connection error"),
    say("too many geofence items"),
    say("invalid argument"),
    say("unsupported"),
    say("denied"),
    say("failed"),
    say("cancelled"),
)
"""Results of MAVSDK in words."""


def _words(error: Exception) -> str:
    result = getattr(error, "result", None)
    words = str(getattr(result, "name", error)).replace("_", " ").lower()
    return next((each for each in _RESULTS if each == words), words)
