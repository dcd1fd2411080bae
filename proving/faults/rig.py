"""One drone with its programs, the proxy, and an operator: brings them into a part of a flight, and runs faults."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
from collections import Counter
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

from aiohttp import ClientError

from hawk.comm.base_socket import ConnectionTimeout, FailedToSend
from hawk.comm.protocol.commands import FlyPlan, SurveyAgain
from hawk.comm.protocol.heartbeat import Heartbeat
from hawk.sim.launch import SimulationOptions
from hawk.store.replay import RecordingError
from hawk.survey.client import LinkLostError
from hawk.survey.handset import SurveyError
from hawk.survey.run import FenceSender
from hawk.survey.stack import SimulatedStack
from proving.faults.disk import DiskError, OwnDisk
from proving.faults.fault import (
    Act,
    Bring,
    ChangeLot,
    CountAgain,
    Disk,
    Drone,
    Fault,
    Flood,
    Forge,
    HalfRequests,
    Hide,
    KillMotors,
    KnowLot,
    Leave,
    Link,
    Moment,
    Order,
    Outcome,
    Return,
    SecondDaemon,
    See,
    Signal,
    StartAgain,
    Station,
    Survey,
    TakePlan,
    WallClock,
    When,
)
from proving.faults.keeping import RECORDED_S, Kept, lost, recording_ends
from proving.faults.pilot import Pilot
from proving.faults.proxy import Direction, Proxy
from proving.faults.second import SecondProcess
from proving.faults.service import Service, socket_in
from proving.faults.since import Since
from proving.faults.stored_lot import StoredLot
from proving.faults.surveying import figures, fly_survey
from proving.faults.vehicle import ArduCopter, VehicleStack

SETTINGS: Final = """
[heights]
minimum_m = 12.0
desired_m = 20.0
maximum_m = 22.0
[operator]
operator_timeout_s = 5.0
operator_hold_s = 8.0
control_lease_s = 10.0
"""
"""Low, so that coming home takes little time, and with little patience."""
WELL: Final[dict[str, Any]] = {
    "camera": "ok",
    "camera_turn_deg": 0.0,
    "gps": "ok",
    "link": "ok",
    "radio": "ok",
    "wind": 0.0,
}
HONEST: Final[dict[str, Any]] = {
    "gps_bias": (0.0, 0.0, 0.0),
    "gps_glitch": (0.0, 0.0, 0.0),
    "gps_walk": (0.0, 0.0),
    "baro_drift": 0.0,
    "baro_error": 0.0,
    "compass": "ok",
    "compass_error_deg": 0.0,
    "battery_counter": "ok",
    "battery_rest_v": 0.0,
    "battery_error_v": 0.0,
    "battery_resistance_ohm": 0.012,
    "battery_cells": 3,
    "others": [],
    "link_version": 2,
    "camera_stamp_step_s": 0.0,
    "camera_orientation": 1,
    "camera_tail_bytes": 0,
    "camera_contrast": 1.0,
    "camera_blank_every": 0,
}
"""Of the simulated drone alone."""
_WALL_CLOCK: Final = Path(__file__).parent / "wall_clock"
_JOURNALLED_S: Final = 2.0  # a crash may lose the last second, so it comes a moment after the comparison's moment
_RESTORED_S: Final = 10.0  # real: a daemon that starts in the air acts first and restores its map seconds later
_LOOK_S: Final = 0.04
_LOT_LOOKS: Final = 20
_LOT_LOOK_S: Final = 1.0  # real: the daemon looks for new lots every two
_PATIENCE: Final = 3.0  # real time may be so much slower than the speed before a wait is given up
_IN_AIR_M: Final = 1.0
_GONE: Final = (SurveyError, LinkLostError, FailedToSend, ConnectionTimeout, TimeoutError, ClientError, DiskError)


People = Survey | Order | KillMotors | Leave | Return | Hide | KnowLot | ChangeLot | TakePlan | Bring | Flood
"""Acts of persons."""


class Rig:
    """Programs and operator of one drone over one drawn lot."""

    def __init__(
        self, folder: Path, options: SimulationOptions, copter: ArduCopter | None = None, *, own_disk: bool = False
    ) -> None:
        """``copter``: a real vehicle, in place of the simulated one. ``own_disk``: for the daemon's store."""
        self.folder = folder
        self._speed = options.speed
        folder.mkdir(parents=True, exist_ok=True)
        config = folder / "config.toml"
        config.write_text(SETTINGS)
        self._notify = socket_in(folder)
        self.proxy = Proxy(options.speed)
        self.stack = (
            SimulatedStack(options, folder / "run", config, None, self.proxy.open)
            if copter is None
            else VehicleStack(copter, options, folder / "run", config, self.proxy.open)
        )
        self._besides = HONEST if copter is None else {"battery": 100.0, "stick": 0.0}  # it drains for real
        self._disk = OwnDisk(self.store) if own_disk else None
        self._second = SecondProcess(folder / "second.log")
        self._wall_clock = folder / "wall_clock"
        _let_wall_clock_step(self._wall_clock)
        self._service = Service(self.stack, self._notify)
        self._pilot: Pilot | None = None
        self._url = ""
        self._truth: dict[str, Any] = {}
        self._watch: asyncio.Task[None] | None = None
        self._broken: list[str] = []
        self._since = Since()
        self._others: list[Pilot] = []
        self._half: list[asyncio.StreamWriter] = []
        self._lot: StoredLot | None = None
        self.falls = False
        """True while motors off in the air are meant."""

    @property
    def store(self) -> Path:
        """The daemon's folder."""
        return self.folder / "run" / "store"

    async def start(self) -> None:
        """Start the programs. Raises StackError, DiskError."""
        if self._disk is not None:
            await self._disk.begin()
        self._url = (await self.stack.start()).url
        self._truth = await self.stack.status()
        self._watch = asyncio.create_task(self._look(), name="truth")
        self._service.start()

    async def stop(self) -> None:
        """End all programs."""
        await self._service.stop()
        for pilot in (*self._others, *([self._pilot] if self._pilot else [])):
            await pilot.close()
        if self._watch is not None:
            self._watch.cancel()
            await asyncio.gather(self._watch, return_exceptions=True)
        if self.stack.daemon is not None and self.stack.daemon.returncode is None:
            self.stack.daemon.send_signal(signal.SIGCONT)
        await self._second.stop()
        await self.stack.stop()
        self.proxy.close()
        if self._disk is not None:
            await self._disk.end()

    async def reach(self, when: When) -> None:
        """Make everything well and bring the drone into this part of a flight. Raises SurveyError and others."""
        self.proxy.use()
        self.falls = False
        await self.stack.inject(WELL | self._besides)
        for writer in self._half:
            writer.close()
        self._half.clear()
        if self._pilot is None:
            self._pilot = await Pilot.connect(self._url)
        await self._pilot.reach(when)

    async def run(self, fault: Fault) -> Outcome:
        """Do what the fault says, from where it says; return its outcome."""
        try:
            await self.reach(fault.when)
        except _GONE as error:
            return Outcome(fault, problems=(f"not {fault.when.value}: {error}{self._ends()}",))
        before, self.falls, self._broken = self._read_kept(), fault.falls, []
        await self._watch_fence()
        await asyncio.sleep(_JOURNALLED_S)
        self._since = Since(
            self._last_number(), len(self._service.exits), self._service.starts, self._passed(), self._truth
        )
        seconds, problems = await self._steps(fault)
        problems += self._broken
        kept: tuple[str, ...] = ()
        if not problems:
            problems, kept = await self._compare(before)
        return Outcome(fault, tuple(seconds), tuple(problems), kept, self._figures())

    def moment(self) -> Moment:
        """Return everything that can be seen now."""
        since, beat = self._since, self._beat()
        log = () if self._pilot is None else tuple(e for e in self._pilot.drone.log if e.number > since.log)
        if self._service.starts > since.starts and self._pilot is not None:
            log = tuple(self._pilot.drone.log)  # a new run of the daemon numbers its messages from zero
        return Moment(
            beat=beat,
            truth=self._truth,
            log=log,
            exits=tuple(self._service.exits[since.exits :]),
            starts=self._service.starts - since.starts,
            sent={kind: count - since.passed[kind] for kind, count in self._passed().items()},
            answers=tuple(since.answers),
            survey=since.survey,
            before=since.truth,
            second=self._second.seen,
        )

    # -- steps -------------------------------------------------------------------------------------------------------

    async def _steps(self, fault: Fault) -> tuple[list[float], list[str]]:
        seconds: list[float] = []
        began = self._now()
        for step in fault.steps:
            if not isinstance(step, See):
                try:
                    await self._do(step)
                except _GONE as error:
                    return seconds, [f"{type(step).__name__}: {error}"]
                began = self._now()
                continue
            found = await (self._lasts(step) if step.lasts else self._appears(step, began))
            if isinstance(found, str):
                return seconds, [found]
            seconds.append(found)
        return seconds, []

    async def _appears(self, see: See, began: float) -> float | str:
        """Return seconds from ``began`` until the sight; words when it did not come in time."""
        unit = self._speed if see.real else 1.0
        limit = asyncio.get_running_loop().time() + see.within_s * unit / self._speed * _PATIENCE + 5.0
        while not see.sight.test(self.moment()):
            if self._now() - began > see.within_s * unit or asyncio.get_running_loop().time() > limit:
                return f"not seen: {see.words}; {self._words()}"
            await asyncio.sleep(_LOOK_S)
        return round(max(0.0, self._now() - began) / unit, 1)

    async def _lasts(self, see: See) -> float | str:
        began = self._now()
        while self._now() - began < see.within_s:
            if not see.sight.test(self.moment()):
                return f"ended after {self._now() - began:.1f} s: {see.words}; {self._words()}"
            await asyncio.sleep(_LOOK_S)
        return see.within_s

    async def _do(self, act: Act) -> None:
        match act:
            case Link(rules):
                self.proxy.use(*rules)
            case Drone(values):
                await self.stack.inject(values)
            case Forge():
                await self._forge(act)
            case Station(kind, fields):
                if isinstance(self.stack, VehicleStack):
                    self.stack.station(kind, fields)
                else:
                    await self.proxy.station(kind, fields)
            case Signal(number, withheld):
                assert self.stack.daemon is not None
                self._service.withheld = withheld
                self.stack.daemon.send_signal(number)
            case StartAgain():
                self._service.withheld = False
            case CountAgain():
                self._since.passed, self._since.truth = self._passed(), self._truth
            case SecondDaemon(shared):
                await self._start_second(shared)
            case Disk(full):
                assert self._disk is not None
                await (self._disk.fill() if full else self._disk.empty())
            case WallClock(step_s):
                self._wall_clock.write_text(f"{step_s}")
            case HalfRequests(count):
                await self._half_requests(count)
            case _:
                await self._people(act)

    async def _people(self, act: People) -> None:
        pilot = self._pilot
        assert pilot is not None
        match act:
            case Survey():
                self._since.surveying = asyncio.create_task(self._survey(pilot), name="survey")
            case Order(command, stranger):
                who = await self._other() if stranger else pilot
                self._since.answers.append(await who.order(command))
            case KillMotors():
                self._since.answers.append(await pilot.kill())
            case Leave():
                await pilot.close()
                self._pilot = await Pilot.connect(self._url)  # somebody who looks on, without control
            case Return():
                await pilot.take_control()
            case Bring(when):
                await pilot.reach(when)
            case Hide(hidden):
                pilot.drone.is_hidden = hidden
            case KnowLot():
                self._since.answers.append(await self._know_lot(pilot))
            case ChangeLot(what):
                assert self._lot is not None
                await self._lot.change(what)
            case TakePlan(stranger):
                who = await self._other() if stranger else pilot
                offer = None if (beat := self._beat()) is None else beat.plan_offer
                self._since.answers.append(await who.order(FlyPlan(plan="none" if offer is None else offer.plan)))
            case Flood(command, count):
                viewer = await self._other()
                answers = [viewer.order(command) for _ in range(count)]
                self._since.flood = asyncio.gather(*answers, return_exceptions=True)

    async def _know_lot(self, pilot: Pilot) -> str | None:
        """Store a lot about the drone, and ask for its survey once the drone knows of it."""
        beat = self._beat()
        assert beat is not None
        assert beat.latitude is not None
        assert beat.longitude is not None
        self._lot = await StoredLot.make(self._url, beat.latitude, beat.longitude)
        for _ in range(_LOT_LOOKS):
            refused = await pilot.order(SurveyAgain(lots=[self._lot.id]))
            if refused is None:
                return None
            await asyncio.sleep(_LOT_LOOK_S)
        return refused

    async def _start_second(self, shared: bool) -> None:
        """Start another daemon on the autopilot's address that the first one has."""
        store = self.store if shared else self.folder / "second"
        ready = self.folder / "second.json"
        command = self.stack.daemon_command(ready, store=store, port=0)
        await self._second.start(command)

    async def _survey(self, pilot: Pilot) -> None:
        since = self._since
        try:
            since.survey, reason = await fly_survey(pilot.drone, self.stack)
        except Exception as error:  # whatever it is, it is why no survey is seen
            reason = repr(error)
        if since.survey.get("status", 1.0) != 0.0:
            self._note(f"the survey: {reason}")

    async def _watch_fence(self) -> None:
        """Let a real vehicle's true place be measured against the fence of the daemon."""
        beat = self._beat()
        if isinstance(self.stack, VehicleStack) and beat is not None:
            watch = FenceSender(self.stack)
            watch.look(beat)
            await watch.close()

    def _figures(self) -> tuple[str, ...]:
        found = tuple(figures(self._since.survey))
        farthest = self._truth.get("farthest_outside", 0.0)
        return (*found, f"{farthest:.1f} m outside at most") if farthest else found

    async def _forge(self, forge: Forge) -> None:
        for _ in range(forge.times):
            fields = {**forge.fields}
            if fields.get("time_boot_ms") == "now":
                fields["time_boot_ms"] = int(self._truth["time_boot"] * 1000)
            await self.proxy.forge(forge.kind, fields, system=forge.system, foreign=forge.foreign)
            await asyncio.sleep(forge.every_s / self._speed if forge.times > 1 else 0)

    async def _half_requests(self, count: int) -> None:
        place = urlsplit(self._url)
        for _ in range(count):
            with contextlib.suppress(OSError):
                _, writer = await asyncio.open_connection(place.hostname, place.port)
                writer.write(b"GET /api/health HTTP/1.1\r\nHost: loc")
                self._half.append(writer)

    async def _other(self) -> Pilot:
        made = await Pilot.connect(self._url)
        self._others.append(made)
        return made

    # -- watching ----------------------------------------------------------------------------------------------------

    async def _look(self) -> None:
        """Follow the true drone; note what must never be."""
        while True:
            with contextlib.suppress(OSError, TimeoutError):
                self._truth = await self.stack.status()
            is_in_air = not self._truth["landed"] and self._truth["position"]["height"] > _IN_AIR_M
            if self._truth["crashed"] and not self.falls:
                self._note("the drone crashed")
            if self._truth["disarmed"] and is_in_air and not self.falls:
                self._note("motors off in the air")
            await asyncio.sleep(_LOOK_S)

    def _note(self, problem: str) -> None:
        if problem not in self._broken:
            self._broken.append(problem)

    def _now(self) -> float:
        return float(self._truth["time"])

    def _passed(self) -> Counter[str]:
        found: Counter[str] = Counter()
        for (direction, kind), count in self.proxy.passed.items():
            if direction is Direction.UP:
                found[kind] += count
        return found

    def _beat(self) -> Heartbeat | None:
        """Return the last heartbeat; None while the daemon's last run has sent none."""
        if self._pilot is None or len(self._service.exits) > self._service.starts:
            return None
        drone = self._pilot.drone
        return drone.heartbeat if drone.is_connected else None

    def _ends(self) -> str:
        return f" (the daemon ended: {self._service.exits})" if self._service.exits else ""

    def _last_number(self) -> int:
        return self._pilot.drone.log[-1].number if self._pilot is not None and self._pilot.drone.log else -1

    def _words(self) -> str:
        """Return what is seen instead."""
        moment = self.moment()
        beat = moment.beat
        shown = "no heartbeat" if beat is None else f"{beat.state}: {beat.detail}"
        parts = [] if beat is None else [f"{i.name}: {i.reason}" for i in beat.health if not i.healthy]
        height = self._truth["position"]["height"]
        said = [entry.text for entry in moment.log[-4:]]
        answers = [answer or "accepted" for answer in moment.answers]
        found = ", ".join((*self._figures(), *self._broken))
        return f"{shown}; mode {self._truth['mode']}, {height:.0f} m; {parts} {said} {answers} {found}"

    # -- nothing is lost ---------------------------------------------------------------------------------------------

    def _read_kept(self) -> Kept | None:
        beat = self._beat()
        return None if beat is None or self._pilot is None else Kept.now(beat, self._pilot.drone.map.stalls, self.store)

    async def _compare(self, before: Kept | None) -> tuple[list[str], tuple[str, ...]]:
        """Compare parameters, stalls, journal and recording with those before the fault."""
        self.proxy.use()
        assert self._pilot is not None
        restarted = self._service.starts > self._since.starts
        limit = asyncio.get_running_loop().time() + (_RESTORED_S if restarted else 0.0)
        while True:
            try:
                await self._pilot.drone.whole_map()
            except _GONE as error:
                return [f"the map does not come: {error}"], ()
            after = self._read_kept()
            if before is None or after is None:
                return ["the daemon shows nothing"], ()
            problems = lost(before, after)
            if not problems or asyncio.get_running_loop().time() > limit:
                break
        kept = [f"{len(before.stalls)} stalls", f"{len(before.tiles)} parts of the map"]
        if restarted:
            problems += self._recorded(before)
            kept.append("recording")
        return problems, tuple(kept)

    def _recorded(self, before: Kept) -> list[str]:
        if before.recording is None:
            return []  # nothing is recorded before the first flight
        try:
            short = before.time - recording_ends(before.recording)
        except RecordingError as error:
            return [f"the recording: {error}"]
        return [f"the recording ends {short:.1f} s before the fault"] if short > RECORDED_S * self._speed else []


def _let_wall_clock_step(file: Path) -> None:
    """Let the wall clock of programs that are started from now on be off by the seconds in a file."""
    os.environ["FAULTS_WALL_CLOCK"] = str(file)
    paths = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    if str(_WALL_CLOCK) not in paths:
        os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (str(_WALL_CLOCK), *paths)))
