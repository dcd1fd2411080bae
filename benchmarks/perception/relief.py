"""Relief that is left in stalls: standing things show farther from the point below the camera than their feet.

``python -m benchmarks.perception.relief --seeds 1-8`` hovers over drawn worlds, whose cars stand up, and compares the
centres that single frames give with the true ones. The result is the height whose relief displacement r h / H (Wolf,
Dewitt and Wilkinson, Elements of Photogrammetry, 4th ed., 6-8) explains the errors. ``--places DIR`` does so over flat
pictures of places, in which nothing stands up.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.chain_flight.campaign import lots
from benchmarks.figures import write_json
from benchmarks.perception.camera_frames import find_whole, labels_of
from benchmarks.perception.places import folder_option
from benchmarks.surveys import seeds_option
from benchmarks.vision_frame import frames
from hawk.algo.vision.decode import NetworkFinder
from hawk.algo.vision.network import StallNetwork
from hawk.algo.vision.rectify import Rectifier
from hawk.algo.vision.seen import Finder, FloatArray
from hawk.model.lot_map import StallState
from hawk.survey.scoring import match
from hawk.worlds.generate import generate_world
from hawk.worlds.world import World

HEIGHTS_M: Final = (20.0, 35.0, 50.0)
FRAMES: Final = 40
"""Frames over each world from each height."""
_LARGEST_M: Final = 1.0
"""A centre farther off than this is another error."""


@dataclass(frozen=True, slots=True)
class Offsets:
    """Matched stalls of single frames: ``places`` (N, 2) from the point below the camera and ``errors`` (N, 2) of their
    centres, metres; ``taken`` (N,) by the truth.
    """

    places: FloatArray = field(repr=False)
    errors: FloatArray = field(repr=False)
    taken: NDArray[np.bool_] = field(repr=False)

    def height(self, height_m: float, *, taken: bool) -> tuple[float, float, int]:
        """Return the height (metres) whose relief explains the errors from ``height_m``, its standard error, and the
        number of stalls: the least squares of ``error = place * h / height_m``.
        """
        chosen = (self.taken == taken) & (np.hypot(*self.errors.T) < _LARGEST_M)
        places, errors = self.places[chosen] / height_m, self.errors[chosen]
        weight = float((places**2).sum())
        if not weight:
            return math.nan, math.nan, 0
        found = float((places * errors).sum()) / weight
        spread = float(((errors - places * found) ** 2).mean())
        return found, math.sqrt(spread / weight), int(chosen.sum())


def measure(finder: Finder, worlds: Iterable[World], height_m: float, count: int = FRAMES) -> Offsets:
    """Return the offsets of all stalls that lie wholly in frames from ``height_m``."""
    rectifier = Rectifier()
    parts: list[tuple[FloatArray, FloatArray, NDArray[np.bool_]]] = []
    for world in worlds:
        labels = labels_of(world)
        for frame in frames(world, height_m, count, lens=False):
            assert frame.pose is not None
            found = find_whole(finder, rectifier, frame)[0].stalls
            pairs = match(found, labels.stalls)
            centres, real = found[pairs.found].mean(axis=1), labels.stalls[pairs.true].mean(axis=1)
            below = np.array([frame.pose.east, -frame.pose.north])
            parts.append((real - below, centres - real, labels.states[pairs.true] == StallState.TAKEN))
    places, errors, states = (np.concatenate(each) for each in zip(*parts, strict=True))
    return Offsets(places, errors, states)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure by command line."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.perception.relief",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", type=seeds_option, default=[], metavar="LIST", help="drawn worlds, as 1-8")
    parser.add_argument("--places", type=folder_option, metavar="DIR", help="pictures of places with labels")
    parser.add_argument("--frames", type=int, default=FRAMES, metavar="N", help=f"of each world (default {FRAMES})")
    parser.add_argument("--model", type=Path, metavar="FILE", help="other weights (default: those that ship)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures here")
    options = parser.parse_args(arguments)
    if not options.seeds and options.places is None:
        parser.error("name --seeds or --places")
    cv2.setNumThreads(1)
    finder = NetworkFinder(StallNetwork.load(options.model))
    figures: dict[str, float] = {}
    print("| over | height of flight | free stalls | taken stalls |", "|---" * 4 + "|", sep="\n")
    for kind, worlds in _worlds(options).items():
        for height_m in HEIGHTS_M:
            offsets = measure(finder, worlds, height_m, options.frames)
            cells = [offsets.height(height_m, taken=taken) for taken in (False, True)]
            parts = [f"{found:.2f} m ± {error:.2f} ({count})" for found, error, count in cells]
            print(f"| {kind} | {height_m:g} m | " + " | ".join(parts) + " |", flush=True)
            for name, (found, _, _) in zip(("free", "taken"), cells, strict=True):
                figures[f"relief_{kind}_{height_m:g}_{name}_m"] = found
    if options.json is not None:
        write_json(options.json, figures)
    return 0


def _worlds(options: argparse.Namespace) -> dict[str, list[World]]:
    places = [] if options.places is None else [world for _, world in lots(options.places)]
    named = {"worlds": [generate_world(seed) for seed in options.seeds], "places": places}
    return {kind: worlds for kind, worlds in named.items() if worlds}


if __name__ == "__main__":
    raise SystemExit(main())
