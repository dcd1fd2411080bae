"""The real daemon and hawk-sim as processes, and an operator who flies them."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from hawk.comm.protocol.commands import Ack, Arm, Command, Control, ReturnToLaunch, SetFailsafes, Takeoff
from hawk.comm.protocol.heartbeat import HealthItem, Heartbeat
from hawk.ddc.parameters.failsafes import GCS_TIMEOUT
from hawk.ddc.recorder import TICK
from hawk.ddc.replay import compare_recording
from hawk.model.operation import StateName
from hawk.sim.launch import SimulationOptions
from hawk.store.journal_state import JournalState, read_survey, surveys_of
from hawk.store.replay import read_recording
from hawk.survey.client import DroneClient
from hawk.survey.handset import Handset, refusal_of
from hawk.survey.stack import Ready, SimulatedStack
from tests.forked import start_program
from tests.integration.sim_support import small_picture
from tests.pace import PATIENCE_S, speed_here

SPEED_ASKED = 3.0
SPEED = speed_here(SPEED_ASKED)
CAMERA_HZ = 3.0
"""Pictures in a simulated second, where there is nothing to be seen: vision would take a whole core for fifteen."""
STEP_S = 300.0
"""No step of a flight takes as long, seconds of the drone, which are real ones where the computer is slow."""
POLL_S = 0.05
DISARM_DELAY_S = 60
"""Motors that run on the ground are off after so long, seconds of the drone."""

LOW_HEIGHTS = """
[heights]
minimum_m = 5.0
desired_m = 8.0
maximum_m = 10.0
[vision]
minimum_height_m = 20.0
"""
"""Settings for flights on which nothing is to be seen: below its least height vision has no work."""


def low(operator_timeout_s: float = 4.0, operator_hold_s: float = 6.0) -> str:
    """Return the same with little patience, seconds of the drone: a lost operator shows soon.

    At `SPEED`, a page that draws for 1.3 s would be lost.
    """
    return f"""{LOW_HEIGHTS}
[operator]
operator_timeout_s = {operator_timeout_s}
operator_hold_s = {operator_hold_s}
control_lease_s = 8.0
"""


LOW = low()


class PatientStack(SimulatedStack):
    """A drone whose autopilot waits for this computer as long as its check allows.

    The default of five simulated seconds is shorter than a daemon takes that starts again on a busy machine, and ten
    between Arm and Take off are three real ones, in which a page may draw no question.
    """

    def __init__(self, options: SimulationOptions, folder: Path, config: Path | None, fence: Path | None) -> None:
        super().__init__(options, folder, config, fence, start_program=start_program)

    async def start(self) -> Ready:
        ready = await super().start()
        await self.inject({"parameters": {GCS_TIMEOUT.name: GCS_TIMEOUT.high, "DISARM_DELAY": DISARM_DELAY_S}})
        return ready


def over_a_picture(folder: Path, settings: str = LOW, **options: Any) -> SimulatedStack:
    """Return a stack over 60 x 60 m of noise: ready at once, and no lot anywhere. ``options`` are hawk-sim's."""
    given = {"speed": SPEED, "camera_rate": CAMERA_HZ, **options}
    simulation = SimulationOptions(world=small_picture(folder), metres_per_pixel=0.5, **given)
    return PatientStack(simulation, folder / "run", write_settings(folder, settings), None)


def write_settings(folder: Path, settings: str) -> Path:
    """Write a settings file and return its path."""
    path = folder / "config.toml"
    path.write_text(settings)
    return path


async def kill_daemon(stack: SimulatedStack) -> None:
    """Send SIGKILL to the daemon, as a crash or an empty companion battery would."""
    if stack.daemon is not None and stack.daemon.returncode is None:
        stack.daemon.kill()
        await stack.daemon.wait()


def newest_journal(store: Path) -> JournalState:
    """Return what the newest survey of a store holds on the disk."""
    return read_survey(surveys_of(store / "journal")[-1])[1]


async def until_journalled(store: Path, holds: Callable[[JournalState], bool]) -> None:
    """Wait until the journal's newest survey holds something; nobody cuts the power within half a second."""
    async with asyncio.timeout(PATIENCE_S):
        while not holds(newest_journal(store)):  # noqa: ASYNC110 - a disk sends no event
            await asyncio.sleep(POLL_S)


async def end_daemon(stack: SimulatedStack) -> int:
    """Send SIGTERM to the daemon, as the service manager does; return the exit status."""
    assert stack.daemon is not None
    stack.daemon.terminate()
    return await stack.daemon.wait()


class Operator:
    """One person with a connection: orders, and waits for what heartbeats show. Times are the drone's unless real."""

    def __init__(self, drone: DroneClient) -> None:
        self.drone = drone
        self.hand = Handset(drone, PATIENCE_S, lambda _, __: None)

    @property
    def beat(self) -> Heartbeat:
        """The last heartbeat."""
        assert self.drone.heartbeat is not None
        return self.drone.heartbeat

    async def until(self, reached: Callable[[Heartbeat], bool], timeout_s: float = STEP_S) -> Heartbeat:
        """Wait for such a heartbeat. Raises SurveyError with what the drone said instead."""
        return await self.hand.until(reached, timeout_s, lambda b: f"still {b.state}, {b.ardupilot_state}: {b.detail}")

    async def until_state(self, state: StateName, timeout_s: float = STEP_S) -> Heartbeat:
        """Wait until the drone is in a state."""
        return await self.until(lambda b: b.state == state, timeout_s)

    async def until_said(self, words: str) -> Heartbeat:
        """Wait until the drone's messages hold these words: those of every heartbeat, the last one may lack them."""
        return await self.until(lambda _: any(words in entry.text for entry in self.drone.log))

    async def order(self, command: Command) -> None:
        """Give a command that must be taken."""
        await self.hand.order(command)

    async def refusal(self, command: Command) -> str:
        """Give a command that must be refused; return the reason."""
        answer = await self.drone.ask(command)
        assert isinstance(answer, Ack)
        assert not answer.accepted
        return answer.reason

    async def take_control(self) -> None:
        """Ask for control, again while somebody who has gone still has it."""
        async with asyncio.timeout(PATIENCE_S):
            while not await self._has_control():
                await self.hand.next()

    async def arm(self) -> None:
        """Take control, set what the checks ask for, and arm."""
        await self.until(lambda b: b.connected and bool(b.checks))
        await self.take_control()
        await self.until(lambda b: all(c.passed or c.remedy_command == "Set Failsafes" for c in b.checks))
        if not all(check.passed for check in self.beat.checks):
            await self.order(SetFailsafes())
        await self.until(lambda b: bool(b.checks) and all(check.passed for check in b.checks))
        await self.order(Arm())
        await self.until(lambda b: b.state == StateName.ARM and b.armed is True)

    async def climb(self) -> None:
        """Take off to the desired height, as soon as a person could."""
        await self.until(lambda b: not refusal_of(b, "Takeoff"))
        await self.order(Takeoff())
        await self.until_state(StateName.HOVER)

    async def take_off(self) -> None:
        """Arm and climb."""
        await self.arm()
        await self.climb()

    async def until_down(self, timeout_s: float = STEP_S) -> Heartbeat:
        """Wait until the motors are off."""
        return await self.until(lambda b: b.state == StateName.IDLE and b.armed is False, timeout_s)

    async def come_home(self) -> None:
        """Return home and wait until the motors are off."""
        await self.order(ReturnToLaunch())
        await self.until_down()

    async def _has_control(self) -> bool:
        answer = await self.drone.ask(Control(action="Request"))
        return isinstance(answer, Ack) and answer.accepted


@contextlib.asynccontextmanager
async def operator(url: str) -> AsyncIterator[Operator]:
    """Connect a new operator, without control."""
    place = urlsplit(url)
    async with DroneClient(place.hostname or "", place.port or 0) as drone:
        yield Operator(drone)


async def eventually(
    ask: Callable[[], Awaitable[dict[str, Any]]],
    reached: Callable[[dict[str, Any]], bool],
    timeout_s: float = PATIENCE_S,
) -> dict[str, Any]:
    """Ask again and again until the answer is such; real seconds. Raises AssertionError with the last answer."""
    clock = asyncio.get_running_loop().time
    deadline = clock() + timeout_s
    while not reached(answer := await ask()):
        assert clock() < deadline, answer
        await asyncio.sleep(POLL_S)
    return answer


def health(beat: Heartbeat, name: str) -> HealthItem:
    """Return the health of one part."""
    return next(item for item in beat.health if item.name == name)


def differing_decisions(recording: Path) -> list[str]:
    """Decide a recording again, entered at its start and at each memory; return in words what differs.

    One that ended before its first tick was written holds nothing to decide. Raises ReplayError, RecordingError.
    """
    if not any(recorded.topic == TICK for recorded in read_recording(recording)):
        return []
    found = compare_recording(recording)
    words = [f"{recording}: {len(found.differences)} of {found.decided} decisions differ"] if found.differences else []
    if found.left_out:
        words.append(f"{recording}: no memory leads to {found.left_out} of {found.decided} moments")
    return words + [f"at {one.at:.2f} {one.command}: {one.recorded} | {one.again}" for one in found.differences[:3]]
