"""Single frames of a flying camera, rectified as in flight: over drawn worlds, and tilted over labelled pictures."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.perception.edges import whole_labels
from benchmarks.perception.eyes import boxes
from benchmarks.perception.places import Place, state_array
from benchmarks.vision_frame import frames
from hawk.algo.frame import FrameInput
from hawk.algo.vision import decode, picture
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.rectify import Rectifier
from hawk.algo.vision.seen import FloatArray, GroundImage, StallSeen
from hawk.model.lot_map import StallState
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import HeightParameters
from hawk.model.poses import MapPose
from hawk.survey.accuracy import Finding, LabelledPlace, Tally, tally
from hawk.worlds.camera import WorldCamera
from hawk.worlds.conditions import Condition
from hawk.worlds.generate import WorldOptions, generate_world
from hawk.worlds.world import World

HEIGHT_M = 35.0
MINIMUM_SCORE = 0.5
TILT = math.radians(10.0)
_TILT_PIXELS = 1280
_TILT_FIELD = math.radians(60)


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
        one = sum((_look(finder, rectifier, f, labels) for f in frames(world, HEIGHT_M, count, lens=False)), Tally())
        if verbose:
            print(f"  world {seed}: R {one.recall:.3f} P {one.precision:.3f} state {one.state_accuracy:.3f}")
        total += one
    return total


def measure_tilted(finder: StallDetector, places: Iterable[Place]) -> Tally:
    """Return the tally of frames taken with `TILT` over labelled pictures, each from four sides.

    Labels that the picture's edge cuts are left out; a find of one counts as false.
    """
    total, rectifier = Tally(), Rectifier()
    for place in map(whole_labels, places):
        labels = Labels(place.truth.stalls, place.truth.states, place.truth.lots)
        for frame in _tilted(place):
            total += _look(finder, rectifier, frame, labels)
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


def _tilted(place: Place) -> Iterator[FrameInput]:
    """Fly over the picture's middle so low that all four tilted footprints lie within it."""
    side = min(place.image.shape[:2]) * place.metres_per_pixel
    height = side / 2 / math.tan(_TILT_FIELD / 2 + TILT)
    focal = _TILT_PIXELS / 2 / math.tan(_TILT_FIELD / 2)
    middle = (_TILT_PIXELS - 1) / 2
    model = CameraModel(_TILT_PIXELS, _TILT_PIXELS, focal, focal, middle, middle)
    world = World(place.name, place.metres_per_pixel, place.image)
    camera = WorldCamera(world, model)
    x, y = np.array(place.image.shape[1::-1]) * place.metres_per_pixel / 2
    for number, (roll, pitch) in enumerate(((TILT, 0.0), (-TILT, 0.0), (0.0, TILT), (0.0, -TILT))):
        image = camera.render(float(x), float(y), height, roll, pitch, 0.0, rng=np.random.default_rng(number))
        jpeg = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 90])[1].tobytes()
        pose = MapPose(-float(y), float(x), height, roll, pitch, 0.0)
        yield FrameInput(
            number, number / 10, jpeg, model, pose, 0.0, StateName.HOVER, None, HeightParameters(), None, None
        )


def _finding(seen: list[StallSeen]) -> Finding:
    table = np.array([(s.north, s.east, s.angle, s.width, s.length) for s in seen]).reshape(-1, 5)
    states = [StallState.FREE if s.taken < 0.5 else StallState.TAKEN for s in seen]
    return Finding(boxes(table), state_array(states))


def _in_view(labels: Labels, ground: GroundImage) -> LabelledPlace:
    """Return the stalls that can be seen wholly in a rectified frame."""
    pixels = ground.pixel_points(np.stack([-labels.stalls[..., 1], labels.stalls[..., 0]], axis=-1))
    whole = decode.sample(ground.valid, pixels).all(axis=1)
    return LabelledPlace(labels.stalls[whole], labels.states[whole], labels.lots)
