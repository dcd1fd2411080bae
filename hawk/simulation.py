"""Starts and ends the simulated drone, a process of its own, on free ports."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import socket
import sys
from dataclasses import dataclass
from pathlib import Path

READY_TIMEOUT_S = 120.0
"""A large world on a slow machine takes a while to draw."""
STOP_TIMEOUT_S = 5.0
SLOWEST, FASTEST = 0.5, 4.0
"""Simulated seconds per real second that can be asked for: MAVSDK's own timers stay real, and bound both."""
SPEED_HELP = f"simulated seconds per second, {SLOWEST:g}-{FASTEST:g}"
"""Of ``--speed``, for hawk-drone and hawk-sim."""


class SimulationError(Exception):
    """The simulated drone did not start; the text is its own words."""


@dataclass(frozen=True, slots=True)
class SimulationOptions:
    """What is flown over and how: the options of ``hawk-sim`` under the same names.

    ``world`` with ``metres_per_pixel`` (and optionally ``truth``) flies over a picture, else ``seed`` draws a world.
    ``condition`` is the drawn world's time of day and weather (`hawk.worlds.conditions.Condition`).
    ``start`` is x, y in metres in the world's picture. ``speed`` is simulated seconds per real second, `SLOWEST` to
    `FASTEST`.
    """

    seed: int = 1
    condition: str | None = None
    world: Path | None = None
    metres_per_pixel: float | None = None
    truth: Path | None = None
    start: str | None = None
    speed: float = 1.0
    gnss_sigma: float | None = None
    wind: float | None = None

    def arguments(self) -> list[str]:
        """Return the command line of ``hawk-sim`` for these options."""
        values = {
            "--seed": None if self.world else self.seed,
            "--condition": self.condition,
            "--world": self.world,
            "--metres-per-pixel": self.metres_per_pixel,
            "--truth": self.truth,
            "--start": self.start,
            "--speed": self.speed,
            "--gnss-sigma": self.gnss_sigma,
            "--wind": self.wind,
        }
        return [f"{name}={value}" for name, value in values.items() if value is not None]


@dataclass(frozen=True, slots=True)
class SimulationAddress:
    """Where a running simulation is reached: ``autopilot_url`` for MAVSDK, ``http`` for camera, truth and faults."""

    http: str
    autopilot_url: str

    @property
    def camera_url(self) -> str:
        """Where the simulated camera's pictures are."""
        return f"{self.http}/stream"


class Simulation:
    """One ``hawk-sim`` process."""

    def __init__(self, options: SimulationOptions) -> None:
        self._options = options
        self._process: asyncio.subprocess.Process | None = None
        self._drain: asyncio.Task[None] | None = None

    async def start(self, log: int | None = None) -> SimulationAddress:
        """Start the process and wait until it flies. Raises SimulationError with its own words.

        ``log`` is a file descriptor for its standard error; the daemon's own when None.
        """
        port = free_udp_port()
        command = [sys.executable, "-m", "hawk.sim.cli", *self._options.arguments()]
        command += [f"--mavlink=udpout:127.0.0.1:{port}", "--http=127.0.0.1:0", f"--parent-pid={os.getpid()}"]
        self._process = await asyncio.create_subprocess_exec(
            *command,
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=log,
            start_new_session=True,  # Ctrl-C is for us: the drone must still be there to come home
        )
        try:
            line = await asyncio.wait_for(self._ready_line(), READY_TIMEOUT_S)
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
        raise SimulationError(f"hawk-sim ended with status {status} before it was ready; see its message above")

    async def _drain_output(self) -> None:
        assert self._process is not None  # noqa: S101
        assert self._process.stdout is not None  # noqa: S101
        async for _ in self._process.stdout:
            pass

    @property
    def pid(self) -> int | None:
        """Process id, None before the start."""
        return self._process.pid if self._process else None

    async def stop(self) -> None:
        """End the process, by force when it does not listen."""
        process = self._process
        if process is None:
            return
        if process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                process.send_signal(signal.SIGTERM)
            try:
                await asyncio.wait_for(process.wait(), STOP_TIMEOUT_S)
            except TimeoutError:
                process.kill()
                await process.wait()
        if self._drain is not None:
            self._drain.cancel()
            await asyncio.gather(self._drain, return_exceptions=True)


def free_udp_port() -> int:
    """Return a UDP port of the loopback that nobody uses."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
