"""Fits the probability of vehicles (`hawk.algo.vision.vehicles.PROBABILITY_WEIGHTS`) to labels by hand.

``python -m training.vehicles --ground DIR --model FILE`` prints the weights of a logistic regression over the scores of
what the network finds in labelled regions. ``--left-out FILE=PATTERN`` names the network that was not trained on some
of them, which looks at these. Each region's error of calibration is that of weights which are fitted to the others.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from benchmarks.cars.eyes import SeenVehicles, vehicles_in
from benchmarks.cars.measures import judged
from benchmarks.cars.scenes import CarScene, read_regions
from benchmarks.perception.measures import Judged, calibration_error
from benchmarks.perception.regions import left_out_option, model_for
from hawk.algo.vision.detection import FloatArray
from hawk.algo.vision.network import StallNetwork
from hawk.algo.vision.vehicles import log_odds_of
from hawk.picture.orthophoto.tile_detector import corners_of
from training.rows import logistic


def main(arguments: Sequence[str] | None = None) -> None:
    """Fit by command line."""
    parser = argparse.ArgumentParser(prog="python -m training.vehicles", description=__doc__)
    parser.add_argument("--ground", type=Path, required=True, help="folder of the regions that benchmarks.cars labels")
    parser.add_argument(
        "--left-out", action="append", default=[], type=left_out_option, metavar="FILE=PATTERN",
        help="a network that was not trained on the regions of these names looks at them",
    )  # fmt: skip
    parser.add_argument("--model", type=Path, help="an ONNX file in place of the package's")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    networks = {path: StallNetwork.load(path) for path in {options.model, *(path for path, _ in options.left_out)}}
    parts = {
        scene.name: scored(scene, networks[model_for(options.left_out, scene.name) or options.model])
        for scene in read_regions(options.ground)
    }
    weights = fit(list(parts.values()))
    for name, part in parts.items():
        others = fit([other for each, other in parts.items() if each != name])
        said = Judged(1 / (1 + np.exp(-(others[0] + others[1] * log_odds_of(part.said)))), part.true)
        print(f"{name:24s} {len(part.true):5d} finds, calibration error {calibration_error([said]):.3f}")
    for name, value in zip(("constant", "log-odds of the score"), weights.tolist(), strict=True):
        print(f"{value:8.2f}  {name}")


def scored(scene: CarScene, network: StallNetwork) -> Judged:
    """Return the scores (N,) of the vehicles that a network finds in a picture, and which are vehicles.

    Raises ValueError for a network that knows none.
    """
    found = vehicles_in(network, scene)
    return judged(SeenVehicles(corners_of(found.boxes), found.boxes.score), scene)


def fit(parts: Sequence[Judged]) -> FloatArray:
    """Return constant and weight (2,) of the log-odds of scores."""
    said, true = (np.concatenate([getattr(part, name) for part in parts]) for name in ("said", "true"))
    return logistic(log_odds_of(said)[:, None], true.astype(np.float64), np.ones(len(true)))


if __name__ == "__main__":
    main()
