"""One photograph's file as a shot."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from hawk.model.pictures import CameraModel, rotation
from hawk.picture.photographs import tags as said
from hawk.picture.photographs.exif import Exif, read_exif
from hawk.picture.photographs.jpeg_head import read_head
from hawk.picture.photographs.lenses import LensError, Lenses, calibrated
from hawk.picture.photographs.xmp import read_xmp
from hawk.picture.values import Shot

MOST_TILT_DEG: Final = 25.0
"""Off straight down: beyond it the far half of a picture is too coarse, and cars hide what stands behind them."""
_SIGMA_M: Final = (2.0, 3.0)
"""Standard deviation of a place whose file gives none: GNSS without corrections, horizontally and in height."""
_SAME_DEG: Final = 5e-4
"""Places of two tags that are farther apart, 50 m, are not one place in two forms."""
_DAMAGED: Final = "copy it again from the camera's card"
_SOURCES: Final = ("drone-dji:ImageSource", "drone:ImageSource")
_BANDS: Final = re.compile(r"LWIR|thermal|nir|infrared|red ?edge|monochrom", re.IGNORECASE)
_COLOURS: Final = frozenset(("red", "green", "blue"))
_THERMAL_MAKERS: Final = re.compile(r"flir|workswell|infratec", re.IGNORECASE)
_THERMAL_MODELS: Final = re.compile(r"\b(xt2|xtr?|zenmuse ?xt|vue|tau ?2|boson|altum-pt)\b", re.IGNORECASE)
_NAMES: Final = re.compile(r".*_(t|ir|thrm)\.jpe?g", re.IGNORECASE)
_MOST_THERMAL: Final = 1280 * 1024
"""Pixels of the largest thermal sensor on a drone; cameras for light have more."""
_OF_DRONE: Final = "use the drone's own files, as its card has them: messengers and editors take the tags out"


Place = tuple[float, float]


class UnusableError(ValueError):
    """A photograph cannot be mapped; the text is the reason with its remedy."""


@dataclass(frozen=True, slots=True)
class Photograph:
    """A shot, whose ``time`` is by the camera's clock, with what a folder is judged by.

    ``gnss_time``: Unix seconds, None where the file has no GNSS time. ``orientation``: EXIF's, 1 to 8. ``saved_by``:
    program that saved the file later than the camera, "" for none. ``zone_h``: that of the camera's clock, hours.
    ``other_place``: that of XMP, where it is not that of EXIF, which the shot has. ``has_hemisphere``: EXIF's place has
    its letters. ``serial``: number of the aircraft or its camera, "" where the file does not say.
    """

    shot: Shot
    gnss_time: float | None
    orientation: int
    saved_by: str = ""
    zone_h: float | None = None
    other_place: Place | None = None
    has_hemisphere: bool = True
    serial: str = ""

    @property
    def has_zone(self) -> bool:
        """True where the camera's clock has one."""
        return self.zone_h is not None

    @property
    def kind(self) -> tuple[str, int, int, float]:
        """Camera, width, height and focal length in widths, to a twentieth: pictures of one kind are of one lens."""
        camera = self.shot.camera
        return self.shot.model, camera.width, camera.height, round(20.0 * camera.fx / camera.width) / 20.0


def read_photograph(path: Path, lenses: Lenses, calibration: CameraModel | None = None) -> Photograph:
    """Return what a photograph's file says; only its head is read. ``calibration``: its lens, before every other.

    Raises UnusableError for a file that is no whole JPEG, says no place, looks elsewhere than down or is of a lens that
    nothing describes; PictureError without Pillow.
    """
    try:
        head = read_head(path)
        exif = read_exif(head.exif, max(head.size))
        tags = read_xmp(head.xmp)
    except ValueError as error:
        raise UnusableError(f"{error}; {_DAMAGED}") from None
    except OSError as error:
        raise UnusableError(f"cannot be read ({error.strerror or error}); {_DAMAGED}") from None
    if light := other_light(path.name, tags, exif, head.size):
        raise UnusableError(f"{light}: stalls are found in pictures of a camera for light alone; take it away")
    latitude, longitude = place = _place(tags, exif)
    attitude, has_yaw = _attitude(tags, exif.make)
    camera, is_known = _lens(tags, exif, head.size, lenses, calibration)
    across, up = said.sigma(tags)
    across = across or exif.error_m
    return Photograph(
        Shot(
            path=path,
            camera=camera,
            latitude=latitude,
            longitude=longitude,
            altitude=exif.altitude if exif.altitude is not None else said.altitude(tags),
            height=said.height(tags),
            attitude=attitude,
            sigma=(across or _SIGMA_M[0], up or _SIGMA_M[1]),
            time=exif.clock,
            model=f"{exif.make} {exif.model}".strip(),
            lens_is_known=is_known,
            yaw_is_sure=has_yaw and not exif.saved_by,
            has_gimbal=said.has_gimbal(tags),
            velocity=said.velocity(tags),
            line_s=said.line_s(tags),
            sigma_is_said=across is not None,
        ),
        exif.gnss,
        exif.orientation,
        exif.saved_by,
        exif.zone_h,
        _other(place, said.place(tags)),
        exif.has_hemisphere,
        said.serial(tags) or exif.serial,
    )


def other_light(name: str, tags: Mapping[str, str], exif: Exif, size: tuple[int, int]) -> str:
    """Return what a photograph shows in place of light that people see, "" where nothing says so.

    Thermal pictures and single bands of multispectral cameras show temperatures or one band, in which lines of paint
    and cars look other than the network knows them. What names such a picture is one of: DJI's ``ImageSource``;
    Pix4D's ``Camera:BandName``; the maker; a name as DJI gives it (``DJI_0001_T.JPG``) beside the size of a thermal
    sensor.
    """
    source = next((tags[tag] for tag in _SOURCES if tag in tags), "")
    if "infrared" in source.casefold() or "thermal" in source.casefold():
        return "is thermal (infrared)"
    band = [part.strip() for part in tags.get("Camera:BandName", "").split(",") if part.strip()]
    if any(_BANDS.search(part) for part in band) or (len(band) == 1 and band[0].casefold() in _COLOURS):
        return f"is the band {', '.join(band)} alone, no picture in colours"
    is_small = size[0] * size[1] <= _MOST_THERMAL
    if is_small and (_THERMAL_MAKERS.search(exif.make) or _THERMAL_MODELS.search(exif.model)):
        return f"is thermal (infrared), by a {exif.make} {exif.model}".rstrip()
    if is_small and not source and exif.make and _NAMES.fullmatch(name):
        return "is thermal (infrared), by its name and size"
    return ""


def tilt_deg(attitude: tuple[float, float, float]) -> float:
    """Return the angle between the camera's axis and straight down, degrees."""
    return math.degrees(math.acos(max(-1.0, min(1.0, float(rotation(*attitude)[2, 2])))))


def _attitude(tags: said.Tags, make: str) -> tuple[said.Attitude | None, bool]:
    """Return the attitude by the tags, and whether they say its yaw. Raises UnusableError for an oblique one."""
    found = said.attitude(tags, make)
    attitude = found or said.tilt_alone(tags, make)
    if attitude is not None and (tilt := tilt_deg(attitude)) > MOST_TILT_DEG:
        raise UnusableError(
            f"looks {tilt:.0f} degrees off straight down, more than {MOST_TILT_DEG:.0f}; turn the camera down, to -90"
        )
    return attitude, found is not None


def _place(tags: said.Tags, exif: Exif) -> tuple[float, float]:
    places = [(exif.latitude, exif.longitude), said.place(tags) or (None, None)]
    for latitude, longitude in places:
        if latitude is None or longitude is None or not (abs(latitude) <= 90 and abs(longitude) <= 180):
            continue
        if (latitude, longitude) != (0.0, 0.0):  # without a fix drones write zeros
            return latitude, longitude
    raise UnusableError(f"has no GPS place; {_OF_DRONE}")


def _other(place: Place, by_xmp: Place | None) -> Place | None:
    """Return the place of XMP where it is one, and another one than EXIF's."""
    if by_xmp is None or not (abs(by_xmp[0]) <= 90 and abs(by_xmp[1]) <= 180) or by_xmp == (0.0, 0.0):
        return None
    apart = math.hypot(
        by_xmp[0] - place[0], math.remainder(by_xmp[1] - place[1], 360.0) * math.cos(math.radians(place[0]))
    )
    return by_xmp if apart > _SAME_DEG else None


def _lens(
    tags: said.Tags, exif: Exif, size: tuple[int, int], lenses: Lenses, calibration: CameraModel | None
) -> tuple[CameraModel, bool]:
    try:
        if calibration is not None:
            return calibrated(calibration, size, "whole photographs"), True
        return lenses.of(tags, exif, size)
    except LensError as error:
        raise UnusableError(str(error)) from None
