"""Perception on still pictures, without a flight: what the network, the votes and the rows find in whole places.

``python -m benchmarks.perception --lots DIR --tiles DIR --negatives DIR --seeds 1-5 --json FILE``

``--lots``: pictures ``PLACE.jpg`` with ``PLACE.json`` (metres_per_pixel, stalls with corners_m and state, lots_m).
``--tiles``: ``images/*.jpg`` with ``labels/*.txt`` (class, polygon in fractions; 0 car, 1 lot, 3 stall); tiles with
fewer than five stalls are left out. ``--negatives``: pictures without any stall. ``--seeds``: single frames over drawn
worlds. The measures are those of `hawk.survey.scoring`.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.vision_frame import frames
from hawk.algo.vision import decode, picture, quads
from hawk.algo.vision.decode import Stalls
from hawk.algo.vision.finder import NetworkFinder
from hawk.algo.vision.lot import lot_area
from hawk.algo.vision.network import CELL_PIXELS, NetworkMaps, StallNetwork
from hawk.algo.vision.rectify import Rectifier
from hawk.algo.vision.rows import complete_rows, row_stalls
from hawk.algo.vision.seen import GroundImage, StallSeen
from hawk.model import StallState
from hawk.survey.scoring import Finding, FloatArray, Tally, Truth, mask_iou, tally
from hawk.worlds.generate import generate_world
from hawk.worlds.world import World

GROUND_M = 0.10
CELL_M = GROUND_M * CELL_PIXELS
LOT_CELLS = 2
MINIMUM_SCORE = 0.5
TILE_METRES_PER_PIXEL = 0.0938
FREE_COVER, TAKEN_COVER = 0.12, 0.30


@dataclass(frozen=True, slots=True)
class Place:
    """A picture and what is there, metres from its upper left corner (x right, y down)."""

    name: str
    image: NDArray[np.uint8]
    metres_per_pixel: float
    truth: Truth


@dataclass(frozen=True, slots=True)
class Result:
    """What was found in a place: stalls in metres and the lot's cells at ``LOT_CELLS * CELL_M``."""

    finding: Finding
    lot: NDArray[np.bool_]


def read_lots(folder: Path) -> Iterator[Place]:
    """Yield the places of a folder of PLACE.jpg and PLACE.json."""
    for path in sorted(folder.glob("*.json")):
        told = json.loads(path.read_text())
        states = [StallState(s["state"]) if s["state"] != "unclear" else StallState.UNKNOWN for s in told["stalls"]]
        corners = np.array([s["corners_m"] for s in told["stalls"]], float).reshape(-1, 4, 2)
        lots = tuple(np.array(lot, float) for lot in told["lots_m"])
        truth = Truth(corners, _states(states), lots)
        yield Place(path.stem, read_picture(path.with_suffix(".jpg")), told["metres_per_pixel"], truth)


def read_tiles(folder: Path) -> Iterator[Place]:
    """Yield the tiles with at least five labelled stalls."""
    for path in sorted((folder / "images").glob("*.jpg")):
        image = read_picture(path)
        size = np.array([image.shape[1], image.shape[0]])
        shapes = [_shape(line, size) for line in _lines(folder / "labels" / f"{path.stem}.txt")]
        stalls = [_box(points) for kind, points in shapes if kind == 3]
        if len(stalls) < 5:
            continue
        cars = np.zeros(image.shape[:2], np.uint8)
        cv2.fillPoly(cars, [points.astype(np.int32) for kind, points in shapes if kind == 0], (1,))
        states = _states([_state(cars, stall) for stall in stalls])
        lots = tuple(points * TILE_METRES_PER_PIXEL for kind, points in shapes if kind == 1)
        truth = Truth(np.array(stalls, float) * TILE_METRES_PER_PIXEL, states, lots)
        yield Place(path.stem, image, TILE_METRES_PER_PIXEL, truth)


def read_picture(path: Path) -> NDArray[np.uint8]:
    """Return the picture, BGR. Raises FileNotFoundError."""
    image = cv2.imread(str(path))
    if image is None:
        raise FileNotFoundError(f"{path} cannot be read as a picture")
    return np.asarray(image, np.uint8)


def look(network: StallNetwork, image: NDArray[np.uint8], metres_per_pixel: float, *, rows: bool = True) -> Result:
    """Find stalls and lot in a nadir picture."""
    scale = metres_per_pixel / GROUND_M
    method = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    scaled = np.asarray(cv2.resize(image, None, fx=scale, fy=scale, interpolation=method), np.uint8)
    maps = network.run(scaled)
    stalls = decode.vote(maps, CELL_M)
    stalls = stalls[stalls.score >= MINIMUM_SCORE]
    if rows:
        stalls = completed(maps, stalls)
    taken = decode.occupancy(maps, stalls)
    states = np.where(taken < 0.5, StallState.FREE, StallState.TAKEN).astype(object)
    probability = cv2.resize(maps.lot, None, fx=1 / LOT_CELLS, fy=1 / LOT_CELLS, interpolation=cv2.INTER_AREA)
    lot = lot_area(np.asarray(probability, np.float32), stalls.corners() / LOT_CELLS, CELL_M * LOT_CELLS)
    # cell (c, r) is picture pixel (2 c, 2 r), whose centre lies half a pixel from the picture's corner
    metres = stalls.corners() * CELL_M + GROUND_M / 2
    return Result(Finding(metres, states), lot)


def completed(maps: NetworkMaps, stalls: Stalls) -> Stalls:
    """Return the stalls with their rows completed."""
    side = CELL_M

    def evidence(corners: FloatArray) -> FloatArray:
        middle = corners.mean(axis=1, keepdims=True)
        return core_mean(maps.core, (middle + (corners - middle) * 0.7) / side)

    given = row_stalls(
        stalls.column * side,
        stalls.row * side,
        stalls.angle,
        stalls.width * side,
        stalls.length * side,
        stalls.score,
    )
    result = complete_rows(given, evidence)
    return Stalls(
        result.north / side,
        result.east / side,
        result.angle,
        result.width / side,
        result.length / side,
        result.score,
    )


def core_mean(core: NDArray[np.float32], corners: FloatArray) -> FloatArray:
    """Return the mean (N,) of a map over quads (N, 4, 2) of (column, row); outside counts as 0."""
    share = (np.arange(9) + 0.5) / 9
    first = corners[:, None, 0] + (corners[:, None, 1] - corners[:, None, 0]) * share[:, None]
    last = corners[:, None, 3] + (corners[:, None, 2] - corners[:, None, 3]) * share[:, None]
    points = first[:, :, None] + (last - first)[:, :, None] * share[:, None]
    return np.asarray(decode.sample(core, points).mean(axis=(1, 2)))


def true_lot(place: Place, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Return the labelled lot as cells of the found one's raster."""
    drawn = np.zeros(shape, np.uint8)
    cell = CELL_M * LOT_CELLS
    cv2.fillPoly(drawn, [np.rint(lot / cell - 0.5).astype(np.int32) for lot in place.truth.lots], (1,))
    return drawn > 0


def measure(network: StallNetwork, places: Iterator[Place], prefix: str, *, verbose: bool) -> dict[str, float]:
    """Return the measures over all places, names led by ``prefix``."""
    total = Tally()
    overlaps: list[float] = []
    for place in places:
        result = look(network, place.image, place.metres_per_pixel)
        one = tally(result.finding, place.truth)
        overlap = mask_iou(result.lot, true_lot(place, result.lot.shape))
        total += one
        overlaps.append(overlap)
        if verbose:
            print(f"  {place.name:24s} {_line(one.measures())} lot {overlap:.2f}")
    figures = {name: value for name, value in total.measures().items() if name not in ("unknown_share",)}
    figures["lot_iou"] = float(np.nanmean(overlaps)) if overlaps else float("nan")
    print(f"{prefix}: {_line(figures)} lot {figures['lot_iou']:.3f} ({len(overlaps)} places, {total.true} labels)")
    return {f"{prefix}_{name}": value for name, value in figures.items()}


def measure_frames(network: StallNetwork, seeds: Sequence[int], count: int = 12) -> dict[str, float]:
    """Return the measures of single frames over drawn worlds at 35 m, stalls that lie wholly in view only."""
    finder, rectifier, total = NetworkFinder(network), Rectifier(), Tally()
    for seed in seeds:
        world = generate_world(seed)
        one = Tally()
        for frame in frames(world, 35.0, count, lens=False):
            assert frame.pose is not None
            ground = rectifier.rectify(picture.decode(frame.jpeg), frame.camera, frame.pose)
            seen = [s for s in finder.find(ground).stalls if s.score >= MINIMUM_SCORE and s.visible > 0.98]
            one += tally(_finding(seen), _truth_in_view(world, ground))
        print(f"  world {seed}: {_line(one.measures())}")
        total += one
    print(f"frames: {_line(total.measures())} ({total.true} stalls in view)")
    return {f"frames_{name}": value for name, value in total.measures().items()}


def _finding(seen: list[StallSeen]) -> Finding:
    """Return stalls of one frame in the world's metres (x east, y south)."""
    if not seen:
        return Finding(np.zeros((0, 4, 2)), _states([]))
    table = np.array([(s.north, s.east, s.angle, s.width, s.length) for s in seen])
    corners = quads.corners(*(table[:, k] for k in range(5)))
    states = [StallState.FREE if s.taken < 0.5 else StallState.TAKEN for s in seen]
    return Finding(np.stack([corners[..., 1], -corners[..., 0]], axis=-1), _states(states))


def _truth_in_view(world: World, ground: GroundImage) -> Truth:
    """Return the stalls that can be seen wholly in a rectified frame; hidden ones are left out."""
    corners = np.array([s.corners for s in world.stalls])
    pixels = ground.pixel_points(np.stack([-corners[..., 1], corners[..., 0]], axis=-1))
    whole = decode.sample(ground.valid, pixels).all(axis=1) & ~np.array([s.hidden for s in world.stalls])
    states = [StallState.TAKEN if s.taken else StallState.FREE for s in world.stalls]
    return Truth(corners[whole], _states(states)[whole], tuple(np.asarray(lot) for lot in world.lots))


def false_alarms(network: StallNetwork, folder: Path, metres_per_pixel: float) -> dict[str, float]:
    """Return how many stalls are found on pictures without any."""
    count = 0
    for path in sorted(p for p in folder.iterdir() if p.suffix.lower() in (".jpg", ".jpeg", ".png")):
        found = len(look(network, read_picture(path), metres_per_pixel).finding.stalls)
        print(f"  {path.name}: {found} false alarms")
        count += found
    return {"negatives_false_alarms": float(count)}


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure by command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.perception", description=__doc__)
    parser.add_argument("--lots", type=Path)
    parser.add_argument("--tiles", type=Path)
    parser.add_argument("--negatives", type=Path)
    parser.add_argument("--negatives-scale", type=float, default=0.03, help="metres per pixel of the negatives")
    parser.add_argument("--seeds", help="drawn worlds to see in single frames, as 1-5")
    parser.add_argument("--model", type=Path, help="an ONNX file in place of the package's")
    parser.add_argument("--json", type=Path, help="write the figures here")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    network = StallNetwork.load(options.model)
    figures: dict[str, float] = {}
    if options.lots:
        figures |= measure(network, read_lots(options.lots), "lots", verbose=True)
    if options.tiles:
        figures |= measure(network, read_tiles(options.tiles), "tiles", verbose=False)
    if options.negatives:
        figures |= false_alarms(network, options.negatives, options.negatives_scale)
    if options.seeds:
        first, _, last = options.seeds.partition("-")
        figures |= measure_frames(network, range(int(first), int(last or first) + 1))
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1))


def _lines(path: Path) -> list[list[float]]:
    if not path.exists():
        return []
    rows = [[float(v) for v in line.split()] for line in path.read_text().splitlines()]
    return [row for row in rows if len(row) >= 5]


def _shape(line: list[float], size: NDArray[np.int_]) -> tuple[int, FloatArray]:
    kind, values = int(line[0]), np.array(line[1:])
    if len(values) == 4:
        centre, half = values[:2], values[2:] / 2
        points = centre + half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    else:
        points = values[: len(values) // 2 * 2].reshape(-1, 2)
    return kind, np.asarray(points * size)


def _box(points: FloatArray) -> FloatArray:
    return np.asarray(cv2.boxPoints(cv2.minAreaRect(points.astype(np.float32))), np.float64)


def _states(values: list[StallState]) -> NDArray[Any]:
    return np.array([str(value) for value in values], dtype=object)


def _state(cars: NDArray[np.uint8], stall: FloatArray) -> StallState:
    inside = np.zeros(cars.shape, np.uint8)
    cv2.fillPoly(inside, [np.asarray(stall).astype(np.int32)], (1,))
    cover = float(cars[inside > 0].mean()) if inside.any() else 0.5 * (FREE_COVER + TAKEN_COVER)
    if cover < FREE_COVER:
        return StallState.FREE
    return StallState.TAKEN if cover > TAKEN_COVER else StallState.UNKNOWN


def _line(m: dict[str, float]) -> str:
    return (
        f"P {m['precision']:.3f} R {m['recall']:.3f} F1 {m['f1']:.3f} P* {m['precision_star']:.3f} "
        f"R-whole {m['recall_whole']:.3f} free P* {m['free_precision_star']:.3f} R {m['free_recall']:.3f} "
        f"state {m['state_accuracy']:.3f}"
    )


if __name__ == "__main__":
    main()
