"""Builds the simulated drone and advances its time."""

from __future__ import annotations

import asyncio
import json
import math
from collections.abc import AsyncGenerator, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np

from hawk.sim.autopilot.autopilot import STEP_S, Autopilot
from hawk.sim.autopilot.parameters import AutopilotOptions, Other
from hawk.sim.camera.camera import RATE_HZ, Camera, Renderer, Shot, SimulationClock
from hawk.sim.camera.follow import Follower
from hawk.sim.camera_server import Backend, CameraServer
from hawk.sim.faults import CameraFaults, apply_camera_fault, apply_fault
from hawk.sim.flight_record import FlightRecord
from hawk.sim.geometry import Origin
from hawk.sim.link.mavlink_link import MavlinkLink
from hawk.sim.link.udp import UdpLink, UdpUrl
from hawk.worlds.stays import LotStays

TICK_S = 0.005
"""Real seconds between two looks at the clock."""
CHUNK_S = 0.25
"""Simulated seconds that are caught up before the sockets get a turn."""


@dataclass(frozen=True, slots=True)
class RunOptions:
    """Options of a run. ``start`` is x, y in metres in the world's picture; ``latency`` simulated seconds.

    ``camera_rate`` is the number of pictures in a simulated second.
    ``mavlink_version`` is 1 or 2; ``others`` are on the link besides the vehicle.
    """

    start: tuple[float, float]
    mavlink: UdpUrl
    http: tuple[str, int]
    origin: Origin = field(default_factory=Origin)
    speed: float = 1.0
    latency: float = 0.05
    camera_rate: float = RATE_HZ
    seed: int = 0
    mavlink_version: int = 2
    others: tuple[Other, ...] = ()
    autopilot: AutopilotOptions = field(default_factory=AutopilotOptions)

    @property
    def frame_s(self) -> float:
        """Simulated seconds from one picture to the next."""
        return 1.0 / self.camera_rate


class Flyer:
    """A whole simulated drone on a clock: physics, link and the camera's slots."""

    def __init__(self, options: RunOptions, camera: Camera, clock: SimulationClock) -> None:
        generators = [np.random.default_rng(seed) for seed in np.random.SeedSequence(options.seed).spawn(2)]
        self.autopilot = Autopilot(options.autopilot, options.origin, generators[0])
        self.link = MavlinkLink(self.autopilot, generators[1])
        self.link.version = options.mavlink_version
        self.link.others.present = frozenset(options.others)
        self.record = FlightRecord(self.autopilot)
        self._camera = camera
        self._clock = clock
        self._frame_s = options.frame_s
        self._next_slot = 0.0

    def advance(self) -> tuple[list[bytes], bool]:
        """Advance to the present; return the datagrams to send, and True when the simulation has caught up."""
        out: list[bytes] = []
        autopilot = self.autopilot
        goal = min(self._clock(), autopilot.time + CHUNK_S)
        while autopilot.time + STEP_S <= goal:
            autopilot.step()
            self.record.step()
            if autopilot.time >= self._next_slot:
                self._next_slot += self._frame_s
                self._camera.expose(self.shot())
            out += self.link.poll()
        return out, self._clock() - autopilot.time < CHUNK_S

    def shot(self) -> Shot:
        """Return the camera's true pose."""
        body = self.autopilot.body
        north, east, down = body.position
        attitude = (body.roll, body.pitch, body.yaw)
        height = -down - self.autopilot.options.slope.height(north, east)
        return Shot(self.autopilot.time_boot, self.autopilot.time, east, -north, height, *attitude)


async def fly(
    truth: Mapping[str, Any],
    renderer: Renderer,
    options: RunOptions,
    say: Callable[[str], None],
    stays: LotStays | None = None,
) -> None:
    """Run the whole simulated drone until cancelled.

    Args:
        truth: the world's truth as it is saved (`World.truth_json`).
        renderer: draws the world.
        options: how to run.
        say: gets one line of JSON with the addresses.
        stays: the stays of the world's cars, where it is at a moment.

    Raises:
        OSError: an address cannot be used.
    """
    clock, camera, faults = _begin(renderer, options)
    flyer = Flyer(options, camera, clock)
    udp = UdpLink(flyer.link.receive)
    backend = Backend(
        camera=camera,
        origin=options.origin,
        truth=_truth(truth, options),
        stays=stays,
        status=lambda: {**flyer.record.summary(), "speed": options.speed, "lag_s": clock() - flyer.autopilot.time},
        watch_fence=flyer.record.watch,
        apply_fault=lambda fault: apply_fault(fault, flyer.autopilot, flyer.link, camera, faults),
        faults=faults,
    )
    async with _open(udp, backend, options, say):
        while True:
            datagrams, caught_up = flyer.advance()
            udp.send(datagrams)
            await asyncio.sleep(TICK_S if caught_up else 0.0)


async def follow(
    truth: Mapping[str, Any],
    renderer: Renderer,
    options: RunOptions,
    say: Callable[[str], None],
    stays: LotStays | None = None,
) -> None:
    """Run the camera alone, over the vehicle at ``options.mavlink``, until cancelled; arguments as for `fly`."""
    clock, camera, faults = _begin(renderer, options)
    follower = Follower(options.origin, clock, options.frame_s)
    udp = UdpLink(follower.receive)
    backend = Backend(
        camera=camera,
        origin=options.origin,
        truth=_truth(truth, options),
        stays=stays,
        status=lambda: _followed(follower, options.origin),
        watch_fence=lambda _: None,
        apply_fault=lambda fault: apply_camera_fault(fault, camera, faults),
        faults=faults,
    )
    async with _open(udp, backend, options, say):
        while True:
            for shot in follower.shots():
                camera.expose(shot)
            udp.send(follower.poll())
            await asyncio.sleep(TICK_S)


def _begin(renderer: Renderer, options: RunOptions) -> tuple[SimulationClock, Camera, CameraFaults]:
    """Build the parts that `fly` and `follow` share."""
    cv2.setNumThreads(1)
    clock = SimulationClock(options.speed)
    rng = np.random.default_rng(options.seed)
    return clock, Camera(renderer, clock, rng, options.latency, options.frame_s), CameraFaults()


@asynccontextmanager
async def _open(
    udp: UdpLink, backend: Backend, options: RunOptions, say: Callable[[str], None]
) -> AsyncGenerator[None]:
    """Open MAVLink and the camera's server and report their addresses; close both, and the camera, at the end."""
    server = CameraServer(backend)
    try:
        url = await udp.open(options.mavlink)
        http = await server.start(*options.http)
        say(json.dumps({"http": http, "mavlink": str(url)}))
        yield
    finally:
        udp.close()
        await server.stop()
        await backend.camera.close()


def _truth(truth: Mapping[str, Any], options: RunOptions) -> Mapping[str, Any]:
    """Return the world's truth with start, origin and camera of this run."""
    x, y = options.start
    origin = options.origin
    latitude, longitude, altitude = origin.to_geodetic((-y, x, 0.0))
    return {
        **truth,
        "start": {"x": x, "y": y, "latitude": latitude, "longitude": longitude, "altitude": altitude},
        "origin": {"latitude": origin.latitude, "longitude": origin.longitude, "altitude": origin.altitude},
        "camera": {"width": 1280, "height": 720, "horizontal_fov_deg": 70.0, "frame_s": options.frame_s},
    }


def _followed(follower: Follower, origin: Origin) -> Mapping[str, Any]:
    shot = follower.last
    if shot is None:
        return {"following": False}
    latitude, longitude, altitude = origin.to_geodetic((-shot.y_south, shot.x_east, -shot.height))
    position = {"x": shot.x_east, "y": shot.y_south, "height": shot.height, "yaw": math.remainder(shot.yaw, math.tau)}
    place = {"latitude": latitude, "longitude": longitude, "altitude": altitude}
    return {"following": True, "time_boot": shot.stamp, "position": {**position, **place}}
