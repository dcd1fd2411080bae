"""Figures of a lot's use as pydantic models, with the keys of `hawk.stats.serialize` (docs/statistics.md)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from hawk.web.v1.models import BLURRED, Count, Placed, Share, Shown, Sourced, Utc
from hawk.web.v1.parameters import Id

Local = Annotated[str, Field(description="moment on the lot's clock, with its offset")]
Weekday = Literal["Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday"]


class Estimate(Shown):
    """A figure with the ends of its interval and the number of surveys behind it; null where nobody flew."""

    value: float | None
    low: float | None
    high: float | None
    surveys: Count


class Bracket(Shown):
    """Ends between which a figure lies; null: no end is known."""

    low: float | None
    high: float | None


class Peak(Shown):
    """The surveyed hour of highest occupancy. `rivals`: other hours whose interval reaches its own."""

    begin: Local
    occupancy: Estimate
    accumulation: Estimate
    rivals: Count


class Steady(Estimate):
    """Number of stalls that every survey saw in one state, and their labels."""

    stalls: list[str]


class Turnover(Shown):
    """Arrivals and stays between surveys that follow each other within `hours`."""

    hours: float
    pairs: Count
    open_pairs: Count
    arrivals: Bracket
    per_stall_hour: Bracket
    stay_hours: Bracket


class Use(Shown):
    """Use of a part of the lot, or of all of it. `above`: shares of the surveyed hours at or above an occupancy."""

    name: str
    capacity: Count
    surveys: Count
    hours: Count
    occupancy: Estimate
    accumulation: Estimate
    load_space_hours: Estimate
    peak: Peak | None
    above: dict[str, Estimate]
    never_taken: Steady
    always_taken: Steady
    turnover: Turnover


class Hour(Shown):
    """Mean over the days with a survey in an hour of the day."""

    hour: Annotated[int, Field(ge=0, le=23)]
    days: Count
    occupancy: Estimate
    accumulation: Estimate


class Day(Shown):
    """Mean over the surveyed hours of a day of the week."""

    day: Weekday
    days: Count
    hours: Count
    occupancy: Estimate


class Compared(Shown):
    """Two days of the week by the hours that both have: by how much the second is fuller, a share."""

    first: Weekday
    second: Weekday
    hours: Count
    difference: Estimate


class LeftOut(Shown):
    """A survey of the period that no figure uses, and why."""

    survey: Id
    ended: Utc
    why: str


class Figures(Shown):
    """Figures of a lot's use in a period. `interval`: share of figures whose interval is to hold the true value."""

    lot: Id
    name: str
    clock: str
    interval: Share
    surveys: Count
    first: Local | None
    last: Local | None
    left_out: list[LeftOut]
    whole: Use | None
    by: Literal["hour", "row", "zone", "kind"] | None
    parts: list[Use]
    hours: list[Hour]
    days: list[Day]
    compared: list[Compared]


class SurveyUse(Sourced):
    """A survey with its share of taken stalls. `left_out`: why no figure uses it; empty where figures do."""

    id: Id
    layout: int | None
    placed: Placed
    free: Count
    taken: Count
    unknown: Count
    blurred: Annotated[int | None, Field(ge=0, description=BLURRED)]
    simulated: bool
    program: str
    accuracy: Annotated[float | None, Field(description="metres, the receiver's own estimate at the landing")]
    began: Utc
    ended: Utc
    occupancy: Estimate
    left_out: str
    left_out_code: Literal["", "unregistered", "no_time", "no_looks"]


class SurveysUse(Shown):
    """Surveys of a lot in a period, the newest first."""

    lot: Id
    name: str
    clock: str
    interval: Share
    surveys: list[SurveyUse]


class StallsUse(Shown):
    """Stalls of a lot in columns: `share` of the `surveys` that saw each in which it was taken, `low` to `high`."""

    lot: Id
    interval: Share
    surveys_in_period: Count
    ids: list[Id]
    labels: list[str]
    surveys: list[Count]
    share: list[Share | None]
    low: list[Share | None]
    high: list[Share | None]


class ChangedStall(Shown):
    """A stall whose state changed; `taken`: now. `chance`: probability that both states are right."""

    id: Id
    label: str
    taken: bool
    chance: Share


class Changed(Shown):
    """Changes between two surveys. `compared`: stalls that both saw; `unknown`: those that one of them did not."""

    compared: Count
    unknown: Count
    came: Estimate
    left: Estimate
    stalls: list[ChangedStall]
