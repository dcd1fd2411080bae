"""Lenses of photographs: of calibrated tags, of a table of sensors, of EXIF.

The first source that knows a plausible lens is taken: a person's table, the maker's calibration, our table, the focal
plane's resolution. Else the first that guesses one: a table whose sensor has another shape than the picture, the focal
length on 35 mm film.

- DJI: `DewarpData` is date; fx, fy, cx, cy, k1, k2, p1, p2, k3, the centre from that of the calibration, pixels
  (github.com/dronemapper-io/dji-dewarp); `DewarpFlag` 1: the camera took the distortion out already.
- Skydio: `CalibratedFocalLength` and `CalibratedOpticalCenter`, pixels, `DewarpData` k1, k2, k3 (its article
  4417425974683).
- Pix4D: lengths in millimetres from the corner of the first pixel, distortion R1, R2, R3, T1, T2 (its article
  360016450032).
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Final

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from hawk.algo.vision.rectify import scaled_camera
from hawk.model.pictures import CameraModel
from hawk.picture.photographs.exif import Exif
from hawk.picture.photographs.xmp import number, numbers
from hawk.picture.values import PictureError

_DJI, _SKYDIO = "drone-dji:", "drone-skydio:"
_PLAUSIBLE: Final = (0.35, 15.0)
"""Focal lengths in longer sides of the picture: 110 degrees wide, and a tele lens that no survey needs."""
_FILM_DIAGONAL_MM: Final = math.hypot(36.0, 24.0)
_WIDE: Final = 1.6
"""A picture that is wider for its height is cut from a sensor of 4:3 at its full width."""
_SAME_SHAPE: Final = 0.01
"""Share by which the scales of a picture's sides against its calibration may differ."""
_SAME_SENSOR: Final = 0.02
"""Share by which a picture's shape, or its pixels' pitch, may differ from its sensor's: makers round both."""
REMEDY: Final = "describe its lens by --lenses FILE, or calibrate it and name the result by --calibration"

Positive = Annotated[float, Field(gt=0.0, le=200.0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Count = Annotated[int, Field(gt=0)]


class LensError(ValueError):
    """Nothing says how a photograph's lens draws; the text names what lacks, and the remedy."""


class LensEntry(BaseModel):
    """A camera in a table of lenses. ``model`` is EXIF's, with or without the maker before it, or Pix4D's rig name.

    ``sensor_width_mm``: covered by the picture's longer side; with ``sensor_pixels``, by that of a whole picture, which
    has as many pixels by its longer and its shorter side. ``film_width_mm``: covered by a film's longer side.
    ``focal_mm``: where EXIF lacks it. ``distortion``: k1, k2, p1, p2, k3. ``source``: of the numbers.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    model: str = Field(min_length=1)
    sensor_width_mm: Positive
    sensor_pixels: tuple[Count, Count] | None = None
    film_width_mm: Positive | None = None
    focal_mm: Positive | None = None
    distortion: tuple[Finite, Finite, Finite, Finite, Finite] | None = None
    source: str = ""

    def per_mm(self, size: tuple[int, int]) -> tuple[float, bool]:
        """Return how many pixels of a picture of this size a millimetre of the sensor has, and whether that is known.

        A picture of another shape than the sensor's is cut from it, as large as it allows. That is a guess, unless the
        pixels then are the sensor's own.
        """
        longer, shorter = max(size), min(size)
        across = longer / self.sensor_width_mm
        if self.sensor_pixels is None:
            return across, True
        whole_longer, whole_shorter = max(self.sensor_pixels), min(self.sensor_pixels)
        own = whole_longer / self.sensor_width_mm
        down = own * shorter / whole_shorter
        found = max(across, down)
        is_whole = abs(across / down - 1.0) <= _SAME_SENSOR
        return found, is_whole or abs(found / own - 1.0) <= _SAME_SENSOR


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid")

    lens: list[LensEntry]


class Lenses:
    """Two tables of cameras: a person's, which goes before every tag, and hawk's own."""

    def __init__(self, own: Path | None = None) -> None:
        """Read the tables. Raises PictureError naming the file, the field and the remedy."""
        shipped = files("hawk.picture.photographs").joinpath("lenses.toml").read_text(encoding="utf-8")
        self._shipped = _by_model(_read(shipped, "lenses.toml"))
        self._own = {} if own is None else _by_model(_read(_text(own), str(own)))

    def of(self, tags: Mapping[str, str], exif: Exif, size: tuple[int, int]) -> tuple[CameraModel, bool]:
        """Return the lens of a picture of this size (width, height), and whether it is known, not guessed.

        Raises LensError.
        """
        guess: CameraModel | None = None
        for camera, is_known in self._candidates(tags, exif, size):
            if camera is not None and _is_plausible(camera):
                if is_known:
                    return camera, True
                guess = guess or camera
        if guess is not None:
            return guess, False
        name = f"{exif.make} {exif.model}".strip() or "camera"
        if tags.get("Camera:ModelType", "").lower() == "fisheye":
            raise LensError(f"was taken by a fisheye lens ({name}), whose tags give no pinhole; {REMEDY}")
        raise LensError(f"gives no focal length that can be used ({name}); {REMEDY}")

    def of_film(self, model: str, size: tuple[int, int]) -> tuple[CameraModel, bool]:
        """Return the lens of a film of this size (width, height), and whether the table knows a film's width.

        Raises LensError for a camera that no table has, or without its focal length.
        """
        entries = [_entry(table, (model,)) for table in (self._own, self._shipped)]
        entry = next((each for each in entries if each is not None and each.focal_mm is not None), None)
        if entry is None:
            raise LensError(f"no table gives the focal length of {model}; {REMEDY}")
        per_mm = entry.per_mm(size)[0] if entry.film_width_mm is None else max(size) / entry.film_width_mm
        camera = _pinhole(size, entry.focal_mm, per_mm, 1.0, entry.distortion or ())
        if camera is None or not _is_plausible(camera):
            raise LensError(f"the table gives no focal length of {model} that can be used; {REMEDY}")
        return camera, entry.film_width_mm is not None

    def _candidates(
        self, tags: Mapping[str, str], exif: Exif, size: tuple[int, int]
    ) -> Iterator[tuple[CameraModel | None, bool]]:
        names = (exif.model, f"{exif.make} {exif.model}", tags.get("Camera:RigName", ""))
        own, shipped = (_entry(table, names) for table in (self._own, self._shipped))
        yield _of_entry(own, exif, size)
        yield _zoomed(_dji(tags, size), exif.zoom), True
        yield _zoomed(_skydio(tags, size), exif.zoom), True
        by_plane = None if exif.sensor_mm is None else max(size) / exif.sensor_mm
        entry = own or shipped
        per_mm, is_known = (by_plane, True) if entry is None else entry.per_mm(size)
        yield _zoomed(_pix4d(tags, per_mm, size), exif.zoom), is_known
        yield _of_entry(shipped, exif, size)
        yield _pinhole(size, exif.focal_mm, by_plane, exif.zoom), True
        yield _of_film(exif, size), False


def _is_plausible(camera: CameraModel) -> bool:
    return _PLAUSIBLE[0] <= camera.fx / max(camera.width, camera.height) <= _PLAUSIBLE[1]


def _read(text: str, name: str) -> list[LensEntry]:
    try:
        return _Table.model_validate(tomllib.loads(text)).lens
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise PictureError(f"{name} is no TOML ({error}); docs/photographs.md shows a table of lenses") from None
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        raise PictureError(f"{name}: {field}: {first['msg']}; docs/photographs.md shows a table of lenses") from None


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise PictureError(f"{path} cannot be read ({error}); name a table of lenses (TOML)") from None


def _by_model(entries: list[LensEntry]) -> dict[str, LensEntry]:
    return {_plain(entry.model): entry for entry in entries}


def _plain(model: str) -> str:
    return " ".join(model.casefold().split())


def _entry(table: Mapping[str, LensEntry], names: tuple[str, ...]) -> LensEntry | None:
    return next((table[_plain(name)] for name in names if name and _plain(name) in table), None)


def _of_entry(entry: LensEntry | None, exif: Exif, size: tuple[int, int]) -> tuple[CameraModel | None, bool]:
    if entry is None:
        return None, True
    per_mm, is_known = entry.per_mm(size)
    return _pinhole(size, exif.focal_mm or entry.focal_mm, per_mm, exif.zoom, entry.distortion or ()), is_known


def _pinhole(
    size: tuple[int, int],
    focal_mm: float | None,
    per_mm: float | None,
    zoom: float,
    distortion: tuple[float, ...] = (),
) -> CameraModel | None:
    if focal_mm is None or per_mm is None:
        return None
    width, height = size
    focal = focal_mm * per_mm * zoom
    return CameraModel(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2, distortion)


def _of_film(exif: Exif, size: tuple[int, int]) -> CameraModel | None:
    """Return the lens by the focal length on 35 mm film, which CIPA (DCG-001) takes by the diagonal."""
    longer, shorter = max(size), min(size)
    diagonal = math.hypot(longer, 0.75 * longer if longer > _WIDE * shorter else shorter)
    return _pinhole(size, exif.focal_35_mm, diagonal / _FILM_DIAGONAL_MM, exif.zoom)


def _dji(tags: Mapping[str, str], size: tuple[int, int]) -> CameraModel | None:
    width, height = size
    centre_x = number(tags, f"{_DJI}CalibratedOpticalCenterX") or width / 2
    centre_y = number(tags, f"{_DJI}CalibratedOpticalCenterY") or height / 2
    data = tags.get(f"{_DJI}DewarpData", "").partition(";")[2]
    dewarp = numbers({"": data}, "")
    if len(dewarp) == 9 and dewarp[0] > 0 and dewarp[1] > 0:
        fx, fy, from_x, from_y, *bent = dewarp
        is_straight = tags.get(f"{_DJI}DewarpFlag", "0").strip() == "1"
        camera = CameraModel(
            round(2 * centre_x),
            round(2 * centre_y),
            fx,
            fy,
            centre_x + from_x - 0.5,
            centre_y + from_y - 0.5,
            () if is_straight else tuple(bent),
        )
        return _at(camera, size)
    focal = number(tags, f"{_DJI}CalibratedFocalLength")
    if focal is None:
        return None
    whole = round(2 * centre_x), round(2 * centre_y)
    return _at(CameraModel(*whole, focal, focal, centre_x - 0.5, centre_y - 0.5), size)


def _skydio(tags: Mapping[str, str], size: tuple[int, int]) -> CameraModel | None:
    fx, fy, cx, cy = (
        number(tags, f"{_SKYDIO}{name}/{_SKYDIO}{axis}", f"{_SKYDIO}{name}{axis}")
        for name in ("CalibratedFocalLength", "CalibratedOpticalCenter")
        for axis in ("X", "Y")
    )
    if fx is None or cx is None or cy is None:
        return None
    k1, k2, k3 = (*numbers(tags, f"{_SKYDIO}DewarpData")[:3], 0.0, 0.0, 0.0)[:3]
    whole = round(2 * cx + 1), round(2 * cy + 1)
    return _at(CameraModel(*whole, fx, fy or fx, cx, cy, (k1, k2, 0.0, 0.0, k3)), size)


def _pix4d(tags: Mapping[str, str], per_mm: float | None, size: tuple[int, int]) -> CameraModel | None:
    focal = number(tags, "Camera:PerspectiveFocalLength")
    if focal is None or per_mm is None:
        return None
    longer, shorter = max(size), min(size)
    centre = numbers(tags, "Camera:PrincipalPoint")
    cx, cy = (value * per_mm - 0.5 for value in centre) if len(centre) == 2 else ((longer - 1) / 2, (shorter - 1) / 2)
    bent = numbers(tags, "Camera:PerspectiveDistortion")
    r1, r2, r3, t1, t2 = bent if len(bent) == 5 else (0.0,) * 5
    distortion = (r1, r2, t1, t2, r3) if bent else ()
    return _at(CameraModel(longer, shorter, focal * per_mm, focal * per_mm, cx, cy, distortion), size)


def _zoomed(camera: CameraModel | None, zoom: float) -> CameraModel | None:
    """Return a maker's lens for a picture that is the middle of the sensor's, at its full size: digital zoom."""
    if camera is None or zoom == 1.0:
        return camera
    middle = (camera.width - 1) / 2, (camera.height - 1) / 2
    return replace(
        camera,
        fx=camera.fx * zoom,
        fy=camera.fy * zoom,
        cx=middle[0] + (camera.cx - middle[0]) * zoom,
        cy=middle[1] + (camera.cy - middle[1]) * zoom,
    )


def _at(camera: CameraModel, size: tuple[int, int]) -> CameraModel | None:
    """Return a maker's lens at another size of its shape, or for a picture that was turned by a quarter."""
    return scaled(camera, size) or scaled(_turned(camera), size)


def _turned(camera: CameraModel) -> CameraModel:
    """Return the lens of a picture turned by a quarter, to a side that nothing says: only what both have alike."""
    width, height = camera.height, camera.width
    k1, k2, _, _, k3 = (*camera.distortion, *(0.0,) * 5)[:5]
    bent = (k1, k2, 0.0, 0.0, k3) if camera.distortion else ()
    return CameraModel(width, height, camera.fy, camera.fx, (width - 1) / 2, (height - 1) / 2, bent)


def calibrated(calibration: CameraModel, size: tuple[int, int], pictures: str) -> CameraModel:
    """Return a calibrated lens, without its mount, for a picture of this size (width, height).

    Raises LensError, which says by which ``pictures`` to calibrate the camera, for a picture of another shape.
    """
    camera = scaled(replace(calibration, mount_roll=0.0, mount_pitch=0.0, mount_yaw=0.0), size)
    if camera is None:
        shape = f"{calibration.width} x {calibration.height}"
        raise LensError(f"is {size[0]} x {size[1]} pixels, its calibration {shape}: calibrate the camera by {pictures}")
    return camera


def scaled(camera: CameraModel, size: tuple[int, int]) -> CameraModel | None:
    """Return a lens for the same picture at another size (width, height); None where the shape differs: it was cut."""
    across, down = size[0] / camera.width, size[1] / camera.height
    if abs(across / down - 1.0) > _SAME_SHAPE:
        return None
    return scaled_camera(camera, *size)
