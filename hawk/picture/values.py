"""Values of a survey by pictures: shots with their places, what was mapped, what was left out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from hawk.exports.ground import Ground
from hawk.exports.values import ExportRecord
from hawk.model.pictures import CameraModel

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


def named(names: Sequence[str]) -> str:
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
class Mapped:
    """A survey by pictures.

    ``ground``: its picture in the frame of the survey's origin, None where none is drawn. ``area_m2``: ground that was
    seen. ``crs``: that of the source as PROJ or GDAL name it (``EPSG:28992``), "" for WGS-84. ``notes``: sentences on
    what a reader must know, such as a coarse scale. ``scores``: the probability that each of the survey's stalls is
    one; empty where it is not known. Its source with what limits it is ``survey.pictures``.
    """

    survey: ExportRecord
    ground: Ground | None = field(repr=False)
    area_m2: float
    crs: str = ""
    left_out: tuple[LeftOut, ...] = ()
    notes: tuple[str, ...] = ()
    scores: tuple[float, ...] = field(default=(), repr=False)


def is_coarser(metres: float, limit: float) -> bool:
    """Return True for a pixel of more ground, metres, than a limit allows, beyond what a projection's scale makes."""
    return metres > limit * _PROJECTED
