"""Fits the evidence of rows (`hawk.algo.rows.evidence`): ``python -m training.rows --scenes 120 --ground DIR``.

A logistic regression over the places of rows that the network's finds propose: stalls of drawn scenes and of labelled
regions against the places between and beside them. It prints the weights, which `hawk.algo.rows.evidence.WEIGHTS`
holds.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.rows.evidence import FEATURES, Strip, strip
from hawk.algo.rows.fit import Row, fit_rows
from hawk.algo.rows.sequence import RowOptions
from hawk.algo.vision import decode, quads
from hawk.algo.vision.detection import FloatArray
from hawk.algo.vision.network import CELL_PIXELS, StallNetwork
from hawk.picture.orthophoto.tile_detector import finds_of, ground_at
from training.ground import read_ground
from training.pool import training_scene
from training.scenes import draw_scene
from training.targets import CELL_M, TrainingScene, shape_of

_SCENE_PIXELS: Final = 704
_HIT, _MISS = 0.15, 0.32
"""A place within the first share of a pitch of a stall is one, beyond the second it is none."""
_WHOLE: Final = 0.97
_DRAWN_WEIGHT: Final = 0.02
"""Drawn places are many, and easy."""
_REAL_WEIGHT: Final = 0.1
"""Neighbouring steps of a strip say nearly the same."""
_RIDGE: Final = 1.0
_ROUNDS: Final = 25


@dataclass(frozen=True, slots=True)
class Places:
    """Features (N, F) of places, whether a stall is there (N,), and their weights (N,)."""

    features: FloatArray = field(repr=False)
    is_stall: FloatArray = field(repr=False)
    weight: FloatArray = field(repr=False)


def main(arguments: Sequence[str] | None = None) -> None:
    """Fit by command line."""
    parser = argparse.ArgumentParser(prog="python -m training.rows", description=__doc__)
    parser.add_argument("--scenes", type=int, default=120, help="drawn scenes (120)")
    parser.add_argument("--seed", type=int, default=777, help="of the scenes (777)")
    parser.add_argument("--ground", type=Path, help="folder of labelled pictures of real ground (training.ground)")
    parser.add_argument("--leave-out", action="append", default=[], metavar="PATTERN", help="names not to fit to")
    parser.add_argument("--model", type=Path, help="an ONNX file in place of the package's")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    network = StallNetwork.load(options.model)
    parts = [places(scene, network, _DRAWN_WEIGHT) for scene in _drawn(options.seed, options.scenes)]
    if options.ground is not None:
        ground = read_ground(options.ground, network, options.leave_out)
        parts += [places(region.scene, network, _REAL_WEIGHT) for region in ground.regions]
    fitted = fit(joined(parts))
    print(f"{sum(len(part.weight) for part in parts)} places")
    for name, value in zip(("constant", *FEATURES), fitted.tolist(), strict=True):
        print(f"{value:8.2f}  {name}")


def _drawn(seed: int, count: int) -> Iterator[TrainingScene]:
    for number in range(count):
        yield training_scene(draw_scene(np.random.default_rng((seed, number)), _SCENE_PIXELS))


def joined(parts: Sequence[Places]) -> Places:
    """Return the places of several scenes as one."""
    none = Places(np.zeros((0, len(FEATURES))), np.zeros(0), np.zeros(0))
    columns = ([getattr(part, name) for part in (*parts, none)] for name in Places.__slots__)
    return Places(*(np.concatenate(column) for column in columns))


def places(scene: TrainingScene, network: StallNetwork, weight: float) -> Places:
    """Return the places of all rows that the network's finds propose in a scene, without those nobody can judge."""
    maps = network.run(scene.image)
    finds = finds_of(decode.vote(maps, CELL_M))
    parts = []
    for row in fit_rows(finds, RowOptions().finds_from):
        read = strip(row, partial(ground_at, maps), finds)
        is_stall, judged = _judged(row, read, scene)
        parts.append(Places(read.features[judged], is_stall[judged], np.full(int(judged.sum()), weight)))
    return joined(parts)


def _judged(row: Row, read: Strip, scene: TrainingScene) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return whether a stall is at each place (M,), and which places are judged (M,)."""
    whole = read.seen > _WHOLE
    if not len(scene.quads):
        return np.zeros(len(read.t)), whole
    centre, angle, width, length = shape_of(np.asarray(scene.quads, np.float64) / CELL_PIXELS * CELL_M)
    offset = row.centres(read.t)[:, None] - centre
    along = offset @ row.along
    aside = offset @ row.side - along * float(row.along @ row.side)
    alike = (np.abs(aside) < 0.3 * row.length) & (quads.angle_between(row.angle, angle) < 0.25)
    apart = np.where(alike, np.abs(along) / row.pitch, np.inf)
    nearest = apart.argmin(axis=1)
    least = apart[np.arange(len(apart)), nearest]
    touches = (np.abs(along) < (row.pitch + width) / 2) & (np.abs(aside) < 0.4 * (row.length + length))
    unclear = (touches & ~scene.judged).any(axis=1)
    return (least < _HIT).astype(float), whole & ~unclear & ((least < _HIT) | (least > _MISS))


def fit(given: Places) -> FloatArray:
    """Return constant and weights (1 + F,) of a logistic regression, by Newton's steps with a small ridge."""
    return logistic(given.features, given.is_stall, given.weight)


def logistic(features: FloatArray, is_so: FloatArray, weight: FloatArray) -> FloatArray:
    """Return constant and weights (1 + F,) for features (N, F) of what is so (N,; 0 or 1), weighted (N,)."""
    middle, spread = features.mean(0), features.std(0) + 1e-6
    terms = np.column_stack([np.ones(len(weight)), (features - middle) / spread])
    ridge = np.diag([0.0, *[_RIDGE] * features.shape[1]])
    found = np.zeros(terms.shape[1])
    for _ in range(_ROUNDS):
        said = 1 / (1 + np.exp(-terms @ found))
        slope = terms.T @ (weight * (is_so - said)) - ridge @ found
        curve = (terms * (weight * said * (1 - said))[:, None]).T @ terms + ridge
        found = found + np.linalg.solve(curve, slope)
    weights = found[1:] / spread
    return np.concatenate([[found[0] - weights @ middle], weights])


if __name__ == "__main__":
    main()
