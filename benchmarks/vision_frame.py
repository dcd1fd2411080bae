"""Time of one frame on one core, from JPEG to what is seen, at 1280 x 720 over a drawn world.

``python -m benchmarks.vision_frame --json FILE``. The last lines are the network's time in each engine that is
installed, beside OpenCV's.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import get_args

import cv2
import numpy as np

from hawk.algo.frame import FrameInput
from hawk.algo.vision.app import VisionApp, VisionSettings
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.network import DEFAULT_ENGINE, Engine, StallNetwork, VisionModelError
from hawk.algo.vision.odometry import Features, find_features, measured_motion
from hawk.algo.vision.picture import annotate, decode
from hawk.algo.vision.rectify import Rectifier
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import HeightParameters
from hawk.model.poses import MapPose
from hawk.worlds.camera import WorldCamera
from hawk.worlds.generate import generate_world
from hawk.worlds.world import World

PIXELS = (1280, 720)
FIELD_OF_VIEW = math.radians(70)


def camera_model(*, lens: bool) -> CameraModel:
    """Return the default camera, with or without a lens distortion to correct."""
    focal = PIXELS[0] / 2 / math.tan(FIELD_OF_VIEW / 2)
    distortion = (-0.1, 0.02, 0.0005, -0.0005, 0.0) if lens else ()
    return CameraModel(*PIXELS, focal, focal, (PIXELS[0] - 1) / 2, (PIXELS[1] - 1) / 2, distortion)


def frames(world: World, height: float, count: int, *, lens: bool) -> list[FrameInput]:
    """Return frames over the world's lot, each at another place and heading.

    With ``lens`` only the correction is timed: the pictures are drawn without distortion.
    """
    model = camera_model(lens=lens)
    camera = WorldCamera(world, camera_model(lens=False))
    rng = np.random.default_rng(0)
    inputs = []
    for k in range(count):
        x, y = np.mean(world.stalls[int(rng.integers(len(world.stalls)))].corners, axis=0)
        roll, pitch, yaw = *rng.normal(0, 0.05, 2), rng.uniform(-math.pi, math.pi)
        image = camera.render(float(x), float(y), height, roll, pitch, yaw, rng=rng)
        jpeg = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes()
        pose = MapPose(-float(y), float(x), height, roll, pitch, yaw)
        inputs.append(
            FrameInput(k, k / 10, jpeg, model, pose, 0.0, StateName.HOVER, None, HeightParameters(), None, None)
        )
    return inputs


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
    app = VisionApp(VisionSettings(), StallDetector(network))
    return measure(app, network, frames(generate_world(seed), 35.0, count, lens=False))["median_ms"]


def engine_figures(inputs: list[FrameInput], model: Path | None = None) -> dict[str, float]:
    """Return the network's median milliseconds in each engine that is installed, and its share of OpenCV's."""
    figures: dict[str, float] = {}
    for engine in get_args(Engine):
        try:
            network = StallNetwork.load(model, engine)
        except VisionModelError as error:
            print(error, file=sys.stderr)
            continue
        spent = measure(VisionApp(VisionSettings(), StallDetector(network)), network, inputs)["network_ms"]
        figures[f"engine_{engine}_ms"] = spent
        figures[f"engine_{engine}_by_{DEFAULT_ENGINE}"] = spent / figures[f"engine_{DEFAULT_ENGINE}_ms"]
    return figures


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure by command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.vision_frame", description=__doc__)
    parser.add_argument("--frames", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--model", type=Path, help="an ONNX file in place of the package's")
    parser.add_argument("--json", type=Path, help="write the figures here")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    network = StallNetwork.load(options.model)
    world = generate_world(options.seed)
    figures: dict[str, float] = {}
    for height, lens in ((15.0, False), (35.0, False), (35.0, True), (60.0, False)):
        app = VisionApp(VisionSettings(), StallDetector(network))
        one = measure(app, network, frames(world, height, options.frames, lens=lens))
        name = f"vision_{height:.0f}m{'_lens' if lens else ''}"
        print(name, " ".join(f"{key} {value:.1f}" for key, value in one.items()), flush=True)
        figures |= {f"{name}_{key}": value for key, value in one.items()}
    engines = engine_figures(frames(world, 35.0, options.frames, lens=False), options.model)
    print("\n".join(f"{name} {value:.2f}" for name, value in engines.items()))
    figures |= engines
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1))


if __name__ == "__main__":
    main()
