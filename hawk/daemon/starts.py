"""The starts of this program: the survey that goes on, and the starts in the air as disk and memory count them.

Boot id and the kernel's time since the boot decide (`hawk.model.moment`); the wall clock steps, and decides nothing
alone. Starts and flight are noted twice: in the journal, which outlives a boot of the computer, and in its memory
(`hawk.store.run_notes`), which works while the disk does not. What either of them says counts.
"""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

from hawk.comm.autopilot.autopilot import expected_autopilot
from hawk.comm.mavlink.passive_listener import wait_until_disarmed
from hawk.config.sections import AutopilotSettings
from hawk.ddc.rules.follower import RESTART_WINDOW_S, RestartRule, flight_goes_on, restart_rule, starts_before
from hawk.model.moment import Moment, this_moment
from hawk.model.operation import FlightSoFar
from hawk.runtime.supervision import end_tasks
from hawk.store.journal import FlightJournal
from hawk.store.journal_state import JournalState
from hawk.store.run_notes import Notes, RunNotes

_LOG = logging.getLogger(__name__)

CONTINUE_S: Final = 1800.0
"""A daemon that starts on the ground continues a survey younger than this, seconds."""
SECOND_START: Final = 2
"""An uncounted start counts as this one: something is wrong with us, so the drone returns home."""


@dataclass(frozen=True, slots=True)
class SurveyAtStart:
    """The survey that this run works on. ``words`` say that another one was set aside; else they are empty.

    ``is_young``: it was written within `CONTINUE_S`; its cars are still there.
    """

    kept: JournalState
    words: str = ""
    is_young: bool = True


def survey_at_start(
    journal: FlightJournal,
    *,
    flies: bool,
    is_new_world: bool,
    continues: bool = False,
    moment: Callable[[], Moment] = this_moment,
) -> SurveyAtStart:
    """Return the journalled survey where it goes on, else another one that is empty.

    It goes on while it is young.

    Args:
        journal: The journal, as it was read.
        flies: A flight may be under way (`Starts.flew_lately`): its survey goes on whatever its age.
        is_new_world: The drone starts over another simulated world, and nothing goes on.
        continues: An operator says that it goes on.
        moment: This computer's clocks.
    """
    kept = journal.state
    is_begun = kept.datum is not None or kept.outline is not None
    age = _age(kept.last_written, moment())
    if is_begun and not is_new_world and (flies or continues or age < CONTINUE_S):
        return SurveyAtStart(kept, is_young=age < CONTINUE_S)
    if kept.datum is None and not (is_new_world and kept.map_parts):  # nothing of a lot was mapped without one
        return SurveyAtStart(replace(kept, arm_place=None))
    words = "" if is_new_world else _set_aside(kept, age, moment())
    empty = JournalState(
        survey_id=journal.new_survey(), starts_in_air=kept.starts_in_air, drains=kept.drains, fall=kept.fall
    )
    return SurveyAtStart(empty, words)


def _age(written: Moment | None, now: Moment) -> float:
    """Return the age of the journal's newest write, seconds; infinite for an empty journal.

    Across a boot of this computer nobody but the wall clock knows it; the time since the boot is the least that it can
    be, so a wall clock that was set back makes nothing young.
    """
    if written is None:
        return math.inf
    passed = now.since(written)
    return max(now.seconds, now.utc - written.utc) if passed is None else passed


def _set_aside(kept: JournalState, age: float, now: Moment) -> str:
    words = f"A new survey begins: the last one, {kept.survey_id}, was written {_duration(age)} ago"
    if kept.last_written is not None and now.since(kept.last_written) is None:
        words += " by the wall clock, and the computer was started since"
    return f"{words}. It is kept in the folder journal of the store"


def _duration(seconds: float) -> str:
    for unit, length in (("days", 86400.0), ("hours", 3600.0)):
        if seconds >= 2 * length:
            return f"{seconds / length:.0f} {unit}"
    return f"{seconds / 60.0:.0f} minutes"


class Starts:
    """This start among those before it.

    It counts from its beginning when disk or memory knows of a flight under way, else once the drone is found in the
    air. A start on the ground and one that ended in order are taken back.
    """

    def __init__(
        self,
        journal: FlightJournal,
        notes: RunNotes,
        speed: float,
        moment: Callable[[], Moment] = this_moment,
        *,
        is_new_world: bool = False,
    ) -> None:
        """Read what the runs before left.

        Args:
            journal: Notes on the disk.
            notes: Notes in memory.
            speed: Seconds of the clock per real second.
            moment: This computer's clocks.
            is_new_world: The drone is another simulated one: what the runs before left is not of it.
        """
        self._journal = journal
        self._notes = notes
        self._moment = moment
        self._speed = speed
        self._found_in_air = False
        self._journal_works = False
        self._begun: Moment | None = None
        self._was_read = journal.state.is_read
        if is_new_world:
            notes.put(Notes())
        on_disk = JournalState() if is_new_world else journal.state
        self._before = _union(on_disk.starts_in_air, notes.notes.starts_in_air)
        self.flight = _newest(on_disk.flight, notes.notes.flight)
        """The flight in which this program may have started, None when there was none."""
        self._flown_id = notes.notes.vehicle_id
        journal.try_disk()
        if self.flew_lately:
            self._count()  # now: a crash before the link is found counts too

    @property
    def flew_lately(self) -> bool:
        """True when an earlier run was in the air a moment ago."""
        return flight_goes_on(self.flight, self._moment(), self._speed) is not None

    @property
    def rule(self) -> RestartRule:
        """The action at this start if the drone is in the air, as far as the starts before it are known."""
        return restart_rule(starts_before(self._before, self.flight, self._moment()) + 1)

    async def settle(self, timeout_s: float) -> None:
        """Wait until this start is on the disk, and note whether the disk can be written at all."""
        self._journal_works = await self._journal.flush(timeout_s) and self._was_read

    def found_in_air(self) -> int:
        """Count this start; return the number of those within the restart window, this one included.

        It is the second one at least when a start before it may be missing: neither disk nor memory keeps them.
        """
        self._found_in_air = True
        begun = self._count()
        number = starts_before(self._before, self.flight, begun) + 1
        return number if self._is_sure(begun) else max(number, SECOND_START)

    @property
    def flown_id(self) -> int | None:
        """MAVLink system id of the vehicle whose flight goes on; None where that is not known."""
        return self._flown_id if self.flew_lately else None

    def keep_flight(self, flight: FlightSoFar | None, vehicle_id: int | None = None) -> None:
        """Keep duration and distance of this flight so far, and whose it is; None: it has ended."""
        self._journal.set_flight(flight)
        self._notes.put(replace(self._notes.notes, flight=flight, vehicle_id=None if flight is None else vehicle_id))

    def found_disarmed(self) -> None:
        """Take this start back, unless it began in the air."""
        if not self._found_in_air:
            self._withdraw()

    def ended_in_order(self) -> None:
        """Take this start back: it did not crash."""
        self._withdraw()

    def _count(self) -> Moment:
        """Note this start, once, and forget those that count no more; return its moment."""
        if self._begun is None:
            self._begun = begun = self._moment()
            self._journal.add_start_in_air(begun)
            recent = tuple(start for start in self._before if starts_before((start,), self.flight, begun))
            self._notes.put(replace(self._notes.notes, starts_in_air=(*recent, begun)))
        return self._begun

    def _withdraw(self) -> None:
        if self._begun is None:
            return
        begun, self._begun = self._begun, None
        self._journal.withdraw_start(begun)
        left = tuple(start for start in self._notes.notes.starts_in_air if start != begun)
        self._notes.put(replace(self._notes.notes, starts_in_air=left))

    def _is_sure(self, now: Moment) -> bool:
        """Return True when no start of the last minute can be missing: the disk works, or the memory is older."""
        if not now.boot_id:
            return False
        return self._journal_works or (self._notes.works and now.seconds >= RESTART_WINDOW_S)


def _union(first: tuple[Moment, ...], second: tuple[Moment, ...]) -> tuple[Moment, ...]:
    """Return the starts that either knows. The journal's keys round to a millisecond."""
    found = {(start.boot_id, round(start.seconds, 3)): start for start in (*first, *second)}
    return tuple(found[key] for key in sorted(found))


def _newest(first: FlightSoFar | None, second: FlightSoFar | None) -> FlightSoFar | None:
    """Return the newer of two words on the flight; ``second``, of this boot's memory, where no clock decides."""
    if first is None or second is None:
        return first or second
    apart = first.moment.since(second.moment)
    return first if apart is not None and apart > 0 else second


async def wait_away(settings: AutopilotSettings, flown_id: int | None, stopping: asyncio.Event) -> None:
    """Leave the drone to the autopilot's failsafe: wait until it is heard to be disarmed, or for a stop signal."""
    _LOG.error("started a third time within a minute in the air: the autopilot's failsafe has the drone")
    listening = asyncio.create_task(
        wait_until_disarmed(settings.url, RESTART_WINDOW_S, expected_autopilot(settings, flown_id, in_flight=True)),
        name="passive-listener",
    )
    stopped = asyncio.create_task(stopping.wait(), name="stop-while-listening")
    await asyncio.wait({listening, stopped}, return_when=asyncio.FIRST_COMPLETED)
    await end_tasks(listening, stopped)
