"""Documents of surveys while everything fails: ``python -m proving.chaos [--minutes 20] [--seed 1] [--json FILE]``.

A desk collects the surveys of ``--senders`` drones on the ground and of ``--flights`` daemons that hover with a
simulated drone. Their stores grow and change all the time. Every 20 s one thing fails, by the seed: a daemon, the
senders or the desk is killed by SIGKILL, the link to the desk loses all answers, or three connections in ten and is 2 s
late, the desk's disk is full, the clock of the senders is an hour off, or the token of a drone is revoked. Then all is
well again, and the desk's tables are compared with those of a desk to which nothing happened, and a recording of each
drone on the ground, which the desk asked for, with that drone's. A full disk needs root.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import random
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass, field
from http import HTTPStatus
from pathlib import Path
from typing import Final

import aiohttp

from benchmarks.figures import BenchmarkError, Figure, Limit, Section, print_and_write
from benchmarks.options import make_parser
from benchmarks.stack import FAULTS, performance
from hawk.comm.protocol.authority import Role
from hawk.config.secrets import SecretUrl
from hawk.lots.storage.database import Database
from hawk.lots.store import FILE
from hawk.lots.values import LotStoreError
from hawk.sim.launch import SimulationOptions
from hawk.survey.stack import SimulatedStack
from hawk.web.access.tokens import TOKEN_FILE, remove_drone, rotate, rotate_drone
from hawk.webhooks.documents import desk_target
from proving.chaos.drones import ChaosDrone, Difference, difference, other_recordings, reference
from proving.chaos.link import HOST, Link, LinkState
from proving.faults.disk import DiskError, OwnDisk
from proving.faults.fault import When
from proving.faults.pilot import Pilot
from tests.integration.sim_support import free_tcp_port

EVERY_S: Final = 20.0
"""Seconds from one fault to the next."""
LASTS_S: Final = (5.0, 18.0)
CHANGE_S: Final = 0.5
"""Seconds from one change of any drone's store to the next."""
SAMPLE_S: Final = 30.0
"""Seconds between two looks at a daemon's account of its last minute."""
LONGEST_S: Final = 900.0
"""Seconds after the last fault in which the desk is to have all."""
TICK_MS: Final = 20.0
KBIT_S: Final = 500
"""Kilobits a second that a drone may send in flight."""
WALL_CLOCK: Final = Path(__file__).parents[1] / "faults" / "wall_clock"
HOUR_S: Final = 3600.0
_SETTINGS: Final = """
[collect]
url = "http://{host}:{port}/"
token_file = "{token}"
kbit_s = {kbit_s}
"""

Fault = Callable[[], Awaitable[Callable[[], Awaitable[object]]]]
"""Lets something fail, and returns what mends it."""


@dataclass
class Program:
    """A program that is killed and started again. ``command``: its line; ``environment``: beside that of this one."""

    command: Sequence[str]
    log: Path
    environment: Mapping[str, str] = field(default_factory=dict)
    process: asyncio.subprocess.Process | None = None

    async def start(self) -> None:
        """Start it."""
        with self.log.open("ab") as log:
            self.process = await asyncio.create_subprocess_exec(
                sys.executable, "-m", *self.command, stdout=log, stderr=log, env={**os.environ, **self.environment}
            )

    async def kill(self) -> None:
        """Kill it by SIGKILL."""
        if self.process is not None:
            with contextlib.suppress(ProcessLookupError):
                self.process.kill()
            await self.process.wait()


@dataclass
class Flight:
    """A daemon that hovers with a simulated drone, and whose store is that of a drone."""

    drone: ChaosDrone
    stack: SimulatedStack
    url: str = ""
    ticks_ms: list[float] = field(default_factory=list)
    starts: int = 0

    async def start(self) -> None:
        """Start both programs."""
        self.url = (await self.stack.start()).url.split("#")[0]

    async def hover(self) -> None:
        """Hover until cancelled, after each start of the daemon again; note its account of each minute."""
        while True:
            with contextlib.suppress(TimeoutError, *FAULTS):
                pilot = await Pilot.connect(self.url)
                try:
                    await pilot.reach(When.HOVERING)
                    await self._watch(pilot)
                finally:
                    await pilot.close()
            await asyncio.sleep(2.0)

    async def _watch(self, pilot: Pilot) -> None:
        looked = time.monotonic() + 2 * SAMPLE_S  # the minute of its start does not count
        while pilot.drone.is_connected:
            await pilot.drone.next_heartbeat(5.0)
            if time.monotonic() > looked:
                looked = time.monotonic() + SAMPLE_S
                self.ticks_ms.append(float((await performance(self.url))["loop_lag_p99_ms"]))

    async def kill(self) -> None:
        """Kill the daemon by SIGKILL."""
        if self.stack.daemon is not None:
            self.stack.daemon.kill()
            await self.stack.daemon.wait()

    async def start_again(self) -> None:
        """Start the daemon again."""
        self.url = (await self.stack.start_daemon()).url.split("#")[0]
        self.starts += 1


class Chaos:
    """All programs of a run below a folder."""

    def __init__(self, folder: Path, rng: random.Random, senders: int, flights: int) -> None:
        """Make stores and tokens; nothing runs before `run`."""
        self.rng = rng
        self.folder = folder
        self.faults: Counter[str] = Counter()
        self.left_out: dict[str, str] = {}
        self._port = free_tcp_port()
        self._link = Link(self._port, rng)
        self._disk = OwnDisk(folder / "desk")
        self._clock = folder / "clock"
        self._drones = [ChaosDrone(f"Drone {n}", folder / "drones" / f"{n:02d}", n) for n in range(senders)]
        self._count = senders
        self._flights = flights
        self.flights: list[Flight] = []
        self.other_recordings = [*self._drones]
        self._not_asked = [*self._drones]
        self._desk = Program(
            ["hawk.cli", "desk", "--collect", "--store", str(folder / "desk"), "--port", str(self._port)],
            folder / "desk.log",
        )
        self._senders = Program([], folder / "senders.log")

    @property
    def drones(self) -> list[ChaosDrone]:
        """All drones, those that fly too."""
        return [*self._drones, *(flight.drone for flight in self.flights)]

    async def run(self, minutes: float) -> tuple[Difference, float]:
        """Let all fail for that time; return what the desk has otherwise, and the seconds until it had all.

        Raises BenchmarkError.
        """
        try:
            await self._start()
            began, others = time.monotonic(), [asyncio.create_task(self._change())]
            others += [asyncio.create_task(flight.hover()) for flight in self.flights]
            try:
                while time.monotonic() - began < 60 * minutes:
                    await self._fail()
            finally:
                for each in others:
                    each.cancel()
                await asyncio.gather(*others, return_exceptions=True)
            ended = time.monotonic()
            await self._until_sent()
            caught_up = time.monotonic() - ended
            await self._desk.kill()
            wanted = reference(self.drones, self.folder / "reference.db")
            desk = Database(self.folder / "desk" / FILE)
            found = difference(desk, wanted)
            desk.close()
            return found, caught_up
        finally:
            await self._end()

    async def _start(self) -> None:
        try:
            await self._disk.begin()
        except DiskError as error:
            self.left_out["disk"] = str(error)
        self._clock.write_text("0")
        port = await self._link.open()
        url = f"http://{HOST}:{port}/"
        clock = {"PYTHONPATH": f"{WALL_CLOCK}:{Path.cwd()}", "FAULTS_WALL_CLOCK": str(self._clock)}
        self._senders.command = ["proving.chaos.senders", str(self.folder / "drones"), url, str(self._count)]
        self._senders.environment = clock
        (self.folder / "desk").mkdir(exist_ok=True)
        self._operator = rotate(self.folder / "desk" / TOKEN_FILE, Role.OPERATOR)
        for number in range(self._flights):
            self.flights.append(self._flight(self._count + number, port))
        for drone in self.drones:
            drone.token_file.write_text(rotate_drone(self.folder / "desk" / TOKEN_FILE, drone.name))
            drone.change(self.rng, time.time())
        self._url = url
        await self._desk.start()
        await self._senders.start()
        for flight in self.flights:
            await flight.start()

    def _flight(self, number: int, port: int) -> Flight:
        folder = self.folder / "flights" / f"{number:02d}"
        drone = ChaosDrone(f"Drone {number}", folder / "store", number)
        config = folder / "config.toml"
        config.write_text(_SETTINGS.format(host=HOST, port=port, token=drone.token_file, kbit_s=KBIT_S))
        return Flight(drone, SimulatedStack(SimulationOptions(seed=number), folder, config, None))

    async def _change(self) -> None:
        while True:
            drone = self.rng.choice(self.drones)
            with contextlib.suppress(LotStoreError):  # a store that is busy
                drone.change(self.rng, time.time())
            await self._ask()
            await asyncio.sleep(CHANGE_S)

    async def _ask(self) -> None:
        """Ask a drone at the desk for the recording of its first survey; one that did not work is asked again later."""
        if not self._not_asked:
            return
        drone = self._not_asked.pop(0)
        path = f"http://{HOST}:{self._port}/api/v1/surveys/{drone.first_survey()}/recordings/ask"
        headers = {"Authorization": f"Bearer {self._operator}"}
        with contextlib.suppress(aiohttp.ClientError, TimeoutError):
            limit = aiohttp.ClientTimeout(total=5.0)
            async with (
                aiohttp.ClientSession(headers=headers, timeout=limit) as session,
                session.post(path, json={"asked": True}) as answer,
            ):
                if answer.status == HTTPStatus.OK:
                    return
        self._not_asked.append(drone)  # others are not kept waiting: its survey may be deleted now

    async def _fail(self) -> None:
        faults: dict[str, Fault] = {
            "senders killed": self._kill_senders, "desk killed": self._kill_desk, "clock": self._shift_clock,
            "no answers": lambda: self._let_link(LinkState.NO_ANSWERS),
            "bad link": lambda: self._let_link(LinkState.BAD), "token revoked": self._revoke,
        }  # fmt: skip
        if "disk" not in self.left_out:
            faults["disk full"] = self._fill
        if self.flights:
            faults["daemon killed"] = self._kill_daemon
        name = self.rng.choice(list(faults))
        self.faults[name] += 1
        began = time.monotonic()
        mend = await faults[name]()
        await asyncio.sleep(self.rng.uniform(*LASTS_S))
        await mend()
        await asyncio.sleep(max(0.0, EVERY_S - (time.monotonic() - began)))

    async def _kill_senders(self) -> Callable[[], Awaitable[object]]:
        await self._senders.kill()
        return self._senders.start

    async def _kill_desk(self) -> Callable[[], Awaitable[object]]:
        await self._desk.kill()
        return self._desk.start

    async def _kill_daemon(self) -> Callable[[], Awaitable[object]]:
        flight = self.rng.choice(self.flights)
        await flight.kill()
        return flight.start_again

    async def _shift_clock(self) -> Callable[[], Awaitable[object]]:
        self._clock.write_text(str(self.rng.choice((-HOUR_S, HOUR_S))))

        async def mend() -> None:
            self._clock.write_text("0")

        return mend

    async def _let_link(self, state: LinkState) -> Callable[[], Awaitable[object]]:
        self._link.state = state

        async def mend() -> None:
            self._link.state = LinkState.GOOD

        return mend

    async def _fill(self) -> Callable[[], Awaitable[object]]:
        await self._disk.fill()
        return self._disk.empty

    async def _revoke(self) -> Callable[[], Awaitable[object]]:
        drone, file = self.rng.choice(self.drones), self.folder / "desk" / TOKEN_FILE
        remove_drone(file, drone.name)

        async def mend() -> None:
            drone.token_file.write_text(rotate_drone(file, drone.name))

        return mend

    async def _until_sent(self) -> None:
        """Wait until the desk has every state, and every recording. Raises BenchmarkError."""
        ends = time.monotonic() + LONGEST_S
        for each in self.drones:
            each.take_back(time.time())
        left = self.drones
        while left:
            left = [drone for drone in left if not drone.is_sent(self._target(drone), time.time() + LONGEST_S)]
            if left and time.monotonic() > ends:
                names = ", ".join(drone.name for drone in left)
                raise BenchmarkError(f"the desk lacks states of {names} after {LONGEST_S:g} s (logs in {self.folder})")
            await asyncio.sleep(0.5)
        while self.other_recordings and time.monotonic() < ends:
            if not self._not_asked:  # a survey that was deleted and taken back has lost its request
                self._not_asked = [*self.other_recordings]
            await self._ask()
            self.other_recordings = other_recordings(self._drones, self.folder / "desk")
            await asyncio.sleep(0.5)

    def _target(self, drone: ChaosDrone) -> str:
        return desk_target(SecretUrl(self._url), drone.token_file.read_text())

    async def _end(self) -> None:
        for flight in self.flights:
            await flight.stack.stop()
        for program in (self._senders, self._desk):
            await program.kill()
        self._link.close()
        await self._disk.end()


def figures(chaos: Chaos, found: Difference, caught_up_s: float) -> list[Figure]:
    """Return the figures with their limits."""
    ticks = sorted(each for flight in chaos.flights for each in flight.ticks_ms)
    none = Limit(highest=0)
    return [
        Figure("surveys", "surveys of all drones", float(found.surveys)),
        Figure("faults", "faults: " + ", ".join(f"{n} {name}" for name, n in sorted(chaos.faults.items())),
               float(chaos.faults.total())),
        Figure("lost", "surveys and looks that the desk lacks", float(found.lost), limit=none),
        Figure("doubled", "surveys and looks that the desk has twice", float(found.doubled), limit=none),
        Figure("other_rows", f"rows that differ: {dict(found.other_rows) or 'none'}",
               float(sum(found.other_rows.values())), limit=none),
        Figure("recordings_other", "recordings that the desk was asked for and has otherwise, or not",
               float(len(chaos.other_recordings)), limit=none),
        Figure("catch_up_s", "seconds from the last fault until the desk had all", caught_up_s, "s"),
        *([Figure("tick_p99_ms", f"lag of a hovering daemon's loop, p99 of a minute, worst of {len(ticks)}",
                  ticks[-1], "ms", limit=Limit(highest=TICK_MS))] if ticks else []),
    ]  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Let everything fail, and print a table; return 1 when a figure lies outside its limits."""
    parser = make_parser("proving.chaos", __doc__)
    parser.add_argument("--minutes", type=float, default=20.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--senders", type=int, default=30, help="drones on the ground (default 30)")
    parser.add_argument("--flights", type=int, default=3, help="daemons that fly, a core for each (default 3)")
    parser.add_argument("--dir", type=Path, help="keep logs and stores here")
    options = parser.parse_args(arguments)
    with contextlib.ExitStack() as stack:
        folder = options.dir or Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="hawk-chaos-")))
        folder.mkdir(parents=True, exist_ok=True)
        chaos = Chaos(folder, random.Random(options.seed), options.senders, options.flights)
        try:
            found, caught_up_s = asyncio.run(chaos.run(options.minutes))
        except (BenchmarkError, aiohttp.ClientError) as error:
            print(f"chaos: {error}", file=sys.stderr)
            return 1
        for name, reason in chaos.left_out.items():
            print(f"left out: {name}: {reason}")
    return print_and_write([Section("chaos", figures(chaos, found, caught_up_s))], options.json)


if __name__ == "__main__":
    sys.exit(main())
