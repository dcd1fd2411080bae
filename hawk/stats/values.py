"""Values of the statistics: what surveys saw of a lot's stalls, groups of stalls, figures with intervals, and totals.

No vehicle is in them: a stall is free, taken or unknown at the moment of a survey.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, tzinfo
from typing import Annotated, Any, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, PlainSerializer

from hawk.lots.answers import Count, Utc
from hawk.lots.plan.kinds import KINDS
from hawk.lots.plan.values import Id
from hawk.stats.partition import Partition

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]
States = NDArray[np.int8]
Figure = Annotated[float, PlainSerializer(lambda value: round(value, DIGITS), return_type=float)]
"""A number of an answer, which shows `DIGITS` decimals."""
DIGITS: Final = 4

LEVEL: Final = 0.9
"""Share of figures whose interval is to hold the true value."""
DEVIATIONS: Final = 1.6449
"""Standard deviations on either side that hold `LEVEL` of a normal distribution."""
FREE: Final = 0
TAKEN: Final = 1
UNSEEN: Final = -1
"""States of a look; the last one is also that of a stall that was looked at without certainty."""
Shape = tuple[float, float, float, float, float]
Unit = Literal["stalls", "places", "vehicles"]
"""Unit of a figure: taken stalls of all stalls; vehicles of the places of sections; vehicles of sections whose
places nobody said."""
Weekday = Literal["Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday"]
WEEKDAYS: Final[tuple[Weekday, ...]] = get_args(Weekday)
Local = Annotated[str, Field(description="moment on the lot's clock, with its offset")]
WHOLE: Final = "lot"
NO_ROW: Final = "other"
"""Row of stalls whose label names none."""
NO_ZONE: Final = "no zone"
NO_TIME: Final = "its time is not sure: neither GNSS nor a time server had set the clock"
NOT_YET: Final = "its time is later than now: map its pictures again, with --taken"


@dataclass(frozen=True, slots=True)
class PanelColumn:
    """A stall: ``row`` is the letter of its label, ``kind`` OSM's value, ``zones`` the names of those it lies in.

    ``shape``: north, east, angle, width, length in the lot's frame.
    """

    id: str
    label: str
    row: str
    kind: str
    zones: tuple[str, ...] = ()
    shape: Shape = (0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class PanelRow:
    """A survey whose stalls are known. ``at``: mean moment of its looks, UTC, Unix seconds."""

    id: str
    at: float


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A survey of the period that no figure uses, and why."""

    survey: Id
    ended: Utc
    why: str


@dataclass(frozen=True, slots=True)
class Panel:
    """Looks of S surveys, by their time, at N stalls of a lot.

    ``taken_probability`` (S, N): NaN where unseen; ``state`` (S, N): `FREE`, `TAKEN`, `UNSEEN`; ``is_there``
    (S, N): the layout of that survey has the stall. ``clock``: the lot's time, called ``clock_name``. ``local_times``
    (S,): moments of the surveys on that clock.
    """

    lot: str
    name: str
    clock: tzinfo
    clock_name: str
    stalls: tuple[PanelColumn, ...] = field(repr=False)
    surveys: tuple[PanelRow, ...] = field(repr=False)
    left_out: tuple[LeftOut, ...]
    taken_probability: Floats32 = field(repr=False)
    state: States = field(repr=False)
    is_there: Bools = field(repr=False)
    local_times: tuple[datetime, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Read the clock once a survey: every question about a panel asks for it."""
        object.__setattr__(self, "local_times", tuple(self.local(each.at) for each in self.surveys))

    @property
    def at(self) -> Floats:
        """Moments of the surveys, (S,), Unix seconds."""
        return np.array([survey.at for survey in self.surveys], np.float64)

    def local(self, at: float) -> datetime:
        """Return a moment on the lot's clock."""
        return datetime.fromtimestamp(at, self.clock)


@dataclass(frozen=True, slots=True)
class Group:
    """Stalls that are counted together: ``members`` (N,) of a panel."""

    name: str
    members: Bools = field(repr=False)


def whole(panel: Panel) -> list[Group]:
    """Return all stalls of the lot as one group."""
    return [Group(panel.name or WHOLE, np.ones(len(panel.stalls), np.bool_))]


def groups_of(panel: Panel, by: Partition | None) -> list[Group]:
    """Return the groups of a lot by a `Partition` of its stalls, else none. A stall in two zones is in two groups."""
    if by not in _NAMES:
        return []
    names = [_NAMES[by](stall) for stall in panel.stalls]
    found = sorted({name for each in names for name in each}, key=lambda name: (len(name), name))
    return [Group(name, np.array([name in each for each in names], np.bool_)) for name in found]


_NAMES: Final[Mapping[Partition | None, Callable[[PanelColumn], tuple[str, ...]]]] = {
    "row": lambda stall: (stall.row or NO_ROW,),
    "zone": lambda stall: stall.zones or (NO_ZONE,),
    "kind": lambda stall: (stall.kind or KINDS[""],),
}


_UNITS: Final = np.float32(2**24)
"""Parts of 1 by which fractions are added: those of a number of 32 bits from a half on."""
_AT_ONCE: Final = 256
"""Surveys whose numbers are made at once: in memory that is at hand."""


def summed(values: NDArray[Any], groups: Sequence[Group]) -> Floats:
    """Return the sums of values (S, N) over the members of each group, (S, G).

    Stalls are counted by a product of matrices, which is exact in 32 bits. So is that of fractions in 64 bits, as
    numbers of `_UNITS`: it does not depend on the library of matrices and its threads.
    """
    total = np.zeros((len(values), len(groups)))
    if not values.size or not groups:
        return total
    members = np.stack([group.members for group in groups], 1)
    if values.dtype == np.bool_:
        return np.asarray(values.astype(np.float32) @ members.astype(np.float32), np.float64)
    for begin in range(0, len(values), _AT_ONCE):
        some = slice(begin, begin + _AT_ONCE)
        total[some] = np.rint(values[some] * _UNITS).astype(np.float64) @ members.astype(np.float64)
    return total / _UNITS


def capacity_of(is_there: Bools, groups: Sequence[Group]) -> Floats:
    """Return how many stalls of each group are there, (S, G); ``is_there`` (S, N)."""
    if is_there.all():
        return np.tile([float(group.members.sum()) for group in groups], (len(is_there), 1))
    return summed(is_there, groups)


@dataclass(frozen=True, slots=True)
class Estimate:
    """A figure with the ends of its interval and the number of surveys behind it; null where nobody flew."""

    value: Figure | None
    low: Figure | None
    high: Figure | None
    surveys: Count

    def times(self, factor: float) -> Estimate:
        """Return the figure in another unit."""
        value, low, high = (None if each is None else each * factor for each in (self.value, self.low, self.high))
        return Estimate(value, low, high, self.surveys)


NOTHING: Final = Estimate(None, None, None, 0)
"""Figure of an hour that nobody flew."""


@dataclass(frozen=True, slots=True)
class Total:
    """Sum of figures of several lots, null without any: ``alike`` as if all erred alike, which adds the ends of all;
    ``apart`` as if each erred for itself, which adds the squares of their distances to the ends.

    How the errors of lots go together is not measured: one network looks at all, and a dark day turns several alike.
    The truth lies between the two, as for a city (`hawk.picture.lot_report`).
    """

    alike: Estimate
    apart: Estimate


def total_of(figures: Sequence[Estimate]) -> Total:
    """Return the total of figures; one without a value is left out."""
    known = [(each.value, each.low, each.high) for each in figures]
    ends = [(value, low, high) for value, low, high in known if None not in (value, low, high)]
    if not ends:
        return Total(NOTHING, NOTHING)
    values, lows, highs = ([float(each or 0.0) for each in column] for column in zip(*ends, strict=True))
    value, surveys = sum(values), sum(each.surveys for each in figures)
    below = math.hypot(*(value - low for value, low in zip(values, lows, strict=True)))
    above = math.hypot(*(high - value for value, high in zip(values, highs, strict=True)))
    return Total(
        Estimate(value, sum(lows), sum(highs), surveys), Estimate(value, value - below, value + above, surveys)
    )  # fmt: skip
