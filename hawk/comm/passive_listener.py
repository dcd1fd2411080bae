"""Listens to an autopilot without saying a word: is it disarmed?

For the daemon that crashed again and again in the air: it must leave the drone to the autopilot's ground-station
failsafe, and any heartbeat of ours would hold that off.
"""

from __future__ import annotations

import asyncio
import logging
from typing import Any
from urllib.parse import urlsplit

from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as mavlink

_LOG = logging.getLogger(__name__)


class _Listener(asyncio.DatagramProtocol):
    def __init__(self) -> None:
        self._parser: Any = mavlink.MAVLink(None)
        self._parser.robust_parsing = True
        self.disarmed = asyncio.Event()

    def datagram_received(self, data: bytes, addr: tuple[str | Any, int]) -> None:  # noqa: ARG002
        for message in self._parser.parse_buffer(data) or ():
            if message.get_type() == "HEARTBEAT" and message.autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA:
                armed = message.base_mode & mavutil.mavlink.MAV_MODE_FLAG_SAFETY_ARMED
                if not armed:
                    self.disarmed.set()


async def wait_until_disarmed(url: str, otherwise_s: float) -> bool:
    """Return True when the autopilot at a ``udpin://`` URL is heard to be disarmed.

    Other links cannot be listened to without opening them, nor can a port that somebody else holds: False after
    ``otherwise_s`` real seconds.
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
