"""The mosaic of drawn worlds, flown with a wrong position and changing light, beside the worlds' own picture.

    python -m benchmarks.mosaic --seeds 1-5 --out DIR --json mosaic.json

Each frame is off by 0.15 m (standard deviation, along each axis), its exposure by up to 15 %, and its corners lack 20 %
of the light. Seams: mean difference of pixels on both sides of a border between two frames, by that of neighbours
elsewhere, and that by the same of the world's own picture; ``steps`` the same for means over 0.6 m on both sides, which
differences of brightness stand out in. Sharpness: variance of the Laplacian by that of the world's picture.
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.chain_flight.flight import camera
from benchmarks.figures import Figure, Limit, Section, print_and_write
from benchmarks.frames import camera_model, encoded
from benchmarks.options import make_parser, seeds_option
from benchmarks.world_lots import joined, rings_about
from hawk.algo.ground import Slices, Window
from hawk.algo.mapper.core import MapperSettings
from hawk.algo.mapper.mosaic import EDGE_M, Mosaic
from hawk.algo.vision.picture import decode
from hawk.algo.vision.rectify import Rectifier, ground_footprint
from hawk.model.lot_map import CELL_M, TILE_CELLS, Cell, TileKey
from hawk.model.poses import GlobalPose, MapPose
from hawk.model.tile_picture import decode_picture, encode_picture
from hawk.results.map_picture import map_picture
from hawk.results.survey_map import SurveyMap
from hawk.worlds.camera import Lens, WorldCamera
from hawk.worlds.generate import generate_world
from hawk.worlds.world import World

HEIGHT_M: Final = 35.0
FRAME_M: Final = 1.2  # six metres a second, five frames a second
STEP_M: Final = MapperSettings().mosaic_step_m
TILES: Final = MapperSettings().mosaic_blended_tiles
LANE_M: Final = 24.0
OFF_M: Final = 0.15
TILT: Final = math.radians(1.5)
EXPOSURE: Final = 0.15
VIGNETTE: Final = 0.2
THREE_HA_M2: Final = 30_000.0
_ORTHO_M: Final = 3000.0
_STEP_PIXELS: Final = 6
_MARGIN: Final = 2 * _STEP_PIXELS
_BLACK: Final = 8

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]


@dataclass(slots=True)
class Sources:
    """Which frame each pixel of the map was taken from, by tiles, and how many frames there were."""

    tiles: dict[TileKey, NDArray[np.int32]] = field(default_factory=dict)
    frame: int = 0

    def note(self, key: TileKey, part: Slices, weight: NDArray[Any]) -> None:
        """Note the pixels that the present frame has most of."""
        tile = self.tiles.setdefault(key, np.full((TILE_CELLS, TILE_CELLS), -1, np.int32))
        tile[part][weight > 0.5] = self.frame


@dataclass(frozen=True, slots=True)
class Flown:
    """The mosaic of a flight on one window of cells: pixels, sources, what was in view, milliseconds of each frame."""

    window: Window
    picture: Image
    seen: Image
    sources: NDArray[np.int32]
    in_view: Image
    frame_ms: list[float]
    finish_s: float


def path(world: World) -> Iterator[tuple[float, float, float]]:
    """Yield (north, east, yaw) to and fro over the lots, `FRAME_M` apart; the origin is the world's start."""
    south, west, north, east = joined(rings_about(world.lots, world.start())).bounds
    count = max(1, math.ceil((east - west) / LANE_M))
    for lane in range(count):
        at = west + (lane + 0.5) * (east - west) / count
        line = np.arange(south, north, FRAME_M)
        yaw = 0.15 if lane % 2 == 0 else math.pi + 0.15
        for place in line if lane % 2 == 0 else line[::-1]:
            yield float(place), at, yaw


def fly(world: World, mosaic: Mosaic, sources: Sources, seed: int) -> Flown:
    """Fly a world and put its mosaic together as the mapper does: a picture each `STEP_M`, a tile encoded a frame."""
    rng, model, rectifier = np.random.default_rng(seed), camera(), Rectifier()
    eye = WorldCamera(world, model, Lens(vignette=VIGNETTE))
    x0, y0 = world.start()
    last: tuple[float, float] | None = None
    outlines: list[Floats] = []
    costs: list[float] = []
    for number, (north, east, yaw) in enumerate(path(world)):
        roll, pitch = rng.normal(0.0, TILT, 2)
        jpeg = _frame(eye, (x0 + east, y0 - north), (roll, pitch, yaw), rng)
        off = rng.normal(0.0, OFF_M, 2)
        pose = MapPose(north + off[0], east + off[1], HEIGHT_M, roll, pitch, yaw)
        ground = rectifier.rectify(decode(jpeg), model, pose)
        started = time.thread_time()
        if not mosaic.go_on(TILES) and (last is None or math.dist(last, (north, east)) >= STEP_M):
            last, sources.frame = (north, east), number
            mosaic.add(ground, (pose.north, pose.east), pose.height, TILES)
            outlines.append(np.array([(point.north, point.east) for point in ground_footprint(model, pose)]))
        mosaic.encode(1, number)
        costs.append((time.thread_time() - started) * 1e3)
    return _finished(mosaic, sources, outlines, costs)


def _frame(
    eye: WorldCamera, place: tuple[float, float], attitude: tuple[float, float, float], rng: np.random.Generator
) -> bytes:
    picture = eye.render(*place, HEIGHT_M, *attitude, rng=rng)
    lit = cv2.convertScaleAbs(picture, alpha=1 + rng.uniform(-EXPOSURE, EXPOSURE))
    return encoded(np.asarray(lit, np.uint8))


def _finished(mosaic: Mosaic, sources: Sources, outlines: list[Floats], costs: list[float]) -> Flown:
    started = time.thread_time()
    mosaic.go_on(None)
    while mosaic.encode(1, len(costs)):
        pass
    corners = np.vstack(outlines)
    window = Window.around(corners, CELL_M)
    pictures = {key: tile.data for key, tile in mosaic.encoded.items()}
    cells = dict.fromkeys(pictures, np.full((TILE_CELLS, TILE_CELLS), Cell.LOT, np.uint8))
    map_picture(SurveyMap(GlobalPose(0.0, 0.0, 0.0), {}, cells, pictures))
    finish_s = time.thread_time() - started
    picture = np.zeros((*window.shape, 3), np.uint8)
    seen = np.zeros(window.shape, np.uint8)
    labels = np.full(window.shape, -1, np.int32)
    for key, in_tile, in_window in window.tiles():
        if key in pictures:
            pixels, mask = decode_picture(pictures[key])
            picture[in_window], seen[in_window] = pixels[in_tile], mask[in_tile]
            labels[in_window] = sources.tiles[key][in_tile]
    return Flown(window, picture, seen, labels, _in_view(window, outlines), costs, finish_s)


def _in_view(window: Window, outlines: list[Floats]) -> Image:
    """Return the cells that lie in a frame, `EDGE_M` and a pixel inside its edge."""
    found = np.zeros(window.shape, np.uint8)
    for ring in outlines:
        inner = shapely.Polygon(ring).buffer(-EDGE_M - 2 * CELL_M, join_style="mitre")
        points = np.array(inner.exterior.coords)
        cells = window.cells_of(points[:, 0], points[:, 1])
        cv2.fillConvexPoly(found, np.round(cells * 16).astype(np.int32), 255, shift=4)
    return found


def own_picture(world: World, window: Window) -> Image:
    """Return the world from straight above on a window's cells: from so far that nothing leans."""
    model = camera_model(window.columns, window.rows, _ORTHO_M / CELL_M)
    x0, y0 = world.start()
    north, east = window.middle
    eye = WorldCamera(world, model, Lens(0.0, 0.0, 0.0))
    return eye.render(x0 + east, y0 - north, _ORTHO_M, 0.0, 0.0, 0.0, rng=np.random.default_rng(0))


def seams(picture: Image, own: Image, sources: NDArray[np.int32], reach: int = 1) -> float:
    """Return the difference across borders of sources by that within, by the same of the world's own picture.

    ``reach``: pixels on each side that are averaged.
    """

    def ratio(image: Image) -> float:
        across: list[NDArray[Any]] = []
        within: list[NDArray[Any]] = []
        for axis in (0, 1):
            first, second = _pairs(sources, axis, 0, 1)
            known = (first >= 0) & (second >= 0)
            change = _change(image, axis, reach)
            across.append(change[known & (first != second)])
            within.append(change[known & (first == second)])
        return float(np.concatenate(across).mean() / np.concatenate(within).mean())

    return ratio(picture) / ratio(own)


def _change(image: Image, axis: int, reach: int) -> NDArray[Any]:
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(np.float32)
    mean = cv2.blur(grey, (1, reach) if axis == 0 else (reach, 1), anchor=(0, 0))  # of the pixels from each one on
    first, second = _pairs(mean, axis, reach - 1, 1)
    return np.asarray(np.abs(first - second))


def _pairs(layer: NDArray[Any], axis: int, back: int, on: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return for each pixel, but those near the edge, the one ``back`` before it along an axis and the one ``on``."""
    inner = (slice(_MARGIN, -_MARGIN), slice(_MARGIN, -_MARGIN))
    return np.roll(layer, back, axis)[inner], np.roll(layer, -on, axis)[inner]


def tile_seams(flown: Flown, own: Image) -> float:
    """Return the same as `seams` for the borders of tiles; the world's own picture is encoded by tiles as well."""
    window, encoded = flown.window, np.zeros_like(own)
    keys = np.full(window.shape, -1, np.int32)
    for number, (_, in_tile, in_window) in enumerate(window.tiles()):
        tile, seen = np.zeros((TILE_CELLS, TILE_CELLS, 3), np.uint8), np.zeros((TILE_CELLS, TILE_CELLS), np.uint8)
        tile[in_tile], seen[in_tile] = own[in_window], flown.seen[in_window]
        encoded[in_window] = decode_picture(encode_picture(tile, seen))[0][in_tile]
        keys[in_window] = np.where(flown.seen[in_window] > 0, number, -1)
    return seams(flown.picture, encoded, keys)


def sharpness(flown: Flown, own: Image) -> float:
    """Return the variance of the Laplacian by that of the world's own picture, a pixel and more from any border."""
    picture, sources = flown.picture, flown.sources.astype(np.float32)
    around = np.ones((5, 5), np.uint8)
    inner = (cv2.erode(sources, around) == cv2.dilate(sources, around)) & (sources >= 0)
    one, other = (cv2.Laplacian(cv2.cvtColor(i, cv2.COLOR_BGR2GRAY), cv2.CV_32F) for i in (picture, own))
    return float(one[inner].var() / other[inner].var())


def figures(flights: Sequence[tuple[Flown, Image]]) -> list[Figure]:
    """Return the figures of all flights; ``flights`` are flown mosaics with the worlds' own pictures."""

    def mean(of: Callable[[Flown, Image], float]) -> float:
        return statistics.fmean(of(flown, own) for flown, own in flights)

    costs = np.concatenate([flown.frame_ms for flown, _ in flights])
    area = sum(np.count_nonzero(flown.seen) * CELL_M**2 for flown, _ in flights)
    finish = sum(flown.finish_s for flown, _ in flights) * THREE_HA_M2 / area
    return [
        Figure("seams", "seams between frames", mean(lambda f, own: seams(f.picture, own, f.sources)), "",
               limit=Limit(highest=1.1)),
        Figure("steps", "steps of brightness between frames",
               mean(lambda f, own: seams(f.picture, own, f.sources, _STEP_PIXELS)), "", limit=Limit(highest=1.1)),
        Figure("tile_seams", "seams between tiles",
               mean(tile_seams), "", limit=Limit(highest=1.1)),
        Figure("black_percent", "black or unseen of what was in view", 100 * mean(lambda f, _: black_share(f)), "%",
               limit=Limit(highest=0.1)),
        Figure("error", "mean error, of 255", mean(_error)),
        Figure("sharpness", "sharpness by the world's own", mean(sharpness)),
        Figure("frame_ms", "a frame, mean", float(costs.mean()), "ms", limit=Limit(highest=8.0)),
        Figure("frame_ms_p99", "a frame, p99", float(np.percentile(costs, 99)), "ms", limit=Limit(highest=25.0)),
        Figure("finish_s", "finished, 3 ha", finish, "s", limit=Limit(highest=20.0)),
    ]  # fmt: skip


def black_share(flown: Flown) -> float:
    """Return the share of what was in view that is black, or that the mosaic says was not seen."""
    there = flown.in_view > 0
    black = (flown.picture.max(axis=2) < _BLACK) | (flown.seen == 0)
    return float(np.count_nonzero(black & there) / np.count_nonzero(there))


def _error(flown: Flown, own: Image) -> float:
    apart = np.abs(flown.picture.astype(np.float32) - own)
    return float(apart[flown.seen > 0].mean())


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly every world and print a table; return 1 when a figure lies outside its limits."""
    parser = make_parser("benchmarks.mosaic", __doc__)
    parser.add_argument("--seeds", type=seeds_option, default="1-5", metavar="A-B", help="drawn worlds (1-5)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write each world's mosaic, and its own picture")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    flights: list[tuple[Flown, Image]] = []
    for seed in options.seeds:
        world, sources = generate_world(seed), Sources()
        flown = fly(world, Mosaic(sources.note), sources, seed)
        flights.append((flown, own_picture(world, flown.window)))
        _write(options.out, seed, *flights[-1])
    return print_and_write([Section("mosaic", figures(flights))], options.json)


def _write(folder: Path | None, seed: int, flown: Flown, own: Image) -> None:
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(folder / f"{seed}.png"), np.dstack([flown.picture, flown.seen]))
        cv2.imwrite(str(folder / f"{seed}-own.png"), own)


if __name__ == "__main__":
    sys.exit(main())
