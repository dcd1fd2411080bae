"""Values of a report: everything that its document and its workbook say, so that both say the same."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import date, datetime, timedelta
from typing import Final, Literal

from hawk.lots.answers import ListedSection
from hawk.stats.answers import SurveyUse
from hawk.stats.hour_use import AskedUse, SurveyShare
from hawk.stats.values import WEEKDAYS, Estimate

Point = tuple[float, float]
"""Column and row of a picture, pixels."""
Why = Literal["deleted", "unregistered", "no_time", "no_looks", "unseen"]
NOT_THERE: Final = 2
"""State of a stall that the layout of a survey has not."""
Note = Literal["picture_broken", "nothing_to_draw", "by_link", "not_kept"]


@dataclass(frozen=True, slots=True)
class Part:
    """A row, zone or kind of stalls, at the hours that are asked. ``always``: number of stalls that every survey of the
    period found taken, None where it is not counted. ``is_asked``: named by the question.
    """

    name: str
    stalls: int
    occupancy: Estimate
    always: Estimate | None = None
    is_asked: bool = False


@dataclass(frozen=True, slots=True)
class DrawnStall:
    """A stall of a picture by its corners; ``number``: its label without the name of the row."""

    corners: tuple[Point, ...]
    number: str
    state: str


@dataclass(frozen=True, slots=True)
class DrawnRow:
    """A row of a picture: the middle of its first stall, and the direction out of the row there, of length 1 or 0."""

    name: str
    first: Point
    out: Point


@dataclass(frozen=True, slots=True)
class DrawnZone:
    """A zone of a picture by its ring."""

    name: str
    ring: tuple[Point, ...]


@dataclass(frozen=True, slots=True)
class LotPicture:
    """A lot from above, ``width`` and ``height`` pixels of ``metres`` each. North is up; to the right if ``is_turned``.

    ``jpeg``: the ground; empty without it. ``stall_width``: of most stalls, pixels.
    """

    width: int
    height: int
    metres: float
    is_turned: bool
    stall_width: float
    stalls: tuple[DrawnStall, ...] = field(repr=False)
    rows: tuple[DrawnRow, ...] = field(repr=False)
    zones: tuple[DrawnZone, ...] = field(repr=False)
    jpeg: bytes = field(default=b"", repr=False)


@dataclass(frozen=True, slots=True)
class Newest:
    """The newest survey with its counts; ``named``: how many of its ``stalls`` have a label that a person confirmed.

    ``note``: why there is no picture, or none of the ground; None for a whole one.
    """

    use: SurveyUse
    at: datetime
    stalls: int
    named: int
    picture: LotPicture | None
    note: Note | None = None


@dataclass(frozen=True, slots=True)
class Missing:
    """A survey of the period that no figure uses."""

    at: datetime
    why: Why


@dataclass(frozen=True, slots=True)
class LayoutChange:
    """A version of the layout that began in the period; ``why``: as the store has it."""

    at: datetime
    why: str
    stalls: int


@dataclass(frozen=True, slots=True)
class StallRecord:
    """A stall with the share of its surveys that found it taken; ``states``: `FREE`, `TAKEN`, `UNSEEN` by survey, and
    `NOT_THERE`.
    """

    id: str
    label: str
    row: str
    kind: str
    zones: tuple[str, ...]
    surveys: int
    share: float | None
    low: float | None
    high: float | None
    states: tuple[int, ...] = field(repr=False)


@dataclass(frozen=True, slots=True)
class SectionReport:
    """Sections that are asked, or all, with what the newest survey that saw one counted at ``at``; ``use``: of those
    that are asked over the period, None where none are.
    """

    at: datetime
    sections: tuple[ListedSection, ...] = field(repr=False)
    use: AskedUse | None = field(repr=False)


@dataclass(frozen=True, slots=True)
class Report:
    """A report. Times are on the clock ``clock``; ``first`` to ``last``: days of the period, None without a survey.

    ``asked``: the question with its answer; ``whole``: all that is asked as one part. ``surveys``: those of the period,
    the oldest first, that figures use; ``flown``: days with a survey, whatever became of it. ``states_at``: moments of
    the columns of the stalls' states. ``unreadable``: surveys and versions of the layout that are damaged on the disk,
    and left out of the lists. ``sections``: None where no survey of the period saw one.
    """

    lot: str
    name: str
    clock: str
    made: datetime
    first: date | None
    last: date | None
    unreadable: int
    asked: AskedUse = field(repr=False)
    newest: Newest | None = field(repr=False)
    whole: Part
    rows: tuple[Part, ...] = field(repr=False)
    zones: tuple[Part, ...] = field(repr=False)
    kinds: tuple[Part, ...] = field(repr=False)
    surveys: tuple[SurveyUse, ...] = field(repr=False)
    flown: frozenset[date] = field(repr=False)
    missing: tuple[Missing, ...] = field(repr=False)
    layouts: tuple[LayoutChange, ...] = field(repr=False)
    sections: SectionReport | None = field(repr=False)
    stalls: tuple[StallRecord, ...] = field(repr=False)
    states_at: tuple[datetime, ...] = field(repr=False)

    @property
    def is_whole(self) -> bool:
        """True when the question is about all stalls."""
        asked = self.asked.asked
        return not (asked.rows or asked.zones or asked.kinds)

    @property
    def is_always(self) -> bool:
        """True when the question is about all hours of the week."""
        return all(cell.is_asked for cell in self.asked.cells)

    @property
    def empty(self) -> frozenset[date]:
        """Days that are asked on which nobody flew."""
        if self.first is None or self.last is None:
            return frozenset()
        days = (self.first + timedelta(number) for number in range((self.last - self.first).days + 1))
        asked = {WEEKDAYS.index(day) for day in self.asked.asked.weekdays}
        return frozenset(day for day in days if day.weekday() in asked and day not in self.flown)

    @property
    def fullest(self) -> SurveyShare | None:
        """The survey that found most of what is asked taken; None without any."""
        return max(self.asked.surveys, key=_share, default=None)

    @property
    def emptiest(self) -> SurveyShare | None:
        """The survey that found least of what is asked taken; None without any."""
        return min(self.asked.surveys, key=_share, default=None)

    @property
    def rivals(self) -> int:
        """Other surveys that may have been as full as the fullest."""
        fullest = self.fullest
        low = 0.0 if fullest is None else fullest.occupancy.low or 0.0
        return sum(each is not fullest and (each.occupancy.high or 0.0) >= low for each in self.asked.surveys)


def _share(survey: SurveyShare) -> float:
    return survey.occupancy.value or 0.0
