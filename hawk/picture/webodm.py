"""A project of OpenDroneMap or WebODM as a source: its orthophoto, its photographs with their poses.

``odm_report/shots.geojson`` has a point a photograph: longitude, latitude, altitude, and ``filename``, ``width``,
``height``, ``focal``; ``translation`` is its camera's place in the project's own projection, ``rotation`` the vector
(Rodrigues) that turns east, north, up of that projection into the camera's right, down, ahead (OpenDroneMap,
`opendm/shots.py`). ``cameras.json`` has OpenSfM's lenses: lengths by the longer side of the picture, from its middle
(https://opensfm.org/docs/geometry.html).
"""

from __future__ import annotations

import cmath
import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Final

import cv2
import numpy as np
import pymap3d
from numpy.typing import NDArray
from pydantic import BaseModel, Field, ValidationError

from hawk.formats import gdal
from hawk.formats.validation import first_wrong
from hawk.model.pictures import CAMERA_TO_BODY, CameraModel, angles
from hawk.picture.photographs.heights import assign_heights
from hawk.picture.photographs.lenses import Lenses
from hawk.picture.photographs.photograph import MOST_TILT_DEG, UnusableError, read_photograph, tilt_deg
from hawk.picture.values import LeftOut, PictureError, Shot, ShotSet
from hawk.runtime.programs import remedy

ORTHOPHOTO: Final = Path("odm_orthophoto/odm_orthophoto.tif")
SHOTS: Final = Path("odm_report/shots.geojson")
CAMERAS: Final = Path("cameras.json")
IMAGES: Final = Path("images")
_GROUND: Final = (Path("odm_dem/dtm.tif"), Path("odm_dem/dsm.tif"))
_MARKS: Final = (ORTHOPHOTO, SHOTS, Path("opensfm"), Path("odm_georeferencing"), Path("odm_texturing"))
_EAST_NORTH_UP: Final = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
"""Turns east, north, up into north, east, down."""
_SIGMA_M: Final = (0.5, 0.5)
"""Of places that OpenDroneMap adjusted, against each other."""
_SPREAD_M: Final = 20.0
"""Photographs that lie farther from their middle than this say how the projection's north is turned."""
_RERUN: Final = "process the project again, or map its folder of photographs"

Finite = Annotated[float, Field(allow_inf_nan=False)]
Vector = tuple[Finite, Finite, Finite]


class _Properties(BaseModel):
    filename: str = Field(min_length=1)
    width: int = Field(gt=0)
    height: int = Field(gt=0)
    focal: Finite | None = Field(default=None, gt=0)
    camera: str = ""
    translation: Vector
    rotation: Vector
    capture_time: Finite | None = None


class _Geometry(BaseModel):
    coordinates: Vector


class _Feature(BaseModel):
    properties: _Properties
    geometry: _Geometry


class _Shots(BaseModel):
    features: list[_Feature]


class _Lens(BaseModel):
    projection_type: str
    width: int = 0
    height: int = 0
    focal: Finite | None = None
    focal_x: Finite | None = None
    focal_y: Finite | None = None
    c_x: Finite = 0.0
    c_y: Finite = 0.0
    k1: Finite = 0.0
    k2: Finite = 0.0
    p1: Finite = 0.0
    p2: Finite = 0.0
    k3: Finite = 0.0


def is_project(path: Path) -> bool:
    """Return whether a folder is a project of OpenDroneMap: two of its own names lie in it, or what we read of one."""
    try:
        found = sum((path / mark).exists() for mark in _MARKS)
        return path.is_dir() and (found >= 2 or any((path / each).is_file() for each in (ORTHOPHOTO, SHOTS)))
    except OSError:
        return False


def orthophoto(path: Path) -> Path | None:
    """Return the orthophoto of a project, None where it has none."""
    found = path / ORTHOPHOTO
    return found if found.is_file() else None


def read_project(path: Path, *, height_m: float | None = None) -> ShotSet:
    """Read a project's photographs with the poses that OpenDroneMap found, by their names.

    Args:
        path: Folder of the project.
        height_m: Height above the ground of the middle photograph, metres, where the project has no elevation model.

    Raises:
        PictureError: The project has no poses or photographs, or they cannot be read.
    """
    features = _features(path / SHOTS)
    lenses = _lenses(path / CAMERAS)
    turn = _convergence([each.geometry.coordinates for each in features], [each.properties for each in features])
    images = {each.name.casefold(): each for each in _images(path / IMAGES)}
    shots: list[Shot] = []
    left: list[LeftOut] = []
    for feature in features:
        name = feature.properties.filename
        image = images.get(name.casefold())
        shot = None if image is None else _shot(image, feature, lenses, turn)
        if shot is None:
            left.append(LeftOut(name, f"is not in {IMAGES}/; copy the project's photographs there"))
        elif shot.attitude is not None and (tilt := tilt_deg(shot.attitude)) > MOST_TILT_DEG:
            left.append(LeftOut(name, f"looks {tilt:.0f} degrees off straight down, more than {MOST_TILT_DEG:.0f}"))
        else:
            shots.append(shot)
    if not shots:
        words = "; ".join(f"{each.name} {each.reason}" for each in left[:3]) or "no photograph is in it"
        raise PictureError(f"{path}: none of its photographs can be used: {words}; {_RERUN}")
    known = {each.properties.filename.casefold() for each in features}
    lost = sorted(each.name for name, each in images.items() if name not in known)
    left += [LeftOut(name, "OpenDroneMap found no pose for it; more overlap helps") for name in lost]
    grounded = _by_tags(shots) if (model := _elevations(path)) is None else _above_ground(shots, model)
    found, low = assign_heights(grounded, height_m)
    return ShotSet(tuple(sorted(found, key=lambda each: each.name)), (*left, *low))


def _features(path: Path) -> list[_Feature]:
    found = _json(path)
    try:
        return _Shots.model_validate(found).features
    except ValidationError as error:
        raise PictureError(f"{path}: {first_wrong(error)}; {_RERUN}") from None


def _lenses(path: Path) -> dict[str, _Lens]:
    if not path.is_file():
        return {}
    found = _json(path)
    try:
        return {str(name): _Lens.model_validate(lens) for name, lens in dict(found).items()}
    except (ValidationError, TypeError, ValueError) as error:
        words = first_wrong(error) if isinstance(error, ValidationError) else "is no table of cameras"
        raise PictureError(f"{path}: {words}; {_RERUN}") from None


def _json(path: Path) -> Any:
    try:
        return json.loads(path.read_bytes())
    except OSError as error:
        raise PictureError(f"{path} cannot be read ({error.strerror or error}); {_RERUN}") from None
    except (ValueError, RecursionError) as error:
        raise PictureError(f"{path}: is no JSON ({error}); {_RERUN}") from None


def _images(folder: Path) -> list[Path]:
    try:
        return [each for each in folder.iterdir() if each.suffix.lower() in (".jpg", ".jpeg")]
    except OSError as error:
        raise PictureError(f"{folder} cannot be read ({error.strerror or error}); {_RERUN}") from None


def _shot(image: Path, feature: _Feature, lenses: dict[str, _Lens], turn: float) -> Shot:
    """Return a photograph's shot. ``turn``: radians, clockwise, from true north to the projection's."""
    said = feature.properties
    longitude, latitude, altitude = feature.geometry.coordinates
    matrix = cv2.Rodrigues(np.array(said.rotation))[0].T  # the camera's axes in east, north, up
    to_ned = _EAST_NORTH_UP @ matrix @ CAMERA_TO_BODY.T
    roll, pitch, yaw = angles(to_ned)
    return Shot(
        path=image,
        camera=_camera(said, lenses),
        latitude=latitude,
        longitude=longitude,
        altitude=altitude,
        height=None,
        attitude=(roll, pitch, math.remainder(yaw + turn, math.tau)),
        sigma=_SIGMA_M,
        time=said.capture_time,
    )


def _camera(said: _Properties, lenses: dict[str, _Lens]) -> CameraModel:
    """Return the lens that ``cameras.json`` has for a photograph: by its name, by its size, or the only one."""
    same = [lens for lens in lenses.values() if (lens.width, lens.height) == (said.width, said.height)]
    lens = lenses.get(said.camera) or (same[0] if same else None)
    side, middle = max(said.width, said.height), ((said.width - 1) / 2, (said.height - 1) / 2)
    if lens is None:
        if said.focal is None:
            raise PictureError(f"{said.filename}: {CAMERAS} has no lens of {said.width} x {said.height}; {_RERUN}")
        return CameraModel(said.width, said.height, said.focal * side, said.focal * side, *middle)
    focal = lens.focal_x or lens.focal
    if lens.projection_type not in ("brown", "perspective", "simple_radial", "radial") or not focal or focal <= 0:
        raise PictureError(
            f"{said.filename}: its lens is of the kind {lens.projection_type}, which is no pinhole; map the orthophoto"
        )
    return CameraModel(
        said.width,
        said.height,
        focal * side,
        (lens.focal_y or focal) * side,
        middle[0] + lens.c_x * side,
        middle[1] + lens.c_y * side,
        (lens.k1, lens.k2, lens.p1, lens.p2, lens.k3),
    )


def _convergence(places: Sequence[Vector], said: Sequence[_Properties]) -> float:
    """Return the angle from true north to the projection's north, radians clockwise, by the photographs' places.

    Between places in the projection and those on Earth lies one turn (and a scale): that of the best similarity. Places
    near each other say nothing of it: 0.
    """
    if len(places) < 2:
        return 0.0
    longitude, latitude, _ = places[0]
    east, north, _ = pymap3d.geodetic2enu(
        np.array([each[1] for each in places]), np.array([each[0] for each in places]), 0.0, latitude, longitude, 0.0
    )
    true = np.asarray(east + 1j * north)
    grid = np.array([complex(each.translation[0], each.translation[1]) for each in said])
    true, grid = true - true.mean(), grid - grid.mean()
    if np.abs(true).max() < _SPREAD_M:
        return 0.0
    return cmath.phase(complex(np.vdot(true, grid)))


def _elevations(path: Path) -> Path | None:
    """Return a project's elevation model, that of the terrain before that of the surface; None without any."""
    return next((path / each for each in _GROUND if (path / each).is_file()), None)


def _by_tags(shots: list[Shot]) -> list[Shot]:
    """Return the shots with the heights above the take-off place that the photographs' own tags give."""
    table, found = Lenses(), []
    for shot in shots:
        try:
            found.append(replace(shot, height=read_photograph(shot.path, table, shot.camera).shot.height))
        except UnusableError:
            found.append(shot)
    return found


def _above_ground(shots: list[Shot], model: Path) -> list[Shot]:
    """Return the shots with their heights above an elevation model."""
    rasterio = _rasterio(model)
    try:
        with gdal.open_picture(model) as raster:
            degrees = [s.longitude for s in shots], [s.latitude for s in shots]
            xs, ys = rasterio.warp.transform("EPSG:4326", raster.crs, *degrees)
            rows = list(raster.sample(zip(xs, ys, strict=True), masked=True))
    except (rasterio.errors.RasterioError, gdal.UnsafeError, OSError) as error:
        raise PictureError(f"{model} cannot be read ({error}); {_RERUN}") from None
    ground = [math.nan if np.ma.is_masked(row) else float(row[0]) for row in rows]
    return _lowered(shots, np.array(ground, np.float64))


def _lowered(shots: list[Shot], ground: NDArray[np.float64]) -> list[Shot]:
    known = ground[np.isfinite(ground)]
    if not len(known):
        return shots
    level = np.where(np.isfinite(ground), ground, np.median(known))
    return [
        replace(shot, height=(shot.altitude or 0.0) - float(below)) for shot, below in zip(shots, level, strict=True)
    ]


def system_of(path: Path) -> str:
    """Return the project's system of coordinates as PROJ names it, that of its orthophoto; "" where nothing says it.

    Raises PictureError where its files cannot be read.
    """
    said = path / "odm_georeferencing" / "proj.txt"
    found = orthophoto(path)
    if found is None:
        try:
            return said.read_text(encoding="utf-8").strip() if said.is_file() else ""
        except (OSError, UnicodeDecodeError) as error:
            raise PictureError(f"{said} cannot be read ({error}); {_RERUN}") from None
    rasterio = _rasterio(found)
    try:
        with gdal.open_picture(found) as raster:
            code = raster.crs.to_authority() if raster.crs else None
            return f"{code[0]}:{code[1]}" if code else raster.crs.to_wkt() if raster.crs else ""
    except (rasterio.errors.RasterioError, gdal.UnsafeError, OSError) as error:
        raise PictureError(f"{found} cannot be read ({error}); {_RERUN}") from None


def _rasterio(path: Path) -> Any:
    try:
        return gdal.rasterio()  # only desks that map pictures have it
    except ImportError as error:
        raise PictureError(f"rasterio is not installed, which reads {path.name}: {remedy('pictures')}") from error
