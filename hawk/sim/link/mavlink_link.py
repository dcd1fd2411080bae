"""The autopilot's end of a MAVLink link: bytes in, bytes out, without socket or clock."""

from __future__ import annotations

import logging
import math
import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.autopilot.autopilot import Autopilot
from hawk.sim.autopilot.commands import Command, execute
from hawk.sim.autopilot.missions import HANDLED as MISSION_MESSAGES
from hawk.sim.autopilot.missions import Missions
from hawk.sim.autopilot.parameters import Other, Parameter
from hawk.sim.autopilot.radio import COMPONENT as TRANSMITTER
from hawk.sim.autopilot.radio import MESSAGES as REMOTE_ID_MESSAGES
from hawk.sim.autopilot.radio import Transmitter
from hawk.sim.autopilot.telemetry import BUILDERS, Message, build, heartbeat
from hawk.sim.geometry import Vector, add

_SECOND_NORTH_DEG: Final = 0.002
"""The second copter flies this far north of where the world begins: 220 m."""


@dataclass(frozen=True, slots=True)
class _Kind:
    """MAVLink ids and the HEARTBEAT's fields (MAV_TYPE, MAV_AUTOPILOT, base_mode, custom_mode, MAV_STATE)."""

    system: int
    component: int
    heartbeat: tuple[int, int, int, int, int]


_KINDS: Final = {
    Other.TRACKER: _Kind(2, 1, (mavlink.MAV_TYPE_ANTENNA_TRACKER, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 81, 10, 4)),
    Other.GIMBAL: _Kind(
        1, mavlink.MAV_COMP_ID_GIMBAL, (mavlink.MAV_TYPE_GIMBAL, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4)
    ),
    Other.COPTER: _Kind(3, 1, (mavlink.MAV_TYPE_HEXAROTOR, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 217, 3, 4)),
    Other.STATION: _Kind(
        255, mavlink.MAV_COMP_ID_MISSIONPLANNER, (mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4)
    ),
}
"""The tracker is armed in AUTO, the second copter flies in AUTO; a gimbal is a component of the vehicle itself."""


class Others:
    """`present` of them are on the link. ``latitude`` and ``longitude`` (degrees) are where the world begins."""

    def __init__(self, latitude: float, longitude: float) -> None:
        self.present: frozenset[Other] = frozenset()
        self._place = round((latitude + _SECOND_NORTH_DEG) * 1e7), round(longitude * 1e7)
        self._encoders = {
            kind: mavlink.MAVLink(None, srcSystem=each.system, srcComponent=each.component)
            for kind, each in _KINDS.items()
        }

    def say(self, now: float, pack: Callable[[Any, mavlink.MAVLink], bytes]) -> list[bytes]:
        """Return the datagrams of one round; ``now`` is seconds of the simulation."""
        return [
            pack(message, self._encoders[kind])
            for kind in sorted(self.present)
            for message in self._messages(kind, int(now * 1000))
        ]

    def _messages(self, kind: Other, milliseconds: int) -> Iterator[Any]:
        yield mavlink.MAVLink_heartbeat_message(*_KINDS[kind].heartbeat, 3)
        if kind is Other.COPTER:
            yield mavlink.MAVLink_global_position_int_message(milliseconds, *self._place, 140_000, 40_000, 500, 0, 0, 0)
            yield mavlink.MAVLink_sys_status_message(0, 0, 0, 300, 14_800, 1500, 61, 0, 0, 0, 0, 0, 0)


log = logging.getLogger(__name__)
_FIRST_IDS = 255
"""MAVLink 1 has no message with a number above this."""


@cache
def _length_1(message_id: int) -> int | None:
    """Return the bytes of a message's payload in MAVLink 1, without its extension fields; None: it has no such one."""
    from pymavlink.dialects.v10 import ardupilotmega as first  # few runs need it

    kind = first.mavlink_map.get(message_id)
    return None if kind is None or message_id > _FIRST_IDS else int(kind.unpacker.size)


def pack_1(message: Message, encoder: mavlink.MAVLink) -> bytes:
    """Return a message in MAVLink 1 framing, empty where it cannot be said (https://mavlink.io/en/guide/serialization)."""
    length = _length_1(message.get_msgId())
    if length is None:
        return b""
    whole = bytes(message.pack(encoder, force_mavlink1=True))
    head = bytes([whole[0], length]) + whole[2:6]
    data = head + whole[6 : 6 + length]
    crc = mavlink.x25crc(data[1:])
    crc.accumulate(bytes([message.crc_extra]))
    return data + int(crc.crc).to_bytes(2, "little")


def pack_2(message: Message, encoder: mavlink.MAVLink) -> bytes:
    """Return a message in MAVLink 2 framing."""
    return bytes(message.pack(encoder))


class Datagrams:
    """Decodes the datagrams of one peer; data that is not MAVLink is ignored."""

    def __init__(self) -> None:
        self._decoder = mavlink.MAVLink(None)
        self._decoder.robust_parsing = True

    def read(self, data: bytes) -> list[Any]:
        """Return the messages of a datagram; part of a message is kept until its rest comes."""
        try:
            return self._decoder.parse_buffer(data) or []
        except mavlink.MAVError as error:
            log.debug("not MAVLink: %s", error)
            return []


SYSTEM, COMPONENT = 1, 1
HEARTBEAT_S = 1.0
FASTEST_S = 1.0 / 200.0
"""No stream is sent faster than this, simulated seconds."""
PARAMETERS_A_POLL = 10
TEXT_BYTES = 50
IGNORE_POSITION = 0b111
IGNORE_VELOCITY = 0b111 << 3
IGNORE_YAW = 1 << 10
"""POSITION_TARGET_TYPEMASK bits."""
BODY_FRAMES = frozenset({mavlink.MAV_FRAME_BODY_NED, mavlink.MAV_FRAME_BODY_OFFSET_NED})
OFFSET_FRAMES = frozenset({mavlink.MAV_FRAME_LOCAL_OFFSET_NED, mavlink.MAV_FRAME_BODY_OFFSET_NED})


class MavlinkLink:
    """One link. ``cut``, ``mute`` and ``loss`` (share of datagrams, 0..1, in each direction) are for tests."""

    def __init__(self, autopilot: Autopilot, rng: np.random.Generator) -> None:
        self.cut = False
        self.mute = False
        """Its messages are lost; it hears."""
        self.loss = 0.0
        self.version = 2
        """1: it speaks MAVLink 1, as SERIALn_PROTOCOL 1 does."""
        self.others = Others(autopilot.origin.latitude, autopilot.origin.longitude)
        self.late_parameters_s = 0.0
        """A parameter whose set was confirmed reads as its old value for this time, simulated seconds."""
        self._old_values: dict[str, tuple[Parameter, float]] = {}
        self.transmitter = Transmitter()
        """Of Remote ID; it has its own power, a boot of the autopilot leaves it alone."""
        self._transmitter_encoder = mavlink.MAVLink(None, srcSystem=SYSTEM, srcComponent=TRANSMITTER)
        self._autopilot = autopilot
        self._rng = rng
        self._encoder = mavlink.MAVLink(None, srcSystem=SYSTEM, srcComponent=COMPONENT)
        self._datagrams = Datagrams()
        self._out: list[Message] = []
        self._boots = 0
        self._reset()

    def receive(self, data: bytes) -> None:
        """Take a datagram; the next `poll` returns the answers."""
        if self._autopilot.stopped or self.cut or self._lost():
            return
        for message in self._datagrams.read(data):
            self._handle(message)

    def poll(self) -> list[bytes]:
        """Return the datagrams that are due."""
        autopilot = self._autopilot
        if autopilot.boots != self._boots:
            self._reset()
        if autopilot.stopped:
            return []
        pack = pack_1 if self.version == 1 else pack_2
        others = self.others.say(autopilot.time, pack) if autopilot.time >= self._next_heartbeat else []
        self._due()
        out, self._out = self._out, []
        packed = [*others, *(pack(message, self._encoder) for message in out)]
        word = self.transmitter.poll(autopilot.time, autopilot.position_ok)
        if word is not None:
            packed.append(pack(word, self._transmitter_encoder))
        return [] if self.cut or self.mute else [data for data in packed if data and not self._lost()]

    def station_says(self, kind: str, fields: Mapping[str, Any], system: int, component: int) -> None:
        """Take a message of a ground station on another link: its answers do not come on this one, but parameters do.

        ArduPilot sends PARAM_VALUE on every link. Raises ValueError for a message that MAVLink does not have.
        """
        values = {name: value.encode() if isinstance(value, str) else value for name, value in fields.items()}
        encoder = mavlink.MAVLink(None, srcSystem=system, srcComponent=component)
        try:
            made = getattr(mavlink, f"MAVLink_{kind.lower()}_message")(**values)
            data = bytes(made.pack(encoder))
        except (AttributeError, TypeError, struct.error) as error:
            raise ValueError(f"{kind}: {error}") from error
        before, self._out = self._out, []
        for message in Datagrams().read(data):
            self._handle(message)
        answers, self._out = self._out, before
        self._out += [answer for answer in answers if answer.get_type() in ("PARAM_VALUE", "STATUSTEXT")]

    def _reset(self) -> None:
        """Forget the requested streams, as a boot does."""
        self._boots = self._autopilot.boots
        self._streams: dict[int, tuple[float, float]] = {}
        self._next_heartbeat = self._autopilot.time
        self._mode_changes = self._autopilot.mode_changes
        self._home: Vector | None = None
        self._list_from: int | None = None
        self._missions = Missions(self._autopilot)

    def _lost(self) -> bool:
        return self.loss > 0.0 and float(self._rng.random()) < self.loss

    def _due(self) -> None:
        autopilot, now = self._autopilot, self._autopilot.time
        self._send_texts()
        if now >= self._next_heartbeat or autopilot.mode_changes != self._mode_changes:
            if now >= self._next_heartbeat:
                self._next_heartbeat = max(self._next_heartbeat + HEARTBEAT_S, now)
            self._mode_changes = autopilot.mode_changes
            self._out.append(heartbeat(autopilot))
        if autopilot.home != self._home:
            self._home = autopilot.home
            self._say(mavlink.MAVLINK_MSG_ID_HOME_POSITION)
        for message_id, (interval, due) in self._streams.items():
            if now >= due:
                self._streams[message_id] = (interval, max(due + interval, now - interval))
                self._say(message_id)
        self._out.extend(self._missions.poll(now))
        self._list_parameters()

    def _send_texts(self) -> None:
        for text in self._autopilot.texts:
            self._out.append(mavlink.MAVLink_statustext_message(text.severity, text.text.encode()[:TEXT_BYTES]))
        self._autopilot.texts.clear()

    def _say(self, message_id: int) -> bool:
        message = build(message_id, self._autopilot)
        if message is not None:
            self._out.append(message)
        return message is not None

    # Incoming messages

    def _handle(self, message: Any) -> None:
        kind = message.get_type()
        target = getattr(message, "target_system", 0)
        if target not in (0, SYSTEM) or kind == "BAD_DATA":
            return
        if kind in MISSION_MESSAGES:
            self._out.extend(self._missions.handle(message, self._autopilot.time))
            return
        if kind in REMOTE_ID_MESSAGES:
            self.transmitter.handle(message, self._autopilot.time)
            return
        handler = _HANDLERS.get(kind)
        if handler is not None:
            handler(self, message)

    def _heartbeat(self, message: Any) -> None:
        if message.type == mavlink.MAV_TYPE_GCS or message.autopilot == mavlink.MAV_AUTOPILOT_INVALID:
            self._autopilot.note_gcs(message.get_srcSystem())

    def _command(self, message: Any) -> None:
        command = Command.of(message)
        own = _LINK_COMMANDS.get(command.number)
        result = execute(command, self._autopilot) if own is None else own(self, command)
        acknowledge = mavlink.MAVLink_command_ack_message(
            command.number, result, 0, 0, target_system=command.sender[0], target_component=command.sender[1]
        )
        # STATUSTEXT with the reason leaves before the refusal, as on the real one
        self._send_texts()
        self._out.append(acknowledge)

    def _set_interval(self, command: Command) -> int:
        message_id, interval = int(command.parameters[0]), command.parameters[1]
        if message_id not in BUILDERS or not math.isfinite(interval):
            return int(mavlink.MAV_RESULT_DENIED)
        if interval <= 0.0:
            self._streams.pop(message_id, None)
        else:
            self._streams[message_id] = (max(interval * 1e-6, FASTEST_S), self._autopilot.time)
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _get_interval(self, command: Command) -> int:
        message_id = int(command.parameters[0])
        if message_id not in BUILDERS:
            return int(mavlink.MAV_RESULT_DENIED)
        interval = self._streams.get(message_id, (-1e-6, 0.0))[0]
        self._out.append(mavlink.MAVLink_message_interval_message(message_id, round(interval * 1e6)))
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _request_message(self, message_id: int) -> int:
        return int(mavlink.MAV_RESULT_ACCEPTED if self._say(message_id) else mavlink.MAV_RESULT_FAILED)

    def _set_mode(self, message: Any) -> None:
        ask = Command(mavlink.MAV_CMD_DO_SET_MODE, (1.0, float(message.custom_mode), 0.0, 0.0), 0, 0, 0, 0, (0, 0))
        execute(ask, self._autopilot)

    def _timesync(self, message: Any) -> None:
        if message.tc1 == 0:
            self._out.append(mavlink.MAVLink_timesync_message(int(self._autopilot.time_boot * 1e9), message.ts1))

    def _ping(self, message: Any) -> None:
        if message.target_system == 0:
            sender = (message.get_srcSystem(), message.get_srcComponent())
            self._out.append(mavlink.MAVLink_ping_message(message.time_usec, message.seq, *sender))

    def _read_parameter(self, message: Any) -> None:
        parameters = self._autopilot.parameters
        try:
            found = (
                parameters.at(message.param_index)
                if message.param_index >= 0
                else parameters.parameter(_text(message.param_id))
            )
        except (KeyError, IndexError):
            return  # ArduPilot says nothing
        old, since = self._old_values.get(found.name, (found, -math.inf))
        shown = old if self._autopilot.time - since < self.late_parameters_s else found
        self._send_parameter(shown, message.param_index if message.param_index >= 0 else None)

    def _set_parameter(self, message: Any) -> None:
        if not math.isfinite(message.param_value):
            return
        name, parameters = _text(message.param_id), self._autopilot.parameters
        try:
            old = parameters.parameter(name)
            written = parameters.set(name, message.param_value)
        except KeyError:
            return
        if written.value != old.value:
            self._old_values[name] = (old, self._autopilot.time)
        self._send_parameter(written, None)

    def _start_list(self, _: Any) -> None:
        self._list_from = 0

    def _list_parameters(self) -> None:
        if self._list_from is None:
            return
        count = len(self._autopilot.parameters)
        for index in range(self._list_from, min(self._list_from + PARAMETERS_A_POLL, count)):
            self._send_parameter(self._autopilot.parameters.at(index), index)
        self._list_from = self._list_from + PARAMETERS_A_POLL if self._list_from + PARAMETERS_A_POLL < count else None

    def _send_parameter(self, parameter: Parameter, index: int | None) -> None:
        self._out.append(
            mavlink.MAVLink_param_value_message(
                parameter.name.encode(),
                parameter.value,
                int(parameter.type),
                len(self._autopilot.parameters),
                self._autopilot.parameters.index(parameter.name) if index is None else index,
            )
        )

    def _local_target(self, message: Any) -> None:
        autopilot, mask = self._autopilot, message.type_mask
        if autopilot.ekf_origin is None:
            return
        yaw = None if mask & IGNORE_YAW else float(message.yaw)
        heading = autopilot.estimate.yaw if message.coordinate_frame in BODY_FRAMES else 0.0
        if yaw is not None and message.coordinate_frame in BODY_FRAMES:
            yaw += heading
        if not mask & IGNORE_POSITION:
            place = _turned((message.x, message.y, message.z), heading)
            offset = message.coordinate_frame in OFFSET_FRAMES or message.coordinate_frame in BODY_FRAMES
            autopilot.fly_to(add(place, autopilot.estimate.position if offset else autopilot.ekf_origin), yaw)
        elif not mask & IGNORE_VELOCITY:
            autopilot.fly_velocity(_turned((message.vx, message.vy, message.vz), heading), yaw)

    def _global_target(self, message: Any) -> None:
        autopilot, mask = self._autopilot, message.type_mask
        if autopilot.home is None:
            return
        yaw = None if mask & IGNORE_YAW else float(message.yaw)
        if not mask & IGNORE_POSITION:
            altitude = message.alt
            if message.coordinate_frame not in (mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_FRAME_GLOBAL_INT):
                altitude += autopilot.origin.altitude - autopilot.home[2]
            autopilot.fly_to(autopilot.origin.to_world(message.lat_int * 1e-7, message.lon_int * 1e-7, altitude), yaw)
        elif not mask & IGNORE_VELOCITY:
            autopilot.fly_velocity((message.vx, message.vy, message.vz), yaw)


def _turned(vector: Vector, heading: float) -> Vector:
    north, east, down = vector
    cosine, sine = math.cos(heading), math.sin(heading)
    return north * cosine - east * sine, north * sine + east * cosine, down


def _text(value: str | bytes) -> str:
    text = value.decode(errors="replace") if isinstance(value, bytes) else value
    return text.rstrip("\0")


_HANDLERS: dict[str, Callable[[MavlinkLink, Any], None]] = {
    "HEARTBEAT": MavlinkLink._heartbeat,
    "COMMAND_LONG": MavlinkLink._command,
    "COMMAND_INT": MavlinkLink._command,
    "SET_MODE": MavlinkLink._set_mode,
    "TIMESYNC": MavlinkLink._timesync,
    "PING": MavlinkLink._ping,
    "PARAM_REQUEST_READ": MavlinkLink._read_parameter,
    "PARAM_REQUEST_LIST": MavlinkLink._start_list,
    "PARAM_SET": MavlinkLink._set_parameter,
    "SET_POSITION_TARGET_LOCAL_NED": MavlinkLink._local_target,
    "SET_POSITION_TARGET_GLOBAL_INT": MavlinkLink._global_target,
}
_LINK_COMMANDS: dict[int, Callable[[MavlinkLink, Command], int]] = {
    mavlink.MAV_CMD_SET_MESSAGE_INTERVAL: MavlinkLink._set_interval,
    mavlink.MAV_CMD_GET_MESSAGE_INTERVAL: MavlinkLink._get_interval,
    mavlink.MAV_CMD_REQUEST_MESSAGE: lambda link, command: link._request_message(int(command.parameters[0])),
    mavlink.MAV_CMD_GET_HOME_POSITION: lambda link, _: link._request_message(mavlink.MAVLINK_MSG_ID_HOME_POSITION),
    mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: (
        lambda link, _: link._request_message(mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION)
    ),
}
