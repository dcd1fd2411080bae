"""What tools ask for over HTTP: the schema, the mosaic, the present map, health and metrics."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Final

from aiohttp import hdrs, web

from hawk.comm.messages import schema
from hawk.comm.status import DroneStatus
from hawk.model import GlobalPose, OccupancyMap, Stall
from hawk.stall_exports import stalls_csv, stalls_geojson_text
from hawk.web.counters import COUNTERS
from hawk.web.metrics import METRICS_CONTENT_TYPE, metrics_text
from hawk.web.services import SERVICES, WebServices

STATUS_AGE_S: Final = 1.0
"""A status older than this (seconds of the daemon's clock) means that the state machine does not run."""
EXPORTER = web.AppKey("exporter", ThreadPoolExecutor)


def add_routes(app: web.Application) -> None:
    """Add every route of this module."""
    app.router.add_get("/api/schema.json", message_schema)
    app.router.add_get(r"/api/mosaic/{row:-?\d{1,6}}/{column:-?\d{1,6}}.jpg", mosaic)
    app.router.add_get("/api/stalls.csv", stalls_table)
    app.router.add_get("/api/stalls.geojson", stalls_features)
    app.router.add_get("/api/report.json", report)
    app.router.add_get("/api/health", health)
    app.router.add_get("/api/performance", performance)
    app.router.add_get("/metrics", metrics)


async def message_schema(_: web.Request) -> web.StreamResponse:
    """JSON schema of every message."""
    return web.json_response(schema(), headers={hdrs.CACHE_CONTROL: "no-cache"})


async def performance(request: web.Request) -> web.StreamResponse:
    """How fast the daemon was over the last minute."""
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


async def stalls_table(request: web.Request) -> web.StreamResponse:
    """Present stalls as CSV."""
    text = await _export(request, stalls_csv)
    return _download(text, "text/csv", "stalls.csv")


async def stalls_features(request: web.Request) -> web.StreamResponse:
    """Present stalls as GeoJSON."""
    text = await _export(request, stalls_geojson_text)
    return _download(text, "application/geo+json", "stalls.geojson")


async def report(request: web.Request) -> web.StreamResponse:
    """Counts and progress of the present map."""
    services = request.app[SERVICES]
    return web.json_response(_report(services, services.status.value, services.occupancy_map.value))


async def health(request: web.Request) -> web.StreamResponse:
    """200 when every part is healthy and the state machine runs, else 503; always with the parts and reasons."""
    services = request.app[SERVICES]
    status = services.status.value
    running = status is not None and services.status.age <= STATUS_AGE_S
    parts = {} if status is None else {i.name: {"healthy": i.healthy, "reason": i.reason} for i in status.health}
    healthy = running and all(part["healthy"] for part in parts.values())
    body = {
        "healthy": healthy,
        "running": running,
        "state": None if status is None else status.state.value,
        "version": services.version,
        "simulation": services.simulation,
        "parts": parts,
    }
    return web.json_response(body, status=200 if healthy else 503)


async def metrics(request: web.Request) -> web.StreamResponse:
    """Prometheus text format."""
    text = metrics_text(request.app[SERVICES], request.app[COUNTERS])
    return web.Response(text=text, headers={hdrs.CONTENT_TYPE: METRICS_CONTENT_TYPE})


async def _export(request: web.Request, make: Callable[[GlobalPose, Mapping[int, Stall]], str]) -> str:
    """Make an export off the loop, on a thread that nothing of the flight uses."""
    services = request.app[SERVICES]
    status, current = services.status.value, services.occupancy_map.value
    if status is None or status.datum is None:
        raise web.HTTPConflict(text="There is no map yet: it gets its place on Earth when the drone is first armed.")
    datum = GlobalPose(*status.datum, 0.0)
    stalls = {} if current is None else current.stalls
    return await asyncio.get_running_loop().run_in_executor(request.app[EXPORTER], make, datum, stalls)


def _download(text: str, content_type: str, name: str) -> web.Response:
    return web.Response(
        text=text,
        content_type=content_type,
        charset="utf-8",
        headers={hdrs.CONTENT_DISPOSITION: f'attachment; filename="{name}"'},
    )


def _report(services: WebServices, status: DroneStatus | None, current: OccupancyMap | None) -> dict[str, Any]:
    counts = None if current is None else current.counts
    return {
        "version": services.version,
        "simulation": services.simulation,
        "utc": None if status is None else status.utc,
        "state": None if status is None else status.state.value,
        "datum": None if status is None or status.datum is None else list(status.datum),
        "stalls": None if counts is None else counts.total,
        "free": None if counts is None else counts.free,
        "taken": None if counts is None else counts.taken,
        "unknown": None if counts is None else counts.unknown,
        "lot_area_m2": None if current is None else current.lot_area_m2,
        "explored": None if status is None else status.explored,
        "explore_done": None if status is None else status.explore_done,
        "flight_time_s": None if status is None else status.flight_time,
        "way_m": None if status is None else status.way,
    }
