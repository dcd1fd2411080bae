"""The result of a survey as files: table, polygons, a picture of the lot, the recording of the flight.

Files are made on a thread that no part of the flight uses, each once for a version of the map. The recording is large:
it is sent on the ground only, where the link and the disk are free, and to operators only: it holds the configuration.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final, TypeVar

import cv2
from aiohttp import hdrs, web

from hawk.comm.protocol.authority import Role
from hawk.comm.protocol.heartbeat import DroneStatus
from hawk.model.lot_map import OccupancyMap
from hawk.model.poses import GlobalPose
from hawk.results.map_picture import map_picture
from hawk.results.stall_files import map_csv, map_geojson
from hawk.results.survey_map import Made, SurveyMap
from hawk.store.recording import NoRecordingError
from hawk.web.access.access import ACCESS
from hawk.web.services import SERVICES, WebServices

JPEG_QUALITY: Final = 90
CHUNK_BYTES: Final = 256 * 1024
RECORDING: Final = "recording.mcap"
NO_MAP: Final = "There is no map yet: it gets its place on Earth when the drone is first armed."
FLYING: Final = "The recording can be downloaded once the motors are off."
FOR_OPERATORS: Final = "Recordings are for operators: log in as operator."
T = TypeVar("T")
_Key = tuple[str, int, GlobalPose]
"""Which map a file shows: its id, its version, and its place on Earth."""


class NotThereError(Exception):
    """A file that cannot be downloaded now; the message says why."""


@dataclass(frozen=True, slots=True)
class FileKind:
    """A file that is made from the map."""

    name: str
    content_type: str
    make: Callable[[SurveyMap], bytes]


def _picture(survey: SurveyMap) -> bytes:
    _, data = cv2.imencode(".jpg", map_picture(survey), [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return data.tobytes()


KINDS: Final = (
    FileKind("stalls.csv", "text/csv", lambda survey: map_csv(survey, Made.now(survey.survey))),
    FileKind("stalls.geojson", "application/geo+json", lambda survey: map_geojson(survey, Made.now(survey.survey))),
    FileKind("lot.jpg", "image/jpeg", _picture),
)


class MapFiles:
    """The files of the newest map that was asked for."""

    def __init__(self, executor: ThreadPoolExecutor) -> None:
        self._executor = executor
        self._made: dict[str, tuple[_Key, bytes]] = {}

    async def get(self, kind: FileKind, services: WebServices) -> bytes:
        """Return a file of the present map. Raises NotThereError."""
        status, current = services.status.value, services.occupancy_map.value
        if status is None or status.site.datum is None:
            raise NotThereError(NO_MAP)
        datum = GlobalPose(*status.site.datum, 0.0)
        current = current or OccupancyMap()
        key = (current.map_id, current.version, datum)
        made_of, data = self._made.get(kind.name, (None, b""))
        if made_of != key:
            make = partial(_made, kind, datum, current)
            data = await asyncio.get_running_loop().run_in_executor(self._executor, make)
            self._made[kind.name] = (key, data)
        return data

    async def run(self, work: Callable[[], T]) -> T:
        """Return what some work with files gives, done on the thread."""
        return await asyncio.get_running_loop().run_in_executor(self._executor, work)

    async def read(self, path: Path, start: int, count: int) -> bytes:
        """Return bytes of a file; empty when it cannot be read any more."""
        return await asyncio.get_running_loop().run_in_executor(self._executor, _read, path, start, count)

    async def recording(self, services: WebServices) -> tuple[Path, int]:
        """Return path and size of the newest recording, bytes. Raises NotThereError."""
        if not is_on_ground(services.status.value):
            raise NotThereError(FLYING)
        find = partial(_found, services.newest_recording)
        return await asyncio.get_running_loop().run_in_executor(self._executor, find)


def _read(path: Path, start: int, count: int) -> bytes:
    """Return bytes of a file; empty when it cannot be read any more."""
    try:
        with path.open("rb") as file:
            file.seek(start)
            return file.read(count)
    except OSError:
        return b""


FILES = web.AppKey("map_files", MapFiles)


def add_routes(app: web.Application) -> None:
    """Add every route of this module, and the thread that makes the files."""
    app.cleanup_ctx.append(_files)
    for kind in KINDS:
        app.router.add_get(f"/api/{kind.name}", partial(_map_file, kind))
    app.router.add_get(f"/api/{RECORDING}", recording)
    app.router.add_get("/api/downloads.json", sizes)


async def sizes(request: web.Request) -> web.StreamResponse:
    """Each file with its size in bytes, or why it is not there."""
    services, files = request.app[SERVICES], request.app[FILES]
    listed: list[dict[str, str | int | None]] = []
    for kind in KINDS:
        try:
            listed.append({"Name": kind.name, "Bytes": len(await files.get(kind, services)), "Reason": ""})
        except NotThereError as error:
            listed.append({"Name": kind.name, "Bytes": None, "Reason": str(error)})
    try:
        if not _may_have_recordings(request):
            raise NotThereError(FOR_OPERATORS)
        _, size = await files.recording(services)
        listed.append({"Name": RECORDING, "Bytes": size, "Reason": ""})
    except NotThereError as error:
        listed.append({"Name": RECORDING, "Bytes": None, "Reason": str(error)})
    return web.json_response({"Downloads": listed}, headers={hdrs.CACHE_CONTROL: "no-store"})


async def recording(request: web.Request) -> web.StreamResponse:
    """The newest recording, under the name that it has on the drone."""
    if not _may_have_recordings(request):
        raise web.HTTPForbidden(text=FOR_OPERATORS)
    try:
        path, size = await request.app[FILES].recording(request.app[SERVICES])
    except NotThereError as error:
        raise web.HTTPConflict(text=str(error)) from error
    return await send_file(request, path, size)


async def _map_file(kind: FileKind, request: web.Request) -> web.StreamResponse:
    try:
        data = await request.app[FILES].get(kind, request.app[SERVICES])
    except NotThereError as error:
        raise web.HTTPConflict(text=str(error)) from error
    charset = "utf-8" if kind.content_type.startswith("text/") else None
    return web.Response(body=data, content_type=kind.content_type, charset=charset, headers=_attachment(kind.name))


async def send_file(request: web.Request, path: Path, size: int) -> web.StreamResponse:
    """Send a file, or the part that was asked for: a broken download goes on. Arming ends it."""
    part = _part_of(request, size)
    is_whole = len(part) == size
    response = web.StreamResponse(status=200 if is_whole else 206, headers=_attachment(path.name))
    response.content_type = "application/octet-stream"
    response.content_length = len(part)
    response.headers[hdrs.ACCEPT_RANGES] = "bytes"
    if not is_whole:
        response.headers[hdrs.CONTENT_RANGE] = f"bytes {part.start}-{part.stop - 1}/{size}"
    await response.prepare(request)
    if request.method == hdrs.METH_HEAD:
        return response
    for start in range(part.start, part.stop, CHUNK_BYTES):
        chunk = await request.app[FILES].read(path, start, min(CHUNK_BYTES, part.stop - start))
        if not chunk or not is_on_ground(request.app[SERVICES].status.value):
            _break_off(request)
            break
        await response.write(chunk)
    return response


def _part_of(request: web.Request, size: int) -> range:
    """Return the bytes that a request asks for; all of them without a range. Raises HTTPRequestRangeNotSatisfiable."""
    try:
        part = range(size)[request.http_range]
    except ValueError:
        part = range(0)
    if len(part) == 0 and size > 0:
        raise web.HTTPRequestRangeNotSatisfiable(headers={hdrs.CONTENT_RANGE: f"bytes */{size}"})
    return part


def _break_off(request: web.Request) -> None:
    """End the connection: the receiver sees that the file is not whole."""
    if request.transport is not None:
        request.transport.abort()


def _attachment(name: str) -> dict[str, str]:
    return {hdrs.CONTENT_DISPOSITION: f'attachment; filename="{name}"', hdrs.CACHE_CONTROL: "no-store"}


def _may_have_recordings(request: web.Request) -> bool:
    """Return True for an operator, and where no login is asked for."""
    access = request.get(ACCESS)
    return access is None or access.role is Role.OPERATOR


def is_on_ground(status: DroneStatus | None) -> bool:
    """Return True while the motors are known to be off, or before the autopilot was first heard."""
    return status is None or status.vehicle.armed is not True


def _made(kind: FileKind, datum: GlobalPose, current: OccupancyMap) -> bytes:
    return kind.make(SurveyMap.of(datum, current))


def _found(newest: Callable[[], Path]) -> tuple[Path, int]:
    try:
        path = newest()
        return path, path.stat().st_size
    except (NoRecordingError, OSError) as error:
        raise NotThereError(str(error)) from error


async def _files(app: web.Application) -> AsyncIterator[None]:
    with ThreadPoolExecutor(1, thread_name_prefix="web-export") as executor:
        app[FILES] = MapFiles(executor)
        yield
