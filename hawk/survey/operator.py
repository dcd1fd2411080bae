"""The headless operator: flies one survey through a `DroneClient`, from the checks to motors off."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from hawk.comm.base_socket import FailedToSend
from hawk.comm.protocol.commands import (
    MOST_LOTS,
    Arm,
    AutonomousExplore,
    CompulsiveMove,
    Configure,
    Control,
    Disarm,
    Hold,
    NewSurvey,
    ReturnToLaunch,
    SetFailsafes,
    SetOutline,
    SurveyAgain,
    Takeoff,
)
from hawk.comm.protocol.heartbeat import Heartbeat, LeftOutStatus, RoundLotStatus
from hawk.model.operation import GROUND_STATES, StateName, UserError
from hawk.model.plans import HeightParameters
from hawk.survey.client import LinkLostError
from hawk.survey.handset import (
    HOMING,
    SETTLED,
    Drone,
    Handset,
    Progress,
    SurveyError,
    SurveyStatus,
    refusal_of,
    sentence,
)

EXPLORE_ATTEMPTS: Final = 3
AGAIN_S: Final = 5.0
"""Seconds between two attempts to begin the return home."""
CHECKING: Final = "Checking"
"""Phase in which the checks before flight must pass."""
SUCCESS: Final = "The whole lot was seen."
OUTLINE_SEEN: Final = "The outline was seen."
SPIRAL_STEP_M: Final = 10.0
SPIRAL_LENGTH_M: Final = 60.0
"""Length of the spiral: legs of 10, 10, 20 and 20 m, flown at Max."""
NO_SURVEY: Final = "There is no survey to continue: the drone has no map of an earlier flight"
NOTHING_LEFT: Final = (
    "Nothing is left of this survey: the lot was seen whole. Nothing was flown; leave --continue out for a new survey."
)
STALLS_SEEN: Final = "Every stall was looked at."
AGAIN_TRIES: Final = 8
"""Attempts, a second apart, to survey a lot again: the drone reads its lots every two seconds."""
NO_LOT: Final = "No lot in sight, not even from the greatest height and 60 m around."


@dataclass(frozen=True, slots=True)
class SurveyLimits:
    """Longest duration of each phase, seconds of the drone's clock; ``silence_s`` is real.

    ``look_s`` is the time to look for the lot from each place; within ``map_s`` the map of an earlier flight is there.
    """

    link_s: float = 60.0
    map_s: float = 60.0
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
    """Plan of a survey. ``heights``: None keeps the drone's present heights.

    ``continues``: fly only when there is a map of an earlier survey. ``outline``: the area to survey; None leaves what
    the drone has.
    """

    heights: HeightParameters | None = None
    set_failsafes: bool = False
    continues: bool = False
    outline: SetOutline | None = None
    again: SurveyAgain | None = None
    """The command for lots that are surveyed again; None: none."""
    limits: SurveyLimits = SurveyLimits()


@dataclass(frozen=True, slots=True)
class SurveyOutcome:
    """Outcome of a survey. ``duration_s`` from take-off to motors off, ``distance_m`` as the drone measured it.

    ``outline_m2`` is the area of the outline inside the fence, ``outline_outside_m2`` outside it, ``outline_unseen_m2``
    what no picture could reach, square metres; None without an outline. ``free_range`` holds the number of free stalls.
    ``left_out`` is what else was not looked at; None with an outline, and unless the exploration was done.
    """

    status: SurveyStatus
    reason: str
    landed: bool
    disarmed: bool
    duration_s: float | None
    distance_m: float | None
    explored: float | None
    outline_m2: float | None = None
    outline_outside_m2: float | None = None
    outline_unseen_m2: float | None = None
    free_range: tuple[int, int] | None = None
    left_out: LeftOutStatus | None = None
    planned_m: float | None = None
    """Length of the flight over lots that are surveyed again, as it was planned before the start, metres."""
    lots: tuple[RoundLotStatus, ...] = ()
    """The lots that are surveyed again."""

    @property
    def was_flown(self) -> bool:
        """True when the drone took off: only then there are results of this survey."""
        return self.duration_s is not None


class SurveyOperator:
    """Flies one survey. `interrupt` (Ctrl-C) brings the drone home at any moment."""

    def __init__(self, drone: Drone, plan: SurveyPlan, progress: Progress = lambda _, __: None) -> None:
        self._plan = plan
        self._limits = self._plan.limits
        self._hand = Handset(drone, self._limits.silence_s, progress)
        self._armed_by_us = False
        self._took_off_at: float | None = None
        self._planned_m: float | None = None

    def interrupt(self) -> None:
        """Come home now; `run` returns when the drone is on the ground."""
        self._hand.interrupt()

    async def run(self) -> SurveyOutcome:
        """Fly the survey. Faults of the drone or the link do not raise: the outcome reports them."""
        status, reason = SurveyStatus.DONE, SUCCESS
        try:
            await self._prepare()
            await self._take_off()
            await self._survey()
            unseen = (await self._hand.beat()).outline_unseen
            reason = f"{OUTLINE_SEEN} {unseen:.0f} m² of it could not be reached." if unseen else SUCCESS
            if self._plan.again:
                seen = (await self._hand.beat()).explored or 0.0
                reason = STALLS_SEEN if seen >= 1.0 else f"{int(100 * seen)} % of the stalls were looked at."
        except SurveyError as error:
            status, reason = error.status, str(error)
        except (LinkLostError, FailedToSend) as error:
            status, reason = SurveyStatus.FAILED, _sentence_of(error)
        try:
            await self._come_home()
        except (SurveyError, LinkLostError, FailedToSend) as error:
            status = SurveyStatus.FAILED if status is SurveyStatus.DONE else status
            reason = f"{reason} {_sentence_of(error)}"
        return self._outcome(status, reason)

    async def _prepare(self) -> None:
        """Wait for the link; take control; set heights and failsafes; pass the checks."""
        beat = await self._hand.until(lambda b: b.connected, self._limits.link_s, "The autopilot is not reached")
        await self._hand.order(Control(action="Request"))
        if beat.state != StateName.IDLE:
            raise SurveyError(sentence(f"The drone is not free for a survey but in {beat.state}", beat.detail))
        if self._plan.continues:
            beat = await self._hand.until(lambda b: (b.lot_area or 0.0) > 0.0, self._limits.map_s, NO_SURVEY)
            if beat.explore_done or (beat.survey_basis == "map" and beat.battery_needed_survey == 0.0):
                raise SurveyError(NOTHING_LEFT)
        self._hand.phase = CHECKING
        if self._plan.heights is not None:
            await self._configure(self._plan.heights)
        if self._plan.outline is not None:
            await self._hand.order(self._plan.outline)
            await self._hand.until(
                lambda b: b.outline_area is not None, self._limits.arm_s, "The outline was not taken"
            )
        if self._plan.again is not None:
            await self._ask_again(self._plan.again)
        await self._pass_checks()

    async def _ask_again(self, asked: SurveyAgain) -> None:
        """Ask for the survey of known lots, on an empty map unless it goes on; wait until its flight is planned."""
        refusal = None
        if not self._plan.continues and ((await self._hand.beat()).lot_area or 0.0) > 0.0:
            await self._hand.order(NewSurvey())
        for _ in range(AGAIN_TRIES):
            refusal = await self._hand.offer(asked)
            if refusal is None:
                break
            await self._hand.pause(1.0)
        else:
            raise SurveyError(sentence("Survey Again was refused", refusal or ""))
        most_s = self._limits.map_s * (len(asked.lots) or MOST_LOTS)  # each lot is planned by itself
        beat = await self._hand.until(
            lambda b: b.again_distance is not None, most_s, "The flight over the lots was not planned"
        )
        self._planned_m = beat.again_distance

    async def _configure(self, heights: HeightParameters) -> None:
        wanted = (heights.minimum, heights.desired, heights.maximum)
        await self._hand.order(Configure(min=wanted[0], des=wanted[1], max=wanted[2]))
        await self._hand.until(
            lambda b: b.state == StateName.IDLE and b.heights == wanted,
            self._limits.arm_s,
            "The heights were not taken",
            failed=lambda b: b.state == StateName.IDLE,
        )

    async def _pass_checks(self) -> None:
        """Wait until every check has passed; set the failsafes once when a check asks for it."""
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
        await self._hand.until(
            lambda b: not refusal_of(b, "Takeoff"),
            self._limits.arm_s,
            lambda b: sentence("Takeoff is not possible", refusal_of(b, "Takeoff")),
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
        """Find the lot and explore it; search again where it was lost from sight. An outline needs no search."""
        search = LotSearch(self._hand, self._limits.look_s, self._limits.move_s)
        explored = False
        while True:
            try:
                if (await self._hand.beat()).outline_area is None:
                    await search.find()
            except SurveyError as error:
                if not explored or error.status is not SurveyStatus.NO_LOT:
                    raise
                raise SurveyError("The lot was lost from sight.", SurveyStatus.INCOMPLETE) from None
            if await self._explore():
                return
            explored = True

    async def _explore(self) -> bool:
        """Explore until nothing is left; begin again up to `EXPLORE_ATTEMPTS` times when it ends early.

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
        """Return To Launch and wait for motors off; a drone that this survey did not arm stays as it is."""
        self._hand.go_home()
        if self._hand.last is None:
            return
        if self._armed_by_us:
            self._hand.phase = "Coming home"
            await self._return_and_land(self._hand.last)
        await self._hand.attempt(Control(action="Release"))

    async def _return_and_land(self, beat: Heartbeat) -> None:
        """Wait for motors off. The first heartbeats may be older than the last order, and prove nothing."""
        asked: float | None = None
        waited, last, seen = 0.0, beat.time, 0
        while seen < SETTLED or not _is_down(beat):
            if waited > self._limits.home_s:
                raise SurveyError(sentence("The drone is not down yet", beat.detail))
            due = asked is None or waited - asked > AGAIN_S
            if due and beat.state not in HOMING | {StateName.MANUAL} and not _is_down(beat):
                asked = waited
                await self._ask_to_come_home(beat)
            self._hand.phase = "Landing" if beat.state == StateName.LAND else "Coming home"
            beat = await self._hand.next()
            seen += 1
            waited, last = waited + max(0.0, beat.time - last), beat.time

    async def _ask_to_come_home(self, beat: Heartbeat) -> None:
        """Ask for the return home. A refusal is no error: it is asked for again."""
        try:
            await self._hand.attempt(Control(action="Request"))
            await self._hand.attempt(Disarm() if beat.state in GROUND_STATES else ReturnToLaunch())
        except (LinkLostError, FailedToSend):
            return  # without a link the drone comes home by its own settings

    def _outcome(self, status: SurveyStatus, reason: str) -> SurveyOutcome:
        beat = self._hand.last
        if beat is None:
            return SurveyOutcome(status, reason, False, False, None, None, None)
        return SurveyOutcome(
            status=status,
            reason=reason,
            landed=_is_down(beat) or beat.landed == "ON_GROUND",
            disarmed=beat.armed is False,
            duration_s=None if self._took_off_at is None else max(0.0, beat.time - self._took_off_at),
            distance_m=beat.distance_flown,
            explored=beat.explored,
            outline_m2=beat.outline_area,
            outline_outside_m2=beat.outline_outside,
            outline_unseen_m2=beat.outline_unseen,
            free_range=beat.free_range,
            left_out=beat.left_out,
            planned_m=self._planned_m,
            lots=beat.again_lots,
        )


def _is_down(beat: Heartbeat) -> bool:
    return beat.armed is False and beat.state == StateName.IDLE


def _failed_checks(beat: Heartbeat) -> str:
    failed = [check for check in beat.checks if not check.passed]
    if not failed:
        return "The checks before flight did not come."
    texts = "; ".join(f"{check.name}: {check.value}. {check.remedy}".strip() for check in failed)
    return f"Checks failed: {texts}"


def _sentence_of(error: Exception) -> str:
    text = str(error)
    return f"{text[:1].upper()}{text[1:].rstrip('.')}."


class LotSearch:
    """Looks for a lot from the present place, then from Max along the spiral; each place is visited once.

    ``look_s``: seconds to look from each place; ``move_s``: longest duration of one move, seconds.
    """

    def __init__(self, hand: Handset, look_s: float, move_s: float) -> None:
        self._hand = hand
        self._look_s = look_s
        self._move_s = move_s
        self._places: Iterator[tuple[float, float]] | None = None

    async def find(self) -> None:
        """Return when the drone hovers with a lot in sight; another call continues at the next place.

        Raises SurveyError with status NO_LOT after the last place.
        """
        self._hand.phase = "Looking for the lot"
        if self._places is None:
            beat = await self._hand.beat()
            if beat.north is None or beat.east is None:
                raise SurveyError("The place of the drone is not known.", SurveyStatus.NO_LOT)
            self._places = spiral(beat.north, beat.east)
            if await _in_sight(self._hand, self._look_s):
                return
        for north, east in self._places:
            if await self._go(north, east) and await _in_sight(self._hand, self._look_s):
                return
        raise SurveyError(NO_LOT, SurveyStatus.NO_LOT)

    async def _go(self, north: float, east: float) -> bool:
        """Fly there at Max and stop at once when a lot comes in sight; return False when the place was refused."""
        beat = await self._hand.beat()
        refusal = await self._hand.offer(CompulsiveMove(x=north, y=east, frame="Map", height=beat.heights[2]))
        if refusal is not None:
            return False  # outside the fence, for one: the next place may be inside
        beat = await self._hand.until(
            lambda b: b.state == StateName.HOVER or b.park_lot_detected is True,
            self._move_s,
            "The drone did not get to where it looks for the lot",
        )
        if beat.state != StateName.HOVER:
            await self._hand.attempt(Hold())
            await self._hand.until(lambda b: b.state == StateName.HOVER, self._move_s, "The drone did not stop")
        return True


def spiral(north: float, east: float) -> Iterator[tuple[float, float]]:
    """Yield the corners of a square spiral of `SPIRAL_LENGTH_M` (metres, map frame), the centre first."""
    yield north, east
    length, leg, sign = 0.0, SPIRAL_STEP_M, 1.0
    while True:
        for step_north, step_east in ((leg * sign, 0.0), (0.0, leg * sign)):
            if length + leg > SPIRAL_LENGTH_M:
                return
            length += leg
            north, east = north + step_north, east + step_east
            yield north, east
        leg, sign = leg + SPIRAL_STEP_M, -sign


async def _in_sight(hand: Handset, look_s: float) -> bool:
    """Return True when the lot is seen within a few seconds."""
    began = (await hand.beat()).time
    beat = await hand.until(
        lambda b: b.park_lot_detected is True or b.time - began > look_s,
        4 * look_s,
        "The lot was looked for too long",
    )
    return beat.park_lot_detected is True
