"""The HTTP side of the simulator: pictures as MJPEG, truth, bookkeeping and faults."""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeVar

from aiohttp import web
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from hawk.sim.autopilot import Autopilot, RefusedError
from hawk.sim.camera import Camera, Frame
from hawk.sim.flight_record import DEFAULT_MARGIN_M, WatchedFence
from hawk.sim.geometry import Origin
from hawk.sim.mavlink_link import MavlinkLink
from hawk.sim.radio import POSITIONS

Metres = Annotated[float, Field(ge=-10_000.0, le=10_000.0, allow_inf_nan=False)]


class Fault(BaseModel):
    """Faults to inject or to clear. A field that is absent stays as it is."""

    model_config = ConfigDict(extra="forbid")

    gps: Literal["ok", "lost"] | None = Field(None, description="GNSS reception")
    gps_jump: tuple[Metres, Metres, Metres] | None = Field(
        None, description="the position estimate jumps by (north, east, down) metres, local and global alike"
    )
    gps_glitch: tuple[Metres, Metres, Metres] | None = Field(
        None, description="GNSS is off by (north, east, down) metres: the EKF refuses it for 10 s, then jumps to it"
    )
    home: tuple[Metres, Metres, Metres] | None = Field(
        None, description="another station moves home to (north, east, down) metres from where the world begins"
    )
    ekf_shift: tuple[Metres, Metres, Metres] | None = Field(
        None, description="EKF-local's origin moves by (north, east, down) metres; global stays"
    )
    camera: Literal["ok", "dark", "frozen", "garbage", "unstamped", "closed", "mirrored"] | None = Field(
        None,
        description="no pictures; one picture for ever with new stamps; broken JPEGs; no time stamps; connections "
        "refused; left and right swapped",
    )
    camera_turn_deg: float | None = Field(
        None, ge=-360.0, le=360.0, description="the camera sits turned in its mount, clockwise seen from above, degrees"
    )
    link: Literal["ok", "cut", "mute"] | None = Field(
        None, description="MAVLink is lost in both directions; only from the autopilot"
    )
    late_parameters_s: float | None = Field(
        None, ge=0.0, le=60.0, description="a parameter that was set reads as the old one for this time, seconds"
    )
    link_loss: float | None = Field(None, ge=0.0, le=1.0, description="share of datagrams lost, in each direction")
    battery: float | None = Field(None, ge=0.0, le=100.0, description="charge left, percent")
    wind: float | None = Field(None, ge=0.0, le=30.0, description="mean wind, m/s")
    wind_heading_deg: float | None = Field(None, ge=-360.0, le=360.0, description="where the wind blows to, degrees")
    radio: Literal["ok", "lost"] | None = Field(None, description="the pilot's radio control")
    rangefinder: Literal["ok", "stuck"] | None = Field(None, description="stuck: it measures what it measures now")
    stick: float | None = Field(None, ge=0.0, le=1.0, description="the pilot's throttle stick")
    mode_switch: int | None = Field(None, ge=1, le=6, description="the pilot's mode switch moves to this position")
    pilot_mode: int | None = Field(None, ge=0, le=255, description="the pilot switches to this custom_mode")
    remote_id: Literal["ok", "lost"] | None = Field(None, description="the Remote ID transmitter")
    repair: bool | None = Field(None, description="true: a crashed vehicle stands upright again where it lies")
    autopilot: Literal["crash", "reboot", "power_cycle"] | None = Field(
        None, description="its program ends; boots when disarmed; boots at once, whatever it does"
    )


class CameraFaults:
    """Faults of the camera's HTTP side."""

    def __init__(self) -> None:
        self.garbage = False
        self.unstamped = False
        self.closed = False


def apply_fault(
    fault: Fault, autopilot: Autopilot, link: MavlinkLink, camera: Camera, server: CameraFaults
) -> list[str]:
    """Inject the faults and return the problems in words."""
    if fault.gps is not None:
        autopilot.estimator.receiving = fault.gps == "ok"
    if fault.gps_jump is not None:
        autopilot.estimator.jump(*fault.gps_jump)
    if fault.gps_glitch is not None:
        autopilot.estimator.glitch.offset = fault.gps_glitch
    if fault.home is not None:
        autopilot.set_home(fault.home)
    if fault.ekf_shift is not None:
        autopilot.shift_ekf_origin(fault.ekf_shift)
    _camera(fault, camera, server)
    if fault.link is not None:
        link.cut, link.mute = fault.link == "cut", fault.link == "mute"
    if fault.late_parameters_s is not None:
        link.late_parameters_s = fault.late_parameters_s
    if fault.link_loss is not None:
        link.loss = fault.link_loss
    if fault.battery is not None:
        autopilot.battery.remaining = fault.battery / 100.0
        autopilot.failsafes.clear_battery()
    if fault.wind is not None:
        autopilot.wind.speed = fault.wind
    if fault.wind_heading_deg is not None:
        autopilot.wind.heading = math.radians(fault.wind_heading_deg)
    if fault.radio is not None:
        autopilot.radio_present = fault.radio == "ok"
    if fault.rangefinder is not None:
        autopilot.rangefinder.stuck_cm = None
        if fault.rangefinder == "stuck":
            autopilot.rangefinder.stuck_cm = autopilot.rangefinder.measure_cm(autopilot.body, autopilot.options.slope)
    if fault.stick is not None:
        autopilot.stick = fault.stick
    if fault.mode_switch is not None:
        autopilot.radio.switch = POSITIONS[fault.mode_switch - 1]
    if fault.remote_id is not None:
        link.transmitter.is_broken = fault.remote_id == "lost"
    if fault.repair:
        autopilot.repair()
    return _commands(fault, autopilot)


def _commands(fault: Fault, autopilot: Autopilot) -> list[str]:
    problems = []
    if fault.pilot_mode is not None:
        try:
            autopilot.set_mode(fault.pilot_mode)
        except RefusedError as error:
            problems.append(f"pilot_mode: {error}")
    if fault.autopilot == "crash":
        autopilot.crash_program("a fault was asked for")
    elif fault.autopilot == "power_cycle":
        autopilot.boot()
    elif fault.autopilot == "reboot":
        try:
            autopilot.reboot()
        except RefusedError as error:
            problems.append(f"autopilot: {error}; power_cycle boots it all the same")
    return problems


def apply_camera_fault(fault: Fault, camera: Camera, server: CameraFaults) -> list[str]:
    """Inject a fault of the camera, where there is no drone; return the problems of the other fields in words."""
    _camera(fault, camera, server)
    return [f"{name}: only the camera can fail here" for name in fault.model_fields_set - {"camera", "camera_turn_deg"}]


def _camera(fault: Fault, camera: Camera, server: CameraFaults) -> None:
    if fault.camera_turn_deg is not None:
        camera.turned = math.radians(fault.camera_turn_deg)
    kind = fault.camera
    if kind is None:
        return
    camera.dark = kind == "dark"
    camera.frozen = kind == "frozen"
    camera.mirrored = kind == "mirrored"
    server.garbage = kind == "garbage"
    server.unstamped = kind == "unstamped"
    server.closed = kind == "closed"


BOUNDARY = "hawk-frame"
SNAPSHOT_TIMEOUT_S = 10.0
MAX_BODY = 1_000_000
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


class CameraServer:
    """Serves one camera on ``host``:``port`` (0: a free one)."""

    def __init__(self, backend: Backend) -> None:
        self._backend = backend
        self._runner: web.AppRunner | None = None
        self._closing = asyncio.Event()

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
        headers = {"X-Timestamp": f"{frame.stamp:.6f}", "Cache-Control": "no-store"}
        return web.Response(body=frame.jpeg, content_type="image/jpeg", headers=headers)

    async def _truth(self, _: web.Request) -> web.Response:
        return web.json_response(dict(self._backend.truth))

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
            for task in (waiting, closing):
                task.cancel()
            await asyncio.gather(waiting, closing, return_exceptions=True)

    def _part(self, frame: Frame) -> bytes:
        faults = self._backend.faults
        jpeg = frame.jpeg[: len(frame.jpeg) // 3] if faults.garbage else frame.jpeg
        stamp = "" if faults.unstamped else f"X-Timestamp: {frame.stamp:.6f}\r\n"
        head = f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n{stamp}\r\n"
        return head.encode() + jpeg + b"\r\n"

    def _refuse_when_closed(self) -> None:
        if self._backend.faults.closed:
            raise web.HTTPServiceUnavailable(text="the camera is switched off by a fault")


async def _read(request: web.Request, model: type[Model]) -> Model:
    """Read a JSON body. Answers 400 with the field that does not fit."""
    try:
        return model.model_validate_json(await request.read())
    except ValidationError as error:
        problems = [
            {"field": ".".join(map(str, item["loc"])) or "body", "problem": item["msg"]} for item in error.errors()
        ]
        raise web.HTTPBadRequest(text=json.dumps({"errors": problems}), content_type="application/json") from None
