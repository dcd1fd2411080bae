"""HTTP for tools: the schema, the mosaic, the report, health and metrics."""

from __future__ import annotations

import asyncio
import logging
import math
import os
import resource
import threading
from collections.abc import AsyncIterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from aiohttp import hdrs, web

from hawk.comm.protocol.commands import schema
from hawk.model.lot_map import StallState
from hawk.web.access.guesses import GUESSES
from hawk.web.door import DOOR
from hawk.web.services import COUNTERS, SERVICES, Counters, WebServices

_LOG = logging.getLogger(__name__)

THERMAL: Final = Path("/sys/class/thermal")
STAT: Final = Path("/proc/stat")
LATE_S: Final = 0.5
"""Real seconds that an answer waits for them."""
_COLDEST, _HOTTEST = -60.0, 200.0
"""Degrees Celsius; a sensor that reads beyond them is broken."""
_TICKS: Final = os.sysconf("SC_CLK_TCK")
_READER = web.AppKey("computer_figures_reader", ThreadPoolExecutor)

Figure = tuple[str, str, str, float, Mapping[str, str]]
"""Name in ``/metrics``, kind, description, value, labels."""


def computer_figures(store: Path | None, thermal: Path = THERMAL, stat: Path = STAT) -> list[Figure]:
    """Return the figures; one that cannot be read is left out. May block.

    Args:
        store: The daemon's folder.
        thermal: Folder of the kernel's thermal zones (Documentation/driver-api/thermal/sysfs-api.rst).
        stat: Processor times (proc(5)).
    """
    used = os.times()
    found: list[Figure] = [
        ("cpu_seconds_total", "counter", "Processor time of the daemon.", used.user + used.system, {}),
    ]
    if store is not None:
        try:
            disk = os.statvfs(store)
        except OSError:
            pass
        else:
            free, whole = disk.f_bavail * disk.f_frsize, disk.f_blocks * disk.f_frsize
            found.append(("disk_free_bytes", "gauge", "Free on the disk of the store.", float(free), {}))
            found.append(("disk_size_bytes", "gauge", "Size of that disk.", float(whole), {}))
    for zone, degrees in temperatures(thermal).items():
        found.append(("temperature_celsius", "gauge", "Of the computer's parts.", degrees, {"zone": zone}))
    for mode, seconds in processor_times(stat).items():
        text = "Processor time of the computer, all cores together."
        found.append(("computer_cpu_seconds_total", "counter", text, seconds, {"mode": mode}))
    return found


def temperatures(thermal: Path = THERMAL) -> dict[str, float]:
    """Return degrees Celsius by zone; zones of one type are numbered."""
    found: dict[str, float] = {}
    for folder in sorted(thermal.glob("thermal_zone*")):
        try:
            kind = (folder / "type").read_text().strip() or folder.name
            degrees = int((folder / "temp").read_text()) / 1000.0
        except (OSError, ValueError):
            continue
        if math.isfinite(degrees) and _COLDEST <= degrees <= _HOTTEST:
            found[kind if kind not in found else f"{kind}-{folder.name.removeprefix('thermal_zone')}"] = degrees
    return found


def processor_times(stat: Path = STAT) -> dict[str, float]:
    """Return seconds since the boot that the processors were busy, and idle; empty when they cannot be read."""
    try:
        name, *fields = stat.read_text().splitlines()[0].split()
        user, nice, system, idle, wait, *rest = (int(field) / _TICKS for field in fields[:8])
    except (OSError, ValueError, IndexError):
        return {}
    return {"busy": user + nice + system + sum(rest), "idle": idle + wait} if name == "cpu" else {}


async def figures(app: web.Application, store: Path | None) -> list[Figure]:
    """Return `computer_figures`, read on the thread; none when they are late."""
    work = asyncio.get_running_loop().run_in_executor(app[_READER], computer_figures, store)
    try:
        return await asyncio.wait_for(work, LATE_S)
    except TimeoutError:
        _LOG.info("figures of the computer were not read within %g s", LATE_S)
        return []


async def reader(app: web.Application) -> AsyncIterator[None]:
    """Own the thread; a context of the application. A read that hangs is left behind."""
    executor = ThreadPoolExecutor(1, thread_name_prefix="computer-figures")
    app[_READER] = executor
    yield
    executor.shutdown(wait=False, cancel_futures=True)


PROC: Final = Path("/proc/self")


def process_figures(proc: Path = PROC) -> Mapping[str, tuple[str, float]]:
    """Return the figures by their name in ``/metrics``, each with its description (proc(5): statm, fd)."""
    resident = int((proc / "statm").read_text().split()[1]) * resource.getpagesize()
    files = open_files(proc)
    sockets = sum(name.startswith("socket:") for name in files)
    return {
        "resident_memory_bytes": ("Resident memory.", float(resident)),
        "open_files": ("Open descriptors, sockets among them.", float(len(files))),
        "open_sockets": ("Open sockets.", float(sockets)),
        "threads": ("Python's threads.", float(threading.active_count())),
        "tasks": ("Tasks of the event loop.", float(len(asyncio.all_tasks()))),
    }


def open_files(proc: Path = PROC) -> list[str]:
    """Return the targets of all descriptors; one that is closed meanwhile is left out."""
    found = []
    for name in os.listdir(proc / "fd"):
        try:
            found.append(str((proc / "fd" / name).readlink()))
        except OSError:
            continue
    return found


ALIVE: Final = "/api/alive"
"""Address for a watch that starts the program again."""
METRICS_CONTENT_TYPE: Final = "text/plain; version=0.0.4; charset=utf-8"
STATUS_AGE_S: Final = 1.0
"""A status older than this (seconds of the daemon's clock) means that the state machine does not run."""


@dataclass(frozen=True, slots=True)
class Access:
    """Figures of the server's door; ``closed`` and ``wrong_tokens`` rise."""

    waiting: int = 0
    answered: int = 0
    closed: int = 0
    wrong_tokens: int = 0


def add_routes(app: web.Application) -> None:
    """Add every route of this module."""
    app.router.add_get("/api/schema.json", message_schema)
    app.router.add_get(r"/api/mosaic/{row:-?\d{1,6}}/{column:-?\d{1,6}}.jpg", mosaic)
    app.router.add_get("/api/report.json", report)
    app.router.add_get("/api/settings.json", all_settings)
    app.router.add_get("/api/health", health)
    app.router.add_get(ALIVE, alive)
    app.router.add_get("/api/performance", performance)
    app.router.add_get("/metrics", metrics)
    app.cleanup_ctx.append(reader)


async def message_schema(_: web.Request) -> web.StreamResponse:
    """JSON schema of every message."""
    return web.json_response(schema(), headers={hdrs.CACHE_CONTROL: "no-cache"})


async def performance(request: web.Request) -> web.StreamResponse:
    """Speed figures of the daemon over the last minute."""
    return web.json_response(dict(request.app[SERVICES].performance()), headers={hdrs.CACHE_CONTROL: "no-cache"})


async def mosaic(request: web.Request) -> web.StreamResponse:
    """JPEG of one tile; a request that names the present version (?v=) may be kept for good."""
    current = request.app[SERVICES].occupancy_map.value
    key = (int(request.match_info["row"]), int(request.match_info["column"]))
    tile = None if current is None else current.mosaic.get(key)
    if current is None or tile is None:
        raise web.HTTPNotFound(text=f"There is no picture of tile {key[0]}/{key[1]} yet.")
    etag = f'"{current.map_id}-{tile.version}"'
    exact = request.query.get("v") == str(tile.version) and request.query.get("map") == current.map_id
    caching = "private, max-age=86400, immutable" if exact else "no-cache"
    headers = {hdrs.ETAG: etag, hdrs.CACHE_CONTROL: caching}
    if request.headers.get(hdrs.IF_NONE_MATCH) == etag:
        return web.Response(status=304, headers=headers)
    return web.Response(body=tile.data, content_type="image/jpeg", headers=headers)


async def report(request: web.Request) -> web.StreamResponse:
    """Counts and progress of the present map."""
    return web.json_response(_report(request.app[SERVICES]))


async def all_settings(request: web.Request) -> web.StreamResponse:
    """Every setting with its text, unit, bounds, default and present value."""
    shown = [
        {name.capitalize(): value for name, value in asdict(setting).items()}
        for setting in request.app[SERVICES].settings
    ]
    return web.json_response({"Settings": shown}, headers={hdrs.CACHE_CONTROL: "no-cache"})


async def health(request: web.Request) -> web.StreamResponse:
    """200 when every part is healthy and the state machine runs, else 503; always with the parts and reasons."""
    services = request.app[SERVICES]
    status = services.status.value
    running = status is not None and services.status.age <= STATUS_AGE_S
    parts = {} if status is None else {i.name: {"healthy": i.healthy, "reason": i.reason} for i in status.parts.health}
    healthy = running and all(part["healthy"] for part in parts.values())
    body = {
        "healthy": healthy,
        "running": running,
        "state": None if status is None else status.operation.state.value,
        "version": services.version,
        "simulation": services.simulation,
        "parts": parts,
    }
    return web.json_response(body, status=200 if healthy else 503)


async def alive(request: web.Request) -> web.StreamResponse:
    """200 while the state machine runs, else 503, whatever the parts do; to everybody, since it says nothing else.

    A camera or an autopilot that is missing does not come back by a new start of the program.
    """
    status = request.app[SERVICES].status
    running = status.value is not None and status.age <= STATUS_AGE_S
    return web.json_response({"running": running}, status=200 if running else 503)


async def metrics(request: web.Request) -> web.StreamResponse:
    """Prometheus text format."""
    services = request.app[SERVICES]
    computer = await figures(request.app, services.folder)
    text = metrics_text(services, request.app[COUNTERS], _access(request.app), computer)
    return web.Response(text=text, headers={hdrs.CONTENT_TYPE: METRICS_CONTENT_TYPE})


def _report(services: WebServices) -> dict[str, Any]:
    status, current = services.status.value, services.occupancy_map.value
    counts = None if current is None else current.counts
    return {
        "version": services.version,
        "simulation": services.simulation,
        "utc": None if status is None else status.stamp.utc,
        "state": None if status is None else status.operation.state.value,
        "datum": None if status is None or status.site.datum is None else list(status.site.datum),
        "stalls": None if counts is None else counts.total,
        "free": None if counts is None else counts.free,
        "taken": None if counts is None else counts.taken,
        "unknown": None if counts is None else counts.unknown,
        "suggested": None if counts is None else counts.suggested,
        "free_range": None if status is None else status.perception.free_range,
        "lot_area_m2": None if current is None else current.lot_area_m2,
        "explored": None if status is None else status.perception.explored,
        "explore_done": None if status is None else status.perception.explore_done,
        "flight_time_s": None if status is None else status.travel.flight_time,
        "distance_flown_m": None if status is None else status.travel.distance_flown,
    }


def _access(app: web.Application) -> Access:
    door, guesses = app[DOOR], app[GUESSES]
    return Access(door.waiting, door.answered, door.closed, guesses.total)


def metrics_text(
    services: WebServices, counters: Counters, access: Access = Access(), computer: Sequence[Figure] = ()
) -> str:
    """Return all metrics, those of the computer among them; unknown values are left out."""
    lag = services.loop_lag()
    status = services.status.value
    lines: list[str] = []

    def add(name: str, kind: str, text: str, value: float | None, labels: str = "") -> None:
        if value is None or math.isnan(value):
            return
        head = f"hawk_{name}"
        if f"# TYPE {head} {kind}" not in lines:
            lines.extend((f"# HELP {head} {text}", f"# TYPE {head} {kind}"))
        lines.append(f"{head}{labels} {_number(value)}")

    about = {"version": services.version, "simulation": str(services.simulation).lower()}
    add("build_info", "gauge", "Always 1; the labels say which program runs.", 1.0, _labels(about))
    for statistic, value in (("median", lag.p50_ms), ("p99", lag.p99_ms), ("max", lag.max_ms)):
        text = "Lag of the event loop over the last minute."
        add(
            "loop_lag_seconds", "gauge", text, None if value is None else value / 1e3, _labels({"statistic": statistic})
        )
    for name, kind, text, value, labels in computer:
        add(name, kind, text, value, _labels(labels))
    add("clients", "gauge", "Connected pages.", len(services.side.hub))
    add("video_clients", "gauge", "Viewers of the video.", counters.video_clients)
    add("video_frames_total", "counter", "Frames handed to viewers.", counters.video_frames)
    add("video_latency_seconds", "gauge", "Age of the newest frame when handed out.", counters.frame_latency_s)
    add("heartbeats_total", "counter", "Heartbeats sent to pages.", counters.heartbeats)
    add("heartbeats_failed_total", "counter", "Heartbeats that could not be built.", counters.heartbeats_failed)
    add("connections_waiting", "gauge", "Connections that wait for a request.", access.waiting)
    add("requests_under_way", "gauge", "Requests that are being answered.", access.answered)
    add("connections_closed_total", "counter", "Connections that were closed while they waited.", access.closed)
    add("wrong_tokens_total", "counter", "Wrong tokens.", access.wrong_tokens)
    add("status_age_seconds", "gauge", "Age of the state machine's last status.", services.status.age)
    add("frame_age_seconds", "gauge", "Age of the newest annotated frame.", services.video.age)
    for name, (text, value) in process_figures().items():
        add(name, "gauge", text, value)
    waiting = {"commands": services.side.socket.waiting, "answers": services.side.hub.waiting, **services.queues()}
    for name, count in waiting.items():
        add("queued", "gauge", "Items that wait in a queue.", count, f'{{queue="{name}"}}')
    for name, count in services.counters().items():
        add(f"{name}_total", "counter", f"{name.replace('_', ' ').capitalize()}.", count)
    if status is not None:
        add("vision_rate_hertz", "gauge", "Frames fused per second.", status.perception.vision_rate)
        add("armed", "gauge", "1 when armed.", None if status.vehicle.armed is None else float(status.vehicle.armed))
        charge = status.vehicle.battery_percentage
        add("battery_ratio", "gauge", "Charge left, 0 to 1.", None if charge is None else charge / 100.0)
        seen = status.perception
        for state in StallState:
            add("stalls", "gauge", "Stalls on the map.", getattr(seen, state.value), f'{{state="{state.value}"}}')
        for item in status.parts.health:
            add("healthy", "gauge", "1 when the part is healthy.", float(item.healthy), f'{{part="{item.name}"}}')
    return "\n".join(lines) + "\n"


def _labels(values: Mapping[str, str]) -> str:
    escaped = (
        (name, value.replace("\\", r"\\").replace('"', r"\"").replace("\n", r"\n")) for name, value in values.items()
    )
    text = ",".join(f'{name}="{value}"' for name, value in escaped)
    return f"{{{text}}}" if text else ""


def _number(value: float) -> str:
    if math.isinf(value):
        return "+Inf" if value > 0 else "-Inf"
    return repr(float(value))
