"""Kill through the whole daemon at full load: from the operator's confirmation to MAV_CMD_DO_FLIGHTTERMINATION on the
wire, while the drone holds above a lot, vision works without a pause, and slow clients watch the video.

A relay between autopilot and daemon notes when each Kill arrives and keeps it from the drone, which flies on, so that
one flight gives many. The time holds the transport of the operator's message, the tick and MAVSDK.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import AsyncIterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import aiohttp
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from benchmarks.figures import BenchmarkError, Figure, Limit, Reference
from benchmarks.processes import cpu_time
from benchmarks.stack import QUIET_CORES, performance, running, void_by
from hawk.comm.protocol.commands import Kill, KillRequest, KillToken
from hawk.runtime.performance import percentile
from hawk.sim.launch import SimulationOptions
from hawk.survey.stack import SimulatedStack
from hawk.web.video.video_wire import HEADER
from proving.faults.fault import When
from proving.faults.pilot import Pilot
from proving.faults.proxy import Direction, Proxy

CLIENTS: Final = 16
FRAME_TAKES_S: Final = 0.3
"""Time that a slow client needs for a frame, seconds."""
LIMIT_MS: Final = 100.0
ARRIVES_S: Final = 4.0
ENDED_S: Final = 8.0
LEAST_KILLS: Final = 20
LEAST_FPS: Final = 5.0
"""A vision that fuses fewer frames a second is not at full load."""


@dataclass(frozen=True, slots=True)
class Run:
    """Milliseconds of each Kill: ``calm_ms`` of those before the clients came; and the load meanwhile."""

    calm_ms: list[float]
    loaded_ms: list[float]
    performance: Mapping[str, Any]
    frames_per_s: float
    cores: Mapping[str, float]


async def measure(kills: int, seed: int, folder: Path) -> tuple[list[Figure], str]:
    """Fly, cut the motors so often before and with the clients; return figures, and why they are void if they are.

    Raises BenchmarkError.
    """
    wire = KillWire()
    stack = SimulatedStack(SimulationOptions(seed=seed, speed=1.0), folder, None, None, wire.proxy.open)
    try:
        async with running(stack, folder) as ready:
            pilot = await Pilot.connect(ready.url)
            try:
                await pilot.reach(When.HOVERING)
                found = await _run(stack, pilot, ready.url, wire, kills)
            finally:
                await pilot.close()
    finally:
        wire.proxy.close()
    return figures(found), void(found)


def figures(run: Run) -> list[Figure]:
    """Return the figures of a run."""
    calm = Reference("no viewers", percentile(run.calm_ms, 99))
    return [
        Figure("kill_loaded_p50_ms", "Kill, confirmed to wire, p50", percentile(run.loaded_ms, 50), "ms",
               Reference("no viewers", percentile(run.calm_ms, 50))),
        Figure("kill_loaded_p99_ms", "Kill, confirmed to wire, p99", percentile(run.loaded_ms, 99), "ms", calm,
               Limit(highest=LIMIT_MS)),
        Figure("kill_loaded_max_ms", "Kill, confirmed to wire, longest", max(run.loaded_ms, default=None), "ms"),
        Figure("kill_loaded_kills", "kills measured", float(len(run.loaded_ms))),
        Figure("kill_loaded_clients", "slow video clients", float(CLIENTS)),
        Figure("kill_loaded_client_fps", "frames that a slow client took", run.frames_per_s / CLIENTS, "1/s"),
        Figure("kill_loaded_vision_fps", "frames fused", run.performance["vision_fps"], "1/s",
               limit=Limit(lowest=LEAST_FPS)),
        Figure("kill_loaded_tick_p99_ms", "one tick, p99", run.performance["tick_p99_ms"], "ms"),
        Figure("kill_loaded_lag_p99_ms", "loop lag, p99", run.performance["loop_lag_p99_ms"], "ms"),
        Figure("kill_loaded_cores_daemon", "cores used: daemon", run.cores.get("daemon")),
        Figure("kill_loaded_cores_others", "cores used: others", run.cores.get("others"),
               limit=Limit(highest=QUIET_CORES)),
    ]  # fmt: skip


def void(run: Run) -> str:
    """Return why the figures do not count, empty when they do."""
    reasons = []
    if len(run.loaded_ms) < LEAST_KILLS:
        reasons.append(f"{len(run.loaded_ms)} kills are too few")
    return void_by(reasons, run.cores)


async def _run(stack: SimulatedStack, pilot: Pilot, url: str, wire: KillWire, kills: int) -> Run:
    calm = [await _kill(stack, pilot, wire) for _ in range(max(1, kills // 4))]
    before, began = cpu_time(), time.monotonic()
    async with _viewers(url) as taken:
        loaded = [await _kill(stack, pilot, wire) for _ in range(kills)]
        measured = await performance(url)
        frames_per_s = taken[0] / (time.monotonic() - began)
    return Run(calm, loaded, measured, frames_per_s, cpu_time().cores_since(before))


async def _kill(stack: SimulatedStack, pilot: Pilot, wire: KillWire) -> float:
    """Cut the motors once; return the milliseconds from the confirmation to the wire."""
    await stack.inject({"battery": 100.0})
    token = await pilot.drone.ask(KillRequest())
    if not isinstance(token, KillToken):
        raise BenchmarkError(f"no token for a Kill: {token}")
    wire.arrived = asyncio.get_running_loop().create_future()
    asked = time.perf_counter()
    reason = await pilot.order(Kill(token=token.token))
    if reason is not None:
        raise BenchmarkError(f"Kill was refused: {reason}")
    try:
        async with asyncio.timeout(ARRIVES_S):
            at = await wire.arrived
    except TimeoutError:
        raise BenchmarkError(f"a Kill did not arrive within {ARRIVES_S:g} s") from None
    async with asyncio.timeout(ENDED_S):
        while (await pilot.drone.next_heartbeat(ENDED_S)).kill_state != "not confirmed":
            pass
    return (at - asked) * 1e3


class KillWire:
    """The link between autopilot and daemon: it keeps every Kill from the drone."""

    def __init__(self) -> None:
        self.proxy = Proxy(1.0, passes=self.passes)
        self.arrived: asyncio.Future[float] | None = None
        self._decoder = mavlink.MAVLink(None)
        self._decoder.robust_parsing = True

    def passes(self, direction: Direction, data: bytes) -> bool:
        """Return True for every datagram that holds no Kill."""
        if direction is Direction.DOWN:
            return True
        at = time.perf_counter()
        for message in self._decoder.parse_buffer(data) or ():
            if message.get_type() == "COMMAND_LONG" and message.command == mavlink.MAV_CMD_DO_FLIGHTTERMINATION:
                if self.arrived is not None and not self.arrived.done():
                    self.arrived.set_result(at)
                return False
        return True


@contextlib.asynccontextmanager
async def _viewers(url: str) -> AsyncIterator[list[int]]:
    """Let slow clients watch; gives the count of frames that they took so far."""
    taken = [0]
    async with aiohttp.ClientSession() as session, asyncio.TaskGroup() as group:
        viewers = [group.create_task(_watch(session, url, taken), name=f"viewer-{k}") for k in range(CLIENTS)]
        try:
            yield taken
        finally:
            for viewer in viewers:
                viewer.cancel()


async def _watch(session: aiohttp.ClientSession, url: str, taken: list[int]) -> None:
    async with session.ws_connect(f"{url}video", max_msg_size=0) as socket:
        async for message in socket:
            if message.type is not aiohttp.WSMsgType.BINARY:
                continue
            taken[0] += 1
            await asyncio.sleep(FRAME_TAKES_S)
            await socket.send_json({"ack": HEADER.unpack_from(message.data)[1]})
    raise BenchmarkError("a viewer was disconnected")
