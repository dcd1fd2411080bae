"""Says on the page that a survey is due, by the settings' ``[[schedule]]``. It says so, and commands nothing."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, time, timedelta, tzinfo
from typing import TYPE_CHECKING, Final

from hawk.config.sections import DAYS, ScheduledSurvey
from hawk.lots.store import LotStore
from hawk.lots.values import LotStoreError
from hawk.model.operation import Level
from hawk.model.sentences import say
from hawk.runtime.late import late

if TYPE_CHECKING:  # loaded on the store's thread
    from sqlalchemy import Connection

    from hawk.lots import known_lot as queries
    from hawk.lots import names, time_zone
    from hawk.lots.documents.lot_document import LotDue
    from hawk.lots.storage import database
else:
    queries, names = late("hawk.lots.known_lot"), late("hawk.lots.names")
    time_zone, database = late("hawk.lots.time_zone"), late("hawk.lots.storage.database")

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

    Pictures whose time is not sure count as none. ``clock``: that of the settings, else of the lot's time zone.
    """

    id: str
    name: str
    last: float | None
    clock: tzinfo


@dataclass(frozen=True, slots=True)
class Come:
    """A moment that has come. ``lot``: as of `Timetable.lots`; ``clock``: of the settings, None for the desk's."""

    lot: str
    moment: datetime
    clock: tzinfo | None


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


def unclear_lot(given: str, lots: Sequence[str], there: Sequence[str]) -> str:
    """Return that no lot has a name or id of the schedule, with the names that there are; or that ``lots`` share it."""
    if lots:
        return say("schedule: more than one lot is called {lot}: write the id of one: {ids}.", lot=given,
                   ids=", ".join(lots))  # fmt: skip
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
        last, there = self.last(lot, last), self._at_desk.get(lot)
        own = moments_due(self.entries, lot, name, last, now, days)
        if there is None:
            return own
        until = now + days * 86_400.0
        moments = (moment for moment in map(_here, there.moments) if now < (moment + LATE).timestamp())
        given = (moment for moment in moments if moment.timestamp() <= until and not is_flown(last, moment))
        return sorted({*own, *given})

    def is_due(self, lot: str, name: str, last: float | None, now: float) -> bool:
        """Return True when a survey of a lot is due now; arguments as those of `moments`."""
        return not self.is_empty and bool(self.moments(lot, name, last, now, 0))

    def come(self, now: float) -> list[Come]:
        """Return the moments that have come and are not over, whether flown or not: those of the settings first."""
        own = ((entry.lot, moment_due(entry, datetime.fromtimestamp(now, entry.clock()))) for entry in self.entries)
        found = [Come(lot, moment, moment.tzinfo) for lot, moment in own if moment is not None]
        for each in self._at_desk.values():
            moments = (datetime.fromtimestamp(seconds, UTC) for seconds in each.moments)
            found += [Come(each.lot, one, None) for one in moments if one.timestamp() <= now < (one + LATE).timestamp()]
        return found

    def last(self, lot: str, here: float | None) -> float | None:
        """Return the end of the newest survey of a lot by its id, here or at the desk."""
        there = self._at_desk.get(lot)
        ends = here, None if there is None else there.last
        return max((each for each in ends if each is not None), default=None)


def _here(seconds: float) -> datetime:
    """Return a moment by this computer's clock."""
    return datetime.fromtimestamp(seconds).astimezone()


async def _keep_looking(look: Callable[[], Awaitable[None]], may_look: Callable[[], bool] = lambda: True) -> None:
    """Look again and again until cancelled, while that may be; a store that cannot be read is logged."""
    while True:
        if may_look():
            try:
                await look()
            except LotStoreError as error:
                _LOG.warning("the schedule cannot read the lots: %s", error)
        await asyncio.sleep(LOOK_S)


class ScheduledNames:
    """Says which lots of the settings' schedule no lot is, and which more than one is: when that is so from the first,
    and when a person's change makes it so. `run` and `look` belong to the loop.
    """

    def __init__(
        self, store: LotStore, entries: Sequence[ScheduledSurvey], add_message: Callable[[Level, str, str], object]
    ) -> None:
        """Take the parts, those of `Schedule`; nothing is read yet."""
        self._store = store
        self._given = sorted({entry.lot for entry in entries})
        self._add_message = add_message
        self._version = ""
        self._unclear: frozenset[tuple[str, bool]] = frozenset()

    async def run(self) -> None:
        """Look again and again until cancelled."""
        if self._given:
            await _keep_looking(self.look)

    async def look(self) -> None:
        """Say which are not clear since the last look, before their surveys are due, too. Raises LotStoreError."""
        if not self._given:
            return
        await self._store.open()
        found = await self._store.read(self._read)
        if found is None:
            return
        self._version, unclear, there = found
        said, self._unclear = self._unclear, frozenset((each, bool(lots)) for each, lots in unclear.items())
        for each, lots in unclear.items():
            if (each, bool(lots)) not in said:
                text = say("The schedule names a lot that is not known: {lot}.", lot=each)
                if lots:
                    text = say("The schedule names {lot}, and more than one lot is called so.", lot=each)
                self._add_message("warning", text, unclear_lot(each, lots, there))

    def _read(self, connection: Connection) -> tuple[str, dict[str, list[str]], list[str]] | None:
        """Return the store's version, the unclear names, and those that there are; None: as at the last look."""
        version = database.version_of(connection)
        return None if version == self._version else (version, *names.unclear_lots(connection, self._given))


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
        self._names = ScheduledNames(store, timetable.entries, add_message)
        self._said: set[tuple[str, float]] = set()

    async def run(self) -> None:
        """Look at the clock until cancelled; where nothing can be due wait for that."""
        if self._timetable.is_empty:
            await asyncio.Event().wait()
        await _keep_looking(self.look, lambda: not self._is_armed())

    async def look(self) -> None:
        """Say what has become due since the last look, and which lots are not known now. Raises LotStoreError."""
        await self._names.look()
        for each in self._timetable.come(self._wall()):
            seconds = each.moment.timestamp()
            if (each.lot, seconds) in self._said:
                continue
            lot = await self._flown(each)
            is_new = lot is not None and (lot.id, seconds) not in self._said
            self._said |= {(each.lot, seconds), *([(lot.id, seconds)] if lot is not None else [])}
            if lot is not None and is_new and not is_flown(self._timetable.last(lot.id, lot.last), each.moment):
                when = f"{each.moment.astimezone(lot.clock):%H:%M}"
                self._add_message(
                    "warning",
                    say("A survey of {name} is due since {when}.", name=lot.name, when=when),
                    say("Arm, and confirm the flight: nothing flies by itself."),
                )

    async def _flown(self, come: Come) -> Flown | None:
        await self._store.open()
        return await self._store.read(lambda connection: _flown(connection, come))


def _flown(connection: Connection, come: Come) -> Flown | None:
    found = queries.newest_survey(connection, come.lot)
    if found is None:
        return None
    return Flown(*found, come.clock or time_zone.clock_of(time_zone.zone_of_lot(connection, found[0])))
