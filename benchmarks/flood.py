"""The whole daemon at speed 1, holding in the air and seeing, while viewers without control send valid commands as fast
as it takes them: the tick beside the same daemon's before the flood, and another client's wait for an answer meanwhile.
The viewers are other computers: their process takes only the processor time that simulator and daemon leave.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
import time
from collections.abc import AsyncIterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from benchmarks.figures import Figure, Limit, Reference
from benchmarks.flood_viewers import Counts
from benchmarks.processes import cpu_time
from benchmarks.stack import QUIET_CORES, client, performance, running, void_by
from hawk.comm.protocol.commands import Arm
from hawk.runtime.performance import WINDOW_S, percentile
from hawk.sim.launch import SimulationOptions, end_process
from hawk.survey.client import DroneClient
from hawk.survey.stack import SimulatedStack
from proving.faults.fault import When
from proving.faults.pilot import Pilot

VIEWERS: Final = 8
TICK_MS: Final = 10.0
"""The limit: p99 of the tick under the flood."""
ASK_S: Final = 0.5
"""Between two questions of the operator who waits for an answer."""
ENDED_S: Final = 10.0
LAST: Final = 19
"""Niceness of the viewers' session."""


@dataclass(slots=True)
class Traffic(Counts):
    """Counts of all viewers, and the operator's waits in milliseconds."""

    waits_ms: list[float] = field(default_factory=list)

    def take(self, counts: Mapping[str, int]) -> None:
        """Take the viewers' counts."""
        for name, count in counts.items():
            setattr(self, name, count)


@dataclass(frozen=True, slots=True)
class Run:
    """Performance as the daemon shows it, before and during the flood."""

    quiet: Mapping[str, Any]
    flooded: Mapping[str, Any]
    calm: Traffic
    traffic: Traffic
    seconds: float
    cores: Mapping[str, float]


async def measure(seconds: float, seed: int, folder: Path) -> tuple[list[Figure], str]:
    """Fly, measure for this time without and with the flood; return the figures, and why they are void if they are.

    Raises BenchmarkError.
    """
    stack = SimulatedStack(SimulationOptions(seed=seed, speed=1.0), folder, None, None)
    async with running(stack, folder) as ready:
        pilot = await Pilot.connect(ready.url)
        try:
            await pilot.reach(When.HOVERING)
            async with client(ready.url) as asker:
                found = await _run(ready.url, asker, seconds)
        finally:
            await pilot.close()
    return figures(found), void(found)


def figures(run: Run) -> list[Figure]:
    """Return the figures of a run."""
    traffic, seconds = run.traffic, max(run.seconds, 1e-9)
    return [
        _beside(run, "tick_p50_ms", "one tick under the flood, p50"),
        _beside(run, "tick_p99_ms", "one tick under the flood, p99", Limit(highest=TICK_MS)),
        _beside(run, "tick_max_ms", "one tick under the flood, longest"),
        _beside(run, "loop_lag_p99_ms", "loop lag under the flood, p99"),
        _beside(run, "vision_fps", "frames fused under the flood", unit="1/s"),
        *(_wait(run, name, percent) for name, percent in (("p50", 50.0), ("p99", 99.0), ("max", 100.0))),
        Figure("flood_viewers", "viewers that flood", float(VIEWERS)),
        Figure("flood_sent_per_s", "commands sent", traffic.sent / seconds, "1/s"),
        Figure("flood_answered_per_s", "answers", traffic.answered / seconds, "1/s"),
        Figure("flood_refused_share", "refused as too many", traffic.refused_as_too_many / max(traffic.answered, 1)),
        Figure("flood_disconnected", "connections ended as floods", float(traffic.disconnected)),
        Figure("flood_measured_s", "measured", run.seconds, "s"),
        Figure("flood_cores_daemon", "cores used: daemon", run.cores.get("daemon")),
        Figure("flood_cores_others", "cores used: others", run.cores.get("others"), limit=Limit(highest=QUIET_CORES)),
    ]


def void(run: Run) -> str:
    """Return why the figures do not count, empty when they do."""
    reasons = []
    if run.seconds < WINDOW_S:
        reasons.append(f"the flood lasted {run.seconds:.0f} s, the daemon's figures cover {WINDOW_S:.0f} s")
    return void_by(reasons, run.cores)


def _beside(run: Run, key: str, text: str, limit: Limit | None = None, unit: str = "ms") -> Figure:
    return Figure(f"flood_{key}", text, run.flooded[key], unit, Reference("no flood", run.quiet[key]), limit)


def _wait(run: Run, name: str, percent: float) -> Figure:
    waits, calm = percentile(run.traffic.waits_ms, percent), percentile(run.calm.waits_ms, percent)
    return Figure(
        f"flood_answer_{name}_ms", f"another client's answer, {name}", waits, "ms", Reference("no flood", calm)
    )


async def _run(url: str, asker: DroneClient, seconds: float) -> Run:
    calm, traffic = Traffic(), Traffic()
    async with _asking(asker, calm):
        await asyncio.sleep(seconds)
    quiet = await performance(url)
    before, began = cpu_time(), time.monotonic()
    async with _asking(asker, traffic), _flood(url, traffic):
        await asyncio.sleep(seconds)
        flooded = await performance(url)
        passed, cores = time.monotonic() - began, cpu_time().cores_since(before)
    return Run(quiet, flooded, calm, traffic, passed, cores)


@contextlib.asynccontextmanager
async def _flood(url: str, traffic: Traffic, niceness: int = LAST) -> AsyncIterator[None]:
    """Let the viewers send from a process of their own; their counts are there afterwards."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "benchmarks.flood_viewers", url, str(VIEWERS), str(niceness),
        stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, start_new_session=True,
    )  # fmt: skip
    try:
        yield
    finally:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(ENDED_S):
                out, _ = await process.communicate(b"")
            traffic.take(json.loads(out or b"{}"))
        await end_process(process, ENDED_S)


@contextlib.asynccontextmanager
async def _asking(drone: DroneClient, traffic: Traffic) -> AsyncIterator[None]:
    """Ask a question that waits for a tick, again and again."""

    async def ask() -> None:
        while True:
            asked = time.perf_counter()
            await drone.ask(Arm())  # refused by the tick: someone else has control
            traffic.waits_ms.append((time.perf_counter() - asked) * 1e3)
            await asyncio.sleep(ASK_S)

    asking = asyncio.create_task(ask(), name="operator-asks")
    try:
        yield
    finally:
        asking.cancel()
        await asyncio.gather(asking, return_exceptions=True)
