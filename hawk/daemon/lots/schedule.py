"""Says on the page that a survey is due, by the settings' ``[[schedule]]``. It says so, and commands nothing."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, time, timedelta
from typing import TYPE_CHECKING, Final

from hawk.config.sections import DAYS, ScheduledSurvey
from hawk.lots.store import LotStore
from hawk.lots.values import LotStoreError
from hawk.model.operation import Level
from hawk.model.sentences import say
from hawk.runtime.late import late

if TYPE_CHECKING:  # loaded on the store's thread
    from hawk.lots import known_lot as queries
    from hawk.lots import names
    from hawk.lots.documents.lot_document import LotDue
else:
    queries, names = late("hawk.lots.known_lot"), late("hawk.lots.names")

_LOG = logging.getLogger(__name__)
LOOK_S: Final = 30.0
"""Real seconds between two looks at the clock."""
EARLY: Final = timedelta(minutes=30)
"""A survey that ended so long before its time counts as the one that was due."""
LATE: Final = timedelta(hours=6)
"""A survey that was missed for so long is due no more: the next one is."""


@dataclass(frozen=True, slots=True)
class Flown:
    """A lot of the schedule as the store has it. ``last``: end of its newest survey, Unix seconds; None: none.

    Pictures whose time is not sure count as none.
    """

    id: str
    name: str
    last: float | None


def moment_due(entry: ScheduledSurvey, now: datetime) -> datetime | None:
    """Return the latest moment of an entry that has come and is not over; ``now`` is of the entry's clock.

    A moment before the newest change of the settings is none: nobody knows whether a survey was due then.
    """
    for days in (0, 1):
        moment = _moment_on(entry, now - timedelta(days=days))
        if moment is not None and moment <= now < moment + LATE and entry.since <= moment.timestamp():
            return moment
    return None


def _moment_on(entry: ScheduledSurvey, at: datetime) -> datetime | None:
    """Return the moment of an entry on the day of ``at``, by the clock of that; None on a day that it does not name."""
    if DAYS[at.weekday()] not in entry.days:
        return None
    hour, minute = (int(part) for part in entry.at.split(":"))
    return datetime.combine(at.date(), time(hour, minute), at.tzinfo)


def moments_due(
    entries: Sequence[ScheduledSurvey], lot: str, name: str, last: float | None, now: float, days: int
) -> list[datetime]:  # fmt: skip
    """Return when surveys of a lot are due from now on, with those that have come, are not over, and are not flown.

    Which surveys were due earlier is not known: the settings do not say since when they are so (`moment_due`).
    """
    found = set()
    for entry in entries:
        if entry.lot not in (lot, name):
            continue
        begin = datetime.fromtimestamp(now, entry.clock())
        come = moment_due(entry, begin)
        if come is not None and not is_flown(last, come):
            found.add(come)
        for number in range(days + 1):
            moment = _moment_on(entry, begin + timedelta(days=number))
            if moment is not None and begin < moment <= begin + timedelta(days=days):
                found.add(moment)
    return sorted(found)


def is_flown(last: float | None, moment: datetime) -> bool:
    """Return True when a survey that ended at ``last``, Unix seconds, is the one that was due at a moment."""
    return last is not None and last >= (moment - EARLY).timestamp()


def unknown_lot(given: str, there: Sequence[str]) -> str:
    """Return that no lot has a name or id of the schedule, with the names that there are."""
    if not there:
        return say("schedule: no lot has the name or id {lot}, and there is none: survey it first.", lot=given)
    return say("schedule: no lot has the name or id {lot}: write one of {names}.", lot=given, names=", ".join(there))


class Timetable:
    """Moments at which surveys are due, by the settings and by the schedule of the desk that the store is sent to.

    `take` belongs to the loop; the others may be called on any thread.
    """

    def __init__(self, entries: Sequence[ScheduledSurvey], *, has_desk: bool = False) -> None:
        """``has_desk``: the store is sent to a desk."""
        self.entries = tuple(entries)
        self.is_empty = not entries and not has_desk
        self._at_desk: Mapping[str, LotDue] = {}

    def take(self, due: Sequence[LotDue]) -> None:
        """Take what is due at the desk, in place of what was."""
        self._at_desk = {each.lot: each for each in due}

    def lots(self) -> list[str]:
        """Return the lots that surveys are due of at some time: names or ids of the settings, ids of the desk."""
        return sorted({*(entry.lot for entry in self.entries), *self._at_desk})

    def moments(self, lot: str, name: str, last: float | None, now: float, days: int) -> list[datetime]:
        """Return when surveys of a lot are due, as `moments_due` does; one that the desk has is flown."""
        there = self._at_desk.get(lot)
        if there is None:
            return moments_due(self.entries, lot, name, last, now, days)
        last = _later(last, there.last)
        own = moments_due(self.entries, lot, name, last, now, days)
        until = now + days * 86_400.0
        moments = (moment for moment in map(_here, there.moments) if now < (moment + LATE).timestamp())
        given = (moment for moment in moments if moment.timestamp() <= until and not is_flown(last, moment))
        return sorted({*own, *given})

    def is_due(self, lot: str, name: str, last: float | None, now: float) -> bool:
        """Return True when a survey of a lot is due now; arguments as those of `moments`."""
        return not self.is_empty and bool(self.moments(lot, name, last, now, 0))

    def come(self, now: float) -> list[tuple[str, datetime]]:
        """Return the lots, by `lots`, with the moments that have come and are not over, whether flown or not."""
        own = ((entry.lot, moment_due(entry, datetime.fromtimestamp(now, entry.clock()))) for entry in self.entries)
        found = [(lot, moment) for lot, moment in own if moment is not None]
        for each in self._at_desk.values():
            moments = map(_here, each.moments)
            found += [(each.lot, one) for one in moments if one.timestamp() <= now < (one + LATE).timestamp()]
        return found

    def last(self, lot: str, here: float | None) -> float | None:
        """Return the end of the newest survey of a lot by its id, here or at the desk."""
        there = self._at_desk.get(lot)
        return here if there is None else _later(here, there.last)


def _later(one: float | None, other: float | None) -> float | None:
    return max((each for each in (one, other) if each is not None), default=None)


def _here(seconds: float) -> datetime:
    """Return a moment by this computer's clock."""
    return datetime.fromtimestamp(seconds).astimezone()


class Schedule:
    """`run` belongs to the loop."""

    def __init__(
        self,
        store: LotStore,
        timetable: Timetable,
        wall: Callable[[], float],
        is_armed: Callable[[], bool],
        add_message: Callable[[Level, str, str], object],
    ) -> None:
        """Take the parts; nothing runs before `run`.

        Args:
            store: The store of lots.
            timetable: What is due when.
            wall: UTC, Unix seconds.
            is_armed: Returns True while the motors are on: nothing is asked then.
            add_message: Adds a message for the operator: level, text, details.
        """
        self._store = store
        self._timetable = timetable
        self._wall = wall
        self._is_armed = is_armed
        self._add_message = add_message
        self._said: set[tuple[str, float]] = set()
        self._is_checked = False

    async def run(self) -> None:
        """Look at the clock until cancelled; where nothing can be due wait for that."""
        if self._timetable.is_empty:
            await asyncio.Event().wait()
        while True:
            if not self._is_armed():
                try:
                    await self.look()
                except LotStoreError as error:
                    _LOG.warning("the schedule cannot read the lots: %s", error)
            await asyncio.sleep(LOOK_S)

    async def look(self) -> None:
        """Say what has become due since the last look, and once which lots are not known. Raises LotStoreError."""
        await self._look_for_unknown()
        for named, moment in self._timetable.come(self._wall()):
            if (named, moment.timestamp()) in self._said:
                continue
            lot = await self._flown(named)
            self._said.add((named, moment.timestamp()))
            if lot is not None and not is_flown(self._timetable.last(lot.id, lot.last), moment):
                when = f"{moment:%H:%M}"
                self._add_message(
                    "warning",
                    say("A survey of {name} is due since {when}.", name=lot.name, when=when),
                    say("Arm, and confirm the flight: nothing flies by itself."),
                )

    async def _look_for_unknown(self) -> None:
        """Say which lots of the schedule are not known, once each: also before their surveys are due."""
        if self._is_checked or not self._timetable.entries:
            return
        await self._store.open()
        given = sorted({entry.lot for entry in self._timetable.entries})
        unknown, there = await self._store.read(lambda connection: names.unknown_lots(connection, given))
        self._is_checked = True
        for each in unknown:
            text = say("The schedule names a lot that is not known: {lot}.", lot=each)
            self._add_message("warning", text, unknown_lot(each, there))

    async def _flown(self, lot: str) -> Flown | None:
        await self._store.open()
        found = await self._store.read(lambda connection: queries.newest_survey(connection, lot))
        return None if found is None else Flown(*found)
