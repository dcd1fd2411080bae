"""Messages by which another station changes what the autopilot holds, where they come by our link.

A router, a shared radio or a broadcast brings them; most links carry only what the autopilot says. MAVSDK keeps them
from us, so they are read from the datagrams (https://mavlink.io/en/guide/serialization.html). They are for display.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from hawk.comm.mavlink.frames import frames
from hawk.model.vehicle import CopterMode

FENCE: Final = "fence"
RALLY: Final = "rally"
HOME: Final = "home"
MODE: Final = "mode"
"""Another mode was asked for, that is not said which; one that is said is `mode_subject`."""
_MISSIONS: Final[Mapping[int, tuple[str, ...]]] = {1: (FENCE,), 2: (RALLY,), 255: (FENCE, RALLY)}  # MAV_MISSION_TYPE
_DO_SET_MODE: Final = 176
_ACCEPTED: Final = 0  # MAV_RESULT
_COMMANDS: Final[Mapping[int, tuple[str, ...]]] = {
    179: (HOME,),  # DO_SET_HOME
    207: (FENCE,),  # DO_FENCE_ENABLE
    20: (f"{MODE} {CopterMode.RTL}",),  # NAV_RETURN_TO_LAUNCH
    21: (f"{MODE} {CopterMode.LAND}",),  # NAV_LAND
}
_MODES: Final = frozenset({_DO_SET_MODE, 20, 21})
_COMMAND_ACK: Final = 77
_ANSWERED: Final = 8
"""Place of ``target_system`` in a COMMAND_ACK, an extension: MAVLink 1 has none."""


@dataclass(frozen=True, slots=True)
class Write:
    """A message that writes: its sender, the system that it is for (0: all), and what it writes.

    ``subjects``: a parameter's name, `FENCE`, `RALLY`, `HOME`, `MODE` or a `mode_subject`.
    """

    system: int
    component: int
    target: int
    subjects: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Kind:
    """CRC_EXTRA, length of the payload, place of ``target_system`` in it, and what a payload writes."""

    extra: int
    length: int
    target: int
    subjects: Callable[[bytes], tuple[str, ...]]


def _parameter(payload: bytes) -> tuple[str, ...]:
    name = payload[6:22].split(b"\0")[0].decode("ascii", "replace")
    return (name,) if name.isprintable() and name else ()


def mode_subject(mode: int) -> str:
    """Return the subject of a message that asks for a mode, ArduPilot's number of it."""
    return f"{MODE} {mode}"


def _command(payload: bytes) -> tuple[str, ...]:
    number = struct.unpack_from("<H", payload, 28)[0]
    if number == _DO_SET_MODE:
        mode = struct.unpack_from("<f", payload, 4)[0]
        return (mode_subject(int(mode)),) if math.isfinite(mode) else ()
    return _COMMANDS.get(number, ())


def _set_mode(payload: bytes) -> tuple[str, ...]:
    return (mode_subject(struct.unpack_from("<I", payload, 0)[0]),)


def _answer(payload: bytes) -> tuple[str, ...]:
    """Return what the autopilot accepted, which says to whom: some links bring the answer and not the command."""
    command, result = struct.unpack_from("<HB", payload, 0)
    return (MODE,) if command in _MODES and result == _ACCEPTED else ()


_KINDS: Final[Mapping[int, _Kind]] = {
    11: _Kind(89, 6, 4, _set_mode),  # SET_MODE
    23: _Kind(168, 23, 4, _parameter),  # PARAM_SET
    44: _Kind(221, 5, 2, lambda payload: _MISSIONS.get(payload[4], ())),  # MISSION_COUNT
    45: _Kind(232, 3, 0, lambda payload: _MISSIONS.get(payload[2], ())),  # MISSION_CLEAR_ALL
    75: _Kind(158, 35, 30, _command),  # COMMAND_INT
    76: _Kind(152, 33, 30, _command),  # COMMAND_LONG
    _COMMAND_ACK: _Kind(143, 10, _ANSWERED, _answer),
}
"""Message id -> kind (MAVLink common.xml)."""


def writes(datagram: bytes) -> Iterator[Write]:
    """Yield the whole messages of a datagram (MAVLink 1 and 2) that write something of ours."""
    for frame in frames(datagram):
        kind = _KINDS.get(frame.message)
        if kind is None or not frame.is_sound(kind.extra):
            continue
        payload = frame.payload.ljust(kind.length, b"\0")  # MAVLink 2 cuts zeros off
        subjects = kind.subjects(payload)
        if not subjects:
            continue
        if frame.message == _COMMAND_ACK:
            yield Write(payload[_ANSWERED], payload[_ANSWERED + 1], frame.system, subjects)
        else:
            yield Write(frame.system, frame.component, payload[kind.target], subjects)
