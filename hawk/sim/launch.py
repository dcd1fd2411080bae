"""Starts and ends the simulated drone, a process of its own, on free ports; its options."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import importlib.util
import json
import math
import os
import secrets
import signal
import socket
import sys
from collections.abc import Awaitable, Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

from hawk.config.options import number, pair, whole
from hawk.runtime.programs import remedy
from hawk.runtime.supervision import end_tasks
from hawk.worlds import COARSEST_M, FINEST_M, MOST_CHANGES
from hawk.worlds.moment import read_moment

SLOWEST, FASTEST = 0.5, 4.0
"""Limits of the simulated seconds per real second: MAVSDK's own timers stay real."""
STEEPEST_PERCENT: Final = 30.0
"""A drone would slide on steeper ground."""

speed = number(SLOWEST, FASTEST)
scale = number(FINEST_M, COARSEST_M)
"""Metres on the ground that a pixel covers."""
gnss_sigma = number(0, 50)
"""Metres."""
camera_rate = number(1, 60)
"""Pictures in a simulated second."""
wind = number(0, 15)
"""Metres a second."""
rangefinder = number(0, 300)
"""Metres."""
repaint = whole(0, MOST_CHANGES)
"""Changes of the layout."""
compass_error = number(-30, 30)
"""Degrees: an autopilot replaces compasses that turn farther."""
gnss_bias = pair("N,E")
"""Metres."""


def moment(text: str) -> str:
    """Return the text of a moment of the lot (`hawk.worlds.moment.read_moment`), whose clock is not known here."""
    try:
        read_moment(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return text


def slope(text: str) -> tuple[float, float]:
    """Return PERCENT,DEG of rising ground."""
    try:
        percent, direction = (float(part) for part in text.split(","))
    except ValueError:
        percent = direction = math.nan
    if not (0.0 <= percent <= STEEPEST_PERCENT and -360.0 <= direction <= 360.0):
        raise argparse.ArgumentTypeError(
            f"must be PERCENT,DEG, 0 to {STEEPEST_PERCENT:g} and -360 to 360, not {text!r}"
        )
    return percent, direction


READY_TIMEOUT_S = 120.0
"""Drawing a large world takes long on a slow machine."""
STOP_TIMEOUT_S = 5.0
_USAGE = 2
"""Exit status of wrong options."""
_PORTS: Final = range(20_000, 30_000)
"""Below the ephemeral ports of Linux (32,768), macOS and Windows (49,152, RFC 6335, 6)."""
SPEED_HELP = f"simulated seconds per second, {SLOWEST:g}-{FASTEST:g}"
"""Of ``--speed``, for hawk-drone and hawk-sim."""
SIMULATOR_MISSING = f"the simulator needs pymavlink, which is not installed: {remedy('sim')}"
"""Error message of both programs where `simulator_installed` is False."""


StartProgram = Callable[..., Awaitable[asyncio.subprocess.Process]]
"""Starts a program as `asyncio.create_subprocess_exec` does."""


class SimulationError(Exception):
    """The simulated drone did not start; the text gives the reason."""


class SimulatorOptionError(SimulationError):
    """hawk-sim refused its options, by status 2: a picture, a truth or a place in them cannot be used."""


@dataclass(frozen=True, slots=True)
class SimulationOptions:
    """Options of ``hawk-sim``, under the same names.

    ``world`` with ``metres_per_pixel`` (and optionally ``truth``) flies over a picture, else ``seed`` draws a world.
    ``cars`` is the seed by which the cars of a picture with a truth are moved to other stalls.
    ``condition`` is the drawn world's time of day and weather (`hawk.worlds.moment.Condition`), ``at`` its moment
    (`hawk.worlds.moment`), ``repaint`` the number of changes of its layout.
    ``slope`` is PERCENT,DEG of rising ground, ``rangefinder`` the reach of one that looks down, metres.
    ``noise_seed`` seeds the errors of position and sensors, the world's seed when None.
    ``camera_rate`` is the number of pictures in a simulated second.
    ``gnss_bias`` is N,E in metres, ``compass_error`` degrees, ``battery_cells`` the battery's cells,
    ``mavlink_version`` 1 or 2; ``others``, with commas between, are others on the link
    (`hawk.sim.autopilot.parameters.Other`).
    ``start`` is x, y in metres in the world's picture. ``speed`` is simulated seconds per real second, `SLOWEST` to
    `FASTEST`.
    """

    seed: int = 1
    condition: str | None = None
    at: str | None = None
    repaint: int | None = None
    world: Path | None = None
    metres_per_pixel: float | None = None
    truth: Path | None = None
    cars: int | None = None
    start: str | None = None
    speed: float = 1.0
    gnss_sigma: float | None = None
    camera_rate: float | None = None
    wind: float | None = None
    slope: str | None = None
    rangefinder: float | None = None
    noise_seed: int | None = None
    gnss_bias: str | None = None
    compass_error: float | None = None
    battery_cells: int | None = None
    mavlink_version: int | None = None
    others: str | None = None

    def arguments(self) -> list[str]:
        """Return the command line of ``hawk-sim`` for these options."""
        values = asdict(self) | ({"seed": None} if self.world else {})
        return [f"--{name.replace('_', '-')}={value}" for name, value in values.items() if value is not None]


@dataclass(frozen=True, slots=True)
class SimulationAddress:
    """Addresses of a running simulation: ``autopilot_url`` for MAVSDK, ``http`` for camera, truth and faults."""

    http: str
    autopilot_url: str

    @property
    def camera_url(self) -> str:
        """URL of the simulated camera's stream."""
        return f"{self.http}/stream"


class Simulation:
    """One ``hawk-sim`` process."""

    def __init__(
        self, options: SimulationOptions, start_program: StartProgram = asyncio.create_subprocess_exec
    ) -> None:
        self._options = options
        self._start_program = start_program
        self._process: asyncio.subprocess.Process | None = None
        self._drain: asyncio.Task[None] | None = None

    async def start(self, log: int | None = None) -> SimulationAddress:
        """Start the process and wait until it is ready. Raises SimulationError.

        ``log`` is a file descriptor for its standard error; the daemon's own when None.
        """
        port = free_udp_port()
        command = [sys.executable, "-m", "hawk.sim.cli", *self._options.arguments()]
        command += [f"--mavlink=udpout:127.0.0.1:{port}", "--http=127.0.0.1:0", f"--parent-pid={os.getpid()}"]
        self._process = await self._start_program(
            *command,
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=log,
            start_new_session=True,  # Ctrl-C is for us: the drone must still be there to come home
        )
        try:
            async with asyncio.timeout(READY_TIMEOUT_S):
                line = await self._ready_line()
        except TimeoutError:
            await self.stop()
            raise SimulationError(f"hawk-sim was not ready after {READY_TIMEOUT_S:.0f} s") from None
        self._drain = asyncio.create_task(self._drain_output(), name="hawk-sim output")
        return SimulationAddress(json.loads(line)["http"].rstrip("/"), f"udpin://127.0.0.1:{port}")

    async def _ready_line(self) -> str:
        assert self._process is not None  # noqa: S101
        assert self._process.stdout is not None  # noqa: S101
        async for raw in self._process.stdout:
            line = raw.decode(errors="replace").strip()
            if line.startswith("{"):
                return line
        status = await self._process.wait()
        words = f"hawk-sim ended with status {status} before it was ready; see its message above"
        raise SimulatorOptionError(words) if status == _USAGE else SimulationError(words)

    async def _drain_output(self) -> None:
        assert self._process is not None  # noqa: S101
        assert self._process.stdout is not None  # noqa: S101
        async for _ in self._process.stdout:
            pass

    async def stop(self) -> None:
        """End the process, by force after `STOP_TIMEOUT_S`."""
        if self._process is None:
            return
        await end_process(self._process, STOP_TIMEOUT_S)
        if self._drain is not None:
            await end_tasks(self._drain)


async def end_process(process: asyncio.subprocess.Process, timeout_s: float) -> None:
    """End a process by SIGTERM, by force after that time in seconds; one that has ended is left alone."""
    if process.returncode is not None:
        return
    with contextlib.suppress(ProcessLookupError):
        process.send_signal(signal.SIGTERM)
    try:
        async with asyncio.timeout(timeout_s):
            await process.wait()
    except TimeoutError:
        process.kill()
        await process.wait()


def simulator_installed() -> bool:
    """Return True when the package that only the simulator needs is installed."""
    return importlib.util.find_spec("pymavlink") is not None


def free_udp_port() -> int:
    """Return a UDP port of the loopback that was free when it was tried.

    It is one of `_PORTS`: the system gives none of them to a program that asks for any port, and so nobody takes it
    before it is opened.
    """
    while True:
        port = secrets.choice(_PORTS)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe, contextlib.suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port
