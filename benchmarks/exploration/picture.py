"""Pictures of flights: the lot, the fence, what the drone flew and what the oracle would have flown."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.exploration.report import distance_over_oracle
from benchmarks.exploration.runs import SeedRun

_SIZE: Final = 900
_MARGIN_M: Final = 30.0
_GROUND, _LOT, _FENCE = (60, 90, 60), (150, 150, 150), (40, 40, 200)
_FLOWN, _AFTER, _ORACLE, _TEXT = (255, 80, 0), (255, 190, 120), (0, 200, 255), (255, 255, 255)

Image = NDArray[np.uint8]


def draw_worst(runs: list[SeedRun], folder: Path, setup: str, count: int = 10) -> list[Path]:
    """Write a picture of each of the worst runs; return the files, the worst first."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for place, run in enumerate(sorted(runs, key=distance_over_oracle, reverse=True)[:count], 1):
        path = folder / f"{setup}-{place:02d}-seed-{run.lot.seed}.png"
        cv2.imwrite(str(path), draw(run))
        paths.append(path)
    return paths


def draw(run: SeedRun) -> Image:
    """Return the picture of one run, north up."""
    low = np.array(run.lot.shape.bounds[:2]) - _MARGIN_M
    high = np.array(run.lot.shape.bounds[2:]) + _MARGIN_M
    scale = _SIZE / float((high - low).max())
    height, width = np.ceil((high - low) * scale).astype(int)
    image = np.full((height, width, 3), _GROUND, np.uint8)

    def pixels(places: NDArray[np.float64]) -> NDArray[np.int32]:
        north, east = places[:, 0], places[:, 1]
        return np.column_stack([(east - low[1]) * scale, (high[0] - north) * scale]).round().astype(np.int32)

    for part in shapely.get_parts(run.lot.shape):
        cv2.fillPoly(image, [pixels(np.array(part.exterior.coords))], _LOT, cv2.LINE_AA)
        for hole in part.interiors:
            cv2.fillPoly(image, [pixels(np.array(hole.coords))], _GROUND, cv2.LINE_AA)
    cv2.polylines(image, [pixels(np.array(run.lot.fence.polygon))], True, _FENCE, 1, cv2.LINE_AA)
    cv2.polylines(image, [pixels(run.oracle.places)], False, _ORACLE, 2, cv2.LINE_AA)
    track = run.planner.track
    seen = int(np.searchsorted(track[:, 2], 0.98))
    cv2.polylines(image, [pixels(track[seen:, :2])], False, _AFTER, 2, cv2.LINE_AA)
    cv2.polylines(image, [pixels(track[: seen + 1, :2])], False, _FLOWN, 2, cv2.LINE_AA)
    cv2.circle(image, tuple(pixels(track[:1, :2])[0].tolist()), 6, _FLOWN, cv2.FILLED, cv2.LINE_AA)
    _write(image, run)
    return image


def _write(image: Image, run: SeedRun) -> None:
    flight = run.planner
    distance = (
        "never"
        if flight.distance_m is None
        else f"{flight.distance_m:.0f} m ({distance_over_oracle(run):.2f} of the best)"
    )
    lines = (
        f"seed {run.lot.seed}, {run.lot.kind}, {run.lot.area / 1e4:.1f} ha",
        f"98 % seen: {distance}; whole {flight.whole_distance_m:.0f} m, {flight.end}",
        f"oracle {run.oracle.distance_m:.0f} m, bound {run.bound:.0f} m",
    )
    for number, line in enumerate(lines, 1):
        cv2.putText(image, line, (10, 22 * number), cv2.FONT_HERSHEY_SIMPLEX, 0.55, _TEXT, 1, cv2.LINE_AA)
