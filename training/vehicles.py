"""Fits the probability of vehicles (`hawk.algo.vision.vehicles.PROBABILITY_WEIGHTS`) to labels by hand.

``python -m training.vehicles --ground DIR --model FILE`` prints the weights of a logistic regression over the scores of
what the network finds in labelled regions. Regions of ``--leave-out`` are judged by weights that are fitted without
them: their error of calibration is printed with a star.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

import cv2
import numpy as np

from benchmarks.cars.eyes import SeenVehicles, corners_of, vehicles_in
from benchmarks.cars.measures import judged
from benchmarks.cars.scenes import CarScene, read_regions
from benchmarks.perception.measures import Judged, calibration_error
from hawk.algo.vision.detection import FloatArray
from hawk.algo.vision.network import StallNetwork
from hawk.algo.vision.vehicles import log_odds_of
from training.rows import logistic


def main(arguments: Sequence[str] | None = None) -> None:
    """Fit by command line."""
    parser = argparse.ArgumentParser(prog="python -m training.vehicles", description=__doc__)
    parser.add_argument("--ground", type=Path, required=True, help="folder of the regions that benchmarks.cars labels")
    parser.add_argument("--leave-out", action="append", default=[], metavar="PATTERN", help="regions not to fit to")
    parser.add_argument("--model", type=Path, help="an ONNX file in place of the package's")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    network = StallNetwork.load(options.model)
    parts = {scene.name: scored(scene, network) for scene in read_regions(options.ground)}
    kept = {n for n in parts if not any(fnmatchcase(n, pattern) for pattern in options.leave_out)}
    weights = fit([parts[name] for name in parts if name in kept])
    for name, part in parts.items():
        said = Judged(1 / (1 + np.exp(-(weights[0] + weights[1] * log_odds_of(part.said)))), part.true)
        words = f"{name:24s} {len(part.true):5d} finds, calibration error {calibration_error([said]):.3f}"
        print(words, "" if name in kept else "*")
    for name, value in zip(("constant", "log-odds of the score"), weights.tolist(), strict=True):
        print(f"{value:8.2f}  {name}")


def scored(scene: CarScene, network: StallNetwork) -> Judged:
    """Return the scores (N,) of the vehicles that a network finds in a picture, and which are vehicles.

    Raises ValueError for a network that knows none.
    """
    found = vehicles_in(network, scene)
    return judged(SeenVehicles(corners_of(found), found.boxes.score), scene)


def fit(parts: Sequence[Judged]) -> FloatArray:
    """Return constant and weight (2,) of the log-odds of scores."""
    said, true = (np.concatenate([getattr(part, name) for part in parts]) for name in ("said", "true"))
    return logistic(log_odds_of(said)[:, None], true.astype(np.float64), np.ones(len(true)))


if __name__ == "__main__":
    main()
