"""Fits the two logistic regressions of the classical finder to drawn scenes and prints them.

``python -m training.fit_classical --scenes 160 --seed 91000``

They stand as `_TAKEN` in `hawk.algo.vision.classical.ground` and as `_SCORE` in `hawk.algo.vision.classical.rows`; a
third of the scenes is left out of a first fit, to measure it on others.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from hawk.algo.vision import quads
from hawk.algo.vision.classical import ground as ground_of
from hawk.algo.vision.classical.finder import survey
from hawk.algo.vision.classical.rows import score_features
from hawk.algo.vision.decode import Stalls
from hawk.algo.vision.seen import FloatArray, GroundImage
from training.scenes import Scene, draw_scene
from training.targets import shape_of

_SIZE = (400, 560)
_HELD_OUT = 3
_CLEAR = 0.3  # share of a stall under crowns and roofs up to which its state is learnt
_RIGHT = 0.5
_DECAY = (1e-3, 1e-4)

Lines = list[tuple[FloatArray, FloatArray]]


def main(arguments: Sequence[str] | None = None) -> None:
    """Fit by command line."""
    parser = argparse.ArgumentParser(prog="python -m training.fit_classical", description=__doc__)
    parser.add_argument("--scenes", type=int, default=160)
    parser.add_argument("--seed", type=int, default=91000)
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    taken: Lines = []
    scores: Lines = []
    for number in range(options.scenes):
        scene = draw_scene(np.random.default_rng((options.seed, number)), _SIZE)
        view = _ground_image(scene)
        taken.append(_taken_lines(scene, view))
        scores.append(_score_lines(scene, view))
    for name, lines, decay in (("_TAKEN", taken, _DECAY[0]), ("_SCORE", scores, _DECAY[1])):
        print(
            f"{name} = {np.round(fit(*_joined(lines), decay), 2).tolist()}  # right on others: "
            f"{_held_out(lines, decay):.3f}"
        )


def fit(features: FloatArray, right: FloatArray, decay: float) -> FloatArray:
    """Return the weights (F,) of a logistic regression of ``right`` (N,), 0 or 1, on ``features`` (N, F), the constant
    first; ``decay`` (ridge) keeps all but the constant's small.
    """
    shrink = np.r_[0.0, np.full(features.shape[1] - 1, decay)]

    def loss(weights: FloatArray) -> tuple[float, FloatArray]:
        said = features @ weights
        slope = features.T @ (1 / (1 + np.exp(-said)) - right) / len(right) + 2 * shrink * weights
        return float((np.logaddexp(0, said) - right * said).mean() + (shrink * weights**2).sum()), slope

    return np.asarray(minimize(loss, np.zeros(features.shape[1]), jac=True, method="L-BFGS-B").x)


def _taken_lines(scene: Scene, view: GroundImage) -> tuple[FloatArray, FloatArray]:
    corners = np.array([stall.quad for stall in scene.stalls]).reshape(-1, 4, 2)
    height, width = scene.image.shape[:2]
    clear = np.array([not s.hidden and s.covered < _CLEAR for s in scene.stalls], np.bool_)
    inside = ((corners > 0) & (corners < (width, height))).all(axis=(1, 2)) & clear
    stalls = _stalls(corners)
    ground = ground_of.survey_ground(view.values, view.valid, stalls, view.metres_per_pixel)
    features = ground_of.stall_features(ground, stalls)[inside]
    right = np.array([stall.taken for stall in scene.stalls], float)[inside]
    return np.column_stack([np.ones(len(right)), features]), right


def _score_lines(scene: Scene, view: GroundImage) -> tuple[FloatArray, FloatArray]:
    _, _, bays, ground = survey(view)
    features = score_features(bays, ground_of.taken(ground, bays.stalls))
    found = bays.stalls.corners()
    true = np.array([stall.quad for stall in scene.stalls]).reshape(-1, 4, 2)
    overlap = np.zeros(len(found))
    if len(found) and len(true):
        i, j = quads.near_pairs(found.mean(axis=1), true.mean(axis=1), 35.0)
        np.maximum.at(overlap, i, quads.overlaps(found[i], true[j]))
    return features, (overlap > _RIGHT).astype(float)


def _ground_image(scene: Scene) -> GroundImage:
    side = scene.metres_per_pixel
    to_map = np.array([[0.0, -side, 0.0], [side, 0.0, 0.0]])
    return GroundImage(scene.image, to_map, np.ones(scene.image.shape[:2], np.bool_))


def _stalls(corners: FloatArray) -> Stalls:
    centre, angle, width, length = shape_of(corners)
    return Stalls(centre[:, 0], centre[:, 1], angle, width, length, np.ones(len(corners)))


def _joined(lines: Lines) -> tuple[FloatArray, FloatArray]:
    kept = [line for line in lines if len(line[1])]
    return np.concatenate([line[0] for line in kept]), np.concatenate([line[1] for line in kept])


def _held_out(lines: Lines, decay: float) -> float:
    """Return the share of right answers on every third scene after a fit to the others."""
    others = [line for k, line in enumerate(lines) if k % _HELD_OUT]
    features, right = _joined(lines[::_HELD_OUT])
    said: NDArray[np.bool_] = features @ fit(*_joined(others), decay) > 0
    return float((said == (right > 0)).mean())


if __name__ == "__main__":
    main()
