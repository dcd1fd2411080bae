"""Worth of a known sun: ``python -m benchmarks.perception.suns --scenes 100 --model FILE``.

Drawn scenes know their sun. The network looks at each three times: with that sun, without any, and with one whose
shadows fall 120 degrees beside the true ones. Scenes without a sun (night) are left out. Stalls that a picture does not
show, and those that its edge cuts, count as neither right nor wrong.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from benchmarks.perception.edges import cut_labels, finds_of_cut, without
from benchmarks.perception.eyes import NetworkEye
from benchmarks.perception.measures import line
from benchmarks.perception.places import Place, state_array
from hawk.algo.vision.network import StallNetwork, sun_input
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import Finding, FloatArray, LabelledPlace, Tally, tally
from training.pool import training_scene
from training.scenes import draw_scene
from training.targets import TrainingScene

SCALE: Final = 0.1
_SIDE: Final = 512
_WRONG: Final = np.radians(120)
_LOW: Final = 1.0
"""Shadows longer than this, metres for one of height, are long: a sun below 45 degrees."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure by command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.perception.suns", description=__doc__)
    parser.add_argument("--scenes", type=int, default=100, help="drawn scenes (100)")
    parser.add_argument("--seed", type=int, default=4711, help="of the scenes (4711)")
    parser.add_argument("--model", type=Path, help="an ONNX file in place of the package's")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    network = StallNetwork.load(options.model)
    sums: dict[str, Tally] = {}
    for scene in _scenes(options.seed, options.scenes):
        for name, counts in looks(network, scene).items():
            sums[name] = sums.get(name, Tally()) + counts
    for name, total in sorted(sums.items()):
        print(f"{name:24s} {total.true:5d} stalls  {line(total.measures())}")


def looks(network: StallNetwork, scene: TrainingScene) -> dict[str, Tally]:
    """Return the counts of a scene with the true, no, and a wrong sun, by name; those of long shadows also apart."""
    assert scene.cast is not None
    turn = np.array([[np.cos(_WRONG), -np.sin(_WRONG)], [np.sin(_WRONG), np.cos(_WRONG)]])
    suns: dict[str, FloatArray | None] = {"true": scene.cast, "none": None, "wrong": turn @ scene.cast}
    counts = {}
    for name, cast in suns.items():
        counts[name] = counted(NetworkEye(network, None if cast is None else sun_input(cast)), scene)
        if np.hypot(*scene.cast) > _LOW:
            counts[f"{name}, long shadows"] = counts[name]
    return counts


def counted(eye: NetworkEye, scene: TrainingScene) -> Tally:
    """Return the counts of an eye over the stalls that a scene shows whole."""
    states = [StallState.TAKEN if taken else StallState.FREE for taken in scene.taken.tolist()]
    truth = LabelledPlace((np.asarray(scene.quads, np.float64) + 0.5) * SCALE, state_array(states), ())
    out = cut_labels(Place("", scene.image, SCALE, truth)) | ~scene.judged
    finding = eye.look(scene.image, SCALE).finding
    left = ~finds_of_cut(finding.stalls, truth.stalls, out)
    kept = Finding(finding.stalls[left], np.asarray(finding.states, object)[left])
    return tally(kept, without(truth, out))


def _scenes(seed: int, count: int) -> Iterator[TrainingScene]:
    """Yield the scenes with a sun."""
    for number in range(count):
        scene = training_scene(draw_scene(np.random.default_rng((seed, number)), _SIDE))
        if scene.cast is not None and scene.cast.any():
            yield replace(scene, quads=scene.quads.reshape(-1, 4, 2))


if __name__ == "__main__":
    main()
