"""A run of fuzzed datagrams at the real link: gate, MAVSDK, telemetry. After each round an honest heartbeat is heard.

A damaged frame may swallow what follows it, as in any MAVLink parser: the honest heartbeat is sent until it is heard.
Its sequence number counts, as an autopilot's does, and its payload bears no start byte. The same bytes again and again
could keep any parser out of step for ever: it takes a start byte in the payload or in the checksum for the start of a
frame, which ends in the middle of a later heartbeat.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
import socket
import struct
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.comm.autopilot.autopilot import MavsdkAutopilot
from hawk.comm.autopilot.vehicle import VehicleTopics
from hawk.comm.clock import Clock
from hawk.config.sections import AutopilotSettings
from hawk.sim.launch import free_udp_port
from proving.fuzz.datagrams import AUTOPILOT, STRANGE_MODE, Datagrams, frame
from proving.fuzz.rig import Faults
from proving.fuzz.run import FINDINGS

ROUND: Final = 64
"""Datagrams between two honest heartbeats; a socket's buffer holds them all."""
HEARD_S: Final = 2.0
"""Real seconds within which one of the honest heartbeats must be heard."""
AGAIN_S: Final = 0.02
"""Real seconds between two of them."""
SETTLED_S: Final = 30.0
"""Real seconds of honest messages alone after which the pose must be the honest one: the boot clock was lied to."""
MAVSDK_LOG: Final = "hawk.comm.mavsdk"
_FIRST_MODE: Final = 0x40000000
"""Honest heartbeats count from here; the fields of the fuzzed ones are elsewhere, up to one in 2³²."""
_HONEST_S: Final = 0.1
"""Interval of honest poses at the end, seconds."""
_PLACE: Final = (43.2609, -79.9192, 100.0)
_LOCAL: Final = (3.0, -4.0, -12.0)


@dataclass(slots=True)
class LinkResult:
    """Counts, and what was found."""

    datagrams: int = 0
    strange: int = 0
    honest: int = 0
    states: int = 0
    """States of the vehicle that were published."""
    seconds: float = 0.0
    findings: list[str] = field(default_factory=list)


class LinkRun:
    """Sends cases ``first`` to ``first + datagrams`` of a seed to a link of its own."""

    def __init__(self, seed: int, datagrams: int, first: int = 0) -> None:
        self._cases = Datagrams(seed)
        self._numbers = range(first, first + datagrams)
        self._faults = Faults()
        self._begun = time.monotonic()
        self._changed = asyncio.Event()
        self._sequence = 0
        self.result = LinkResult()

    async def run(self, report: Callable[[LinkResult], None] = lambda _: None) -> LinkResult:
        """Send everything; ``report`` is called after each hundredth."""
        with _collected(self._faults), _sender() as autopilot, _sender() as stranger:
            port = free_udp_port()
            topics = VehicleTopics.create(clock := Clock())
            link = MavsdkAutopilot(AutopilotSettings(url=f"udpin://127.0.0.1:{port}"), clock, topics)
            stop = topics.state.listen(self._note)
            await link.start()
            autopilot.connect(("127.0.0.1", port))
            stranger.connect(("127.0.0.1", port))
            try:
                await self._meet(autopilot, topics)
                await self._rounds(autopilot, stranger, topics, report)
                if not self.result.findings:
                    await self._settle(autopilot, topics)
                    self._note_faults("the end")
            finally:
                stop()
                await link.close()
        return self.result

    async def _rounds(
        self,
        autopilot: socket.socket,
        stranger: socket.socket,
        topics: VehicleTopics,
        report: Callable[[LinkResult], None],
    ) -> None:
        result, begun = self.result, time.monotonic()
        every = max(1, len(self._numbers) // ROUND // 100)
        for at in range(0, len(self._numbers), ROUND):
            numbers = self._numbers[at : at + ROUND]
            for number in numbers:
                case = self._cases.at(number)
                result.strange += case.is_strange
                _send(stranger if case.is_strange else autopilot, case.data)
            result.datagrams += len(numbers)
            if not await self._is_heard(autopilot, topics):
                self._find(f"cases {numbers[0]} to {numbers[-1]}: the honest heartbeat after them was not heard")
            self._note_faults(f"cases {numbers[0]} to {numbers[-1]}")
            result.seconds = time.monotonic() - begun
            if (at // ROUND) % every == 0:
                report(result)
            if len(result.findings) >= FINDINGS:
                break

    async def _meet(self, autopilot: socket.socket, topics: VehicleTopics) -> None:
        """Send honest messages until the link has found the autopilot."""
        async with asyncio.timeout(SETTLED_S):
            while topics.state.value is None or not topics.state.value.connected:
                self._send_honest(autopilot)
                await asyncio.sleep(_HONEST_S)

    async def _is_heard(self, autopilot: socket.socket, topics: VehicleTopics) -> bool:
        """Send an honest heartbeat with a mode of its own; return True when it was heard."""
        mode = _mode(self.result.honest)
        self.result.honest += 1
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(HEARD_S):
                while topics.state.value is None or topics.state.value.custom_mode != mode:
                    self._send_heartbeat(autopilot, mode)
                    self._changed.clear()
                    with contextlib.suppress(TimeoutError):
                        async with asyncio.timeout(AGAIN_S):
                            await self._changed.wait()
                return True
        return False

    async def _settle(self, autopilot: socket.socket, topics: VehicleTopics) -> None:
        """Send honest messages alone; the pose must become the honest one."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(SETTLED_S):
                while not self._is_honest(topics) and not self._faults.found:
                    self._send_honest(autopilot)
                    await asyncio.sleep(_HONEST_S)
                return
        self._find(f"after {SETTLED_S:.0f} s of honest messages the pose is {topics.pose.value}")

    def _is_honest(self, topics: VehicleTopics) -> bool:
        pose, state = topics.pose.value, topics.state.value
        if pose is None or state is None or state.armed or not state.connected:
            return False
        near = math.dist((pose.global_.latitude, pose.global_.longitude), _PLACE[:2]) < 1e-4
        return near and abs(pose.roll - 0.01) < 1e-3

    def _send_honest(self, autopilot: socket.socket) -> None:
        since_boot = int((time.monotonic() - self._begun) * 1000) + 60_000
        latitude, longitude, altitude = _PLACE
        self._send_heartbeat(autopilot, 0)
        for message in (
            mavlink.MAVLink_attitude_message(since_boot, 0.01, 0.02, 0.3, 0.0, 0.0, 0.0),
            mavlink.MAVLink_local_position_ned_message(since_boot, *_LOCAL, 0.0, 0.0, 0.0),
            mavlink.MAVLink_global_position_int_message(
                since_boot, round(latitude * 1e7), round(longitude * 1e7), round(altitude * 1e3), 12_000, 0, 0, 0, 0
            ),
            mavlink.MAVLink_extended_sys_state_message(0, 1),
        ):
            _send(autopilot, message.pack(mavlink.MAVLink(None, *AUTOPILOT)))

    def _send_heartbeat(self, autopilot: socket.socket, mode: int) -> None:
        payload = struct.pack("<IBBBBB", mode, 2, 3, 1, 4, 3)
        _send(autopilot, frame(0, payload, AUTOPILOT, self._sequence))
        self._sequence = (self._sequence + 1) % 256

    def _note(self, state: Any) -> None:
        self.result.states += 1
        if state.custom_mode == STRANGE_MODE:
            self._find(f"a stranger was believed: {state}")
        self._changed.set()

    def _note_faults(self, where: str) -> None:
        for text in self._faults.found:
            self._find(f"{where}: {text}")
        self._faults.found.clear()

    def _find(self, what: str) -> None:
        if len(self.result.findings) < FINDINGS:
            self.result.findings.append(what)


def _mode(number: int) -> int:
    """Return the mode of an honest heartbeat: seven bits a byte, so that none is a start byte of MAVLink."""
    return _FIRST_MODE + sum((number >> 7 * place & 0x7F) << 8 * place for place in range(3))


def _send(target: socket.socket, data: bytes) -> None:
    with contextlib.suppress(ConnectionRefusedError):  # the port is not open yet
        target.send(data)


@contextlib.contextmanager
def _sender() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
        yield opened


@contextlib.contextmanager
def _collected(faults: Faults) -> Iterator[None]:
    """Collect logged errors, and exceptions on MAVSDK's threads, where nobody can raise."""
    root, before = logging.getLogger(), sys.unraisablehook
    faults.addFilter(lambda record: record.name != MAVSDK_LOG)  # MAVSDK calls unknown values errors
    root.addHandler(faults)
    sys.unraisablehook = lambda lost: faults.found.append(f"{lost.err_msg}: {lost.exc_value!r}")
    try:
        yield
    finally:
        sys.unraisablehook = before
        root.removeHandler(faults)
