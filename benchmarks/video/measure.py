"""One measurement: a server with viewers and a page beside them, several times, and the figures of all."""

from __future__ import annotations

import asyncio
import json
import sys
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Final

from benchmarks.figures import BenchmarkError, Figure, Limit, Reference
from benchmarks.video import servers
from benchmarks.video.clients import Order
from hawk.runtime.performance import percentile

SOCKET: Final = "socket"
STREAM: Final = "stream"
USTREAMER: Final = "ustreamer"
PATHS: Final = {SOCKET: "/video", STREAM: "/stream.mjpg", USTREAMER: "/stream"}
NAMES: Final = {SOCKET: "/video", STREAM: "/stream.mjpg", USTREAMER: "µStreamer"}
FPS: Final = 30.0
SLOW_BYTES_PER_S: Final = 12e6 / 8
STALL_S: Final = 5.0
WARM_UP_S: Final = 2.0
STALE_MS: Final = 1000.0
FAST_LIMIT, SLOW_LIMIT, CPU_LIMIT, CONTROL_MS = 0.7, 0.1, 0.8, 30.0
LEAST_SHARE: Final = 0.95
"""Of the pictures that a fast viewer receives: fewer would be cheap and young."""
ENDS_S: Final = 20.0


@dataclass(slots=True)
class Run:
    """Findings of all rounds of one server's address with one number of viewers."""

    transport: str
    viewers: int
    fast: int
    fast_ms: list[float] = field(default_factory=list)
    slow_ms: list[float] = field(default_factory=list)
    stalled_ms: list[float] = field(default_factory=list)
    control_ms: list[float] = field(default_factory=list)
    fast_bytes: int = 0
    slow_bytes: int = 0
    cpu_s: float = 0.0
    seconds: float = 0.0
    memory_mb: float = 0.0

    @property
    def delivered(self) -> int:
        """Pictures that arrived."""
        return len(self.fast_ms) + len(self.slow_ms) + len(self.stalled_ms)

    @property
    def cpu_us(self) -> float | None:
        """Microseconds of the server's processor time for each picture that arrived."""
        return self.cpu_s / self.delivered * 1e6 if self.delivered else None

    @property
    def fast_share(self) -> float | None:
        """Share of the camera's pictures that a fast viewer received."""
        return len(self.fast_ms) / (self.fast * FPS * self.seconds) if self.fast and self.seconds else None

    def mean_kb(self, kind: str) -> float | None:
        """Return the mean size of the pictures of a kind of viewers, "fast" or "slow"."""
        count = len(getattr(self, f"{kind}_ms"))
        return getattr(self, f"{kind}_bytes") / count / 1e3 if count else None


@dataclass(frozen=True, slots=True)
class Setting:
    """Inputs of a measurement."""

    pictures: Path
    folder: Path
    seconds: float
    feeder: Path | None
    """µStreamer's camera; None: µStreamer is left out."""

    @property
    def transports(self) -> tuple[str, ...]:
        """Names of what is measured, one after the other in each round."""
        return (SOCKET, STREAM) if self.feeder is None else (SOCKET, USTREAMER, STREAM)


async def measure(setting: Setting, counts: Sequence[int], rounds: int) -> list[Run]:
    """Measure every address with every number of viewers, one after the other in each round. Raises BenchmarkError."""
    runs = {
        (transport, viewers): Run(transport, viewers, _kinds(viewers)[0])
        for viewers in counts
        for transport in setting.transports
    }
    for viewers in counts:
        for number in range(rounds):
            for transport in setting.transports:
                print(f"{viewers} viewers, {NAMES[transport]}, round {number + 1} ...", file=sys.stderr, flush=True)
                await _round(setting, runs[transport, viewers])
        for transport in (SOCKET, STREAM):
            print(f"{viewers} viewers, {NAMES[transport]}, a page beside them ...", file=sys.stderr, flush=True)
            await _round_with_page(setting, runs[transport, viewers])
    return list(runs.values())


async def _round(setting: Setting, run: Run) -> None:
    ours, theirs = servers.cores()
    async with _server(setting, run.transport, ours) as served:
        report = await _watch(setting, run, served, theirs)
    run.fast_ms += report["fast_ms"]
    run.slow_ms += report["slow_ms"]
    run.stalled_ms += report["stalled_ms"]
    run.fast_bytes += report["fast_bytes"]
    run.slow_bytes += report["slow_bytes"]
    run.cpu_s += report["cpu_s"]
    run.seconds += report["seconds"]
    run.memory_mb = max(run.memory_mb, report["memory_mb"])


async def _round_with_page(setting: Setting, run: Run) -> None:
    """Measure a page's round trips only: what the page costs the server is no cost of the pictures."""
    ours, theirs = servers.cores()
    async with _server(setting, run.transport, ours) as served:
        address = (f"http://{servers.HOST}:{served.port}", f"{WARM_UP_S + setting.seconds:g}")
        page = asyncio.create_task(_ask("benchmarks.video.control", address, theirs, "", setting.seconds))
        try:
            await _watch(setting, run, served, theirs)
            run.control_ms += await page
        finally:
            page.cancel()
            await asyncio.gather(page, return_exceptions=True)


async def _watch(setting: Setting, run: Run, served: servers.Served, cores: str) -> Any:
    """Let the viewers watch; return their report."""
    fast, slow, stalled = _kinds(run.viewers)
    order = Order(
        run.transport, servers.HOST, served.port, PATHS[run.transport], fast, slow, stalled, SLOW_BYTES_PER_S,
        WARM_UP_S, setting.seconds, min(STALL_S, 0.4 * setting.seconds), served.pid,
    )  # fmt: skip
    return await _ask("benchmarks.video.clients", (), cores, json.dumps(asdict(order)), setting.seconds)


@asynccontextmanager
async def _server(setting: Setting, transport: str, cores: str) -> AsyncIterator[servers.Served]:
    if transport == USTREAMER:
        assert setting.feeder is not None
        log = setting.folder / "ustreamer.log"
        async with servers.ustreamer(setting.pictures, FPS, cores, setting.feeder, log) as served:
            yield served
    else:
        async with servers.hawk(setting.pictures, FPS, cores) as served:
            yield served


async def _ask(module: str, arguments: Sequence[str], cores: str, text: str, seconds: float) -> Any:
    """Run a module to its end; return what it printed as JSON. Raises BenchmarkError."""
    process = await servers.spawn((sys.executable, "-m", module, *arguments), cores)
    try:
        async with asyncio.timeout(WARM_UP_S + seconds + ENDS_S):
            output, _ = await process.communicate(text.encode())
        return json.loads(output)
    except (TimeoutError, ValueError) as error:
        raise BenchmarkError(f"{module} did not answer; see its message above") from error
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()


def _kinds(viewers: int) -> tuple[int, int, int]:
    """Return the numbers of fast, slow and stalled viewers; one viewer alone is fast."""
    return (viewers, 0, 0) if viewers < 3 else (viewers - 2, 1, 1)


def figures(runs: Sequence[Run]) -> list[Figure]:
    """Return the figures of all runs, last those with limits: of the most viewers, the worse of our two addresses."""
    by_key = {(run.transport, run.viewers): run for run in runs}
    found = [figure for run in runs for figure in _figures(run, by_key.get((USTREAMER, run.viewers)))]
    most = max(run.viewers for run in runs)
    return found + _promises(
        [run for run in runs if run.viewers == most and run.transport != USTREAMER], by_key.get((USTREAMER, most))
    )


def _figures(run: Run, ustreamer: Run | None) -> list[Figure]:
    key, text = f"{run.transport}_{run.viewers}", f"{NAMES[run.transport]}, {run.viewers} viewers"
    beside = None if ustreamer is run else ustreamer

    def figure(name: str, words: str, value: float | None, unit: str, other: float | None) -> Figure:
        reference = None if beside is None else Reference("µStreamer", other)
        return Figure(f"{key}_{name}", f"{text}: {words}", value, unit, reference)

    found = []
    for kind in ("fast", "slow", "stalled"):
        ages, theirs = getattr(run, f"{kind}_ms"), [] if beside is None else getattr(beside, f"{kind}_ms")
        if not ages:
            continue
        for share in (50, 99):
            words = f"age at the {kind} viewer, p{share}"
            found.append(
                figure(f"{kind}_age_p{share}_ms", words, percentile(ages, share), "ms", percentile(theirs, share))
            )
        found.append(figure(f"{kind}_frames", f"pictures, {kind}", float(len(ages)), "", float(len(theirs))))
    for kind in ("fast", "slow"):
        size, other = run.mean_kb(kind), None if beside is None else beside.mean_kb(kind)
        if size is not None:
            found.append(figure(f"{kind}_picture_kb", f"a picture, {kind}", size, "kB", other))
    if run.stalled_ms:
        stale = float(sum(age > STALE_MS for age in run.stalled_ms))
        theirs_stale = None if beside is None else float(sum(age > STALE_MS for age in beside.stalled_ms))
        found.append(figure("stalled_stale_frames", "pictures over 1 s old, stalled", stale, "", theirs_stale))
    found.append(figure("fast_share", "of the camera's pictures, fast", run.fast_share, "",
                        None if beside is None else beside.fast_share))  # fmt: skip
    found.append(figure("cpu_us_per_frame", "processor time a picture", run.cpu_us, "µs",
                        None if beside is None else beside.cpu_us))  # fmt: skip
    found.append(figure("memory_mb", "most memory", run.memory_mb, "MB", None if beside is None else beside.memory_mb))
    if run.control_ms:
        found.append(figure("control_rtt_p99_ms", "a command's round trip, p99", percentile(run.control_ms, 99), "ms",
                            None))  # fmt: skip
    return found


def _promises(ours: Sequence[Run], ustreamer: Run | None) -> list[Figure]:
    """Return the figures with limits: of each address (``socket_...``, ``stream_...``), and of the worse one."""
    found = []
    for key, text, limit, of in (
        ("fast_p99_over_ustreamer", "age at fast viewers, p99, by µStreamer's", FAST_LIMIT,
         lambda run: percentile(run.fast_ms, 99)),
        ("slow_p50_over_ustreamer", "age at the slow viewer, p50, by µStreamer's", SLOW_LIMIT,
         lambda run: percentile(run.slow_ms, 50)),
        ("cpu_per_frame_over_ustreamer", "processor time a picture, by µStreamer's", CPU_LIMIT,
         lambda run: run.cpu_us),
    ):  # fmt: skip
        theirs = None if ustreamer is None else of(ustreamer)
        ratios = [_ratio(of(run), theirs) for run in ours]
        found += [
            Figure(f"{run.transport}_{key}", f"{NAMES[run.transport]}: {text}", ratio, limit=Limit(highest=limit))
            for run, ratio in zip(ours, ratios, strict=True)
        ]
        known = [ratio for ratio in ratios if ratio is not None]
        worst = max(known) if len(known) == len(ratios) and known else None
        found.append(Figure(key, text, worst, limit=Limit(highest=limit)))
    control = [time for run in ours for time in run.control_ms]
    shares = [run.fast_share for run in ours if run.fast_share is not None]
    return [
        *(found if ustreamer is not None else []),
        Figure("control_rtt_p99_ms", "a command's round trip, p99", percentile(control, 99), "ms",
               limit=Limit(highest=CONTROL_MS)),
        Figure("fast_share", "of the camera's pictures, fast, the least", min(shares, default=None),
               limit=Limit(lowest=LEAST_SHARE)),
    ]  # fmt: skip


def _ratio(value: float | None, by: float | None) -> float | None:
    return None if value is None or not by else value / by
