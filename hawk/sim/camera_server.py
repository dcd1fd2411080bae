"""The HTTP side of the simulator: pictures as MJPEG, truth, bookkeeping and faults."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Annotated, Any, Final, NoReturn, TypeVar

from aiohttp import web
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from hawk.runtime.supervision import end_tasks
from hawk.sim.camera.camera import Camera, Frame
from hawk.sim.faults import CameraFaults, Fault
from hawk.sim.flight_record import DEFAULT_MARGIN_M, WatchedFence
from hawk.sim.geometry import Origin
from hawk.worlds.moment import read_moment
from hawk.worlds.stays import LotStays

BOUNDARY = "hawk-frame"
SNAPSHOT_TIMEOUT_S = 10.0
MAX_BODY = 1_000_000
LONGEST_SPAN: Final = timedelta(days=31)
"""Of one question for stays."""
Latitude = Annotated[float, Field(ge=-90.0, le=90.0, allow_inf_nan=False)]
Longitude = Annotated[float, Field(ge=-180.0, le=180.0, allow_inf_nan=False)]
Model = TypeVar("Model", bound=BaseModel)
Height = Annotated[float, Field(gt=0.0, le=10_000.0, allow_inf_nan=False)]


class FenceRequest(BaseModel):
    """`POST /fence`: a polygon (latitude, longitude; degrees) and a ceiling (metres above the ground)."""

    model_config = ConfigDict(extra="forbid")

    polygon: list[tuple[Latitude, Longitude]] = Field(min_length=3)
    ceiling: Height
    margin: float = Field(DEFAULT_MARGIN_M, ge=0.0, le=1000.0, allow_inf_nan=False)


@dataclass(frozen=True, slots=True)
class Backend:
    """Sources and sinks of the server."""

    camera: Camera
    origin: Origin
    truth: Mapping[str, Any]
    status: Callable[[], Mapping[str, Any]]
    watch_fence: Callable[[WatchedFence | None], None]
    apply_fault: Callable[[Fault], list[str]]
    faults: CameraFaults
    stays: LotStays | None = None


class CameraServer:
    """Serves one camera on ``host``:``port`` (0: a free one)."""

    def __init__(self, backend: Backend) -> None:
        self._backend = backend
        self._runner: web.AppRunner | None = None
        self._closing = asyncio.Event()
        self._searching = ThreadPoolExecutor(1, "hawk-sim stays")

    async def start(self, host: str, port: int) -> str:
        """Listen; return the base URL. Raises OSError when the address cannot be used."""
        application = web.Application(client_max_size=MAX_BODY)
        application.add_routes(
            [
                web.get("/stream", self._stream),
                web.get("/snapshot", self._snapshot),
                web.get("/truth", self._truth),
                web.get("/status", self._status),
                web.post("/fence", self._fence),
                web.post("/fault", self._fault),
            ]
        )
        self._runner = web.AppRunner(application, access_log=None, handler_cancellation=True, shutdown_timeout=1.0)
        await self._runner.setup()
        site = web.TCPSite(self._runner, host, port)
        await site.start()
        address = self._runner.addresses[0]
        return f"http://{address[0]}:{address[1]}"

    async def stop(self) -> None:
        """Close every connection."""
        self._closing.set()
        if self._runner is not None:
            await self._runner.cleanup()
        self._searching.shutdown(wait=False, cancel_futures=True)

    async def _stream(self, request: web.Request) -> web.StreamResponse:
        self._refuse_when_closed()
        response = web.StreamResponse(
            headers={"Content-Type": f"multipart/x-mixed-replace; boundary={BOUNDARY}", "Cache-Control": "no-store"}
        )
        await response.prepare(request)
        camera = self._backend.camera
        camera.forget()
        camera.watch(1)
        sequence = -1
        try:
            with contextlib.suppress(ConnectionError):
                while not self._backend.faults.closed:
                    frame = await self._next(sequence)
                    if frame is None:
                        break
                    sequence = frame.sequence
                    await response.write(self._part(frame))
        finally:
            camera.watch(-1)
        return response

    async def _snapshot(self, _: web.Request) -> web.Response:
        self._refuse_when_closed()
        self._backend.camera.forget()
        try:
            async with asyncio.timeout(SNAPSHOT_TIMEOUT_S):
                frame = await self._next(-1)
        except TimeoutError:
            frame = None
        if frame is None:
            raise web.HTTPServiceUnavailable(text="no picture")
        faults = self._backend.faults
        headers = {"X-Timestamp": f"{faults.stamp(frame):.6f}", "Cache-Control": "no-store"}
        return web.Response(body=faults.picture(frame), content_type="image/jpeg", headers=headers)

    async def _truth(self, request: web.Request) -> web.Response:
        if not request.query:
            return web.json_response(dict(self._backend.truth))
        stays = self._backend.stays
        if stays is None:
            _refuse("from", "this world stands still: start hawk-sim with --at, or ask for /truth alone")
        span = _span_of(request.query, self._backend.origin.longitude)
        found = await asyncio.get_running_loop().run_in_executor(self._searching, stays.between, span.begin, span.end)
        listed = [{"stall": s.stall, "from": s.begin.isoformat(), "to": s.end.isoformat()} for s in found]
        return web.json_response({"from": span.begin.isoformat(), "to": span.end.isoformat(), "stays": listed})

    async def _status(self, _: web.Request) -> web.Response:
        camera = self._backend.camera
        frames = {"frames_due": camera.due, "frames_drawn": camera.drawn, "frames_late": camera.late}
        return web.json_response({**frames, **self._backend.status()})

    async def _fence(self, request: web.Request) -> web.Response:
        asked = await _read(request, FenceRequest)
        origin = self._backend.origin
        polygon = [origin.to_world(*corner, origin.altitude)[:2] for corner in asked.polygon]
        self._backend.watch_fence(WatchedFence.of(polygon, asked.ceiling, asked.margin))
        return web.json_response({"watching": True})

    async def _fault(self, request: web.Request) -> web.Response:
        problems = self._backend.apply_fault(await _read(request, Fault))
        return web.json_response({"problems": problems}, status=409 if problems else 200)

    async def _next(self, after: int) -> Frame | None:
        """Return the next picture, None when the server closes."""
        waiting = asyncio.ensure_future(self._backend.camera.next_frame(after))
        closing = asyncio.ensure_future(self._closing.wait())
        try:
            await asyncio.wait({waiting, closing}, return_when=asyncio.FIRST_COMPLETED)
            return waiting.result() if waiting.done() else None
        finally:
            await end_tasks(waiting, closing)

    def _part(self, frame: Frame) -> bytes:
        faults = self._backend.faults
        jpeg = faults.picture(frame)
        stamp = "" if faults.unstamped else f"X-Timestamp: {faults.stamp(frame):.6f}\r\n"
        head = f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n{stamp}\r\n"
        return head.encode() + jpeg + b"\r\n"

    def _refuse_when_closed(self) -> None:
        if self._backend.faults.closed:
            raise web.HTTPServiceUnavailable(text="the camera is switched off by a fault")


@dataclass(frozen=True, slots=True)
class _Span:
    begin: datetime
    end: datetime


def _span_of(query: Mapping[str, str], longitude: float) -> _Span:
    """Return the time that `GET /truth?from=&to=` asks for. Answers 400 with the field that does not fit."""
    for name in query:
        if name not in ("from", "to"):
            _refuse(name, "is not known: ask with from and to, or without both")
    moments = []
    for name in ("from", "to"):
        if name not in query:
            _refuse(name, f"is missing: give from and to, as {name}=2026-05-04T10:30")
        try:
            moments.append(read_moment(query[name], longitude))
        except ValueError as error:
            _refuse(name, str(error))
    begin, end = moments
    if end < begin:
        _refuse("to", f"lies before from ({begin.isoformat()}): exchange them")
    if end - begin > LONGEST_SPAN:
        _refuse("to", f"lies more than {LONGEST_SPAN.days} days after from: ask for parts")
    return _Span(begin, end)


def _refuse(field: str, problem: str) -> NoReturn:
    text = json.dumps({"errors": [{"field": field, "problem": problem}]})
    raise web.HTTPBadRequest(text=text, content_type="application/json")


async def _read(request: web.Request, model: type[Model]) -> Model:
    """Read a JSON body. Answers 400 with the field that does not fit."""
    try:
        return model.model_validate_json(await request.read())
    except ValidationError as error:
        problems = [
            {"field": ".".join(map(str, item["loc"])) or "body", "problem": item["msg"]} for item in error.errors()
        ]
        raise web.HTTPBadRequest(text=json.dumps({"errors": problems}), content_type="application/json") from None
