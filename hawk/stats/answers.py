"""Answers about the surveys and the stalls of a lot, one by one."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from hawk.lots.answers import Count, CountedSurvey, Share, Shown, Utc
from hawk.lots.plan.values import Id
from hawk.stats.values import Estimate


class SurveyUse(CountedSurvey):
    """A survey with its share of taken stalls. `left_out`: why no figure uses it; empty where figures do."""

    at: Annotated[
        Utc, Field(description="its moment: the mean time of its observations, the end of one that is left out")
    ]
    accuracy: Annotated[float | None, Field(description="metres, the receiver's own estimate at the landing")]
    occupancy: Estimate
    left_out: str
    left_out_code: Literal["", "unregistered", "no_time", "no_looks"]


class NextSurvey(Shown):
    """A survey next to those of an answer."""

    id: Id
    at: Utc


class SurveysUse(Shown):
    """Surveys of a lot in a period, the newest first. `before`, `after`: the surveys next to these."""

    lot: Id
    name: str
    clock: str
    interval: Share
    surveys: list[SurveyUse]
    before: NextSurvey | None
    after: NextSurvey | None


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
