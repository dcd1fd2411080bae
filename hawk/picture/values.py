"""Values of a survey by pictures: shots with their places, what was mapped, what was left out."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from hawk.exports.ground import Ground
from hawk.exports.values import ExportRecord, Observation
from hawk.lots.survey.landing import LandingFacts
from hawk.lots.survey.source import Limit, PictureSource, SourceKind
from hawk.lots.values import fitting_name
from hawk.model.pictures import CameraModel
from hawk.model.plans import Outline

COARSEST_M: Final = 0.20
"""Metres a pixel from which stalls cannot be found well."""
COARSE_M: Final = 0.12
"""The same from which fewer are found."""
_PROJECTED: Final = 1.02
"""Ground of a pixel is measured on the ellipsoid: a projection's 20 cm are up to 2 % more or less of it."""
Progress = Callable[[str, int, int], None]
"""Takes the step under way, how much of it is done, and of how much."""
NO_STALLS: Final = "it has no stalls"
"""Doubt of a survey that makes no lot."""
_FEW: Final = 4
"""Names that a sentence lists."""


def list_names(names: Sequence[str]) -> str:
    """Return names for a sentence: the first ones, and how many more there are."""
    rest = len(names) - _FEW
    return ", ".join(names[:_FEW]) + (f" and {rest} more" if rest > 0 else "")


class PictureError(ValueError):
    """A source cannot be mapped; the text names the file or field, and the remedy."""


def cannot_write(path: Path, error: OSError) -> str:
    """Return why a result of the work cannot be kept, with the remedy."""
    return (
        f"{path}: cannot be written ({error.strerror or error}); see that there is room and that this user may write "
        "there, and go on by --resume"
    )


def of_model(error: Exception) -> PictureError:
    """Return the error of a network that cannot be used, which names the option in place of the setting."""
    return PictureError(str(error).replace("vision.model", "--model", 1))


@dataclass(frozen=True, slots=True)
class Shot:
    """A picture from the air with what its file says.

    ``camera``: its lens for the picture's own pixels, as the sensor gave them (EXIF's orientation is not applied), with
    a mount of zero. ``latitude``, ``longitude``: degrees, WGS-84. ``altitude``: metres above sea or ellipsoid.
    ``height``: metres above the take-off place. ``attitude``: roll, pitch and yaw (radians) as `MapPose` has them: at
    zero the camera looks straight down with the picture's top to the north. ``sigma``: standard deviation of the place,
    horizontally and in height, metres. ``time``: Unix seconds of the exposure; by the camera's own clock where no GNSS
    time is written. None: the file does not say. ``lens_is_known``: not guessed.
    ``yaw_is_sure``: False where another program than the camera saved the file: it may have turned the picture by
    quarter turns, and the tags stayed. ``has_gimbal``: the angles are the camera's; without one they are the
    aircraft's, which sways. ``velocity``: metres a second north and east; ``line_s``: seconds between two lines of the
    picture that are read out, 0 where it is not known. ``frame``: number of the frame, from 0, where ``path`` is a
    film. ``sigma_is_said``: the file gives the horizontal one; else it is what such receivers err by, or against each
    other.
    """

    path: Path
    camera: CameraModel
    latitude: float
    longitude: float
    altitude: float | None
    height: float | None
    attitude: tuple[float, float, float] | None
    sigma: tuple[float, float]
    time: float | None
    model: str = ""
    lens_is_known: bool = True
    yaw_is_sure: bool = True
    has_gimbal: bool = True
    velocity: tuple[float, float] = (0.0, 0.0)
    line_s: float = 0.0
    frame: int | None = None
    sigma_is_said: bool = False

    @property
    def latitude_longitude(self) -> tuple[float, float]:
        """The place, degrees."""
        return self.latitude, self.longitude

    @property
    def name(self) -> str:
        """Name of the file, with the number of the frame of a film."""
        return self.path.name if self.frame is None else f"{self.path.name}, frame {self.frame}"


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A picture or window that is not mapped: its name, and the reason with its remedy."""

    name: str
    reason: str


@dataclass(frozen=True, slots=True)
class ShotSet:
    """Shots of one flight in order of time, each with a height, or none where the files say none.

    ``notes``: sentences on what a person must know. ``time_is_sure``: all times are GNSS's, or of clocks whose zone the
    files say.
    """

    shots: tuple[Shot, ...]
    left_out: tuple[LeftOut, ...] = ()
    notes: tuple[str, ...] = ()
    time_is_sure: bool = False


@dataclass(frozen=True, slots=True)
class FlightId:
    """Identity of a flight whose pictures may arrive in parts: its survey with more of them replaces the former one.

    ``name``: for its lot. ``datum``: latitude and longitude of the survey's frame, degrees; None: the pictures' middle.
    """

    id: str
    name: str
    datum: tuple[float, float] | None


@dataclass(frozen=True, slots=True)
class Provenance:
    """Origin of pictures: the ``name`` of their folder or file, and its kind.

    ``title``: name of the lot that a person gave, "" for that of the pictures. ``ended``: moment of the last picture
    that a person says, Unix seconds; None: as the files say it, and not ``time_is_sure`` by a clock that a person set
    and whose zone is not known. ``height_m``: above the ground, that a person gave. ``flight``: None where the pictures
    themselves say which survey it is.
    """

    name: str
    kind: SourceKind
    time_is_sure: bool = False
    height_m: float | None = None
    title: str = ""
    ended: float | None = None
    flight: FlightId | None = None

    @property
    def own_name(self) -> str:
        """Name of the folder, or of the file without its ending, as far as it can be shown."""
        name = self.name if self.kind is SourceKind.PHOTOGRAPHS else Path(self.name).stem
        return fitting_name(name) or self.kind.value

    @property
    def lot(self) -> str:
        """Name of the lot: a person's, else that of the pictures."""
        return self.title or self.own_name

    def moment(self, ended: float) -> tuple[float, bool]:
        """Return the moment of the last picture, which files say as ``ended``, and whether it is sure."""
        return (ended, self.time_is_sure) if self.ended is None else (self.ended, True)

    def source(self, limits: Sequence[Limit] = ()) -> PictureSource:
        """Return the source of a survey, with what limits it."""
        return PictureSource(self.kind, fitting_name(self.name) or self.kind.value, tuple(limits))


@dataclass(frozen=True, slots=True)
class SampleWindow:
    """A square of a picture for checking by eye.

    ``counts``: what the program counts in it, by name; ``doubt``: sum of the chances that its stalls are none or have
    another state. ``ring``: its corners, (latitude, longitude), degrees.
    """

    number: int
    name: str
    counts: Mapping[str, int]
    doubt: float
    ring: tuple[tuple[float, float], ...] = field(repr=False)


class CheckSample(Protocol):
    """The windows of a mapped picture."""

    @property
    def identity(self) -> str:
        """Text that is the same for the same findings."""
        ...

    def windows(self) -> tuple[SampleWindow, ...]:
        """Return all windows, in order."""
        ...

    def picture(self, window: SampleWindow) -> NDArray[np.uint8]:
        """Return a window's picture, BGR. Raises PictureError."""
        ...


@dataclass(frozen=True, slots=True)
class PictureSurvey:
    """A survey by pictures: as files have it, and ``landed``, as the store takes one after a flight.

    ``ground``: its picture in the frame of the survey's origin, None where none is drawn. ``area_m2``: ground that was
    seen. ``crs``: that of the source as PROJ or GDAL name it (``EPSG:28992``), "" for WGS-84. ``notes``: sentences on
    what a reader must know, such as a coarse scale. Its source with what limits it is ``survey.pictures``. ``lots``:
    those of its outlines, None where there are not several; it is the survey of all of them then. ``sample``: windows
    for checking it by eye, None where there are none; ``checked``: totals by such windows, as values of JSON.
    """

    survey: ExportRecord
    landed: LandingFacts = field(repr=False)
    ground: Ground | None = field(repr=False)
    area_m2: float
    crs: str = ""
    left_out: tuple[LeftOut, ...] = ()
    notes: tuple[str, ...] = ()
    lots: LotSurveys | None = field(default=None, repr=False, compare=False)
    sample: CheckSample | None = field(default=None, repr=False, compare=False)
    checked: Mapping[str, Any] | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class LotFacts:
    """A lot as a file of outlines says it.

    ``id``: the feature's own, else by name and place. ``name``: ``is_named`` by the file, else by its number there.
    ``tags``: what else the file says, by the names of its properties. ``capacity``: places that it gives; None: none.
    """

    id: str
    name: str
    is_named: bool = False
    tags: tuple[tuple[str, str], ...] = ()
    capacity: int | None = None


@dataclass(frozen=True, slots=True)
class LotSurvey:
    """The survey of one lot of several outlines.

    ``unseen_share``: of its outline, that was not seen. ``unsure``: mean chance, by the network, that a stall is none
    or has another state; None without stalls. ``doubts``: sentences on why its count may be wrong. ``vehicles``: how
    many are found in it, and the least and most of their interval; None of a network that finds none.
    """

    facts: LotFacts
    mapped: PictureSurvey
    unseen_share: float
    unsure: float | None
    doubts: tuple[str, ...] = ()
    vehicles: tuple[int, int, int] | None = None


class LotSurveys(Protocol):
    """Surveys of lots, made one after the other: the pictures of all need more memory than there is."""

    def __len__(self) -> int:
        """Return the number of lots."""

    def __iter__(self) -> Iterator[LotSurvey]:
        """Make the surveys, in the order of their names."""


def id_of(place: str) -> str:
    """Return the id that a lot or survey has wherever it is mapped, by a text that names it alone."""
    return str(uuid.uuid5(uuid.NAMESPACE_URL, place))


def export_survey(
    landed: LandingFacts, ids: tuple[str, str], outline: Outline, stalls: tuple[Observation, ...]
) -> ExportRecord:
    """Return a survey as files have it: ``ids`` of its lot and its own, ``outline`` of the lot, its ``stalls``."""
    return ExportRecord(
        lot=landed.title,
        lot_id=ids[0] if stalls else "",
        survey=ids[1],
        began=landed.utc - landed.flown_s,
        ended=landed.utc,
        time_is_sure=landed.time_is_sure,
        layout=None,
        software=f"hawk-drone {landed.program}",
        is_simulated=False,
        accuracy=landed.accuracy,
        is_pinned=False,
        origin=(landed.datum.latitude, landed.datum.longitude),
        outline=outline,
        stalls=stalls,
        doubt="" if stalls else NO_STALLS,
        pictures=landed.pictures,
    )


def is_coarser(metres: float, limit: float) -> bool:
    """Return True for a pixel of more ground, metres, than a limit allows, beyond what a projection's scale makes."""
    return metres > limit * _PROJECTED
