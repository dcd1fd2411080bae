"""The whole daemon at speed 1, flying a survey of a simulated drone, with one headless page that shows video and map:
frame to map, loop lag, heartbeats, beside an idle loop on the same machine at the same time.
"""

from __future__ import annotations

import asyncio
import contextlib
import re
import shutil
from collections.abc import AsyncIterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import aiohttp
from playwright.async_api import async_playwright

from benchmarks.figures import BenchmarkError, Figure, Limit, Reference
from benchmarks.processes import CpuTime, cpu_time
from benchmarks.stack import QUIET_CORES, client, performance, probed, running, void_by
from hawk.comm.protocol.heartbeat import Heartbeat
from hawk.model.operation import StateName
from hawk.sim.launch import SimulationOptions
from hawk.survey.operator import SurveyOperator, SurveyPlan
from hawk.survey.run import LATE_FRAMES_LIMIT
from hawk.survey.stack import Ready, SimulatedStack

CHROMIUM: Final = shutil.which("chromium") or "/usr/bin/chromium"
EXPLORING_S: Final = 300.0
"""Longest time from the start to exploring, seconds."""
SETTLE_S: Final = 3.0
LAG_MS, JITTER_MS, FRAME_TO_MAP_MS, FRAMES_PER_S = 10.0, 20.0, 250.0, 8.0
"""The issue's limits: lag or twice the idle loop's, jitter above the idle timer's, frame to map, vision."""
LEAST_S: Final = 10.0
"""A lot that is explored sooner gives no figures."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Readings at one end of the measured time."""

    cpu: CpuTime
    simulator: Mapping[str, Any]
    metrics: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Run:
    """All that was read in one run; ``idle`` and ``heartbeats`` as the probes print it."""

    ready: Ready
    before: Sample
    after: Sample
    performance: Mapping[str, Any]
    idle: Mapping[str, Any]
    heartbeats: Mapping[str, Any]

    @property
    def seconds(self) -> float:
        """Real seconds that were measured."""
        return self.after.cpu.at - self.before.cpu.at

    @property
    def late_frames(self) -> float | None:
        """Share of the pictures due meanwhile that the simulator drew late or not at all."""
        due, late = self._counted("frames_due"), self._counted("frames_late")
        return late / due if due else None

    @property
    def camera_fps(self) -> float:
        """Pictures that the simulator drew each second."""
        return self._counted("frames_drawn") / self.seconds

    @property
    def page_frames_per_s(self) -> float:
        """Pictures that the page got each second."""
        key = "hawk_video_frames_total"
        return (self.after.metrics.get(key, 0.0) - self.before.metrics.get(key, 0.0)) / self.seconds

    def _counted(self, key: str) -> float:
        return float(self.after.simulator[key] - self.before.simulator[key])


async def measure(seconds: float, seed: int, folder: Path) -> tuple[list[Figure], str]:
    """Fly and measure for so long while exploring; return the figures, and why they are void if they are.

    Raises BenchmarkError.
    """
    stack = SimulatedStack(SimulationOptions(seed=seed, speed=1.0), folder, None, None)
    async with running(stack, folder) as ready, _page(ready.url), _exploring(ready.url) as ended:
        run = await _sample(stack, ready, seconds, ended)
    return figures(run), void(run)


def figures(run: Run) -> list[Figure]:
    """Return the figures of a run."""
    return [*_frame_figures(run), *_loop_figures(run), *_machine_figures(run)]


def void(run: Run) -> str:
    """Return why the figures do not count, empty when they do."""
    reasons = []
    if run.seconds < LEAST_S:
        reasons.append(f"the drone explored for {run.seconds:.1f} s only")
    if run.late_frames is None or run.late_frames > LATE_FRAMES_LIMIT:
        reasons.append("the simulator drew more than 1 % of its pictures late")
    if run.page_frames_per_s == 0:
        reasons.append("the page got no video")
    return void_by(reasons, run.after.cpu.cores_since(run.before.cpu))


def parse_metrics(text: str) -> dict[str, float]:
    """Return the unlabelled values of a Prometheus text."""
    return {name: float(value) for name, value in re.findall(r"^(\w+) (\S+)$", text, re.MULTILINE)}


def _frame_figures(run: Run) -> list[Figure]:
    measured = run.performance
    steps = measured.get("steps_p50_ms") or {}
    return [
        Figure("frame_to_map_p50_ms", "light caught to map published, p50", measured["frame_to_map_p50_ms"], "ms"),
        Figure(
            "frame_to_map_p95_ms", "light caught to map published, p95", measured["frame_to_map_p95_ms"], "ms",
            limit=Limit(highest=FRAME_TO_MAP_MS),
        ),
        Figure(
            "vision_fps", "frames fused", measured["vision_fps"], "1/s",
            reference=Reference("camera", run.camera_fps), limit=Limit(lowest=FRAMES_PER_S),
        ),
        Figure("frames_dropped_share", "frames replaced by newer ones", measured["frames_dropped_share"]),
        *(Figure(_step_key(name), f"step {name}, p50", value, "ms") for name, value in steps.items()),
        Figure("page_video_fps", "pictures to the page", run.page_frames_per_s, "1/s"),
    ]  # fmt: skip


def _step_key(name: str) -> str:
    return f"step_{name.replace(' ', '_')}_p50_ms"


def _loop_figures(run: Run) -> list[Figure]:
    measured, idle, beats = run.performance, run.idle, run.heartbeats
    highest_lag = max(LAG_MS, 2 * idle["lag_p99_ms"])
    return [
        Figure(
            "loop_lag_p50_ms", "loop lag, p50", measured["loop_lag_p50_ms"], "ms",
            Reference("idle loop", idle["lag_p50_ms"]),
        ),
        Figure(
            "loop_lag_p99_ms", "loop lag, p99", measured["loop_lag_p99_ms"], "ms",
            Reference("idle loop", idle["lag_p99_ms"]), Limit(highest=highest_lag),
        ),
        Figure(
            "loop_lag_max_ms", "loop lag, longest", measured["loop_lag_max_ms"], "ms",
            Reference("idle loop", idle["lag_max_ms"]),
        ),
        Figure("loop_lag_idle_p50_ms", "idle loop's lag, p50", idle["lag_p50_ms"], "ms"),
        Figure("loop_lag_idle_p99_ms", "idle loop's lag, p99", idle["lag_p99_ms"], "ms"),
        Figure("loop_lag_idle_max_ms", "idle loop's lag, longest", idle["lag_max_ms"], "ms"),
        Figure("tick_p99_ms", "one tick of the state machine, p99", measured["tick_p99_ms"], "ms"),
        Figure(
            "heartbeat_jitter_p99_ms", "heartbeat jitter, p99", beats["jitter_p99_ms"], "ms",
            Reference("idle timer", idle["jitter_p99_ms"]), Limit(highest=(idle["jitter_p99_ms"] or 0.0) + JITTER_MS),
        ),
        Figure("heartbeat_jitter_idle_p99_ms", "idle 5 Hz timer's jitter, p99", idle["jitter_p99_ms"], "ms"),
        Figure("heartbeat_hz", "heartbeats at a client", beats["rate_hz"], "1/s", limit=Limit(4.9, 5.1)),
    ]  # fmt: skip


def _machine_figures(run: Run) -> list[Figure]:
    cores = run.after.cpu.cores_since(run.before.cpu)
    return [
        Figure("start_to_first_tick_s", "process start to first tick", run.ready.first_tick_s, "s"),
        Figure("late_frames", "late frames of the simulator", run.late_frames, limit=Limit(highest=LATE_FRAMES_LIMIT)),
        Figure("measured_s", "measured", run.seconds, "s"),
        *(
            Figure(f"cores_{name}", f"cores used: {name}", cores.get(name))
            for name in ("daemon", "simulator", "browser", "benchmark")
        ),
        Figure("cores_others", "cores used: others", cores["others"], limit=Limit(highest=QUIET_CORES)),
    ]


async def _sample(stack: SimulatedStack, ready: Ready, seconds: float, ended: asyncio.Event) -> Run:
    """Read everything at both ends; a lot that is explored sooner ends the measured time."""
    async with aiohttp.ClientSession(timeout=aiohttp.ClientTimeout(total=10)) as session, probed(ready.url) as probes:
        before = await _look(stack, session, ready.url)
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                await ended.wait()
        after = await _look(stack, session, ready.url)
        measured = await performance(ready.url)
    return Run(ready, before, after, measured, probes["idle"], probes["heartbeats"])


async def _look(stack: SimulatedStack, session: aiohttp.ClientSession, url: str) -> Sample:
    async with session.get(f"{url}metrics") as response:
        response.raise_for_status()
        text = await response.text()
    return Sample(cpu_time(), await stack.status(), parse_metrics(text))


@contextlib.asynccontextmanager
async def _page(url: str) -> AsyncIterator[None]:
    """Show the operator's page in a browser without a window."""
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic"]
        )
        page = await browser.new_page(viewport={"width": 1440, "height": 900})
        await page.goto(url)
        yield
        await browser.close()


@contextlib.asynccontextmanager
async def _exploring(url: str) -> AsyncIterator[asyncio.Event]:
    """Fly until the drone explores; the event is set when it does so no more. The flight is given up at the end.

    Raises BenchmarkError with the drone's reason when it does not get so far.
    """
    begun, ended = asyncio.Event(), asyncio.Event()

    def watch(_: str, beat: Heartbeat) -> None:
        if beat.state == StateName.AUTONOMOUS_EXPLORE:
            begun.set()
        elif begun.is_set():
            ended.set()

    async with client(url) as drone:
        operator = SurveyOperator(drone, SurveyPlan(set_failsafes=True), watch)
        flight = asyncio.create_task(operator.run(), name="benchmark-flight")
        waiting = asyncio.create_task(begun.wait(), name="benchmark-exploring")
        try:
            await asyncio.wait({flight, waiting}, timeout=EXPLORING_S, return_when=asyncio.FIRST_COMPLETED)
            if not begun.is_set():
                reason = flight.result().reason if flight.done() else f"not after {EXPLORING_S:.0f} s"
                raise BenchmarkError(f"the drone did not explore: {reason}")
            await asyncio.sleep(SETTLE_S)
            yield ended
        finally:
            for task in (flight, waiting):
                task.cancel()
            await asyncio.gather(flight, waiting, return_exceptions=True)
