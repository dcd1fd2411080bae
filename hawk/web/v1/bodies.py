"""Bodies of changes as pydantic models, and the answers to these. Further rules stand where each change is made."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from hawk.lots.answers import Count, Degrees, EditedStall, EditedZone, Shown, Utc
from hawk.lots.plan.operations import Operation
from hawk.lots.values import LONGEST_NAME
from hawk.web.v1.parameters import Id

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


class LotMerge(Given):
    """The lot that becomes part of this one."""

    other: Annotated[Id, Field(alias="with")]


class LotSplit(Given):
    """Ground of the stalls that become a lot of their own, and its name."""

    name: Name
    outline: Annotated[list[Corner], Field(min_length=3, max_length=500)]


class Chosen(Given):
    """Proposals of a survey: lists of their ids, or "all"."""

    survey: Id
    begin: list[int] | Literal["all"] = []
    end: list[Id] | Literal["all"] = []


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


class Done(Shown):
    """A change that was made; its `seq` undoes it."""

    seq: int
    kind: str
    lot: str


class Pinned(Done):
    """Move of a lot's datum and frame, metres and degrees. `residual`: by how much two points contradict the lot, m."""

    north: float
    east: float
    turn: float
    residual: float
    datum: Degrees


class Undone(Shown):
    """A change that was undone."""

    seq: int
    kind: str


class Opened(Shown):
    """An open edit. `undo`, `redo`: operations that can be undone, done again."""

    edit: Id
    lot: Id
    who: str
    since: Utc
    layout: int
    revision: Count
    undo: Count
    redo: Count


class Edited(Shown):
    """Changes by an operation. `gone`: stalls that are no part of the plan any more. Zones are all there are."""

    edit: Id
    revision: Count
    stalls: list[EditedStall]
    gone: list[Id]
    zones: list[EditedZone]
    named_zones: list[EditedZone]
    undo: Count
    redo: Count


class Stepped(Edited):
    """Changes by an undo or a redo; `operation` names what was undone or done again."""

    operation: str


class Closed(Shown):
    """A closed edit: `seq` undoes all of it, `layout` is its version; both null where nothing is changed."""

    lot: Id
    edit: Id
    seq: int | None
    layout: int | None


class Kept(Shown):
    """A recording with its mark."""

    name: str
    keep: bool


class Deleted(Shown):
    """A recording that was deleted."""

    name: str
    deleted: bool


class SharedLink(Shown):
    """A link to a lot: the page is `/shared#TOKEN`. No later answer holds the `token`."""

    id: Id
    token: str
    ends: Utc


class ListedLink(Shown):
    """A link to a lot, without its token. `open`: it opens the lot now."""

    id: Id
    made: Utc
    ends: Utc
    open: bool
    taken_back: Utc | None


class SharedLinks(Shown):
    """All links to a lot, the newest first."""

    shares: list[ListedLink]


class TakenBack(Shown):
    """A link that opens nothing from now on."""

    id: Id
    taken_back: bool


class PlanPlace(Shown):
    """Place of a file's plan on the lot: by what it was found, on what; a shift, metres, a turn, degrees."""

    by: str
    on: str
    is_certain: bool
    doubt: str
    north: float
    east: float
    turn: float
    residual: float
    accuracy: float | None


class PlanShape(Shown):
    """A stall in the lot's frame, metres and radians."""

    north: float
    east: float
    angle: float
    width: float
    length: float
    label: str


class BeginningShape(PlanShape):
    """A stall that the plan would have besides."""

    kind: str


class StayingShape(BeginningShape):
    """A stall of the plan as the file has it; `former`: its label."""

    id: Id
    former: str


class EndingShape(PlanShape):
    """A stall that the plan would have no more."""

    id: Id


class LeftOutFeature(Shown):
    """A feature of the file that is left out, or that clashes, and why."""

    name: str
    reason: str


class Renamed(Shown):
    """A label of the file that another stall had, and the one in its place."""

    label: str
    to: str


class PlanLayer(Shown):
    """A layer of a drawing."""

    name: str
    outlines: Count


class PlanPreview(Shown):
    """Effect of an import, which its `token` takes within minutes; nothing is written before. `same`: stalls that the
    plan has as the file does.
    """

    token: str
    lot: Id | None
    file: str
    format: str
    crs: str
    datum: Degrees
    placed: PlanPlace
    begin: list[BeginningShape]
    stay: list[StayingShape]
    same: int
    end: list[EndingShape]
    left_out: list[LeftOutFeature]
    left_out_count: Count
    clashes: list[LeftOutFeature]
    clash_count: Count
    renamed: list[Renamed]
    layers: list[PlanLayer]


class Begun(Done):
    """A lot that a plan made; `stalls`: how many it has."""

    stalls: Count
