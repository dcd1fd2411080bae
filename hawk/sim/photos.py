"""Photographs of a flight over a world, as a DJI's camera writes them, with the truth beside them.

The pixels are of the true poses and the true lens. The tags err as those of real drones do: the place by white noise
and one bias, the yaw by a bias and noise, the height and the lens by one factor each.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
import shapely

from hawk.model.pictures import CameraModel
from hawk.sim.geometry import Origin
from hawk.sim.photos_tags import CAMERAS, DroneCamera, Written, tagged
from hawk.worlds.camera import WorldCamera
from hawk.worlds.moment import clock_of
from hawk.worlds.world import World

MOST_PHOTOS: Final = 3000
TRUTH: Final = "truth.json"
_SPEED: Final = 5.0
"""Metres a second along a lane and from one lane to the next."""
_QUALITY: Final = 92
_MORNING: Final = datetime(2026, 5, 4, 10, 30, tzinfo=UTC)
"""Of a world that has no moment, by the lot's clock."""
_ERRORS, _PIXELS = 1, 2
"""Streams of the noise seed."""


class PhotosError(ValueError):
    """A flight that cannot be photographed; the text names the option and the remedy."""


@dataclass(frozen=True, slots=True)
class Errors:
    """Errors of the tags: ``gps_sigma`` and ``gps_bias`` metres, ``yaw`` degrees, ``height`` and ``lens`` percent.

    ``gps_sigma`` is a standard deviation along each axis, ``gps_bias`` a length; the others are the most.
    """

    gps_sigma: float = 1.5
    gps_bias: float = 2.0
    yaw: float = 3.0
    height: float = 5.0
    lens: float = 2.0


@dataclass(frozen=True, slots=True)
class PhotoOptions:
    """A flight: true ``height`` above the ground (metres), ``overlap`` along and between lanes (shares 0..1), the
    camera, the ``width`` of its pictures, the errors of its tags and the seed of all chance.
    """

    height: float = 60.0
    overlap: tuple[float, float] = (0.7, 0.6)
    camera: DroneCamera = CAMERAS["FC6310"]
    width: int = 2000
    errors: Errors = field(default_factory=Errors)
    noise_seed: int = 1
    origin: Origin = field(default_factory=Origin)


@dataclass(frozen=True, slots=True)
class Pose:
    """True pose of a photograph: metres in the world's frame (x east, y south), ``yaw`` radians from north, ``seconds``
    since the first one.
    """

    x_east: float
    y_south: float
    yaw: float
    seconds: float


@dataclass(frozen=True, slots=True)
class Drawn:
    """The errors of one flight's tags: its common ``bias`` (north, east; metres) and ``yaw`` (degrees), and the factors
    by which the written ``height`` and the true ``lens`` differ from the true height and the nominal lens.
    """

    bias: tuple[float, float]
    yaw: float
    height: float
    lens: float


def write_photos(world: World, options: PhotoOptions, folder: Path, say: Callable[[str], None] | None = None) -> int:
    """Draw and write the photographs and `TRUTH`; return how many there are.

    The same world, options and seed give the same bytes. Raises PhotosError, TagsError and OSError.
    """
    nominal = options.camera.focal_px(options.width)
    poses = plan(world, options)
    rng = np.random.default_rng([options.noise_seed, _ERRORS])
    drawn = _draw(rng, options.errors)
    lens = true_lens(options, drawn)
    camera = WorldCamera(world, lens)
    folder.mkdir(parents=True, exist_ok=True)
    shots = []
    for number, (pose, off) in enumerate(zip(poses, _noise(rng, options.errors, len(poses)), strict=True), 1):
        name = f"DJI_{number:04d}.JPG"
        pixels = np.random.default_rng([options.noise_seed, _PIXELS, number])
        frame = camera.render(pose.x_east, pose.y_south, options.height, 0.0, 0.0, pose.yaw, rng=pixels)
        done, jpeg = cv2.imencode(".jpg", frame, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
        if not done:
            raise PhotosError(f"{name}: the picture cannot be encoded; take another --width")
        written = _written(world, options, pose, drawn, off, nominal)
        (folder / name).write_bytes(tagged(jpeg.tobytes(), written))
        shots.append(_true_shot(name, pose, options))
        if say is not None and number % 10 == 0:
            say(f"{number} of {len(poses)} photographs")
    truth = {**world.truth_json(), "photos": _truth(options, drawn, lens, shots)}
    (folder / TRUTH).write_text(json.dumps(truth), encoding="utf-8")
    return len(poses)


def true_lens(options: PhotoOptions, drawn: Drawn) -> CameraModel:
    """Return the lens that draws the pictures."""
    width, height = options.width, options.camera.height_px(options.width)
    focal = options.camera.focal_px(width) * drawn.lens
    return CameraModel(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)


def plan(world: World, options: PhotoOptions) -> list[Pose]:
    """Return the poses of lanes to and fro over the world's lots, or over all of it where it has none.

    The lanes run along the longer side of the smallest rectangle about the lots, the picture's top ahead; one more lane
    than fits lies over each edge, so that the edge is seen as often as the middle. Raises PhotosError.
    """
    (corner, along, across), (length, breadth) = _rectangle(world)
    focal = options.camera.focal_px(options.width)
    seen = np.array([options.camera.height_px(options.width), options.width]) / focal * options.height
    steps = seen * (1.0 - np.array(options.overlap))
    lanes, photos = _places(breadth, float(steps[1])), _places(length, float(steps[0]))
    if len(lanes) * len(photos) > MOST_PHOTOS:
        raise PhotosError(
            f"--height: {len(lanes) * len(photos)} photographs, more than {MOST_PHOTOS}; fly higher, or with less "
            "--overlap"
        )
    poses: list[Pose] = []
    for number, side in enumerate(lanes):
        ahead = along if number % 2 == 0 else -along
        for place in photos if number % 2 == 0 else photos[::-1]:
            x, y = corner + place * along + side * across
            seconds = 0.0
            if poses:
                seconds = poses[-1].seconds + math.hypot(x - poses[-1].x_east, y - poses[-1].y_south) / _SPEED
            poses.append(Pose(float(x), float(y), math.atan2(ahead[0], -ahead[1]), seconds))
    return poses


def _rectangle(world: World) -> tuple[tuple[Any, Any, Any], tuple[float, float]]:
    """Return a corner of the rectangle about the lots, its unit vectors along and across, its length and breadth."""
    width, height = world.size_m
    points = np.concatenate(world.lots) if world.lots else np.array([[0, 0], [width, 0], [width, height], [0, height]])
    box = shapely.MultiPoint(points).minimum_rotated_rectangle
    corners = np.array(box.exterior.coords)[:4]
    sides = corners[[1, 3]] - corners[0]
    lengths = np.linalg.norm(sides, axis=1)
    first = int(lengths.argmax())
    along, across = sides[first] / lengths[first], sides[1 - first] / lengths[1 - first]
    return (corners[0], along, across), (float(lengths[first]), float(lengths[1 - first]))


def _places(length: float, step: float) -> list[float]:
    """Return places a step apart about the middle of a length, the first and last at its ends or beyond."""
    count = math.ceil(length / step) + 1
    first = length / 2 - (count - 1) * step / 2
    return [first + k * step for k in range(count)]


def _draw(rng: np.random.Generator, errors: Errors) -> Drawn:
    direction = rng.uniform(0.0, math.tau)
    return Drawn(
        bias=(errors.gps_bias * math.cos(direction), errors.gps_bias * math.sin(direction)),
        yaw=rng.uniform(-0.5, 0.5) * errors.yaw,
        height=1.0 + rng.uniform(-1.0, 1.0) * errors.height / 100.0,
        lens=1.0 + rng.uniform(-1.0, 1.0) * errors.lens / 100.0,
    )


def _noise(rng: np.random.Generator, errors: Errors, count: int) -> Iterator[tuple[float, float, float]]:
    """Yield each photograph's own error: metres north and east, degrees of yaw."""
    for _ in range(count):
        north, east = rng.normal(0.0, errors.gps_sigma, 2)
        yield float(north), float(east), float(rng.uniform(-0.5, 0.5) * errors.yaw)


def _written(
    world: World, options: PhotoOptions, pose: Pose, drawn: Drawn, off: tuple[float, float, float], nominal: float
) -> Written:
    height = options.height * drawn.height
    place = (-pose.y_south + drawn.bias[0] + off[0], pose.x_east + drawn.bias[1] + off[1], 0.0)
    latitude, longitude, _ = options.origin.to_geodetic(place)
    start = world.at or _MORNING.replace(tzinfo=clock_of(options.origin.longitude))
    return Written(
        camera=options.camera,
        size=(options.width, options.camera.height_px(options.width)),
        focal_px=nominal,
        time=start + timedelta(seconds=round(pose.seconds)),
        latitude=latitude,
        longitude=longitude,
        altitude=options.origin.altitude + height,
        height=height,
        yaw=math.degrees(pose.yaw) + drawn.yaw + off[2],
    )


def _true_shot(name: str, pose: Pose, options: PhotoOptions) -> dict[str, Any]:
    place = (-pose.y_south, pose.x_east, -options.height)
    latitude, longitude, altitude = options.origin.to_geodetic(place)
    return {
        "name": name,
        "x_m": round(pose.x_east, 4),
        "y_m": round(pose.y_south, 4),
        "height_m": options.height,
        "roll_deg": 0.0,
        "pitch_deg": 0.0,
        "yaw_deg": round(math.degrees(pose.yaw), 4),
        "latitude": latitude,
        "longitude": longitude,
        "altitude_m": altitude,
    }


def _truth(options: PhotoOptions, drawn: Drawn, lens: CameraModel, shots: list[dict[str, Any]]) -> dict[str, Any]:
    sizes = {name: getattr(lens, name) for name in ("width", "height", "fx", "fy", "cx", "cy")}
    return {
        "camera": options.camera.model,
        "lens": sizes,
        "nominal_focal_px": options.camera.focal_px(options.width),
        "overlap": list(options.overlap),
        "errors": asdict(drawn),
        "origin": asdict(options.origin),
        "shots": shots,
    }
