"""Time of one frame on one core, from JPEG to what is seen, at 1280 x 720 over a drawn world.

``python -m benchmarks.vision_frame --json FILE``. The last lines are the network's time in each engine that is
installed, beside OpenCV's.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import get_args

import cv2
import numpy as np

from benchmarks.figures import Figure, Reference, Section, print_and_write
from benchmarks.frames import LENS, camera_model, drawn_frames
from benchmarks.options import make_parser
from hawk.algo.frame import FrameInput
from hawk.algo.vision.app import VisionApp, VisionSettings
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.network import DEFAULT_ENGINE, Engine, StallNetwork
from hawk.algo.vision.network_file import VisionModelError
from hawk.algo.vision.odometry import Features, find_features, measured_motion
from hawk.algo.vision.picture import annotate, decode
from hawk.algo.vision.rectify import Rectifier
from hawk.worlds.generate import generate_world
from hawk.worlds.world import World


def frames(world: World, height: float, count: int, *, lens: bool = False) -> list[FrameInput]:
    """Return frames over the world's lot, each at another place and heading.

    With ``lens`` only the correction is timed: the pictures are drawn without distortion.
    """
    rng, reported = np.random.default_rng(0), camera_model(distortion=LENS if lens else ())
    poses = _poses(world, count, rng)
    return list(drawn_frames(world, poses, height, rng, pictures_s=10, reported=reported))


def _poses(world: World, count: int, rng: np.random.Generator) -> Iterator[tuple[float, float, float, float, float]]:
    for _ in range(count):
        x, y = np.mean(world.stalls[int(rng.integers(len(world.stalls)))].corners, axis=0).tolist()
        roll, pitch = rng.normal(0, 0.05, 2).tolist()
        yield x, y, roll, pitch, float(rng.uniform(-math.pi, math.pi))


def measure(app: VisionApp, network: StallNetwork, inputs: list[FrameInput]) -> dict[str, float]:
    """Return median and 95th percentile of a frame, and the medians of its steps, milliseconds.

    The camera's check compares two frames each time; in flight it does so once in 3.5 m at 35 m.
    """
    rectifier, finder = Rectifier(), StallDetector(network)
    rows = []
    before: Features | None = None
    for frame in [inputs[0], *inputs]:
        assert frame.pose is not None
        at = [time.perf_counter()]
        seen = app.see(frame)
        at.append(time.perf_counter())
        image = decode(frame.jpeg)
        at.append(time.perf_counter())
        ground = rectifier.rectify(image, frame.camera, frame.pose)
        at.append(time.perf_counter())
        network.run(ground.values)
        at.append(time.perf_counter())
        finder.detect(ground)
        at.append(time.perf_counter())
        features = find_features(image, frame.camera)
        measured_motion(before or features, features)
        before = features
        at.append(time.perf_counter())
        stalls = seen.ground.stalls if seen.ground else ()
        annotate(image, frame.camera, frame.pose, stalls)
        at.append(time.perf_counter())
        rows.append((*(np.diff(at) * 1e3), float(len(stalls))))
    table = np.array(rows[1:])
    middle = np.median(table, axis=0)
    return {
        "median_ms": middle[0],
        "p95_ms": float(np.percentile(table[:, 0], 95)),
        "decode_ms": middle[1],
        "rectify_ms": middle[2],
        "network_ms": middle[3],
        "votes_ms": middle[4] - middle[3],
        "camera_check_ms": middle[5],
        "annotate_ms": middle[6],
        "stalls": middle[7],
    }


def frame_ms(network: StallNetwork, count: int = 20, seed: int = 1) -> float:
    """Return the median milliseconds of a frame at 35 m over a drawn world, from JPEG to stalls."""
    return _measured(network, frames(generate_world(seed), 35.0, count))["median_ms"]


def _measured(network: StallNetwork, inputs: list[FrameInput]) -> dict[str, float]:
    return measure(VisionApp(VisionSettings(), StallDetector(network)), network, inputs)


def engine_figures(inputs: list[FrameInput], model: Path | None = None) -> list[Figure]:
    """Return the network's median milliseconds in each engine that is installed, beside OpenCV's."""
    found: dict[str, float] = {}
    for engine in get_args(Engine):
        try:
            network = StallNetwork.load(model, engine)
        except VisionModelError as error:
            print(error, file=sys.stderr)
            continue
        found[engine] = _measured(network, inputs)["network_ms"]
    beside = Reference(DEFAULT_ENGINE, found.get(DEFAULT_ENGINE))
    return [Figure(f"engine_{name}_ms", f"network in {name}", spent, "ms", beside) for name, spent in found.items()]


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure by command line."""
    parser = make_parser("benchmarks.vision_frame", __doc__, model=True)
    parser.add_argument("--frames", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    network, world = StallNetwork.load(options.model), generate_world(options.seed)
    sections = []
    for height, lens in ((15.0, False), (35.0, False), (35.0, True), (60.0, False)):
        one = _measured(network, frames(world, height, options.frames, lens=lens))
        name = f"vision_{height:.0f}m{'_lens' if lens else ''}"
        figures = [Figure(f"{name}_{key}", key.replace("_", " "), value) for key, value in one.items()]
        sections.append(Section(f"{height:.0f} m{', lens corrected' if lens else ''}", figures))
    sections.append(Section("engines", engine_figures(frames(world, 35.0, options.frames), options.model)))
    return print_and_write(sections, options.json)


if __name__ == "__main__":
    sys.exit(main())
