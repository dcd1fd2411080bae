"""Answers about lots: what a list or a question says, declared once. The API's definition, its page and the types of
the page are made of these models, and pydantic encodes them.

Places are [north, east], metres in the lot's frame, or degrees of WGS-84, latitude first; times are UTC (RFC 3339).
"""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Final, Literal, Self

from pydantic import BaseModel, ConfigDict, Field
from pydantic.dataclasses import dataclass

from hawk.lots.plan.kinds import Kind
from hawk.lots.plan.values import ANSWER, Id, PlanSection, PlanStall
from hawk.lots.values import PossiblePlace
from hawk.model.sentences import Sentence

Utc = Annotated[datetime, Field(description="UTC")]
Degrees = Annotated[list[float], Field(min_length=2, max_length=2, description="latitude and longitude, degrees")]
Metres = Annotated[list[float], Field(min_length=2, max_length=2, description="north and east, metres")]
State = Literal["free", "taken", "unknown"]
Source = Literal["", "photographs", "orthophoto", "film"]
Limit = Literal["by_gps", "stretched", "coarse", "partly"]
Placed = Literal["first", "registered", "unregistered", "undecided", "nothing", "deleted"]
Next = Annotated[str | None, Field(description="`after` of the next part; null at the end of the list")]
Share = Annotated[float, Field(ge=0, le=1)]
Count = Annotated[int, Field(ge=0)]
BLURRED: Final = "stalls that only blurred pictures showed; null: not measured"


class Shown(BaseModel):
    """An object of an answer."""

    model_config = ConfigDict(frozen=True, populate_by_name=True, **ANSWER)


class SpokenSentence(Shown):
    """A sentence of the program: a page that has words of its own for the code shows those."""

    text: str
    code: str
    values: dict[str, str | int | float]

    @classmethod
    def of(cls, said: Sentence) -> Self:
        """Return the answer's form of a sentence."""
        return cls(text=str(said), code=said.code, values=dict(said.values))


class Doubt(Shown):
    """Reason why the place of a survey is not certain, with the places to choose from."""

    why: str
    places: list[PossiblePlace]
    chosen: int | None


class SurveyPlace(Shown):
    """Move that brings a survey's frame onto its lot's: a shift, metres, and a turn, radians clockwise."""

    north: float
    east: float
    turn: float


class Sourced(Shown):
    """Source of a survey."""

    kind: Annotated[Literal["flown", "picture"], Field(description="picture: made of pictures that others took")]
    source: Annotated[Source, Field(description="kind of those pictures")]
    source_name: Annotated[str, Field(description="name of their folder or file")]
    limits: Annotated[
        list[Limit],
        Field(
            description="what limits a survey by pictures: places by GPS alone, a map that GPS leaves turned or "
            "stretched, coarse ground (over 12 cm a pixel), a part of the lot that was not seen"
        ),
    ]


class CountedSurvey(Sourced):
    """A survey with its counts, and the program that flew it."""

    id: Id
    layout: Annotated[int | None, Field(description="version of the layout by which its stalls are known")]
    placed: Placed
    free: Count
    taken: Count
    unknown: Count
    found: Annotated[
        int, Field(ge=0, description="stalls on the flight's own map, those that no layout has among them")
    ]
    blurred: Annotated[int | None, Field(ge=0, description=BLURRED)]
    simulated: bool
    program: Annotated[str, Field(description="version of hawk-drone that flew it")]
    began: Utc
    ended: Utc


class Survey(CountedSurvey):
    """A survey. `candidates`: the lots that it may be of, while a person has to say it."""

    seq: Annotated[int, Field(description="number in the order of the landings")]
    lot: Id | None
    drone: Annotated[str | None, Field(description="name of the drone or desk that sent it; null: it was stored here")]
    datum: Degrees
    place: SurveyPlace | None
    doubt: Doubt | None
    time_is_sure: Annotated[bool, Field(description="false: no sure clock says the time, or it is later than now")]
    candidates: list[Id]


class SurveyGround(Shown):
    """Picture of the ground that a survey mapped, as square tiles of JPEG in the survey's own frame.

    A tile [row, column] covers north from -(row + 1) to -row sides and east from column to column + 1 sides; `cell_m`
    metres a pixel. `place` brings the survey's frame onto the one about `datum`. `ground/whole` is one
    picture of their rectangle, at most 1280 pixels a side.
    """

    datum: Degrees
    place: SurveyPlace
    cells: Count
    cell_m: float
    tiles: list[Annotated[list[int], Field(min_length=2, max_length=2)]]


class ListedLot(Shown):
    """A lot, with its newest survey. `time_zone`: that of its place, unless a person chose another one."""

    id: Id
    name: str
    time_zone: str
    stalls: Count
    sections: Count
    survey_count: Count
    last_survey: Survey | None
    due: Annotated[
        Utc | None, Field(description="when the next survey is due, by `[[schedule]]`; null: not within 7 days")
    ]


class Edit(Shown):
    """Person who edits a plan, and since when; `layout`: the version that it makes."""

    who: str
    since: Utc
    last: Utc
    layout: int


class Lot(ListedLot):
    """A lot. `datum`: origin of its frame, north up. `revision` rises with every change of its plan."""

    datum: Degrees
    datum_is_pinned: bool
    outline: Annotated[list[list[Degrees]], Field(description="rings of the ground")]
    edit: Edit | None
    revision: Count


class Layout(Shown):
    """A version of a lot's layout."""

    version: int
    valid_from: Utc
    who: str
    why: str


@dataclass(frozen=True, slots=True, kw_only=True, config=ANSWER)
class PlacedStall(PlanStall):
    """A stall of a layout, with its row and its place on Earth."""

    row: Annotated[str | None, Field(description="letter of its row; null under an owner's own label")]
    latitude: float
    longitude: float


@dataclass(frozen=True, slots=True, kw_only=True, config=ANSWER)
class ListedStall(PlacedStall):
    """A stall with the last look at it, all null where no survey looked; `survey`: which survey looked."""

    state: State | None
    taken_probability: Share | None
    observed: Utc | None
    survey: Id | None


@dataclass(frozen=True, slots=True, kw_only=True, config=ANSWER)
class Stall(ListedStall):
    """A stall of a lot: `begins` is the first version of the layout that has it, `ends` the first that has not."""

    lot: Id
    begins: int
    ends: int | None


class Zone(Shown):
    """An area of a plan: one without stalls, or one that statistics count by itself, for a kind of stalls."""

    id: Id
    name: str
    kind: Kind
    has_stalls: bool
    is_private: bool
    outline: list[Metres]
    ground: list[Degrees]


class SectionLook(Shown):
    """Look of a survey at a section. `least` to `most` holds the true number of parked vehicles in 90 % of looks."""

    survey: Id
    section: Id
    name: str
    observed: Utc
    source: Annotated[
        Literal["vehicles", "stalls"],
        Field(description="what was counted: vehicles, or taken stalls where the network knows no vehicles"),
    ]
    parked: Count
    least: Count
    most: Count
    capacity: Annotated[int | None, Field(description="places of the section now; null: not known")]
    occupancy: Annotated[
        float | None, Field(ge=0, description="parked of the capacity, above 1 where more are parked; null without one")
    ]
    room: Annotated[
        int | None,
        Field(ge=0, description="vehicles that the gaps have room for; null for an area, and where 30 % is hidden"),
    ]
    hidden_share: Annotated[Share, Field(description="ground that was seen, but whose state is not known")]
    seen_share: Annotated[Share, Field(description="ground of the section that was seen")]


class VehicleCounts(Shown):
    """Vehicles of a survey by the ground that they stand on, each counted once; null where that is not known.

    `vehicles`: all of them, null where the network knows none. `beside`: on the lot's ground, on no stall and in no
    section: in an aisle, on hatching.
    """

    survey: Id
    vehicles: Count | None
    on_stalls: Count | None = None
    in_sections: Count | None = None
    beside: Count | None = None
    elsewhere: Count | None = None


@dataclass(frozen=True, slots=True, kw_only=True, config=ANSWER)
class ListedSection(PlanSection):
    """A section of a plan with its place on Earth and the newest look at it; null where no survey looked."""

    ground: list[Degrees]
    look: SectionLook | None


class SeenSections(Shown):
    """Sections of a lot's plan by their names, with what one survey saw of each; null where it did not look."""

    survey: Id
    sections: list[ListedSection]


class Observation(Shown):
    """Look of a survey at a stall. `picture_count`: pictures behind it."""

    survey: Id
    stall: Id
    label: str
    state: State
    taken_probability: Share
    observed: Utc
    picture_count: Count


class Change(Shown):
    """A change that a person made in a `lot`; `surveys`: those that it moved, placed or deleted. `undone`: when it was
    undone. `kept`: why it cannot be undone now; null for one that can.
    """

    seq: int
    kind: str
    lot: Id
    surveys: list[Id]
    who: str
    made: Utc
    undone: Utc | None
    kept: str | None


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


class Begun(Done):
    """A lot that a plan made; `stalls`, `sections`: how many it has."""

    stalls: Count
    sections: Count


class FoundStall(Shown):
    """A stall that a survey found, in the lot's frame, with the number that the survey gave it."""

    id: int
    north: float
    east: float
    angle: float
    width: float
    length: float
    state: State


class BeginProposal(FoundStall):
    """A stall that surveys found where the layout has none. `instead`: stalls that it overlaps."""

    instead: list[Id]
    corners: list[Degrees]


class EndProposal(Shown):
    """A stall of the layout that surveys did not find."""

    id: Id
    label: str
    is_confirmed: bool
    corners: list[Degrees]


class SurveyProposals(Shown):
    """Changes of the layout that a survey proposes."""

    survey: Id
    ended: Utc
    begin: list[BeginProposal]
    end: list[EndProposal]


class DoubtfulSurvey(Shown):
    """A survey whose place a person may choose: the number of places."""

    survey: Id
    ended: Utc
    why: str
    places: Count


class DroneStall(Shown):
    """A stall as a drone's plan has it."""

    id: Id
    label: str
    corners: list[Degrees]


class DroneProposals(Shown):
    """Changes of a plan on a drone, of a plan that was changed here since. `areas`: names of zones and sections.

    `base`: plan that the drone changed.
    """

    drone: str
    base: str
    begin: list[DroneStall]
    end: list[DroneStall]
    change: list[DroneStall]
    areas: list[str]


class LotPair(Shown):
    """A lot on the ground of another one. `share`: of the smaller area that both have."""

    lot: Id
    name: str
    share: Share


class Proposals(Shown):
    """Changes of a lot's layout that its newest surveys propose, and those that were made on drones.

    `same`: lots on its ground, to be merged into it.
    """

    lot: Id
    datum: Degrees
    surveys: list[SurveyProposals]
    drones: list[DroneProposals] = []
    same: list[LotPair] = []
    doubtful: list[DoubtfulSurvey]


class MissedStall(Shown):
    """A stall of the layout."""

    id: Id
    label: str


class Comparison(Shown):
    """Newest registered survey of a lot beside the layout; null where there is none. `found`: stalls that the layout
    lacks; `missed`: stalls of the layout that it did not find where it saw their ground.
    """

    survey: Id | None
    found: list[FoundStall]
    missed: list[MissedStall]


Shape = Annotated[
    list[float],
    Field(min_length=5, max_length=5, description="north, east, angle, width and length in the lot's frame"),
]  # fmt: skip


class PlacedShapes(Shown):
    """Stalls of a survey at one of its possible places."""

    stalls: list[Shape]


class PossiblePlaces(Shown):
    """Places of a survey's doubt, in their order, with its stalls at each; `known`: stalls of its lot."""

    survey: Id
    lot: Id
    known: list[Shape]
    places: list[PlacedShapes]


class SharedLink(Shown):
    """A link to a lot: the page is `/shared#TOKEN`. No later answer holds the `token`."""

    id: Id
    token: str
    ends: Utc


class ListedLink(Shown):
    """A link to a lot, without its token. `open`: it opens the lot now. `who`: the person of some lots who made it."""

    id: Id
    who: str | None
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


class Part(Shown):
    """Part of a list."""

    next: Next


class ChangeList(Part):
    """Part of the list of changes."""

    items: list[Change]


class LotList(Part):
    """Part of the list of lots."""

    items: list[ListedLot]


class LayoutList(Part):
    """Part of the list of layouts."""

    items: list[Layout]


class PlacedStallList(Part):
    """Part of the list of a layout's stalls."""

    items: list[PlacedStall]


class StallList(Part):
    """Part of the list of stalls."""

    items: list[ListedStall]


class ZoneList(Part):
    """Part of the list of zones."""

    items: list[Zone]


class SectionList(Part):
    """Part of the list of sections."""

    items: list[ListedSection]


class SectionLookList(Part):
    """Part of the list of a survey's looks at sections."""

    items: list[SectionLook]


class SurveyList(Part):
    """Part of the list of surveys."""

    items: list[Survey]


class ObservationList(Part):
    """Part of the list of observations."""

    items: list[Observation]


class Geometry(Shown):
    """Polygon or MultiPolygon of [longitude, latitude], degrees."""

    type: Literal["Polygon", "MultiPolygon"]
    coordinates: list[Any]


class Feature(Shown):
    """A lot, a stall or a survey with its ground; null where none is known."""

    type: Literal["Feature"]
    id: Id
    geometry: Geometry | None
    properties: dict[str, Any]
