"""The headless operator: flies one survey through a `DroneClient`, from the checks to motors off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from hawk.comm.base_socket import FailedToSend
from hawk.comm.messages import (
    Arm,
    AutonomousExplore,
    Configure,
    Control,
    Disarm,
    Heartbeat,
    ReturnToLaunch,
    SetFailsafes,
    Takeoff,
)
from hawk.model import GROUND_STATES, HeightParameters, StateName, UserError
from hawk.survey.client import LinkLostError
from hawk.survey.handset import HOMING, SETTLED, Drone, Handset, Progress, SurveyError, SurveyStatus, sentence
from hawk.survey.search import LotSearch

__all__ = ["Progress", "SurveyLimits", "SurveyOperator", "SurveyOutcome", "SurveyPlan", "SurveyStatus"]

EXPLORE_ATTEMPTS: Final = 3
AGAIN_S: Final = 5.0
"""Seconds between two attempts to begin the way home."""
SUCCESS: Final = "The whole lot was seen."


@dataclass(frozen=True, slots=True)
class SurveyLimits:
    """How long each phase may take, seconds of the drone's clock; ``silence_s`` is real.

    ``look_s`` is how long each place is looked from for the lot.
    """

    link_s: float = 60.0
    checks_s: float = 120.0
    arm_s: float = 30.0
    takeoff_s: float = 90.0
    look_s: float = 4.0
    move_s: float = 120.0
    explore_s: float = 1800.0
    home_s: float = 600.0
    silence_s: float = 20.0


@dataclass(frozen=True, slots=True)
class SurveyPlan:
    """What to do. ``heights``: None keeps those that the drone has."""

    heights: HeightParameters | None = None
    set_failsafes: bool = False
    limits: SurveyLimits = SurveyLimits()


@dataclass(frozen=True, slots=True)
class SurveyOutcome:
    """How it ended. ``duration_s`` from take-off to motors off, ``way_m`` as the drone counted it."""

    status: SurveyStatus
    reason: str
    landed: bool
    disarmed: bool
    duration_s: float | None
    way_m: float | None
    explored: float | None


class SurveyOperator:
    """Flies one survey. `interrupt` (Ctrl-C) brings the drone home at any moment."""

    def __init__(
        self, drone: Drone, plan: SurveyPlan | None = None, progress: Callable[[Progress], None] | None = None
    ) -> None:
        self._plan = plan or SurveyPlan()
        self._limits = self._plan.limits
        self._hand = Handset(drone, self._limits.silence_s, progress or (lambda _: None))
        self._armed_by_us = False
        self._took_off_at: float | None = None

    def interrupt(self) -> None:
        """Come home now; `run` returns when the drone is down."""
        self._hand.interrupt()

    async def run(self) -> SurveyOutcome:
        """Fly it. Never raises for what the drone or the link does: the outcome tells."""
        status, reason = SurveyStatus.DONE, SUCCESS
        try:
            await self._prepare()
            await self._take_off()
            await self._survey()
        except SurveyError as error:
            status, reason = error.status, str(error)
        except (LinkLostError, FailedToSend) as error:
            status, reason = SurveyStatus.FAILED, _told(error)
        try:
            await self._come_home()
        except (SurveyError, LinkLostError, FailedToSend) as error:
            status = SurveyStatus.FAILED if status is SurveyStatus.DONE else status
            reason = f"{reason} {_told(error)}"
        return self._outcome(status, reason)

    async def _prepare(self) -> None:
        """Link, control, heights, failsafes, checks."""
        beat = await self._hand.until(lambda b: b.connected, self._limits.link_s, "The autopilot is not reached")
        await self._hand.order(Control(action="Request"))
        if beat.state != StateName.IDLE:
            raise SurveyError(sentence(f"The drone is not free for a survey but in {beat.state}", beat.detail))
        self._hand.phase = "Checking"
        if self._plan.heights is not None:
            await self._configure(self._plan.heights)
        await self._pass_checks()

    async def _configure(self, heights: HeightParameters) -> None:
        wanted = [heights.minimum, heights.desired, heights.maximum]
        await self._hand.order(Configure(min=wanted[0], des=wanted[1], max=wanted[2]))
        await self._hand.until(
            lambda b: b.state == StateName.IDLE and b.heights == wanted,
            self._limits.arm_s,
            "The heights were not taken",
            failed=lambda b: b.state == StateName.IDLE,
        )

    async def _pass_checks(self) -> None:
        """Wait until every check has passed; set failsafes, once, when a check asks for it."""
        asked = False

        def settled(beat: Heartbeat) -> bool:
            failed = [check for check in beat.checks if not check.passed]
            wants_failsafes = any(check.remedy_command == "Set Failsafes" for check in failed)
            return bool(beat.checks) and (not failed or (wants_failsafes and not asked))

        while True:
            beat = await self._hand.until(settled, self._limits.checks_s, _failed_checks)
            if all(check.passed for check in beat.checks):
                return
            if not self._plan.set_failsafes:
                raise SurveyError(f"{_failed_checks(beat)} The option --set-failsafes does that.")
            await self._hand.order(SetFailsafes())
            asked = True

    async def _take_off(self) -> None:
        self._hand.phase = "Taking off"
        self._armed_by_us = True
        await self._hand.order(Arm())
        await self._hand.until(
            lambda b: b.armed is True and b.state == StateName.ARM,
            self._limits.arm_s,
            "The drone did not arm",
            failed=lambda b: b.state == StateName.IDLE,
        )
        self._took_off_at = (await self._hand.beat()).time
        self._hand.flying = True
        await self._hand.order(Takeoff())
        await self._hand.until(
            lambda b: b.state == StateName.HOVER,
            self._limits.takeoff_s,
            "The drone did not reach its height",
            failed=lambda b: b.state in GROUND_STATES,
        )

    async def _survey(self) -> None:
        """Find the lot and explore it; look for it again where it was lost from sight."""
        search = LotSearch(self._hand, self._limits.look_s, self._limits.move_s)
        explored = False
        while True:
            try:
                await search.find()
            except SurveyError as error:
                if not explored or error.status is not SurveyStatus.NO_LOT:
                    raise
                raise SurveyError("The lot was lost from sight.", SurveyStatus.INCOMPLETE) from None
            if await self._explore():
                return
            explored = True

    async def _explore(self) -> bool:
        """Explore until nothing is left, beginning again a few times after what ended it early.

        Returns False when the lot was lost from sight.
        """
        self._hand.phase = "Exploring"
        for _ in range(EXPLORE_ATTEMPTS):
            refusal = await self._hand.offer(AutonomousExplore())
            beat = await self._hand.until(
                lambda b: b.state == StateName.HOVER,
                self._limits.explore_s,
                "The time for exploring is over",
                status=SurveyStatus.INCOMPLETE,
            )
            if beat.user_error == UserError.NO_LOT_DETECTED:
                return False
            if refusal is not None:
                await self._hand.pause(self._limits.look_s)
            elif beat.explore_done:
                return True
        raise SurveyError(sentence("Exploring ended early", refusal or beat.detail), SurveyStatus.INCOMPLETE)

    async def _come_home(self) -> None:
        """Return To Launch and motors off; a drone that this survey did not arm is left alone."""
        self._hand.go_home()
        if self._hand.last is None:
            return
        if self._armed_by_us:
            self._hand.phase = "Coming home"
            await self._return_and_land(self._hand.last)
        await self._hand.tell(Control(action="Release"))

    async def _return_and_land(self, beat: Heartbeat) -> None:
        """Wait for motors off. The first heartbeats may be older than the last order: down is believed after them."""
        asked: float | None = None
        waited, last, seen = 0.0, beat.time, 0
        while seen < SETTLED or not _is_down(beat):
            if waited > self._limits.home_s:
                raise SurveyError(sentence("The drone is not down yet", beat.detail))
            due = asked is None or waited - asked > AGAIN_S
            if due and beat.state not in HOMING | {StateName.MANUAL} and not _is_down(beat):
                asked = waited
                await self._ask_for_the_way_home(beat)
            self._hand.phase = "Landing" if beat.state == StateName.LAND else "Coming home"
            beat = await self._hand.next()
            seen += 1
            waited, last = waited + max(0.0, beat.time - last), beat.time

    async def _ask_for_the_way_home(self, beat: Heartbeat) -> None:
        """Refused or not heard: it is asked for again, since nothing else is left to do."""
        try:
            await self._hand.tell(Control(action="Request"))
            await self._hand.tell(Disarm() if beat.state in GROUND_STATES else ReturnToLaunch())
        except (LinkLostError, FailedToSend):
            return  # without a link the drone comes home by its own settings

    def _outcome(self, status: SurveyStatus, reason: str) -> SurveyOutcome:
        beat = self._hand.last
        if beat is None:
            return SurveyOutcome(status, reason, False, False, None, None, None)
        return SurveyOutcome(
            status=status,
            reason=reason,
            landed=_is_down(beat) or beat.landed == "GROUND_STATES",
            disarmed=beat.armed is False,
            duration_s=None if self._took_off_at is None else max(0.0, beat.time - self._took_off_at),
            way_m=beat.way,
            explored=beat.explored,
        )


def _is_down(beat: Heartbeat) -> bool:
    return beat.armed is False and beat.state == StateName.IDLE


def _failed_checks(beat: Heartbeat) -> str:
    failed = [check for check in beat.checks if not check.passed]
    if not failed:
        return "The checks before flight did not come."
    told = "; ".join(f"{check.name}: {check.value}. {check.remedy}".strip() for check in failed)
    return f"Checks failed: {told}"


def _told(error: Exception) -> str:
    text = str(error)
    return f"{text[:1].upper()}{text[1:].rstrip('.')}."
