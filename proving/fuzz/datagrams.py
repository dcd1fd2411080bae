"""Fuzzed datagrams of an autopilot: frames with random fields, damaged frames, noise, and those of a stranger.

A case depends on seed and number alone.
"""

from __future__ import annotations

import math
import random
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from pymavlink.dialects.v20 import ardupilotmega as mavlink
from pymavlink.generator.mavcrc import x25crc

AUTOPILOT: Final = (1, 1)
"""System and component id of the autopilot."""
STRANGE_MODE: Final = 0x5EEDBAD5
"""The custom_mode that a stranger's HEARTBEAT bears; the autopilot's never does."""
_V1, _V2 = 0xFE, 0xFD
_LARGEST: Final = 255
_HEARTBEAT: Final = 0
_READ: Final = (
    *("HEARTBEAT", "EXTENDED_SYS_STATE", "LOCAL_POSITION_NED", "ATTITUDE", "GLOBAL_POSITION_INT", "SYS_STATUS"),
    *("GPS_RAW_INT", "EKF_STATUS_REPORT", "HOME_POSITION", "DISTANCE_SENSOR", "STATUSTEXT", "RC_CHANNELS"),
    *("OPEN_DRONE_ID_ARM_STATUS", "SYSTEM_TIME", "PARAM_VALUE", "COMMAND_ACK"),
)
"""Messages that the daemon reads."""
_CLASSES: Final[dict[int, Any]] = {number: kind for number, kind in mavlink.mavlink_map.items() if number >= 0}
_READ_IDS: Final = tuple(number for number, kind in _CLASSES.items() if kind.msgname in _READ)
_ALL_IDS: Final = tuple(sorted(_CLASSES))
_INTEGERS: Final = {"b": 8, "B": 8, "h": 16, "H": 16, "i": 32, "I": 32, "q": 64, "Q": 64}
_REALS: Final = (0.0, -0.0, 1.0, -1.0, math.nan, math.inf, -math.inf, 1e-38, 3.4e38, -3.4e38)


@dataclass(frozen=True, slots=True)
class Datagram:
    """One case; ``is_strange``: another sender than the autopilot sends it."""

    data: bytes
    is_strange: bool = False


class Datagrams:
    """The cases of a seed."""

    def __init__(self, seed: int) -> None:
        self._seed = seed

    def at(self, number: int) -> Datagram:
        """Return a case."""
        rng = random.Random(f"datagram:{self._seed}:{number}")
        kinds: tuple[tuple[float, Callable[[random.Random], bytes]], ...] = (
            (0.55, _read_frame),
            (0.10, _any_frame),
            (0.15, _damaged),
            (0.05, _several),
            (0.05, _foreign_ids),
            (0.05, _noise),
        )
        share = rng.random()
        for part, make in kinds:
            if share < part:
                return Datagram(make(rng))
            share -= part
        return Datagram(_strange(rng), is_strange=True)


def frame(message: int, payload: bytes, ids: tuple[int, int], sequence: int = 0, *, version: int = _V2) -> bytes:
    """Return a frame with a right checksum (https://mavlink.io/en/guide/serialization.html)."""
    if version == _V1:
        head = struct.pack("<BBBBB", len(payload), sequence, *ids, message)
    else:
        head = struct.pack("<BBBBBBHB", len(payload), 0, 0, sequence, *ids, message & 0xFFFF, message >> 16)
    extra = bytes([_CLASSES[message].crc_extra]) if message in _CLASSES else b"\0"
    check = x25crc()
    check.accumulate(head + payload + extra)
    return bytes([version]) + head + payload + struct.pack("<H", check.crc)


def _read_frame(rng: random.Random) -> bytes:
    message = rng.choice(_READ_IDS)
    return frame(message, _payload(rng, message), AUTOPILOT, rng.randrange(256), version=_version(rng, message))


def _any_frame(rng: random.Random) -> bytes:
    message = rng.choice(_ALL_IDS)
    return frame(message, _payload(rng, message), AUTOPILOT, rng.randrange(256))


def _damaged(rng: random.Random) -> bytes:
    data = bytearray(_read_frame(rng))
    for _ in range(rng.randint(1, 4)):
        kind, place = rng.randrange(4), rng.randrange(len(data))
        if kind == 0:
            data[place] ^= 1 << rng.randrange(8)
        elif kind == 1 and len(data) > 1:
            del data[place:]
        elif kind == 2:
            data[place:place] = rng.randbytes(rng.randint(1, 20))
        else:
            data[place] = rng.choice((0, 0xFD, 0xFE, 0xFF))
        if not data:
            break
    return bytes(data) or b"\0"


def _several(rng: random.Random) -> bytes:
    parts = [rng.choice((_read_frame, _damaged, _noise))(rng) for _ in range(rng.randint(2, 5))]
    return b"".join(parts)


def _foreign_ids(rng: random.Random) -> bytes:
    """Return a frame of another component, or of another vehicle behind the same router."""
    message = rng.choice(_READ_IDS)
    ids = (rng.choice((1, 2, 255, rng.randrange(1, 256))), rng.choice((0, 2, 154, 190, 236, rng.randrange(256))))
    return frame(message, _payload(rng, message), ids, rng.randrange(256))


def _noise(rng: random.Random) -> bytes:
    return rng.randbytes(rng.randint(1, 300))


def _strange(rng: random.Random) -> bytes:
    """Return a HEARTBEAT that claims to be the autopilot's; the gate knows it by its sender alone."""
    payload = struct.pack("<IBBBBB", STRANGE_MODE, 2, 3, rng.choice((1, 129)), 4, 3)
    return frame(_HEARTBEAT, payload, AUTOPILOT, rng.randrange(256))


def _version(rng: random.Random, message: int) -> int:
    return _V1 if message < 256 and rng.random() < 0.2 else _V2


def _payload(rng: random.Random, message: int) -> bytes:
    """Return fields at random, often at the ends of their range; sometimes too short or too long."""
    packer = struct.Struct(_CLASSES[message].unpacker.format)
    payload = b"".join(_field(rng, code) for code in _codes(packer.format))
    share = rng.random()
    if share < 0.05:
        payload = payload[: rng.randrange(len(payload) + 1)]
    elif share < 0.1:
        payload += rng.randbytes(rng.randint(1, 30))
    elif share < 0.2:
        payload = rng.randbytes(len(payload))
    return payload[:_LARGEST] or b"\0"


def _codes(form: str) -> list[str]:
    """Return the format's codes one by one, with the size of texts: `<I3f50s` gives I, f, f, f, 50s."""
    found, count = [], ""
    for letter in form.lstrip("<"):
        if letter.isdigit():
            count += letter
        elif letter == "s":
            found.append(f"{count or 1}s")
            count = ""
        else:
            found += [letter] * int(count or 1)
            count = ""
    return found


def _field(rng: random.Random, code: str) -> bytes:
    if code.endswith("s"):
        size = int(code[:-1])
        return rng.choice((rng.randbytes(size), b"\0" * size, b"\xff" * size, b"A" * size, _text(rng, size)))
    if code in ("f", "d"):
        value = rng.choice((*_REALS, rng.uniform(-200.0, 200.0), rng.uniform(-1e7, 1e7)))
        return struct.pack(f"<{code}", value)
    if code == "c":
        return rng.randbytes(1)
    bits = _INTEGERS[code]
    low, high = (0, 2**bits - 1) if code.isupper() else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    value = rng.choice((low, high, 0, 1, rng.randint(low, high), rng.randint(0, min(high, 255))))
    return struct.pack(f"<{code}", value)


def _text(rng: random.Random, size: int) -> bytes:
    text = rng.choice(("PreArm: {}%s\n", "\u202e", "FENCE_ENABLE", "\x1b[31m", "é" * 30, "EKF3 lane switch"))
    return text.encode()[:size].ljust(size, b"\0")
