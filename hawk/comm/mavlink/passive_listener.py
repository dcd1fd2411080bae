"""Listens to an autopilot without sending: is it disarmed?

For a daemon that crashed again and again in the air: it must leave the drone to the autopilot's ground-station
failsafe, and any heartbeat of ours would hold that off. MAVSDK cannot listen without sending.
"""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable
from typing import Any, Final
from urllib.parse import urlsplit

from hawk.comm.mavlink.frames import heartbeats
from hawk.comm.mavlink.peer import FIRST_HEARD, Expected, PeerKeeper

_LOG = logging.getLogger(__name__)
SURE_S: Final = 2.0
"""Real seconds for which one sender, and no other, must say that the motors are off."""


class _Listener(asyncio.DatagramProtocol):
    def __init__(self, expected: Expected, sure_s: float, monotonic: Callable[[], float] = time.monotonic) -> None:
        self._keeper = PeerKeeper(expected)
        self._sure_s = sure_s
        self._monotonic = monotonic
        self._off_since: float | None = None
        self.disarmed = asyncio.Event()

    def datagram_received(self, data: bytes, addr: tuple[str | Any, int]) -> None:
        now = self._monotonic()
        is_admitted = self._keeper.admit(addr[:2], data, now)
        if self._keeper.second_sender(now):
            self._off_since = None  # one of them is lying
        elif is_admitted:
            for beat in heartbeats(data):
                if beat.system == self._keeper.system_id and beat.is_of_an_autopilot:
                    self._take(beat.is_disarmed_copter, now)

    def _take(self, is_off: bool, now: float) -> None:
        if not is_off:
            self._off_since = None
        elif self._off_since is None:
            self._off_since = now
        if self._off_since is not None and now - self._off_since >= self._sure_s:
            self.disarmed.set()


async def wait_until_disarmed(
    url: str,
    otherwise_s: float,
    expected: Expected = FIRST_HEARD,
    sure_s: float = SURE_S,
) -> bool:
    """Wait until the expected autopilot is heard to be disarmed for ``sure_s``, without sending, and return True.

    Only a free ``udpin://`` port can be listened to; for other links return False after ``otherwise_s`` real seconds.
    """
    place = urlsplit(url)
    if place.scheme != "udpin" or place.port is None:
        await asyncio.sleep(otherwise_s)
        return False
    loop = asyncio.get_running_loop()
    address = (place.hostname or "127.0.0.1", place.port)
    try:
        transport, listener = await loop.create_datagram_endpoint(
            lambda: _Listener(expected, sure_s), local_addr=address
        )
    except OSError as error:
        _LOG.warning("%s cannot be listened to: %s", url, error)
        await asyncio.sleep(otherwise_s)
        return False
    try:
        await listener.disarmed.wait()
    finally:
        transport.close()
    return True
