"""HEARTBEAT in a datagram, read without MAVSDK (https://mavlink.io/en/guide/serialization.html)."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from hawk.model.sentences import say

COPTERS: Final = {
    2: say("quadrotor"),
    3: say("coaxial"),
    4: say("helicopter"),
    13: say("hexarotor"),
    14: say("octorotor"),
    15: say("tricopter"),
    29: say("dodecarotor"),
    35: say("decarotor"),
    43: say("multirotor"),
}
"""MAV_TYPE of what ArduCopter flies."""
ARDUPILOT: Final = 3  # MAV_AUTOPILOT_ARDUPILOTMEGA
NO_AUTOPILOT: Final = 8  # MAV_AUTOPILOT_INVALID
GROUND_STATION: Final = 6  # MAV_TYPE_GCS
_OTHERS: Final = {
    0: say("generic vehicle"),
    1: say("plane"),
    5: say("antenna tracker"),
    6: say("ground station"),
    7: say("airship"),
    8: say("balloon"),
    9: say("rocket"),
    10: say("rover"),
    11: say("boat"),
    12: say("submarine"),
    16: say("flapping wing"),
    17: say("kite"),
    18: say("companion computer"),
    **dict.fromkeys(range(19, 26), say("VTOL")),
    26: say("gimbal"),
    27: say("ADS-B receiver"),
    28: say("parafoil"),
    30: say("onboard camera"),
    31: say("charging station"),
    32: say("FLARM"),
    33: say("servo"),
    34: say("Remote ID transmitter"),
    36: say("smart battery"),
    37: say("parachute"),
    38: say("log"),
    39: say("video encoder"),
    40: say("IMU"),
    41: say("GNSS receiver"),
    42: say("winch"),
}
_AUTOPILOTS: Final = {0: say("generic autopilot"), 3: "ArduPilot", 12: "PX4"}


def is_copter(kind: int, autopilot: int) -> bool:
    """Return True for a copter that an ArduPilot flies."""
    return kind in COPTERS and autopilot == ARDUPILOT


def kind_words(kind: int, autopilot: int) -> str:
    """Return what a system is: ``antenna tracker (ArduPilot)``, ``ground station``."""
    words = COPTERS.get(kind) or _OTHERS.get(kind) or f"MAV_TYPE {kind}"
    if autopilot == NO_AUTOPILOT:
        return words
    return say("{kind} ({maker})", kind=words, maker=_AUTOPILOTS.get(autopilot, f"MAV_AUTOPILOT {autopilot}"))


_V1, _V2 = 0xFE, 0xFD
_HEADER: Final = {_V1: 6, _V2: 10}
"""Bytes before the payload, the magic among them."""
_SYSTEM: Final = {_V1: 3, _V2: 5}
"""Place of the system id in a frame; the component id follows it."""
_HEARTBEAT: Final = 0  # message id
_FIELDS: Final = struct.Struct("<IBBBBB")  # custom_mode, type, autopilot, base_mode, system_status, mavlink_version
_CRC_EXTRA: Final = 0x32  # of HEARTBEAT
_NOT_AN_AUTOPILOT: Final = NO_AUTOPILOT
_ARMED: Final = 128  # MAV_MODE_FLAG_SAFETY_ARMED

_ACTIVE: Final = 4  # MAV_STATE_ACTIVE
_MAVLINK_2: Final = 3  # mavlink_version

_SIGNATURE: Final = 13  # bytes behind a signed frame of MAVLink 2
AUTOPILOT_COMPONENT: Final = 1
"""MAV_COMP_ID_AUTOPILOT1."""


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """A HEARTBEAT: its sender's ids, MAV_TYPE, MAV_AUTOPILOT and MAV_MODE_FLAG bits."""

    system: int
    component: int
    kind: int
    autopilot: int
    base_mode: int

    @property
    def is_of_an_autopilot(self) -> bool:
        """True when an autopilot sent it, not a ground station, camera or gimbal."""
        return self.component == AUTOPILOT_COMPONENT and self.autopilot != _NOT_AN_AUTOPILOT

    @property
    def is_of_a_copter(self) -> bool:
        """True when an ArduPilot sent it that flies a copter: no antenna tracker, plane, rover or other autopilot."""
        return self.component == AUTOPILOT_COMPONENT and is_copter(self.kind, self.autopilot)

    @property
    def is_disarmed_copter(self) -> bool:
        """True when a copter sent it and its motors are off."""
        return self.is_of_a_copter and not self.base_mode & _ARMED


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame: its sender's ids, its message's id and payload; ``signed`` is what the checksum is made of."""

    system: int
    component: int
    message: int
    payload: bytes
    signed: bytes
    checksum: bytes

    def is_sound(self, crc_extra: int) -> bool:
        """Return True when the checksum is that of a message with this CRC_EXTRA."""
        return _checksum(self.signed + bytes((crc_extra,))) == int.from_bytes(self.checksum, "little")


def _frame_at(datagram: bytes, start: int) -> Frame | None:
    """Return the frame (MAVLink 1 or 2) that begins there; None where none does, and where its end is missing."""
    magic = datagram[start]
    header = _HEADER.get(magic)
    if header is None or start + header > len(datagram):
        return None
    end = start + header + datagram[start + 1]
    if end + 2 > len(datagram):
        return None
    frame = datagram[start:end]
    message = frame[5] if magic == _V1 else int.from_bytes(frame[7:10], "little")
    system, component = frame[_SYSTEM[magic]], frame[_SYSTEM[magic] + 1]
    return Frame(system, component, message, frame[header:], frame[1:], datagram[end : end + 2])


def heartbeats(datagram: bytes) -> Iterator[Heartbeat]:
    """Yield the whole HEARTBEATs (MAVLink 1 and 2) of a datagram; other bytes are skipped."""
    for start, magic in enumerate(datagram):
        frame = _frame_at(datagram, start) if magic in _HEADER else None
        if frame is None or frame.message != _HEARTBEAT or len(frame.payload) > _FIELDS.size:
            continue
        if frame.is_sound(_CRC_EXTRA):
            _, kind, autopilot, base_mode, _, _ = _FIELDS.unpack(frame.payload.ljust(_FIELDS.size, b"\0"))  # v2 cuts 0s
            yield Heartbeat(frame.system, frame.component, kind, autopilot, base_mode)


def frames(datagram: bytes) -> Iterator[Frame]:
    """Yield the frames of a datagram, one behind the other; what follows bytes that are none is left out."""
    start = 0
    while start < len(datagram) and (frame := _frame_at(datagram, start)) is not None:
        yield frame
        signature = _SIGNATURE if datagram[start] == _V2 and datagram[start + 2] & 1 else 0
        start += 1 + len(frame.signed) + 2 + signature


def ground_station_heartbeat(system: int, component: int) -> bytes:
    """Return a ground station's HEARTBEAT as one MAVLink 2 frame, sequence 0."""
    payload = _FIELDS.pack(0, GROUND_STATION, _NOT_AN_AUTOPILOT, 0, _ACTIVE, _MAVLINK_2)
    frame = bytes((len(payload), 0, 0, 0, system, component)) + _HEARTBEAT.to_bytes(3, "little") + payload
    return bytes((_V2,)) + frame + _checksum(frame + bytes((_CRC_EXTRA,))).to_bytes(2, "little")


def is_heartbeat(frame: bytes) -> bool:
    """Return True when a datagram begins with a HEARTBEAT (unchecked: of a program that we trust)."""
    magic = frame[0] if frame else None
    if magic == _V1:
        return len(frame) > _HEADER[_V1] and frame[5] == _HEARTBEAT
    return magic == _V2 and len(frame) > _HEADER[_V2] and int.from_bytes(frame[7:10], "little") == _HEARTBEAT


def is_mavlink_1(datagram: bytes, system: int) -> bool | None:
    """Return whether a datagram's first frame is MAVLink 1, when that system sent it; else None."""
    return datagram[0] == _V1 if system_of(datagram) == system else None


def system_of(datagram: bytes) -> int | None:
    """Return the system id that a datagram's first frame names (unchecked: for display); None without a frame."""
    place = _SYSTEM.get(datagram[0]) if datagram else None
    return datagram[place] if place is not None and place < len(datagram) else None


def _checksum(data: bytes) -> int:
    """Return CRC-16/MCRF4XX, which MAVLink calls X.25."""
    crc = 0xFFFF
    for byte in data:
        mixed = byte ^ (crc & 0xFF)
        mixed = (mixed ^ (mixed << 4)) & 0xFF
        crc = (crc >> 8) ^ (mixed << 8) ^ (mixed << 3) ^ (mixed >> 4)
    return crc
