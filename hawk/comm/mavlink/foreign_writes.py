"""Messages by which another station changes what the autopilot holds, where they come by our link.

A router, a shared radio or a broadcast brings them; most links carry only what the autopilot says. MAVSDK keeps them
from us, so they are read from the datagrams (https://mavlink.io/en/guide/serialization.html). They are for display.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from hawk.comm.mavlink.frames import frames

FENCE: Final = "fence"
RALLY: Final = "rally"
HOME: Final = "home"
_MISSIONS: Final[Mapping[int, tuple[str, ...]]] = {1: (FENCE,), 2: (RALLY,), 255: (FENCE, RALLY)}  # MAV_MISSION_TYPE
_COMMANDS: Final[Mapping[int, tuple[str, ...]]] = {179: (HOME,), 207: (FENCE,)}  # DO_SET_HOME, DO_FENCE_ENABLE


@dataclass(frozen=True, slots=True)
class Write:
    """A message that writes: its sender, the system that it is for (0: all), and what it writes.

    ``subjects``: a parameter's name, `FENCE`, `RALLY`, `HOME`.
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


def _command(payload: bytes) -> tuple[str, ...]:
    return _COMMANDS.get(struct.unpack_from("<H", payload, 28)[0], ())


_KINDS: Final[Mapping[int, _Kind]] = {
    23: _Kind(168, 23, 4, _parameter),  # PARAM_SET
    44: _Kind(221, 5, 2, lambda payload: _MISSIONS.get(payload[4], ())),  # MISSION_COUNT
    45: _Kind(232, 3, 0, lambda payload: _MISSIONS.get(payload[2], ())),  # MISSION_CLEAR_ALL
    75: _Kind(158, 35, 30, _command),  # COMMAND_INT
    76: _Kind(152, 33, 30, _command),  # COMMAND_LONG
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
        if subjects:
            yield Write(frame.system, frame.component, payload[kind.target], subjects)
