"""The programs of a simulated survey: the simulated drone, and a daemon of its own that flies it."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import sys
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Protocol
from urllib.parse import urlsplit

import aiohttp

from hawk.sim.launch import (
    Simulation,
    SimulationAddress,
    SimulationError,
    SimulationOptions,
    SimulatorOptionError,
    StartProgram,
    end_process,
)
from hawk.survey.truth import GroundTruth, TruthError, parse_truth

READY_TIMEOUT_S = 60.0
STOP_TIMEOUT_S = 12.0
FENCE_MARGIN_M = 15.0
"""Distance of the default fence around the lots, metres."""


class StackError(Exception):
    """The simulation or the daemon did not start; the text names the program and its log."""


@dataclass(frozen=True, slots=True)
class Ready:
    """The daemon's ready file; ``first_tick_s`` is real seconds from its start to the first tick."""

    url: str
    first_tick_s: float


class StackOptionError(StackError):
    """hawk-sim refused its options: a picture, a truth or a place in them cannot be used."""


class DronePrograms(Protocol):
    """The drone's programs, without the daemon: `Simulation`, or another vehicle under hawk-sim's camera."""

    async def start(self, log: int | None = None) -> SimulationAddress:
        """Start and wait until they are ready; ``log`` takes their standard error. Raises SimulationError."""

    async def stop(self) -> None:
        """End them."""


class SimulatedStack:
    """One simulated drone and one daemon; logs, journal and recording go below ``folder``."""

    def __init__(
        self,
        options: SimulationOptions,
        folder: Path,
        config: Path | None,
        fence: Path | None,
        link: Callable[[str], Awaitable[str]] | None = None,
        drone: DronePrograms | None = None,
        start_program: StartProgram = asyncio.create_subprocess_exec,
    ) -> None:
        """``link`` gets the autopilot's URL once it is known and returns the one for the daemon: a proxy between.

        ``drone`` is flown in place of the simulated one of ``options``. ``start_program`` starts the programs.
        """
        self._options = options
        self._link = link
        self._autopilot_url = ""
        self._folder = folder
        self._config = config
        self._fence = fence
        self._start_program = start_program
        self._simulation = Simulation(options, start_program) if drone is None else drone
        self.daemon: asyncio.subprocess.Process | None = None
        """The daemon's process."""
        self._port = 0
        self._logs: list[IO[bytes]] = []
        self._session: aiohttp.ClientSession | None = None
        self.address: SimulationAddress | None = None
        self.truth: GroundTruth | None = None
        """Ground truth of the world, None for a picture without one."""

    async def start(self) -> Ready:
        """Start both. Raises StackError."""
        self._folder.mkdir(parents=True, exist_ok=True)
        self._session = aiohttp.ClientSession(timeout=aiohttp.ClientTimeout(total=20))
        return await self._start_both()

    async def swap_battery(self, options: SimulationOptions) -> Ready:
        """Cut the power of both and start them again on the same store: another boot, a full battery.

        ``options`` are those of the new simulation: a drone that stands elsewhere, other errors of its position. The
        daemon is killed: a battery that is taken out lets no program end in order. Raises StackError.
        """
        if self.daemon is not None and self.daemon.returncode is None:
            self.daemon.kill()
            await self.daemon.wait()
        await self._simulation.stop()
        self._options, self._simulation = options, Simulation(options, self._start_program)
        return await self._start_both()

    async def _start_both(self) -> Ready:
        try:
            self.address = await self._simulation.start(self._log("hawk-sim.log").fileno())
        except SimulationError as error:
            log = self._folder / "hawk-sim.log"
            if isinstance(error, SimulatorOptionError):
                raise StackOptionError(f"the simulator's options: {_last_line(log)}") from None
            raise StackError(f"{error} ({log})") from None
        url = self.address.autopilot_url
        self._autopilot_url = url if self._link is None else await self._link(url)
        values = await self._get("/truth")
        (self._folder / "truth.json").write_text(json.dumps(values))
        try:
            truth = parse_truth(values)
        except TruthError as error:
            raise StackError(f"the simulator's truth: {error}") from None
        self.truth = truth if truth.lots else None
        return await self.start_daemon()

    async def start_daemon(self) -> Ready:
        """Start the daemon, again after it was killed. Raises StackError."""
        assert self.address is not None  # noqa: S101
        ready = self._folder / "ready.json"
        ready.unlink(missing_ok=True)
        log = self._log("hawk-drone.log")
        self.daemon = await self._start_program(
            *self.daemon_command(ready),
            stdin=asyncio.subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            start_new_session=True,  # Ctrl-C is for the survey, which brings the drone home first
        )
        self._began(self.daemon.pid)
        deadline = asyncio.get_running_loop().time() + READY_TIMEOUT_S
        while not ready.exists():
            if self.daemon.returncode is not None:
                raise StackError(f"hawk-drone ended with status {self.daemon.returncode} ({log.name})")
            if asyncio.get_running_loop().time() > deadline:
                raise StackError(f"hawk-drone was not ready after {READY_TIMEOUT_S:.0f} s ({log.name})")
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(0.05):
                    await self.daemon.wait()
        values = json.loads(ready.read_text())
        self._port = urlsplit(values["url"]).port or 0
        return Ready(values["url"], float(values["first_tick_s"]))

    async def status(self) -> dict[str, Any]:
        """Return the simulator's account of the flight."""
        return await self._get("/status")

    async def inject(self, fault: Mapping[str, Any]) -> None:
        """Inject or clear faults of the simulated drone (`hawk.sim.faults.Fault`)."""
        assert self._session is not None and self.address is not None  # noqa: S101, PT018
        async with self._session.post(f"{self.address.http}/fault", json=dict(fault)) as response:
            response.raise_for_status()

    async def watch_fence(self, polygon: list[tuple[float, float]], ceiling: float) -> None:
        """Let the simulator count how often the true position leaves this fence (latitude, longitude) by over 3 m."""
        assert self._session is not None and self.address is not None  # noqa: S101, PT018
        values = {"polygon": polygon, "ceiling": ceiling, "margin": 3.0}
        async with self._session.post(f"{self.address.http}/fence", json=values) as response:
            response.raise_for_status()

    async def stop(self) -> None:
        """End both processes, by force when they do not listen."""
        if self.daemon is not None:
            await end_process(self.daemon, STOP_TIMEOUT_S)
        await self._simulation.stop()
        if self._session is not None:
            await self._session.close()
        for log in self._logs:
            log.close()

    def daemon_command(self, ready: Path, *, store: Path | None = None, port: int | None = None) -> list[str]:
        """Return the daemon's command line; ``store`` and ``port`` replace its own for a second one."""
        assert self.address is not None  # noqa: S101
        command = [sys.executable, "-m", "hawk.cli", "run", *self._attached(), "--parent-pid", str(os.getpid())]
        command += ["--autopilot", self._autopilot_url, "--camera", self.address.camera_url]
        command += ["--host", "127.0.0.1", "--port", str(self._port if port is None else port)]
        command += ["--store", str(store or self._folder / "store"), "--ready-file", str(ready)]
        fence = self._fence_file()
        if fence is not None:
            command += ["--fence", str(fence)]
        if self._config is not None:
            command += ["--config", str(self._config)]
        return command

    def _began(self, session: int) -> None:
        """Do what is to be done when the daemon's process has begun; ``session`` is its id."""

    def _attached(self) -> list[str]:
        """Return the options by which the daemon knows that it flies hawk-sim, and its speed."""
        assert self.address is not None  # noqa: S101
        return ["--attach-sim", self.address.http, "--speed", str(self._options.speed)]

    def _fence_file(self) -> Path | None:
        if self._fence is not None or self.truth is None:
            return self._fence
        path = self._folder / "fence.geojson"
        path.write_text(json.dumps(self.truth.fence(FENCE_MARGIN_M)))
        return path

    def _log(self, name: str) -> IO[bytes]:
        log = (self._folder / name).open("ab")
        self._logs.append(log)
        return log

    async def _get(self, path: str) -> dict[str, Any]:
        assert self._session is not None and self.address is not None  # noqa: S101, PT018
        async with self._session.get(f"{self.address.http}{path}") as response:
            response.raise_for_status()
            return dict(await response.json())


def _last_line(log: Path) -> str:
    lines = log.read_text(errors="replace").strip().splitlines()
    return lines[-1] if lines else f"see {log}"
