"""Values of the lots' store: a survey that has ended, its stalls, and the errors. Nothing here needs a database."""

from __future__ import annotations

import math
import uuid
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields
from datetime import UTC, datetime
from enum import StrEnum
from typing import TYPE_CHECKING, Any, ClassVar, Final

from hawk.lots.plan.values import ANSWER, LayoutStall
from hawk.lots.survey.source import PictureSource, SurveyKind
from hawk.model.lot_map import Stall, StallState
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose
from hawk.model.vehicles import Vehicle

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

LONGEST_NAME: Final = 80
"""Characters of a name of a lot or a person."""
LONGEST_ZONE: Final = 64
"""Characters of a name of a time zone."""
SHARE: Final = "@"
"""Stands between the name of a round's journal and the id of a lot in the name of that lot's survey."""
UTC_NAME: Final = "UTC"
"""Time zone of what is of no lot, and of a place for which the map has none that Python knows."""
DAMAGED: Final = "The store of lots holds a value that cannot be: hawk-drone verify reports what is damaged."


class LotStoreError(Exception):
    """The store cannot be used, or refuses; the text names the file and the remedy."""


class LotInputError(LotStoreError):
    """A value cannot be used. ``field`` names it."""

    def __init__(self, field: str, reason: str) -> None:
        super().__init__(f"{field}: {reason}")
        self.field = field
        self.reason = reason


NEWER_FIELD: Final = "version"
"""Field of the refusal of a document of a newer version, as a drone reads it in the desk's answer."""


class FormatVersionError(LotInputError):
    """A document is of a newer version than this program reads."""

    def __init__(self, version: int, newest: int) -> None:
        remedy = f"who takes it in reads up to {newest}: upgrade that one"
        super().__init__(NEWER_FIELD, f"is {version}, of a newer hawk-drone; {remedy}")


class NotFoundError(LotStoreError):
    """There is no such lot, survey or change."""


class StoreBusyError(LotStoreError):
    """A read took longer than it may, or too many wait already: it may be asked again."""


class StoreFullError(LotStoreError):
    """The disk of the store is full: nothing was written, and it may be asked again once there is room."""


class OtherDroneError(LotStoreError):
    """A document is of a survey that another drone has sent, or that was stored here."""


class ErasedError(LotStoreError):
    """A document is of a survey or a lot that was erased here: it does not come back."""


class BeingEditedError(LotStoreError):
    """A person edits the plan of a lot: ``who``, since ``since`` (UTC, Unix seconds)."""

    def __init__(self, who: str, since: float, reason: str) -> None:
        super().__init__(f"edit: {reason}")
        self.who = who
        self.since = since


def new_id() -> str:
    """Return a UUID that nothing else has."""
    return str(uuid.uuid4())


def moment(seconds: float) -> datetime:
    """Return a time, Unix seconds, in UTC, as answers show it: without the fraction of the second."""
    return datetime.fromtimestamp(math.floor(seconds), UTC)


def utc(seconds: float) -> str:
    """Return a time, Unix seconds, as ISO 8601 text in UTC."""
    return moment(seconds).isoformat().replace("+00:00", "Z")


_JOINERS: Final = "\N{ZERO WIDTH NON-JOINER}\N{ZERO WIDTH JOINER}"
"""Between letters they choose their forms, in Persian and in Hindi; between emoji they make one of several."""
_WITHOUT_JOINERS: Final = str.maketrans("", "", _JOINERS)


def is_shown(text: str) -> bool:
    """Return whether all of a text can be shown: no control character, no turn of the direction."""
    letters = text.translate(_WITHOUT_JOINERS)
    return letters.isprintable() and (letters.strip() != "" or text == "")


def fitting_name(text: str) -> str:
    """Return a text as the name of a lot: without what cannot be shown, and cut; "" where nothing is left."""
    shown = "".join(each if each.isprintable() or each in _JOINERS else " " for each in text)
    return " ".join(shown.split())[:LONGEST_NAME].rstrip()


def free_name(name: str, used: Collection[str]) -> str:
    """Return a name that is not used: a number follows where it is. "" stays."""
    number, found = 1, name
    while name and found in used:
        number += 1
        found = f"{name[: LONGEST_NAME - len(str(number)) - 1].rstrip()} {number}"
    return found


def checked_name(name: object, field: str = "name") -> str:
    """Return a name without space around it. Any text is one; nothing of it is read. Raises LotInputError."""
    if not isinstance(name, str):
        raise LotInputError(field, "must be text")
    tidy = " ".join(name.split())
    if not tidy:
        raise LotInputError(field, "is empty: write one or more letters")
    if len(tidy) > LONGEST_NAME:
        raise LotInputError(field, f"has {len(tidy)} characters: write {LONGEST_NAME} or fewer")
    if not is_shown(tidy):
        raise LotInputError(field, "holds characters that cannot be shown: write it without")
    return tidy


def check_fields(asked: Mapping[str, Any], known: Sequence[str]) -> None:
    """Refuse fields of a request that it has not. Raises LotInputError."""
    for name in asked:
        if name not in known:
            raise LotInputError(str(name)[:20], f"is no field of this request: it takes {', '.join(known)}")


def checked_degrees(given: object, field: str) -> tuple[float, float]:
    """Return a place on Earth from JSON values: [latitude, longitude], degrees. Raises LotInputError."""
    pair = given if isinstance(given, list) and len(given) == 2 else []
    if not pair or not all(type(each) in (int, float) and math.isfinite(each) for each in pair):
        raise LotInputError(field, "must be [latitude, longitude], two finite numbers of degrees")
    latitude, longitude = map(float, pair)
    if abs(latitude) > 90 or abs(longitude) > 180:
        raise LotInputError(field, "must be degrees: latitude -90 to 90, longitude -180 to 180")
    return latitude, longitude


class Placed(StrEnum):
    """Relation of a survey to a lot's stalls."""

    FIRST = "first"
    """It made the lot's first layout."""
    REGISTERED = "registered"
    """Its stalls are known ones of the lot."""
    UNREGISTERED = "unregistered"
    """The lot is known; its stalls were not compared, or not with certainty."""
    UNDECIDED = "undecided"
    """Several lots may be meant: a person is asked."""
    NOTHING = "nothing"
    """No lot was found."""
    DELETED = "deleted"
    """A person deleted it: no lot has it, until that is undone."""


PLACED: Final = (Placed.FIRST.value, Placed.REGISTERED.value)
"""Surveys whose stalls are those of a lot."""
WITNESS_SCORE: Final = 0.5
"""Score from which a given stall of a survey was also found by vision."""


@dataclass(frozen=True, slots=True)
class Detection:
    """A stall as a survey saw it: `Stall`, with the time of the last look in place of the daemon's clock.

    ``north``, ``east``: centre in the survey's frame, metres. ``looked_at``: UTC, Unix seconds. ``known``: the UUID of
    that stall in the lot's plan, by which the flight gave it; it says nothing of where the survey lies. ``is_extra``:
    found beside given stalls, where the plan has none. ``is_blurred``: only blurred pictures showed it;
    None: not measured.
    """

    id: int
    north: float
    east: float
    angle: float
    width: float
    length: float
    taken_probability: float
    state: StallState
    score: float
    picture_count: int
    looked_at: float
    known: str = ""
    is_extra: bool = False
    is_blurred: bool | None = None

    @property
    def shape(self) -> tuple[float, float, float, float, float]:
        """North, east, angle, width, length."""
        return self.north, self.east, self.angle, self.width, self.length

    @property
    def is_witness(self) -> bool:
        """True when the pictures show it, whatever the plan says."""
        return not self.known or self.score >= WITNESS_SCORE

    def __post_init__(self) -> None:
        """Refuse what is no number. Raises LotInputError."""
        _check_finite(self, "stalls")

    @classmethod
    def of(cls, stall: Stall, looked_at: float) -> Detection:
        """Return a stall of the map with the time of its last look (UTC, Unix seconds)."""
        return cls(
            id=stall.id,
            north=float(stall.north),
            east=float(stall.east),
            angle=float(stall.angle),
            width=float(stall.width),
            length=float(stall.length),
            taken_probability=float(stall.taken),
            state=stall.extra or stall.state,
            score=float(stall.score),
            picture_count=int(stall.seen),
            looked_at=looked_at,
            known=stall.known,
            is_extra=stall.extra is not None,
            is_blurred=stall.is_blurred,
        )

    def on_map(self) -> Stall:
        """Return the stall as one of a map, without a time."""
        names = (each.name for each in fields(self) if each.name not in _NOT_ON_MAP)
        shown = {_ON_MAP.get(name, name): getattr(self, name) for name in names}
        return Stall(**shown, last_seen=0.0, version=0)


_NOT_ON_MAP: Final = ("looked_at", "is_extra")
_ON_MAP: Final = {"taken_probability": "taken", "picture_count": "seen"}
"""Names that a stall of the map has for columns of a detection."""


@dataclass(frozen=True, slots=True)
class VehicleDetection(Vehicle):
    """A vehicle as a survey saw it, in the survey's frame. ``looked_at``: last look, UTC, Unix seconds.

    It is kept with its survey alone, and compared with no vehicle of another one.
    """

    looked_at: float

    @property
    def shape(self) -> tuple[float, float, float, float, float]:
        """North, east, angle, width, length."""
        return self.north, self.east, self.angle, self.width, self.length

    def __post_init__(self) -> None:
        """Refuse what is no number. Raises LotInputError."""
        _check_finite(self, "vehicles")

    @classmethod
    def of(cls, vehicle: Vehicle, looked_at: float) -> VehicleDetection:
        """Return a vehicle of the map with the time of its last look (UTC, Unix seconds)."""
        return cls(**{each.name: getattr(vehicle, each.name) for each in fields(Vehicle)}, looked_at=looked_at)


def _check_finite(value: Detection | VehicleDetection, those: str) -> None:
    for name in _FRACTIONS[those]:
        number = getattr(value, name)
        if not math.isfinite(number):
            raise LotInputError(f"{those}[{value.id}].{name}", f"must be a finite number, not {number}")


_FRACTIONS: Final = {
    name: tuple(each.name for each in fields(kind) if each.type == "float")
    for name, kind in (("stalls", Detection), ("vehicles", VehicleDetection))
}
"""Columns that are no whole numbers: looked up once, not for each of a thousand stalls."""


@dataclass(frozen=True, slots=True)
class FinishedSurvey:
    """A survey that has ended.

    ``name``: that of its journal. ``began``, ``ended``: UTC, Unix seconds; not ``time_is_sure`` while neither a time
    server nor GNSS has set the clock. ``outline``: the area flown, or the lot's ground that was seen. ``stalls``:
    without the suggested ones, but with the extra ones. ``seen_ground``: all that was seen, of the lot or beside it.
    ``accuracy``: metres, the receiver's own estimate at the landing; None where it gave none. ``pictures``: the
    source of a survey that nobody flew. ``title``: name for a new lot; "": by its number. ``beside``: outlines of the
    other lots near by, where a person gave those of several lots, this one among them; None: nobody did.
    ``vehicles``: None of a network that knows none. ``capacity``: places on the outline as a person gave them; a lot
    without stalls has that section.
    """

    name: str
    datum: GlobalPose
    began: float
    ended: float
    time_is_sure: bool
    outline: Outline
    stalls: tuple[Detection, ...]
    program: str
    simulated: bool = False
    seen_ground: Outline = field(default=Outline(), repr=False)
    accuracy: float | None = None
    pictures: PictureSource | None = None
    title: str = ""
    beside: tuple[Outline, ...] | None = field(default=None, repr=False)
    vehicles: tuple[VehicleDetection, ...] | None = field(default=None, repr=False)
    capacity: int | None = None

    def __post_init__(self) -> None:
        """Refuse what is no number, and an end before the beginning. Raises LotInputError."""
        given = {"datum.latitude": self.datum.latitude, "datum.longitude": self.datum.longitude}
        given |= {"began": self.began, "ended": self.ended, "accuracy": self.accuracy or 0.0}
        corners = [corner for ring in (*self.outline.polygons, *self.outline.holes) for corner in ring]
        given |= {f"outline[{n}]": sum(map(abs, corner)) for n, corner in enumerate(corners)}
        for name, value in given.items():
            if not math.isfinite(value):
                raise LotInputError(name, f"must be a finite number, not {value}")
        if self.ended < self.began:
            words = f"{utc(self.ended)} is before began, {utc(self.began)}: correct the clock or the files' times"
            raise LotInputError("ended", words)

    @property
    def kind(self) -> SurveyKind:
        """Kind of the survey: hawk flew it, or it was made of pictures."""
        return SurveyKind.FLOWN if self.pictures is None else SurveyKind.PICTURE

    @property
    def origin(self) -> str:
        """Identity of the survey across saves: its journal and its datum, which no other survey shares."""
        return f"{self.name} {self.datum.latitude:.9f} {self.datum.longitude:.9f}"


def journal_of(origin: str, writer: str = "") -> str:
    """Return the name of the journal of a survey's ``origin``: the surveys of one round share it.

    ``writer``: name of the drone that sent the survey here; "": it is of this store.
    """
    return origin.removeprefix(f"{writer}: ").partition(" ")[0].partition(SHARE)[0]


@dataclass(frozen=True, slots=True)
class Registration:
    """Place of a survey among a lot's stalls: a rigid move of the survey's frame, and the stalls that are the same.

    ``north``, ``east`` (metres) and ``turn`` (radians clockwise) bring the survey's frame onto the lot's. ``same``:
    the survey's stall id -> the stored stall's UUID, each at most once.
    """

    north: float
    east: float
    turn: float
    same: Mapping[int, str]


@dataclass(frozen=True, slots=True)
class KnownGround:
    """A lot's stalls, and the ground on which it would know every stall; metres (north, east) in the lot's frame."""

    stalls: tuple[LayoutStall, ...] = field(repr=False)
    seen: BaseGeometry = field(repr=False)


@dataclass(frozen=True, slots=True)
class MappedGround:
    """A survey's stalls, and the ground that it saw; metres (north, east) in the lot's frame as GNSS places it."""

    stalls: tuple[Detection, ...] = field(repr=False)
    seen: BaseGeometry = field(repr=False)


@dataclass(frozen=True, slots=True)
class PossiblePlace:
    """A place where a survey may lie on its lot: a shift, metres, a turn, radians clockwise, and how well it fits."""

    __pydantic_config__: ClassVar = ANSWER

    north: float
    east: float
    turn: float
    score: float


@dataclass(frozen=True, slots=True)
class Doubtful:
    """It is not certain where a survey lies. ``why``: a sentence; ``places`` to choose from, the best first."""

    why: str
    places: tuple[PossiblePlace, ...] = ()


Register = Callable[[KnownGround, MappedGround], Registration | Doubtful]
"""Finds a survey's stalls among those of a lot, by where they are. States must be no argument."""


@dataclass(frozen=True, slots=True)
class Saved:
    """Outcome of a save. ``lot``: UUID, None without one. ``candidates``: the lots that may be meant, by UUID.

    ``stalls``: how many the survey found, ``known`` of them are the lot's. ``doubt``: why it is unregistered.
    """

    seq: int
    survey: str
    lot: str | None
    lot_name: str
    placed: Placed
    candidates: tuple[str, ...] = ()
    stalls: int = 0
    known: int = 0
    doubt: str = ""
