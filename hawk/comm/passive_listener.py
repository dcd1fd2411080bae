"""Listens to an autopilot without sending: is it disarmed?

For a daemon that crashed again and again in the air: it must leave the drone to the autopilot's ground-station
failsafe, and any heartbeat of ours would hold that off. MAVSDK cannot listen without sending, so HEARTBEAT is parsed
here (https://mavlink.io/en/guide/serialization.html).
"""

from __future__ import annotations

import asyncio
import logging
import struct
from collections.abc import Iterator
from typing import Any, Final
from urllib.parse import urlsplit

_LOG = logging.getLogger(__name__)

_V1, _V2 = 0xFE, 0xFD
_HEADER: Final = {_V1: 6, _V2: 10}
"""Bytes before the payload, the magic among them."""
_HEARTBEAT: Final = 0  # message id
_FIELDS: Final = struct.Struct("<IBBBBB")  # custom_mode, type, autopilot, base_mode, system_status, mavlink_version
_CRC_EXTRA: Final = b"\x32"  # of HEARTBEAT
_ARDUPILOT: Final = 3  # MAV_AUTOPILOT_ARDUPILOTMEGA
_ARMED: Final = 128  # MAV_MODE_FLAG_SAFETY_ARMED


def heartbeats(datagram: bytes) -> Iterator[tuple[int, int]]:
    """Yield (autopilot, base_mode) of the whole HEARTBEATs (MAVLink 1 and 2) in a datagram; other bytes are skipped."""
    for start, magic in enumerate(datagram):
        header = _HEADER.get(magic)
        if header is None or start + header > len(datagram):
            continue
        end = start + header + datagram[start + 1] + 2
        frame = datagram[start:end]
        message = frame[5] if magic == _V1 else int.from_bytes(frame[7:10], "little")
        payload = frame[header:-2]
        if message != _HEARTBEAT or end > len(datagram) or len(payload) > _FIELDS.size:
            continue
        if _checksum(frame[1:-2] + _CRC_EXTRA) == int.from_bytes(frame[-2:], "little"):
            _, _, autopilot, base_mode, _, _ = _FIELDS.unpack(payload.ljust(_FIELDS.size, b"\0"))  # v2 cuts zeros off
            yield autopilot, base_mode


def _checksum(data: bytes) -> int:
    """Return CRC-16/MCRF4XX, which MAVLink calls X.25."""
    crc = 0xFFFF
    for byte in data:
        mixed = byte ^ (crc & 0xFF)
        mixed = (mixed ^ (mixed << 4)) & 0xFF
        crc = (crc >> 8) ^ (mixed << 8) ^ (mixed << 3) ^ (mixed >> 4)
    return crc


class _Listener(asyncio.DatagramProtocol):
    def __init__(self) -> None:
        self.disarmed = asyncio.Event()

    def datagram_received(self, data: bytes, addr: tuple[str | Any, int]) -> None:  # noqa: ARG002
        if any(autopilot == _ARDUPILOT and not base_mode & _ARMED for autopilot, base_mode in heartbeats(data)):
            self.disarmed.set()


async def wait_until_disarmed(url: str, otherwise_s: float) -> bool:
    """Wait until the autopilot is heard to be disarmed, without sending, and return True.

    Only a free ``udpin://`` port can be listened to; for other links return False after ``otherwise_s`` real seconds.
    """
    place = urlsplit(url)
    if place.scheme != "udpin" or place.port is None:
        await asyncio.sleep(otherwise_s)
        return False
    loop = asyncio.get_running_loop()
    address = (place.hostname or "0.0.0.0", place.port)  # noqa: S104 - as configured
    try:
        transport, listener = await loop.create_datagram_endpoint(_Listener, local_addr=address)
    except OSError as error:
        _LOG.warning("%s cannot be listened to: %s", url, error)
        await asyncio.sleep(otherwise_s)
        return False
    try:
        await listener.disarmed.wait()
    finally:
        transport.close()
    return True
