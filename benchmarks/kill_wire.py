"""Kill on the wire: from the call of `MavsdkAutopilot.kill` to MAV_CMD_DO_FLIGHTTERMINATION at the other end of a UDP
link, while the loop's default executor is blocked and the commands' threads wait for an autopilot that is silent.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import threading
import time
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from typing import Final

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from benchmarks.figures import BenchmarkError, Figure, Limit
from hawk.comm.autopilot.autopilot import MavsdkAutopilot
from hawk.comm.autopilot.vehicle import AutopilotError, VehicleTopics
from hawk.comm.clock import Clock
from hawk.config.sections import AutopilotSettings
from hawk.model.vehicle import CopterMode
from hawk.runtime.performance import percentile
from hawk.sim.launch import free_udp_port

LIMIT_MS: Final = 100.0
PAUSE_S: Final = 0.02
"""Between two kills."""
FOUND_S: Final = 20.0
ARRIVED_S: Final = 2.0
BLOCKED_COMMANDS: Final = 4
DEFAULT_WORKERS: Final = 2
_READ_S: Final = 0.05
_HEARTBEAT_S: Final = 0.25


class SilentAutopilot:
    """A UDP peer on a thread: sends an ArduCopter's heartbeats, answers nothing, notes when each kill arrives."""

    def __init__(self, port: int) -> None:
        self._port = port
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._mavlink = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self._thread = threading.Thread(target=self._run, name="silent-autopilot", daemon=True)
        self._ended = threading.Event()
        self._arrived = threading.Condition()
        self.arrivals: list[float] = []
        """`time.perf_counter` of each kill."""

    def start(self) -> None:
        """Begin to send."""
        self._socket.settimeout(_READ_S)
        self._thread.start()

    def close(self) -> None:
        """End the thread and close the socket."""
        self._ended.set()
        self._thread.join()
        self._socket.close()

    def wait_for(self, count: int, timeout_s: float) -> float:
        """Return when the kill of that number (from 1) arrived. Blocks. Raises BenchmarkError."""
        with self._arrived:
            if not self._arrived.wait_for(lambda: len(self.arrivals) >= count, timeout_s):
                raise BenchmarkError(f"kill {count} did not arrive within {timeout_s:g} s")
            return self.arrivals[count - 1]

    def _run(self) -> None:
        due = 0.0
        while not self._ended.is_set():
            if time.monotonic() >= due:
                due = time.monotonic() + _HEARTBEAT_S
                self._beat()
            with contextlib.suppress(TimeoutError, ConnectionError):
                self._take(self._socket.recv(2048), time.perf_counter())

    def _beat(self) -> None:
        flags = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | mavlink.MAV_MODE_FLAG_SAFETY_ARMED
        beat = mavlink.MAVLink_heartbeat_message(
            mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, flags, CopterMode.GUIDED,
            mavlink.MAV_STATE_ACTIVE, 3,
        )  # fmt: skip
        self._socket.sendto(beat.pack(self._mavlink), ("127.0.0.1", self._port))

    def _take(self, datagram: bytes, at: float) -> None:
        for message in self._mavlink.parse_buffer(datagram) or ():
            is_command = message.get_type() == "COMMAND_LONG"
            if is_command and message.command == mavlink.MAV_CMD_DO_FLIGHTTERMINATION:
                with self._arrived:
                    self.arrivals.append(at)
                    self._arrived.notify_all()


async def measure(kills: int) -> list[Figure]:
    """Kill so often. Raises BenchmarkError."""
    loop = asyncio.get_running_loop()
    release = threading.Event()
    default = ThreadPoolExecutor(DEFAULT_WORKERS, "default-blocked")
    loop.set_default_executor(default)
    blocked = [loop.run_in_executor(None, release.wait) for _ in range(DEFAULT_WORKERS + 1)]
    try:
        async with _link() as (autopilot, peer), _busy_commands(autopilot):
            delays = [await _kill(autopilot, peer, number) for number in range(1, kills + 1)]
    finally:
        release.set()
        await asyncio.gather(*blocked)
    return figures(delays)


def figures(delays_ms: list[float]) -> list[Figure]:
    """Return the figures of the delays."""
    return [
        Figure("kill_to_wire_p50_ms", "Kill, call to wire, p50", percentile(delays_ms, 50), "ms"),
        Figure(
            "kill_to_wire_p99_ms", "Kill, call to wire, p99", percentile(delays_ms, 99), "ms",
            limit=Limit(highest=LIMIT_MS),
        ),
        Figure("kill_to_wire_max_ms", "Kill, call to wire, longest", max(delays_ms, default=None), "ms"),
        Figure("kills", "kills measured", float(len(delays_ms))),
    ]  # fmt: skip


async def _kill(autopilot: MavsdkAutopilot, peer: SilentAutopilot, number: int) -> float:
    """Kill once; return the milliseconds until it was on the wire."""
    await asyncio.sleep(PAUSE_S)
    called = time.perf_counter()
    await autopilot.kill()
    return (peer.wait_for(number, ARRIVED_S) - called) * 1e3


@contextlib.asynccontextmanager
async def _link() -> AsyncIterator[tuple[MavsdkAutopilot, SilentAutopilot]]:
    """Connect the real autopilot's side to a silent one."""
    port = free_udp_port()
    clock = Clock(1.0)
    topics = VehicleTopics.create(clock)
    autopilot = MavsdkAutopilot(AutopilotSettings(url=f"udpin://127.0.0.1:{port}"), clock, topics)
    peer = SilentAutopilot(port)
    peer.start()
    try:
        await autopilot.start()
        async with asyncio.timeout(FOUND_S):
            while not (topics.state.value and topics.state.value.connected):
                await topics.state.next()
        yield autopilot, peer
    except TimeoutError as error:
        raise BenchmarkError(f"MAVSDK did not find the autopilot within {FOUND_S:g} s") from error
    finally:
        await autopilot.close()
        peer.close()


@contextlib.asynccontextmanager
async def _busy_commands(autopilot: MavsdkAutopilot) -> AsyncIterator[None]:
    """Keep more commands waiting for their acknowledgement than there are threads for them."""
    ended = asyncio.Event()

    async def ask() -> None:
        while not ended.is_set():
            with contextlib.suppress(AutopilotError):
                await autopilot.set_mode(CopterMode.GUIDED)

    asking = [asyncio.create_task(ask(), name=f"blocked-command-{k}") for k in range(BLOCKED_COMMANDS)]
    try:
        yield
    finally:
        ended.set()
        await asyncio.gather(*asking)  # a call into MAVSDK cannot be cancelled: each ends by its own time limit
