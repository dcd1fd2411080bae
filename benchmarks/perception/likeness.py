"""Drawn pictures beside real ones: light, paint, brightness, sharpness and stalls a picture.

``python -m benchmarks.perception.likeness --lots DIR --regions DIR --worlds 1-8 --scenes 40 --json FILE``

``--lots``, ``--regions``: labelled pictures, as in ``python -m benchmarks.perception``. ``--worlds``: seeds of worlds
that `hawk.worlds` draws, by day. ``--scenes``: how many scenes `training.scenes` draws to train on, in all conditions.
Each row is the median with the 10th and 90th percentile: of pictures, of shaded pixels for the colours of shade, and of
painted sides of stalls for lines.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.figures import BenchmarkError, write_json
from benchmarks.perception.ground_light import GROUND_M, ground_light, odd
from benchmarks.perception.paint import SHOWN, brightness, side_lines
from benchmarks.perception.places import Place, read_lots, state_array
from benchmarks.perception.stall_rows import Boxes
from benchmarks.surveys import seeds_option
from hawk.model.lot_map import StallState
from hawk.model.pictures import CameraModel
from hawk.survey.accuracy import LabelledPlace
from hawk.worlds.camera import WorldCamera
from hawk.worlds.generate import generate_world
from training.scenes import draw_scene

Floats = NDArray[np.float64]
ROWS: Final = {
    "shade_green": "shade: green by that of lit ground",
    "shade_blue": "shade: blue by green",
    "shade_red": "shade: red by green",
    "lit_blue": "lit ground: blue by green",
    "lit_red": "lit ground: red by green",
    "line_contrast": "line: contrast, share of the ground",
    "line_width": "line: width at half height, m",
    "brightness": "brightness: mean level of green",
    "sharpness": "sharpness: step over 1 pixel by that over 4, at the strongest edges",
    "stalls": "stalls a picture",
    "stalls_per_1000_m2": "stalls per 1000 m² of picture",
}
_LARGEST_SAMPLE = 2000
_EDGE_PERCENTILE, _EDGE_PIXELS = 99.5, 4
_SHADE_INSET_M = 0.5
_WORLD_PIXELS, _WORLD_HEIGHT_M = 1024, 300.0


@dataclass(frozen=True, slots=True)
class Spread:
    """Median with the 10th and 90th percentile; NaN of nothing."""

    low: float
    median: float
    high: float
    count: int

    @classmethod
    def of(cls, values: Floats) -> Spread:
        """Return the spread of values (N,); NaN among them is left out."""
        values = values[np.isfinite(values)]
        if not len(values):
            return cls(np.nan, np.nan, np.nan, 0)
        low, median, high = np.percentile(values, [10, 50, 90])
        return cls(float(low), float(median), float(high), len(values))

    def __str__(self) -> str:
        if not self.count:
            return "–"
        digits = 2 if abs(self.high) < 10 else 0
        return f"{self.median:.{digits}f} ({self.low:.{digits}f} to {self.high:.{digits}f})"


def statistics(places: Iterable[Place]) -> dict[str, Spread]:
    """Return the rows of `ROWS` over pictures. Raises BenchmarkError for none."""
    samples: dict[str, list[Floats]] = {name: [] for name in ROWS}
    for place in places:
        for name, values in _samples(place).items():
            samples[name].append(values)
    if not samples["stalls"]:
        raise BenchmarkError("no picture to look at: name a folder that holds PLACE.jpg with PLACE.json, or seeds")
    return {name: Spread.of(np.concatenate(parts)) for name, parts in samples.items()}


def _samples(place: Place) -> dict[str, Floats]:
    stalls = place.truth.stalls
    light = ground_light(place, stalls)
    colours = np.asarray(cv2.GaussianBlur(light.image, (0, 0), 1.5), np.float64)
    # the rim of a shadow is neither lit nor in shade
    inner = cv2.erode(light.shade.astype(np.uint8), np.ones((odd(_SHADE_INSET_M),) * 2, np.uint8)) > 0
    dark = colours[inner & light.ground]
    lit = np.broadcast_to(light.lit, inner.shape)[inner & light.ground]
    bright, boxes = brightness(light.image), Boxes.of(stalls)
    lines = [line for k in range(len(boxes)) for line in side_lines(bright, boxes, k) if line.shown >= SHOWN]
    shown = np.ones(inner.shape, np.bool_)
    if place.missing is not None:
        shown = cv2.resize(place.missing.astype(np.uint8), inner.shape[::-1]) == 0
    area = float(shown.sum()) * GROUND_M**2
    green = np.maximum(dark[:, 1], 1.0)
    lit_blue, _, lit_red = light.lit_colour / light.lit_colour[1]
    return {
        "shade_green": _some(dark[:, 1] / lit),
        "shade_blue": _some(dark[:, 0] / green),
        "shade_red": _some(dark[:, 2] / green),
        "lit_blue": np.array([lit_blue], np.float64),
        "lit_red": np.array([lit_red], np.float64),
        "line_contrast": np.array([line.contrast for line in lines], np.float64),
        "line_width": np.array([line.width for line in lines], np.float64),
        "brightness": np.array([light.image[..., 1][shown].mean()], np.float64),
        "sharpness": np.array([_step(light.image, shown, 1) / max(_step(light.image, shown, _EDGE_PIXELS), 1.0)]),
        "stalls": np.array([len(stalls)], np.float64),
        "stalls_per_1000_m2": np.array([1e3 * len(stalls) / area], np.float64),
    }


def _step(image: NDArray[np.uint8], shown: NDArray[np.bool_], pixels: int) -> float:
    """Return the difference of green over some pixels along rows, grey levels, at the strongest edges."""
    green = image[..., 1].astype(np.float64)
    apart = np.abs(green[:, pixels:] - green[:, :-pixels])[shown[:, pixels:] & shown[:, :-pixels]]
    return float(np.percentile(apart, _EDGE_PERCENTILE)) if len(apart) else 0.0


def _some(values: Floats) -> Floats:
    """Return evenly spaced ones of values, so that no picture outweighs the others by its shade."""
    return np.asarray(values[:: max(1, len(values) // _LARGEST_SAMPLE)], np.float64)


def worlds(seeds: Sequence[int]) -> Iterator[Place]:
    """Yield drawn worlds by day, as a camera with a long lens sees them from far above the middle of the lot."""
    middle = (_WORLD_PIXELS - 1) / 2
    focal = _WORLD_HEIGHT_M / GROUND_M
    model = CameraModel(_WORLD_PIXELS, _WORLD_PIXELS, focal, focal, middle, middle)
    for seed in seeds:
        world = generate_world(seed)
        outline = np.concatenate([np.asarray(lot, float) for lot in world.lots])
        centre = (outline.min(axis=0) + outline.max(axis=0)) / 2
        rng = np.random.default_rng(seed)
        camera = WorldCamera(world, model)
        image = camera.render(float(centre[0]), float(centre[1]), _WORLD_HEIGHT_M, 0.0, 0.0, 0.0, rng=rng)
        shown = [stall.corners for stall in world.stalls if not stall.hidden]
        corners = np.array(shown, float).reshape(-1, 4, 2) - centre + (middle + 0.5) * GROUND_M
        size = _WORLD_PIXELS * GROUND_M
        corners = corners[((corners >= 0) & (corners <= size)).all(axis=(1, 2))]
        truth = LabelledPlace(corners, state_array([StallState.UNKNOWN] * len(corners)))
        yield Place(f"world {seed}", np.asarray(image, np.uint8), GROUND_M, truth)


def scenes(count: int) -> Iterator[Place]:
    """Yield scenes as the network is trained on them, those without a stall left out."""
    for seed in range(count):
        scene = draw_scene(np.random.default_rng(seed), metres_per_pixel=GROUND_M)
        quads = [(stall.quad + 0.5) * GROUND_M for stall in scene.stalls if not stall.hidden]
        corners = np.array(quads, float).reshape(-1, 4, 2)
        if len(corners):
            truth = LabelledPlace(corners, state_array([StallState.UNKNOWN] * len(corners)))
            yield Place(f"scene {seed}", np.asarray(scene.image, np.uint8), GROUND_M, truth)


def table(columns: dict[str, dict[str, Spread]]) -> str:
    """Return the table in Markdown, a column for each kind of picture."""
    lines = ["| | " + " | ".join(columns) + " |", "|---" * (len(columns) + 1) + "|"]
    for name, text in ROWS.items():
        lines.append(f"| {text} | " + " | ".join(str(spreads[name]) for spreads in columns.values()) + " |")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure by command line."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.perception.likeness",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--lots", type=Path, metavar="DIR")
    parser.add_argument("--regions", type=Path, metavar="DIR")
    parser.add_argument("--worlds", type=seeds_option, default=[], metavar="A-B", help="seeds of drawn worlds")
    parser.add_argument("--scenes", type=int, default=0, metavar="N", help="scenes to train on")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures here")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    asked: dict[str, Callable[[], Iterable[Place]]] = {}
    if options.lots:
        asked["real lots"] = lambda: read_lots(options.lots)
    if options.regions:
        asked["real regions"] = lambda: read_lots(options.regions)
    if options.worlds:
        asked["drawn worlds"] = lambda: worlds(options.worlds)
    if options.scenes > 0:
        asked["scenes to train on"] = lambda: scenes(options.scenes)
    if not asked:
        parser.error("name --lots, --regions, --worlds or --scenes")
    try:
        columns = {name: statistics(read()) for name, read in asked.items()}
    except (BenchmarkError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    print(table(columns))
    if options.json is not None:
        write_json(options.json, _flat(columns))
    return 0


def _flat(columns: dict[str, dict[str, Spread]]) -> dict[str, float | None]:
    return {
        f"{kind.replace(' ', '_')}_{name}_{part}": value if np.isfinite(value) else None
        for kind, spreads in columns.items()
        for name, spread in spreads.items()
        for part, value in (("p10", spread.low), ("p50", spread.median), ("p90", spread.high))
    }


if __name__ == "__main__":
    sys.exit(main())
