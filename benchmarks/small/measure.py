"""A whole survey by a daemon in the small box: start, loop, heartbeats, frames and memory, and what came of it."""

from __future__ import annotations

import asyncio
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import aiohttp

from benchmarks.figures import BenchmarkError, Figure, Limit, Reference
from benchmarks.small.box import Box
from benchmarks.small.lot import SCALE, DrawnLot
from benchmarks.stack import client, performance, probed, running
from hawk.runtime.performance import WINDOW_S
from hawk.sim.launch import SimulationOptions
from hawk.survey.handset import SurveyStatus
from hawk.survey.operator import SurveyOperator, SurveyPlan
from hawk.survey.run import LATE_FRAMES_LIMIT
from hawk.survey.stack import Ready, SimulatedStack

LAG_MS: Final = 20.0
JITTER_MS: Final = 20.0
"""Above that of an idle timer on another core."""
START_S: Final = 3.0
MEMORY_MIB: Final = 400.0
SURVEY_S: Final = 1500.0
SAMPLE_S: Final = 1.0
_MIB: Final = 2**20


class BoxedStack(SimulatedStack):
    """A simulated drone outside of the box, and its daemon within it."""

    def __init__(self, options: SimulationOptions, folder: Path, box: Box) -> None:
        super().__init__(options, folder, None, None)
        self._box = box
        self.page_s = 0.0
        """Real seconds from the start of the daemon's process to the page in a client's hands."""

    async def start_daemon(self) -> Ready:
        """Start the daemon and fetch its page."""
        began = time.monotonic()
        ready = await super().start_daemon()
        async with aiohttp.ClientSession() as session, session.get(ready.url) as response:
            response.raise_for_status()
            await response.read()
        self.page_s = time.monotonic() - began
        return ready

    def daemon_command(self, ready: Path, *, store: Path | None = None, port: int | None = None) -> list[str]:
        """Return the daemon's command line within the box."""
        return [*self._box.prefix, *super().daemon_command(ready, store=store, port=port)]


@dataclass(slots=True)
class Readings:
    """All that was read during a flight. ``lags_ms``: p99 of the loop's lag, a value for each whole minute."""

    page_s: float = 0.0
    lags_ms: list[float] = field(default_factory=list)
    anonymous: list[int] = field(default_factory=list)
    peak: int | None = None
    vision_fps: list[float] = field(default_factory=list)
    camera_fps: float = 0.0
    late_frames: float | None = None
    idle: dict[str, Any] = field(default_factory=dict)
    heartbeats: dict[str, Any] = field(default_factory=dict)
    outcome: str = ""
    is_done: bool = False
    seconds: float = 0.0


async def measure(lot: DrawnLot, box: Box, folder: Path) -> tuple[list[Figure], str]:
    """Fly over the whole lot; return the figures, and why they are void if they are. Raises BenchmarkError."""
    options = SimulationOptions(world=lot.picture, metres_per_pixel=SCALE, truth=lot.truth, speed=1.0)
    stack = BoxedStack(options, folder, box)
    readings = Readings()
    async with running(stack, folder) as ready:
        readings.page_s = stack.page_s
        async with probed(ready.url) as probes:
            await _fly(stack, ready, box, readings)
        readings.idle, readings.heartbeats = probes["idle"], probes["heartbeats"]
        readings.peak = box.peak_bytes()
    return figures(readings, lot), problem(readings)


def figures(read: Readings, lot: DrawnLot) -> list[Figure]:
    """Return the figures of a flight."""
    idle_jitter, idle_lag = read.idle.get("jitter_p99_ms"), read.idle.get("lag_p99_ms")
    mib = [value / _MIB for value in read.anonymous]
    return [
        Figure("small_start_s", "start of the daemon to the page", read.page_s, "s", limit=Limit(highest=START_S)),
        Figure(
            "small_lag_p99_ms", "loop lag, p99 of the worst minute", max(read.lags_ms, default=None), "ms",
            Reference("idle loop on another core", idle_lag), Limit(highest=LAG_MS),
        ),
        Figure("small_heartbeat_hz", "heartbeats", read.heartbeats.get("rate_hz"), "1/s", limit=Limit(4.9, 5.1)),
        Figure(
            "small_heartbeat_jitter_p99_ms", "heartbeat jitter, p99", read.heartbeats.get("jitter_p99_ms"), "ms",
            Reference("idle timer on another core", idle_jitter), Limit(highest=(idle_jitter or 0.0) + JITTER_MS),
        ),
        Figure(
            "small_vision_fps", "frames fused, least", min(read.vision_fps, default=None), "1/s",
            Reference("camera", read.camera_fps),
        ),
        Figure(
            "small_memory_mib", "memory of its processes, most", max(mib, default=None), "MiB",
            limit=Limit(highest=MEMORY_MIB),
        ),
        Figure(
            "small_memory_all_mib", "with the files that it read, most",
            None if read.peak is None else read.peak / _MIB, "MiB",
        ),
        Figure("small_survey_done", "survey done", float(read.is_done), limit=Limit(lowest=1.0)),
        Figure("small_survey_s", "from the checks to motors off", read.seconds, "s"),
        Figure("small_lot_ha", "lot", lot.hectares, "ha"),
        Figure("small_lot_stalls", "stalls in it", float(lot.stalls)),
    ]  # fmt: skip


def problem(read: Readings) -> str:
    """Return why the figures do not count, or why the survey was not done; empty when all is well."""
    if read.late_frames is None or read.late_frames > LATE_FRAMES_LIMIT:
        return "VOID: the simulator drew more than 1 % of its pictures late"
    return "" if read.is_done else f"the survey was not done: {read.outcome}"


async def _fly(stack: SimulatedStack, ready: Ready, box: Box, readings: Readings) -> None:
    before = await stack.status()
    began = time.monotonic()
    async with client(ready.url) as drone:
        watch = asyncio.create_task(_watch(ready.url, box, readings), name="small-watch")
        try:
            async with asyncio.timeout(SURVEY_S):
                outcome = await SurveyOperator(drone, SurveyPlan(set_failsafes=True)).run()
        except TimeoutError:
            raise BenchmarkError(f"the survey took more than {SURVEY_S:.0f} s") from None
        finally:
            watch.cancel()
            await asyncio.gather(watch, return_exceptions=True)
    readings.seconds = time.monotonic() - began
    readings.outcome, readings.is_done = outcome.reason, outcome.status is SurveyStatus.DONE
    after = await stack.status()
    due, late, drawn = (after[key] - before[key] for key in ("frames_due", "frames_late", "frames_drawn"))
    readings.late_frames = late / due if due else None
    readings.camera_fps = drawn / readings.seconds


async def _watch(url: str, box: Box, readings: Readings) -> None:
    """Read memory every second, and the daemon's own account of each whole minute."""
    next_minute = time.monotonic() + WINDOW_S
    while True:
        readings.anonymous.append(box.anonymous_bytes())
        if time.monotonic() >= next_minute:
            next_minute += WINDOW_S
            values = await performance(url)
            for values_of, key in ((readings.lags_ms, "loop_lag_p99_ms"), (readings.vision_fps, "vision_fps")):
                if values.get(key) is not None:
                    values_of.append(float(values[key]))
        await asyncio.sleep(SAMPLE_S)
