"""Orders to the drone, and waits for their effect in its heartbeats. The phases of a survey consist of them.

Every wait has an end, with a reason in the drone's own words. Times are of the drone's clock unless called real.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from enum import IntEnum
from typing import Final, Protocol

from hawk.comm.protocol.commands import Ack, Answer, Command
from hawk.comm.protocol.heartbeat import Heartbeat
from hawk.model.operation import StateName

SETTLED: Final = 2
"""Heartbeats after an answer until one surely shows the command's effect."""
HOMING: Final = frozenset({StateName.RETURN_TO_LAUNCH, StateName.LAND})


class SurveyStatus(IntEnum):
    """Outcome of a survey; the command's exit status."""

    DONE = 0
    FAILED = 1
    NO_LOT = 3
    INCOMPLETE = 4
    INTERRUPTED = 130


class SurveyError(Exception):
    """The survey cannot go on; the drone is brought home. The text is the reason."""

    def __init__(self, reason: str, status: SurveyStatus = SurveyStatus.FAILED) -> None:
        super().__init__(reason)
        self.status = status


Progress = Callable[[str, Heartbeat], None]
"""Called with every heartbeat and the phase in a word or two."""


class Drone(Protocol):
    """The part of `hawk.survey.client.DroneClient` that a survey uses."""

    heartbeat: Heartbeat | None

    async def next_heartbeat(self, timeout_s: float) -> Heartbeat:
        """Wait for the next heartbeat. Raises LinkLostError after real seconds."""

    async def ask(self, command: Command) -> Answer:
        """Send a command and return the answer. Raises FailedToSend, LinkLostError."""


def refusal_of(beat: Heartbeat, command: str) -> str:
    """Return why a heartbeat says that a command (by its type) is not possible now; empty when it is."""
    return next((option.reason for option in beat.options if option.command == command and not option.possible), "")


class Handset:
    """Orders and waits, for one survey. `interrupt` ends any wait until `go_home` was called."""

    def __init__(self, drone: Drone, silence_s: float, progress: Progress) -> None:
        self._drone = drone
        self._silence = silence_s
        self._progress = progress
        self._interrupted = asyncio.Event()
        self._going_home = False
        self.phase = "Connecting"
        self.flying = False
        """True once take-off was ordered: from then on a return home, or a pilot, ends every wait."""

    def interrupt(self) -> None:
        """End the present wait, and every later one until `go_home`, with status INTERRUPTED."""
        self._interrupted.set()

    def go_home(self) -> None:
        """From now on only silence ends a wait for a heartbeat."""
        self._going_home = True

    @property
    def last(self) -> Heartbeat | None:
        """The last heartbeat."""
        return self._drone.heartbeat

    async def beat(self) -> Heartbeat:
        """Return the last heartbeat; wait for the first."""
        return self._drone.heartbeat or await self.next()

    async def next(self) -> Heartbeat:
        """Wait for the next heartbeat. Raises LinkLostError after real ``silence_s``, SurveyError when interrupted."""
        if self._going_home:
            beat = await self._drone.next_heartbeat(self._silence)
        else:
            beat = await self._next_or_interrupt()
        self._progress(self.phase, beat)
        return beat

    async def order(self, command: Command) -> None:
        """Send a command that must be accepted, and wait until heartbeats show its effect. Raises SurveyError."""
        refusal = await self.offer(command)
        if refusal is not None:
            raise SurveyError(sentence(f"{getattr(command, 'type', 'A command')} was refused", refusal))

    async def offer(self, command: Command) -> str | None:
        """Send a command; return the reason when it was refused. Waits until heartbeats show its effect."""
        answer = await self._drone.ask(command)
        if isinstance(answer, Ack) and not answer.accepted:
            return answer.reason or "no reason given"
        for _ in range(SETTLED):
            await self.next()
        return None

    async def pause(self, seconds: float) -> None:
        """Wait that many seconds of the drone's clock."""
        began = (await self.beat()).time
        await self.until(lambda b: b.time - began >= seconds, 10 * seconds, "The drone's clock stands still")

    async def attempt(self, command: Command) -> None:
        """Send a command whose refusal changes nothing."""
        await self._drone.ask(command)

    async def until(
        self,
        reached: Callable[[Heartbeat], bool],
        timeout_s: float,
        otherwise: str | Callable[[Heartbeat], str],
        *,
        failed: Callable[[Heartbeat], bool] = lambda _: False,
        status: SurveyStatus = SurveyStatus.FAILED,
    ) -> Heartbeat:
        """Wait until ``reached`` is true of a heartbeat, and return that heartbeat.

        Raises:
            SurveyError: After ``timeout_s``, when ``failed`` is true, when the drone goes home or a pilot flies it, or
                when interrupted. The text is ``otherwise`` and the drone's own words.
        """
        beat = await self.beat()
        waited, last = 0.0, beat.time
        while not reached(beat):
            self._check_course(beat)
            if failed(beat) or waited > timeout_s:
                text = sentence(otherwise, beat.detail) if isinstance(otherwise, str) else otherwise(beat)
                raise SurveyError(text, status)
            beat = await self.next()
            # A restarted drone's clock starts at zero again: only steps forward are added.
            waited, last = waited + max(0.0, beat.time - last), beat.time
        return beat

    def _check_course(self, beat: Heartbeat) -> None:
        if not self.flying or self._going_home:
            return
        state = StateName(beat.state)
        if state in HOMING:
            raise SurveyError(sentence("The drone comes home early", beat.detail), SurveyStatus.INCOMPLETE)
        if state is StateName.MANUAL:
            raise SurveyError(sentence("A pilot has taken over", beat.detail), SurveyStatus.INCOMPLETE)
        if state is StateName.IDLE:
            raise SurveyError(sentence("The drone is on the ground", beat.detail), SurveyStatus.INCOMPLETE)

    async def _next_or_interrupt(self) -> Heartbeat:
        next_beat = asyncio.create_task(self._drone.next_heartbeat(self._silence), name="survey-heartbeat")
        stop = asyncio.create_task(self._interrupted.wait(), name="survey-interrupt")
        try:
            await asyncio.wait({next_beat, stop}, return_when=asyncio.FIRST_COMPLETED)
            if stop.done():
                raise SurveyError("Interrupted.", SurveyStatus.INTERRUPTED)
            return next_beat.result()
        finally:
            next_beat.cancel()
            stop.cancel()
            await asyncio.gather(next_beat, stop, return_exceptions=True)


def sentence(text: str, detail: str) -> str:
    """Return the text followed by the drone's own words."""
    head = text.rstrip(".")
    return f"{head}: {detail}" if detail else f"{head}."
