"""Says on the page that a survey is due, by the settings' ``[[schedule]]``. It says so, and commands nothing."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Sequence
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


def due_lots(
    entries: Sequence[ScheduledSurvey], wall: Callable[[], float], lot: str, name: str, last: float | None
) -> bool:
    """Return True when a survey of a lot is due now, by its id or name; ``last`` as for `moments_due`."""
    return bool(entries) and bool(moments_due(entries, lot, name, last, wall(), 0))


def is_flown(last: float | None, moment: datetime) -> bool:
    """Return True when a survey that ended at ``last``, Unix seconds, is the one that was due at a moment."""
    return last is not None and last >= (moment - EARLY).timestamp()


def unknown_lot(given: str, there: Sequence[str]) -> str:
    """Return that no lot has a name or id of the schedule, with the names that there are."""
    if not there:
        return say("schedule: no lot has the name or id {lot}, and there is none: survey it first.", lot=given)
    return say("schedule: no lot has the name or id {lot}: write one of {names}.", lot=given, names=", ".join(there))


class Schedule:
    """`run` belongs to the loop."""

    def __init__(
        self,
        store: LotStore,
        entries: Sequence[ScheduledSurvey],
        wall: Callable[[], float],
        is_armed: Callable[[], bool],
        add_message: Callable[[Level, str, str], object],
    ) -> None:
        """Take the parts; nothing runs before `run`.

        Args:
            store: The store of lots.
            entries: What is due when.
            wall: UTC, Unix seconds.
            is_armed: Returns True while the motors are on: nothing is asked then.
            add_message: Adds a message for the operator: level, text, details.
        """
        self._store = store
        self._entries = entries
        self._wall = wall
        self._is_armed = is_armed
        self._add_message = add_message
        self._said: set[tuple[int, float]] = set()
        self._is_checked = False

    async def run(self) -> None:
        """Look at the clock until cancelled; without entries wait for that."""
        if not self._entries:
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
        for number, entry in enumerate(self._entries):
            moment = moment_due(entry, datetime.fromtimestamp(self._wall(), entry.clock()))
            if moment is None or (number, moment.timestamp()) in self._said:
                continue
            lot = await self._flown(entry.lot)
            self._said.add((number, moment.timestamp()))
            if lot is not None and not is_flown(lot.last, moment):
                when = f"{moment:%H:%M}"
                self._add_message(
                    "warning",
                    say("A survey of {name} is due since {when}.", name=lot.name, when=when),
                    say("Arm, and confirm the flight: nothing flies by itself."),
                )

    async def _look_for_unknown(self) -> None:
        """Say which lots of the schedule are not known, once each: also before their surveys are due."""
        if self._is_checked:
            return
        await self._store.open()
        given = sorted({entry.lot for entry in self._entries})
        unknown, there = await self._store.read(lambda connection: names.unknown_lots(connection, given))
        self._is_checked = True
        for each in unknown:
            text = say("The schedule names a lot that is not known: {lot}.", lot=each)
            self._add_message("warning", text, unknown_lot(each, there))

    async def _flown(self, lot: str) -> Flown | None:
        await self._store.open()
        found = await self._store.read(lambda connection: queries.newest_survey(connection, lot))
        return None if found is None else Flown(*found)
