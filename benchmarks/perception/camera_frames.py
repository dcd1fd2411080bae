"""Single frames of a flying camera over drawn worlds, rectified as in flight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.perception.eyes import boxes
from benchmarks.perception.places import state_array
from benchmarks.vision_frame import frames
from hawk.algo.frame import FrameInput
from hawk.algo.vision import decode, picture
from hawk.algo.vision.detection import Detection, FloatArray, GroundImage
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.rectify import Rectifier
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import Finding, LabelledPlace, Tally, tally
from hawk.worlds.generate import WorldOptions, generate_world
from hawk.worlds.moment import Condition
from hawk.worlds.world import World

HEIGHT_M = 35.0
MINIMUM_SCORE = 0.5


@dataclass(frozen=True, slots=True)
class Labels:
    """Stalls (N, 4, 2) in the world's metres (x east, y south), their states and the lots."""

    stalls: FloatArray
    states: NDArray[np.object_]
    lots: tuple[FloatArray, ...]


def measure_worlds(
    finder: StallDetector,
    seeds: Sequence[int],
    count: int = 12,
    *,
    condition: Condition = Condition.DAY,
    verbose: bool = False,
) -> Tally:
    """Return the tally of single frames over drawn worlds at `HEIGHT_M`, stalls that lie wholly in view only."""
    total = Tally()
    rectifier = Rectifier()
    for seed in seeds:
        world = generate_world(seed, WorldOptions(condition=condition))
        labels = _labels_of(world)
        one = sum((_look(finder, rectifier, f, labels) for f in frames(world, HEIGHT_M, count)), Tally())
        if verbose:
            print(f"  world {seed}: R {one.recall:.3f} P {one.precision:.3f} state {one.state_accuracy:.3f}")
        total += one
    return total


def _find_whole(finder: StallDetector, rectifier: Rectifier, frame: FrameInput) -> tuple[Finding, GroundImage]:
    """Return the stalls that lie wholly in a frame, in the world's metres, and the frame on the ground."""
    assert frame.pose is not None
    ground = rectifier.rectify(picture.decode(frame.jpeg), frame.camera, frame.pose)
    seen = [s for s in finder.detect(ground).stalls if s.score >= MINIMUM_SCORE and s.visible > 0.98]
    return _finding(seen), ground


def _labels_of(world: World) -> Labels:
    """Return what can be seen of a drawn world; hidden stalls are left out."""
    shown = [stall for stall in world.stalls if not stall.hidden]
    states = [StallState.TAKEN if stall.taken else StallState.FREE for stall in shown]
    corners = np.array([stall.corners for stall in shown]).reshape(-1, 4, 2)
    return Labels(corners, state_array(states), tuple(np.asarray(lot) for lot in world.lots))


def _look(finder: StallDetector, rectifier: Rectifier, frame: FrameInput, labels: Labels) -> Tally:
    finding, ground = _find_whole(finder, rectifier, frame)
    return tally(finding, _in_view(labels, ground))


def _finding(seen: list[Detection]) -> Finding:
    table = np.array([(s.north, s.east, s.angle, s.width, s.length) for s in seen]).reshape(-1, 5)
    states = [StallState.FREE if s.taken < 0.5 else StallState.TAKEN for s in seen]
    return Finding(boxes(table), state_array(states))


def _in_view(labels: Labels, ground: GroundImage) -> LabelledPlace:
    """Return the stalls that can be seen wholly in a rectified frame."""
    pixels = ground.pixel_points(np.stack([-labels.stalls[..., 1], labels.stalls[..., 0]], axis=-1))
    whole = decode.sample(ground.valid, pixels).all(axis=1)
    return LabelledPlace(labels.stalls[whole], labels.states[whole], labels.lots)
