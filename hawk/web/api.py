"""HTTP for tools: the schema, the mosaic, the report, health and metrics; the name and icon for BlueOS."""

from __future__ import annotations

import logging
from dataclasses import asdict, dataclass
from typing import Any, Final

from aiohttp import hdrs, web

from hawk.comm.protocol.commands import schema
from hawk.web.access.guesses import GUESSES, LINK_GUESSES, is_loopback_peer
from hawk.web.access.proxied import forwarding_header
from hawk.web.door import DOOR
from hawk.web.metrics import Access, figures, metrics_text, reader
from hawk.web.services import COUNTERS, SERVICES, WebServices

_LOG = logging.getLogger(__name__)

ALIVE: Final = "/api/alive"
"""Address for a watch that starts the program again."""
METRICS_CONTENT_TYPE: Final = "text/plain; version=0.0.4; charset=utf-8"
STATUS_AGE_S: Final = 1.0
"""A status older than this (seconds of the daemon's clock) means that the state machine does not run."""


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
    app.router.add_get(ADDRESS, register)
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
    door, wrong = request.app[DOOR], request.app[GUESSES].total + request.app[LINK_GUESSES].total
    access = Access(door.waiting, door.answered, door.closed, wrong)
    text = metrics_text(services, request.app[COUNTERS], access, computer)
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


ADDRESS: Final = "/register_service"


@dataclass(frozen=True, slots=True)
class Registration:
    """Keys as BlueOS's ``ServiceMetadata`` names them (core/services/helper/main.py)."""

    version: str
    name: str = "Hawk"
    description: str = "Parking lot survey: live picture and map of every free and taken stall"
    icon: str = "mdi-quadcopter"
    """A name of Material Design Icons, which BlueOS brings."""
    company: str = "Parking Lot Hawk"
    webpage: str = "https://github.com/parking-lot-hawk/hawk"
    api: str = "/api/schema.json"
    new_page: bool = True
    avoid_iframes: bool = True
    """The page refuses to stand in a frame of another page; BlueOS opens it at its own port."""
    works_in_relative_paths: bool = False
    """The page's addresses begin at the root of its own port, so BlueOS's proxy (/extensionv2/) cannot serve it."""


def is_for_everybody_here(request: web.BaseRequest) -> bool:
    """Return True for this question when a program of this computer asks it: no token is needed then."""
    return request.path == ADDRESS and is_loopback_peer(request.remote) and forwarding_header(request) is None


async def register(request: web.Request) -> web.StreamResponse:
    """Name and version of the product, for BlueOS's menu; nothing of the drone."""
    registration = Registration(request.app[SERVICES].version)
    return web.json_response(asdict(registration), headers={hdrs.CACHE_CONTROL: "no-cache"})
