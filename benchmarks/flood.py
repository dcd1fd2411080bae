"""The whole daemon at speed 1, holding in the air and seeing, while viewers without control send valid commands as fast
as it takes them: the tick beside the same daemon's before the flood, and another client's wait for an answer meanwhile.
The viewers are other computers: their process takes only the processor time that simulator and daemon leave.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import sys
import time
from collections.abc import AsyncIterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

import aiohttp

from benchmarks.figures import BenchmarkError, Figure, Limit, Reference
from benchmarks.flood_viewers import Counts
from benchmarks.processes import CpuTime, cpu_time
from benchmarks.whole_daemon import QUIET_CORES
from hawk.comm.protocol.commands import Arm, Control, SetFailsafes, Takeoff
from hawk.comm.protocol.heartbeat import Heartbeat
from hawk.model.operation import StateName
from hawk.runtime.performance import WINDOW_S, percentile
from hawk.sim.launch import SimulationOptions, end_process
from hawk.survey.client import DroneClient
from hawk.survey.handset import Handset, SurveyError, refusal_of
from hawk.survey.stack import SimulatedStack, StackError

VIEWERS: Final = 8
TICK_MS: Final = 10.0
"""The limit: p99 of the tick under the flood."""
ASK_S: Final = 0.5
"""Between two questions of the operator who waits for an answer."""
SILENCE_S: Final = 15.0
ENDED_S: Final = 10.0
LAST: Final = 19
"""Niceness of the viewers' session."""
CHECKED_S, CLIMBED_S = 120.0, 60.0
"""Longest waits before take-off and during it, seconds."""


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
    try:
        url = (await stack.start()).url
        async with DroneClient(*_address(url)) as operator, DroneClient(*_address(url)) as asker:
            await _take_off(operator)
            found = await _run(url, asker, seconds)
    except (StackError, SurveyError, aiohttp.ClientError, ConnectionError) as error:
        raise BenchmarkError(f"{error} (logs in {folder})") from error
    finally:
        await stack.stop()
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
    if run.cores.get("others", math.inf) > QUIET_CORES:
        reasons.append(f"other programs used {run.cores.get('others', math.nan):.2f} cores meanwhile")
    return f"VOID: {'; '.join(reasons)}" if reasons else ""


def _beside(run: Run, key: str, text: str, limit: Limit | None = None, unit: str = "ms") -> Figure:
    return Figure(f"flood_{key}", text, run.flooded[key], unit, Reference("no flood", run.quiet[key]), limit)


def _wait(run: Run, name: str, percent: float) -> Figure:
    waits, calm = percentile(run.traffic.waits_ms, percent), percentile(run.calm.waits_ms, percent)
    return Figure(
        f"flood_answer_{name}_ms", f"another client's answer, {name}", waits, "ms", Reference("no flood", calm)
    )


async def _take_off(drone: DroneClient) -> None:
    """Arm and climb to the height of the travels, with failsafes set. Raises SurveyError."""
    hand = Handset(drone, SILENCE_S, lambda _, __: None)
    settled = await hand.until(_may_arm_after_setting, CHECKED_S, lambda _: "the checks do not pass")
    await hand.order(Control(action="Request"))
    if not all(check.passed for check in settled.checks):
        await hand.order(SetFailsafes())
    await hand.until(_may_arm, CHECKED_S, lambda _: "the failsafes were not set")
    await hand.order(Arm())
    await hand.until(lambda b: b.armed is True, CLIMBED_S, lambda _: "it was not armed")
    await hand.until(lambda b: not refusal_of(b, "Takeoff"), CLIMBED_S, lambda b: refusal_of(b, "Takeoff"))
    await hand.order(Takeoff())
    await hand.until(lambda b: b.state == StateName.HOVER, CLIMBED_S, lambda _: "it did not climb")


def _may_arm(beat: Heartbeat) -> bool:
    return bool(beat.checks) and all(check.passed for check in beat.checks)


def _may_arm_after_setting(beat: Heartbeat) -> bool:
    return bool(beat.checks) and all(c.passed or c.remedy_command == "Set Failsafes" for c in beat.checks)


async def _run(url: str, asker: DroneClient, seconds: float) -> Run:
    async with aiohttp.ClientSession(timeout=aiohttp.ClientTimeout(total=30)) as session:
        calm, traffic = Traffic(), Traffic()
        async with _asking(asker, calm):
            await asyncio.sleep(seconds)
        quiet = await _performance(session, url)
        before, began = cpu_time(), time.monotonic()
        async with _asking(asker, traffic), _flood(url, traffic):
            await asyncio.sleep(seconds)
            flooded = await _performance(session, url)
            passed, cores = time.monotonic() - began, _cores(before)
    return Run(quiet, flooded, calm, traffic, passed, cores)


def _cores(before: CpuTime) -> dict[str, float]:
    return cpu_time().cores_since(before)


async def _performance(session: aiohttp.ClientSession, url: str) -> dict[str, Any]:
    async with session.get(f"{url}api/performance") as response:
        response.raise_for_status()
        return dict(await response.json())


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


def _address(url: str) -> tuple[str, int]:
    place = urlsplit(url)
    return place.hostname or "127.0.0.1", place.port or 0
