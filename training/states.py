"""Fits the states of stalls (`hawk.algo.vision.decode.STATE_WEIGHTS`): ``python -m training.states --ground DIR``.

A logistic regression over what the network says of the stalls that it finds, in drawn scenes, and in labelled regions
(``REGION.jpg``, ``REGION.json``) whose states ``dutch_states.json`` has. It prints the weights and how many states are
right. Regions of ``--leave-out`` are judged by weights that are fitted without them.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.perception.edges import cut_labels
from benchmarks.perception.eyes import north_up
from benchmarks.perception.places import Place, read_lots, state_array
from hawk.algo.vision.decode import STATE_FEATURES, state_features
from hawk.algo.vision.detection import FloatArray
from hawk.algo.vision.network import StallNetwork, sun_input
from hawk.model.lot_map import StallState
from hawk.picture.orthophoto.tile_detector import CELL_M, GROUND_M, stalls_of
from hawk.survey.accuracy import LabelledPlace, match
from training.pool import training_scene
from training.rows import logistic
from training.scenes import draw_scene

DUTCH_STATES: Final = Path(__file__).with_name("dutch_states.json")
_SCENE_PIXELS: Final = 512


@dataclass(frozen=True, slots=True)
class Judged:
    """Features (N, F) of stalls that were found, and whether each is taken (N,)."""

    features: FloatArray = field(repr=False)
    taken: NDArray[np.bool_] = field(repr=False)


def main(arguments: Sequence[str] | None = None) -> None:
    """Fit by command line."""
    parser = argparse.ArgumentParser(prog="python -m training.states", description=__doc__)
    parser.add_argument("--scenes", type=int, default=200, help="drawn scenes (200)")
    parser.add_argument("--seed", type=int, default=991, help="of the scenes (991)")
    parser.add_argument("--ground", type=Path, help="folder of the regions of dutch_states.json")
    parser.add_argument("--leave-out", action="append", default=[], metavar="PATTERN", help="regions not to fit to")
    parser.add_argument("--model", type=Path, help="an ONNX file in place of the package's")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    network = StallNetwork.load(options.model)
    parts = {"drawn": joined([judged(place, network, cast) for place, cast in drawn(options.seed, options.scenes)])}
    if options.ground is not None:
        parts |= {place.name: judged(place, network, None) for place in regions(options.ground, DUTCH_STATES)}
    kept = {n for n in parts if not any(fnmatchcase(n, pattern) for pattern in options.leave_out)}
    weights = fit(joined([parts[name] for name in parts if name in kept]))
    for name, part in parts.items():
        print(f"{name:24s} {len(part.taken):5d} states, right {right(part, weights):.4f}", "" if name in kept else "*")
    for name, value in zip(("constant", *STATE_FEATURES), weights.tolist(), strict=True):
        print(f"{value:8.2f}  {name}")


def drawn(seed: int, count: int) -> Iterator[tuple[Place, FloatArray | None]]:
    """Yield drawn scenes as places, each with the shadow of one metre in its picture; unjudged stalls are unknown."""
    for number in range(count):
        scene = training_scene(draw_scene(np.random.default_rng((seed, number)), _SCENE_PIXELS))
        states = np.where(scene.taken, StallState.TAKEN, StallState.FREE).astype(object)
        states[~scene.judged] = StallState.UNKNOWN
        quads = (np.asarray(scene.quads, np.float64).reshape(-1, 4, 2) + 0.5) * GROUND_M
        truth = LabelledPlace(quads, state_array(states.tolist()), ())
        yield Place(f"scene {number}", scene.image, GROUND_M, truth), scene.cast


def regions(folder: Path, labels: Path) -> Iterator[Place]:
    """Yield the regions of a folder that a file of states names, with these states.

    Raises ValueError where the file names a stall that a region lacks.
    """
    states = json.loads(labels.read_text())["states"]
    for place in read_lots(folder):
        if place.name not in states:
            continue
        known = [StallState.UNKNOWN] * len(place.truth.stalls)
        for state in (StallState.FREE, StallState.TAKEN):
            for number in states[place.name][state.value]:
                if not 0 <= number < len(known):
                    raise ValueError(f"{labels}: {place.name} has no stall {number}; name those of its file, from 0")
                known[number] = state
        truth = LabelledPlace(place.truth.stalls, state_array(known), place.truth.lots)
        yield Place(place.name, place.image, place.metres_per_pixel, truth, place.ground, place.missing)


def judged(place: Place, network: StallNetwork, cast: FloatArray | None) -> Judged:
    """Return the stalls that the network finds in a place, of those whose state is known and that no edge cuts.

    ``cast`` (2,): shadow of one metre of height in the picture, metres along columns and rows; None: not known.
    """
    sun = None if cast is None else sun_input(cast)
    maps = network.run(north_up(place.image, place.metres_per_pixel).values, sun)
    stalls = stalls_of(maps)
    pairs = match(stalls.corners() * CELL_M + GROUND_M / 2, place.truth.stalls)
    states = np.asarray(place.truth.states, object)
    known = (states != StallState.UNKNOWN) & ~cut_labels(place)
    kept = known[pairs.true]
    features = state_features(maps, stalls)[pairs.found[kept]]
    return Judged(features, np.asarray(states[pairs.true[kept]] == StallState.TAKEN, np.bool_))


def joined(parts: Sequence[Judged]) -> Judged:
    """Return the stalls of several places as one."""
    none = Judged(np.zeros((0, len(STATE_FEATURES))), np.zeros(0, np.bool_))
    every = (*parts, none)
    return Judged(np.concatenate([part.features for part in every]), np.concatenate([part.taken for part in every]))


def fit(given: Judged) -> FloatArray:
    """Return constant and weights (1 + F,)."""
    return logistic(given.features, given.taken.astype(np.float64), np.ones(len(given.taken)))


def right(given: Judged, weights: FloatArray) -> float:
    """Return the share of the states that the weights call right; NaN of nothing."""
    called = weights[0] + given.features @ weights[1:] > 0
    return float((called == given.taken).mean()) if len(called) else float("nan")


if __name__ == "__main__":
    main()
