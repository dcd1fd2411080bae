"""Pictures that are cut close to their stalls: ``python -m benchmarks.perception.close DIR... [--margins 0.3,9.3]``.

Each group of at least eight labelled stalls (places of `benchmarks.perception.places.read_lots`) is cut out of its
picture with that many metres around it, and drawn rows too (``--drawn``: plain asphalt, white lines). What is found is
counted as `hawk.picture.orthophoto.tile_detector` looks at pictures, and without what it shows the network beyond their
ends.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.options import folder_option
from benchmarks.perception.places import read_lots
from hawk.algo.vision.detector import ALL_ENDS, NO_ENDS
from hawk.picture.orthophoto.tile_detector import TileDetector
from hawk.survey.accuracy import FloatArray, match

LEAST: Final = 8
"""Stalls of a group."""
_JOIN_M: Final = 3.5
"""Stalls nearer to each other are of one group."""
_WIDE, _LONG, _AISLE, _METRES = 2.5, 5.0, 6.0, 0.05


@dataclass(frozen=True, slots=True)
class Cut:
    """A picture cut close to stalls (N, 4, 2), metres from its upper left corner."""

    image: NDArray[np.uint8]
    metres: float
    stalls: FloatArray


def cuts(folder: Path, margin_m: float, least: int) -> Iterator[Cut]:
    """Yield the groups of stalls of a folder's places that lie wholly within their pictures."""
    for place in read_lots(folder):
        size = np.array(place.image.shape[1::-1]) * place.metres_per_pixel
        for stalls in _groups(place.truth.stalls):
            low, high = stalls.min(axis=(0, 1)), stalls.max(axis=(0, 1))
            if len(stalls) < least or (low < 1.0).any() or (high > size - 1.0).any():
                continue
            first = np.maximum(np.floor((low - margin_m) / place.metres_per_pixel), 0).astype(int)
            last = np.ceil((high + margin_m) / place.metres_per_pixel).astype(int)
            image = np.ascontiguousarray(place.image[first[1] : last[1], first[0] : last[0]])
            yield Cut(image, place.metres_per_pixel, stalls - first * place.metres_per_pixel)


def _groups(stalls: FloatArray) -> list[FloatArray]:
    parts = shapely.get_parts(shapely.union_all([shapely.Polygon(each).buffer(_JOIN_M / 2) for each in stalls]))
    middles = stalls.mean(axis=1)
    return [stalls[shapely.contains_xy(part, middles[:, 0], middles[:, 1])] for part in parts.tolist()]


def drawn(margin_m: float) -> Iterator[Cut]:
    """Yield drawn lots of 30 free stalls: one, two and three rows, on asphalt of three brightnesses."""
    rng = np.random.default_rng(0)
    for grey in (60, 90, 130):
        for rows in (1, 2, 3):
            count = 30 // rows
            tops = margin_m + np.arange(rows) * (_LONG + _AISLE)
            size = (tops[-1] + _LONG + margin_m, 2 * margin_m + count * _WIDE)
            image = np.full((*(round(side / _METRES) for side in size), 3), grey, np.float64)
            for top in tops:
                rows_of = slice(round(top / _METRES), round((top + _LONG) / _METRES))
                for k in range(count + 1):
                    column = round((margin_m + k * _WIDE) / _METRES)
                    image[rows_of, max(0, column - 1) : column + 1] = 230
            noisy = cv2.GaussianBlur(image + rng.normal(0, 6, image.shape), (3, 3), 0)
            corner = np.array([[margin_m + k * _WIDE, top] for top in tops for k in range(count)])
            box = np.array([(0, 0), (_WIDE, 0), (_WIDE, _LONG), (0, _LONG)])
            yield Cut(np.clip(noisy, 0, 255).astype(np.uint8), _METRES, corner[:, None] + box)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print, for each margin, how many stalls are found as the program looks, and without ground beyond the ends."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.perception.close", description=__doc__)
    parser.add_argument("folders", type=folder_option, nargs="*", metavar="DIR")
    parser.add_argument("--drawn", action="store_true", help="drawn rows too")
    parser.add_argument("--margins", default="0.3,9.3", help="metres around the stalls (0.3,9.3)")
    parser.add_argument("--least", type=int, default=LEAST, help="stalls of a group (8)")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    detector = TileDetector.load()
    for margin_m in (float(each) for each in options.margins.split(",")):
        found, alone, count = np.zeros(2, int), np.zeros(2, int), 0
        every = [cut for folder in options.folders for cut in cuts(folder, margin_m, options.least)]
        for cut in [*every, *(drawn(margin_m) if options.drawn else ())]:
            count += len(cut.stalls)
            for k, ends in enumerate((ALL_ENDS, NO_ENDS)):
                stalls = detector.detect(cut.image, cut.metres, ends=ends).stalls
                hits = len(match(stalls, cut.stalls).found)
                found[k] += hits
                alone[k] += len(stalls) - hits
        print(
            f"margin {margin_m:g} m: {found[0]} of {count} found, {alone[0]} more; without: {found[1]}, {alone[1]} more"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
