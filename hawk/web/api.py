"""HTTP for tools: the schema, the mosaic, the report, health and metrics."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final

from aiohttp import hdrs, web

from hawk.comm.protocol.commands import schema
from hawk.model.lot_map import StallState
from hawk.web.access.guesses import GUESSES
from hawk.web.computer_figures import Figure, figures, reader
from hawk.web.door import DOOR
from hawk.web.process_figures import process_figures
from hawk.web.services import COUNTERS, SERVICES, Counters, WebServices

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
        "way_m": None if status is None else status.travel.distance_flown,
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
