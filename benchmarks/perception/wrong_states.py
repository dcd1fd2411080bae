"""Pictures of the stalls whose state is wrong, to look at one by one: is it the network, or the label?

``python -m benchmarks.perception.wrong_states --lots DIR --tiles DIR --out DIR`` writes ``lots.png`` and ``tiles.png``:
numbered cuttings of 14 m about each such stall, with its label's outline, green where the label calls it free and red
where taken. ``--lots`` and ``--tiles`` are those of ``python -m benchmarks.perception``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.perception.eyes import NetworkEye
from benchmarks.perception.measures import Looked, look
from benchmarks.perception.places import Place, folder_option, read_lots, read_tiles
from hawk.algo.vision.network import StallNetwork
from hawk.model.lot_map import StallState
from hawk.survey.scoring import FloatArray, match

AROUND_M: Final = 7.0
"""From a stall's middle to the edge of its cutting, metres."""
SIDE_PX: Final = 230
COLUMNS: Final = 8
_COLOURS: Final = {StallState.FREE: (0, 255, 0), StallState.TAKEN: (0, 0, 255)}

Picture = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Wrong:
    """A stall of a place, its label's corners (4, 2) in metres, and the state that the label gives it."""

    place: Place = field(repr=False)
    corners: FloatArray
    labelled: StallState


def wrong_states(looked: Iterable[Looked]) -> Iterator[Wrong]:
    """Yield the matched stalls whose labelled state is free or taken, and not the one that was found."""
    for one in looked:
        finding, truth = one.kept.result.finding, one.kept.truth
        pairs = match(finding.stalls, truth.stalls)
        for found, label in zip(pairs.found, pairs.true, strict=True):
            state = truth.states[label]
            if state in _COLOURS and state != finding.states[found]:
                yield Wrong(one.place, truth.stalls[label], StallState(state))


def sheet(wrong: Sequence[Wrong]) -> Picture:
    """Return the cuttings of all stalls, numbered from 0, `COLUMNS` in a row."""
    rows = max(1, -(-len(wrong) // COLUMNS))
    drawn = np.zeros((rows * SIDE_PX, COLUMNS * SIDE_PX, 3), np.uint8)
    for number, one in enumerate(wrong):
        top, left = number // COLUMNS * SIDE_PX, number % COLUMNS * SIDE_PX
        part = _cutting(one)
        for colour, width in (((255, 255, 255), 2), ((0, 0, 0), 1)):
            cv2.putText(part, str(number), (3, 20), cv2.FONT_HERSHEY_SIMPLEX, 0.6, colour, width)
        drawn[top : top + SIDE_PX, left : left + SIDE_PX] = part
    return drawn


def _cutting(wrong: Wrong) -> Picture:
    scale = wrong.place.metres_per_pixel
    corners = wrong.corners / scale
    image = wrong.place.image.copy()
    cv2.polylines(image, [np.rint(corners).astype(np.int32)], True, _COLOURS[wrong.labelled], 1)
    reach = round(AROUND_M / scale)
    x, y = np.rint(corners.mean(axis=0)).astype(int) + reach
    around = cv2.copyMakeBorder(image, reach, reach, reach, reach, cv2.BORDER_CONSTANT)
    part = around[y - reach : y + reach, x - reach : x + reach]
    return np.asarray(cv2.resize(part, (SIDE_PX, SIDE_PX), interpolation=cv2.INTER_CUBIC), np.uint8)


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the pictures by command line."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.perception.wrong_states",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--lots", type=folder_option)
    parser.add_argument("--tiles", type=folder_option)
    parser.add_argument("--out", type=Path, required=True, help="folder for the pictures")
    parser.add_argument("--model", type=Path, help="an ONNX file in place of the package's")
    options = parser.parse_args(arguments)
    if not (options.lots or options.tiles):
        parser.error("name places with --lots, or tiles with --tiles")
    cv2.setNumThreads(1)
    eye = NetworkEye(StallNetwork.load(options.model))
    options.out.mkdir(parents=True, exist_ok=True)
    for name, folder, read in (("lots", options.lots, read_lots), ("tiles", options.tiles, read_tiles)):
        if folder is not None:
            wrong = list(wrong_states(look(eye, read(folder))))
            cv2.imwrite(str(options.out / f"{name}.png"), sheet(wrong))
            print(f"{name}: {len(wrong)} wrong states, {options.out / f'{name}.png'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
