"""The first page of a report over several lots: a line a lot, and the total.

A line counts the newest survey of the period that figures use, and the newest one that saw a section.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, date, datetime
from typing import Final

from sqlalchemy import Connection

from hawk.lots import lists
from hawk.lots.answers import SectionLook
from hawk.lots.queries import NextDue
from hawk.lots.time_zone import clock_of
from hawk.lots.values import LotInputError
from hawk.report.options import MOST_LOTS
from hawk.report.values import Report
from hawk.stats.use_query import Asked
from hawk.stats.values import NOTHING, Estimate, Total, total_of

_PARTS: Final = (("row", "rows"), ("zone", "zones"), ("kind", "kinds"), ("section", "sections"))


@dataclass(frozen=True, slots=True)
class LotLine:
    """A lot of the table. Times are on the lot's clock.

    ``stalls``: of the layout of its newest survey, else of its plan; ``free`` of them. ``vehicles`` in its sections,
    which have ``places``, None without any, or where nobody said how many. ``unseen``: sections that this survey did
    not see.
    ``at``: the newest survey, None without one that counts; ``drone`` that sent it, "" for one that was stored here.
    ``first`` to ``last``: days of its report.
    """

    lot: str
    name: str
    clock: str
    first: date | None
    last: date | None
    stalls: int
    free: Estimate
    unseen: int
    vehicles: Estimate
    places: int | None
    at: datetime | None
    drone: str
    due: datetime | None


@dataclass(frozen=True, slots=True)
class LotsReport:
    """The first page. ``made`` is on the clock ``clock`` of all lots, in UTC where they have several: "" then.

    ``asked``: days and hours of all lots.
    """

    made: datetime
    clock: str
    asked: Asked
    lines: tuple[LotLine, ...] = field(repr=False)

    @property
    def first(self) -> date | None:
        """First day of all reports; None without any."""
        return min((each.first for each in self.lines if each.first is not None), default=None)

    @property
    def last(self) -> date | None:
        """Last day of all reports; None without any."""
        return max((each.last for each in self.lines if each.last is not None), default=None)

    @property
    def stalls(self) -> int:
        """Stalls of the lots that are in the total."""
        return sum(each.stalls for each in self.lines if each.free.value is not None)

    @property
    def free(self) -> Total:
        """Free stalls of all lots."""
        return total_of([each.free for each in self.lines])

    @property
    def vehicles(self) -> Total:
        """Vehicles in the sections of all lots."""
        return total_of([each.vehicles for each in self.lines])

    @property
    def places(self) -> int | None:
        """Places of all sections; None without any, and where nobody said those of a lot."""
        return _sum([each.places for each in self.lines if each.vehicles.value is not None])

    @property
    def uncounted(self) -> int:
        """Lots without a survey that counts."""
        return sum(each.at is None for each in self.lines)

    @property
    def moments(self) -> tuple[datetime, datetime] | None:
        """The oldest and the newest survey that the total is of; None of less than two lots."""
        found = sorted(each.at for each in self.lines if each.at is not None)
        return (found[0], found[-1]) if len(found) > 1 else None


def check_lots(lots: Sequence[str], asked: Asked) -> None:
    """Refuse a report over too many lots, or over none, and a question about a part of one. Raises LotInputError."""
    if not lots:
        raise LotInputError("lot", "the store has none: survey one first")
    if len(lots) > MOST_LOTS:
        remedy = "ask for fewer, in several reports"
        raise LotInputError("lot", f"a report is over {MOST_LOTS} lots at most, and these are {len(lots)}: {remedy}")
    for name, parts in _PARTS:
        if getattr(asked, parts):
            raise LotInputError(name, "is a part of one lot: leave it out, or ask for the report of that lot alone")


def line_of(connection: Connection, report: Report, due: NextDue) -> LotLine:
    """Return the line of a lot, by its own report. Raises NotFoundError, LotStoreError."""
    listed, newest, sections = lists.lot(connection, report.lot, due), report.newest, report.sections
    counts = [] if sections is None else [each.look for each in sections.sections if each.look is not None]
    survey = newest.use.id if newest is not None else counts[0].survey if counts else None
    at = newest.at if newest is not None else sections.at if sections is not None else None
    drone = None if survey is None else lists.survey(connection, survey).drone
    stalls = listed.stalls if newest is None else newest.stalls
    return LotLine(
        lot=report.lot, name=report.name, clock=report.clock, first=report.first, last=report.last, stalls=stalls,
        free=NOTHING if newest is None else _free(newest.use.occupancy, stalls),
        unseen=0 if sections is None else len(sections.sections) - len(counts),
        vehicles=_vehicles(counts), places=_places(counts), at=at, drone=drone or "",
        due=None if listed.due is None else listed.due.astimezone(report.made.tzinfo),
    )  # fmt: skip


def lots_report(lines: Sequence[LotLine], asked: Asked, now: float) -> LotsReport:
    """Return the first page of some lines; ``now``: Unix seconds."""
    clocks = {each.clock for each in lines}
    clock = clocks.pop() if len(clocks) == 1 else ""
    return LotsReport(datetime.fromtimestamp(now, clock_of(clock) if clock else UTC), clock, asked, tuple(lines))


def _free(taken: Estimate, stalls: int) -> Estimate:
    """Return how many of some stalls are free, by the share that is taken: unseen ones are as full as the others.

    Whole stalls, as they are shown: readers add them up.
    """
    ends = (taken.value, taken.low, taken.high)
    value, high, low = (None if each is None else float(round(stalls * (1 - each))) for each in ends)
    return Estimate(value, low, high, taken.surveys)


def _vehicles(looks: Sequence[SectionLook]) -> Estimate:
    """Return the vehicles of some sections: their ends are added, as `hawk.stats.section_use` counts several."""
    if not looks:
        return NOTHING
    least, most = sum(each.least for each in looks), sum(each.most for each in looks)
    return Estimate(float(sum(each.parked for each in looks)), float(least), float(most), 1)


def _places(looks: Sequence[SectionLook]) -> int | None:
    """Return the places of some sections; None without any, and where nobody said those of one."""
    return _sum([each.capacity for each in looks])


def _sum(places: Sequence[int | None]) -> int | None:
    return None if None in places or not places else sum(each or 0 for each in places)
