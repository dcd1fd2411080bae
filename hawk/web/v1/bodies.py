"""Bodies of changes, and the answers that the web room makes itself: refusals, and the recordings on the drone's disk.

Further rules of a body stand where each change is made.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, model_validator

from hawk.formats.validation import FieldError
from hawk.lots.answers import Count, Next, Shown, SpokenSentence, Utc
from hawk.lots.plan.operations import Operation
from hawk.lots.values import LONGEST_NAME, LONGEST_ZONE
from hawk.store.recording_request import MOST_RECORDINGS
from hawk.web.v1.parameters import Id
from hawk.web.v1.unknown import PATTERNS

Name = Annotated[str, Field(min_length=1, max_length=LONGEST_NAME)]
Why = Annotated[str, Field(max_length=LONGEST_NAME, description="reason of the change")]
Latitude = Annotated[float, Field(ge=-90, le=90, allow_inf_nan=False)]
Longitude = Annotated[float, Field(ge=-180, le=180, allow_inf_nan=False)]
Corner = Annotated[tuple[Latitude, Longitude], Field(strict=False, description="latitude and longitude, degrees")]


class Given(BaseModel):
    """Body of a change. Another key than these is refused."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Nothing(Given):
    """No values."""


class LotName(Given):
    """Name of a lot: any text that can be shown."""

    name: Name


class LotTimeZone(Given):
    """Name of a lot's time zone, as Europe/Amsterdam; null: that of its place."""

    time_zone: Annotated[str, Field(max_length=LONGEST_ZONE)] | None


class LotMerge(Given):
    """The lot that becomes part of this one."""

    other: Annotated[Id, Field(alias="with")]


class LotSplit(Given):
    """Ground of the stalls that become a lot of their own, and its name."""

    name: Name
    outline: Annotated[list[Corner], Field(min_length=3, max_length=500)]


class Chosen(Given):
    """Proposals of a survey: lists of their ids, or "all"; or those of a drone, all of them, by its name and base."""

    survey: Id | None = None
    begin: list[int] | Literal["all"] = []
    end: list[Id] | Literal["all"] = []
    drone: Name | None = None
    base: Annotated[str, Field(max_length=64)] = ""


class TakeOver(Chosen):
    """Proposals of a survey that become a version of the layout."""

    why: Why | None = None


class PinnedPoint(Given):
    """A place of the lot as it is shown, and where it really is."""

    shown: Annotated[Corner, Field(alias="from")]
    true: Annotated[Corner, Field(alias="to")]


class LotPin(Given):
    """One point shifts the lot, two also turn it; none unpins it."""

    points: Annotated[list[PinnedPoint], Field(max_length=2)]


class SurveyMove(Given):
    """The lot of a survey; null: a new one, with a name where one is given."""

    lot: Id | None
    name: Name | None = None


class Choose(Given):
    """Number of one of the places of a survey's doubt, from 0."""

    place: Annotated[int, Field(ge=0, le=1000)]


class OpenEdit(Given):
    """Name of the person who edits. `take_over` closes another person's edit as it is."""

    who: Name
    take_over: bool = False


class InEdit(Given):
    """Id of the edit."""

    edit: Id


class CloseEdit(InEdit):
    """Id of the edit, and the reason of the version that it made."""

    why: Why | None = None


class Do(InEdit):
    """An operation on the plan within the edit."""

    operation: Annotated[Operation, Field(discriminator="do")]


class LinkDays(Given):
    """Days for which a link to a lot opens: above 0."""

    days: Annotated[float, Field(gt=0, le=366, strict=False, allow_inf_nan=False)]


class TakePlan(InEdit):
    """Id of the edit. `uncertain`: the plan is taken although its place is not certain."""

    uncertain: bool = False


class BeginLot(Given):
    """Name of the lot that a plan makes."""

    name: Name


class Keep(Given):
    """Mark of a recording: it is never removed for room."""

    keep: bool


class Kept(Shown):
    """A recording with its mark."""

    name: str
    keep: bool


class Deleted(Shown):
    """A recording that was deleted."""

    name: str
    deleted: bool


class RecordingRequest(Given):
    """Request for the recordings of a survey; false takes it back."""

    asked: bool


class RecordingsOfSurvey(Shown):
    """Recordings of a survey that a drone sent. `drone`: its name; null: no drone has flown it and sent it here.
    `stored` of `bytes` are here; `problem`: why no more comes now.
    """

    survey: Id
    drone: str | None
    state: Annotated[
        Literal["none", "asked", "coming", "here", "never", "gone"],
        Field(description="never: the drone's settings forbid it; gone: the drone has none of it"),
    ]
    stored: Count
    bytes: Count | None
    problem: str


class FileOffer(Given):
    """A recording on a drone."""

    name: Annotated[str, Field(pattern=f"^{PATTERNS['name']}$")]
    bytes: Annotated[int, Field(ge=1, le=2**53)]


class RecordingOffer(Given):
    """Recordings that a drone has of a survey. `answer`: never, its settings forbid it; gone, it has none."""

    recordings: Annotated[list[FileOffer], Field(max_length=MOST_RECORDINGS)] = []
    answer: Literal["", "never", "gone"] = ""


class RecordingState(Shown):
    """A recording of which `stored` of `bytes` are here: the next part begins there."""

    name: str
    stored: Count
    bytes: Count


class OfferState(Shown):
    """Recordings of a survey that a drone offered."""

    survey: Id
    recordings: list[RecordingState]


class Problem(Shown):
    """Refusal of a request (RFC 9457): `detail` says what is wrong and the remedy, `field` names the value."""

    type: str
    title: str
    status: int
    detail: str
    field: str = ""
    who: Annotated[str, Field(description="person who edits the plan")] = ""
    since: Annotated[Utc | None, Field(description="beginning of that edit")] = None
    sentences: Annotated[list[SpokenSentence], Field(description="`detail`, and those in it")]


class SurveyState(Shown):
    """A survey that was sent as a document: its newest state here, and its lot."""

    survey: Id
    state: Count
    lot: Id | None


class LotState(Shown):
    """A lot that was sent as a document: `state` of the document. `keeps_plan`: the plan is another one here."""

    lot: Id
    state: Count
    keeps_plan: bool


class InboxFile(Shown):
    """A file that lies in the inbox. `flight`: its folder there."""

    name: str
    flight: str | None
    bytes: Count


class DueList(Shown):
    """Moments at which surveys of a lot are due, by the settings; one that has come and is not flown among them."""

    items: list[Utc]


Time = Annotated[AwareDatetime, Field(strict=False, description="with its offset, as 2026-05-04T10:00+02:00")]
Speed = Annotated[float, Field(ge=0, le=100, allow_inf_nan=False, description="m/s, 10 m above the ground")]


class ForecastHour(Given):
    """Weather from a time on, for some hours. `cloud`: percent of the sky; `rain`: mm in an hour."""

    begin: Time
    hours: Annotated[int, Field(ge=1, le=72)] = 1
    wind: Speed
    gust: Speed
    cloud: Annotated[float, Field(ge=0, le=100, allow_inf_nan=False)] = 0.0
    rain: Annotated[float, Field(ge=0, le=500, allow_inf_nan=False)] = 0.0

    @model_validator(mode="after")
    def _gust_is_stronger(self) -> ForecastHour:
        if self.gust < self.wind:
            raise FieldError("gust", "must not be less than wind")
        return self


class Forecast(Given):
    """A forecast. `made`: when its source made it."""

    made: Time
    hours: Annotated[list[ForecastHour], Field(min_length=1, max_length=200)]


class DayPlanQuery(Given):
    """Full batteries for the day, and a forecast; without one no start is proposed."""

    batteries: Annotated[int, Field(ge=1, le=100)] = 1
    forecast: Forecast | None = None


class RoundLotName(Shown):
    """A lot of a round."""

    id: Id
    name: str


class RoundStart(Shown):
    """A time at which a round could start, and the reasons against it; none where it fits."""

    at: Utc
    reasons: list[str]


class DayRound(Shown):
    """A flight over some lots. `start`: null where `problem` or `hours` say why it has none."""

    lots: list[RoundLotName]
    due: Utc
    start: Utc | None
    end: Utc | None
    seconds: float
    batteries: Count
    distance_m: float
    problem: str
    hours: list[RoundStart]


class DayPlan(Shown):
    """Rounds of the next 24 hours: proposed, and started by a person. `sentences`: those of problems and reasons."""

    rounds: list[DayRound]
    problems: list[str]
    sentences: list[SpokenSentence]


class RecordedLot(Shown):
    """Lot of a recorded flight, and the survey of it that the flight made."""

    id: Id
    name: str
    time_zone: str
    survey: Id


class Recording(Shown):
    """A recording on this disk. `began` by the clock of the surveys; `drone`: name of the one that sent it here;
    `keep`: it is never removed for room, nor for its age at `keep_end`.
    """

    name: str
    bytes: Count
    began: Utc | None
    seconds: float | None
    survey: str | None
    lot: RecordedLot | None
    drone: str | None
    keep: bool
    keep_end: Utc | None
    under_way: bool


class RecordingList(Shown):
    """Part of the list of recordings."""

    items: list[Recording]
    next: Next
