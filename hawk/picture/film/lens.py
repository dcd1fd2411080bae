"""A film's lens: calibrated, by its field of view, of the table of cameras, or by its focal length on 35 mm film."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from hawk.model.pictures import CameraModel
from hawk.picture.photographs.exif import Exif
from hawk.picture.photographs.lenses import LensError, Lenses, calibrated
from hawk.picture.values import PictureError

_VIEW_DEG: Final = (5.0, 160.0)
_FOCAL_MM: Final = (8.0, 500.0)
_ZOOMED: Final = 1.01
REMEDY: Final = (
    "give its field of view across by --hfov DEGREES or its focal length on 35 mm film by --focal35 MM, or calibrate "
    "the camera and name the result by --calibration"
)


@dataclass(frozen=True, slots=True)
class LensChoice:
    """A person's word on a film's lens; the first that is given counts.

    ``calibration``: by films of this camera. ``hfov_deg``: field of view across the film's picture, degrees.
    ``focal35_mm``: focal length on 35 mm film. ``lenses``: a table that adds to hawk's own. ``model``: the camera's
    name in a table, where the film does not say it.
    """

    calibration: CameraModel | None = None
    hfov_deg: float | None = None
    focal35_mm: float | None = None
    lenses: Path | None = None
    model: str = ""


@dataclass(frozen=True, slots=True)
class FilmLens:
    """A lens, whether it is known and not guessed, and sentences on it."""

    camera: CameraModel
    is_known: bool
    notes: tuple[str, ...] = ()


def lens_of(
    name: str, size: tuple[int, int], choice: LensChoice, model: str, focal_mm: float | None, zoom: float
) -> FilmLens:
    """Return the lens of a film whose picture is ``size`` (width, height).

    Args:
        name: Of the film.
        size: Width and height.
        choice: A person's word on it.
        model: Camera by the film's file, "" where it does not say.
        focal_mm: On 35 mm film by the captions, None where they do not say.
        zoom: Largest digital zoom by the captions.

    Raises:
        PictureError: Nothing says how the lens draws, or a given value cannot be one.
    """
    if choice.calibration is not None:
        try:
            return FilmLens(calibrated(choice.calibration, size, "a film's frames"), True)
        except LensError as error:
            raise PictureError(f"{name}: {error}") from None
    if choice.hfov_deg is not None:
        if not _VIEW_DEG[0] <= choice.hfov_deg <= _VIEW_DEG[1]:
            raise PictureError(f"--hfov {choice.hfov_deg:g}: must be {_VIEW_DEG[0]:g} to {_VIEW_DEG[1]:g} degrees")
        return FilmLens(_pinhole(size, size[0] / 2 / math.tan(math.radians(choice.hfov_deg) / 2)), False)
    if choice.focal35_mm is not None:
        if not _FOCAL_MM[0] <= choice.focal35_mm <= _FOCAL_MM[1]:
            raise PictureError(f"--focal35 {choice.focal35_mm:g}: must be {_FOCAL_MM[0]:g} to {_FOCAL_MM[1]:g} mm")
        return FilmLens(_of_film(size, choice.focal35_mm, f"--focal35 {choice.focal35_mm:g}: is"), False)
    if zoom > _ZOOMED:
        raise PictureError(f"{name}: was taken with a digital zoom of {zoom:.2f}; {REMEDY}")
    found = _of_table(size, choice, model)
    if found is not None:
        return found
    if focal_mm is not None and _FOCAL_MM[0] <= focal_mm <= _FOCAL_MM[1]:
        note = (
            f"The lens is guessed from its focal length on 35 mm film, {focal_mm:.1f} mm by the captions; films are "
            "often cut from the middle of the sensor: --hfov or --calibration knows it better"
        )
        words = f"{name}: its captions give a focal length on 35 mm film of {focal_mm:g} mm,"
        return FilmLens(_of_film(size, focal_mm, words), False, (note,))
    raise PictureError(f"{name}: nothing says how its lens draws; {REMEDY}")


def _of_table(size: tuple[int, int], choice: LensChoice, model: str) -> FilmLens | None:
    """Return the lens of a table whose entry gives a focal length; films that are cut from the sensor err."""
    named = choice.model or model
    if not named:
        return None
    try:
        camera, is_known = Lenses(choice.lenses).of_film(named, size)
    except LensError:
        return None
    note = f"The lens is that of {named} over the whole width of its sensor; a film that is cut from it needs --hfov"
    return FilmLens(camera, is_known, () if is_known else (note,))


def _of_film(size: tuple[int, int], focal_mm: float, words: str) -> CameraModel:
    """Return the lens by the focal length on 35 mm film, as that of photographs.

    Raises PictureError, which begins with these words, for one that no pinhole has.
    """
    try:
        return Lenses().of({}, Exif(focal_35_mm=focal_mm), size)[0]
    except LensError:
        raise PictureError(f"{words} wider or narrower than every lens that can be mapped; {REMEDY}") from None


def _pinhole(size: tuple[int, int], focal: float) -> CameraModel:
    return CameraModel(*size, focal, focal, (size[0] - 1) / 2, (size[1] - 1) / 2)
