"""Blur of pictures and the stalls found in them: where `hawk.algo.vision.blur.BLURRED` comes from.

``python -m benchmarks.blur --json FILE``. Frames of drawn worlds, 1280 x 720 from 20 and 35 m, are smeared along a
direction as by a drone that flies while the shutter is open, or softened as by a wrong focus; each line gives the
measured blur (tenth and ninetieth hundredths too), the share of the stalls in the frame that were found, and of these
the share with the right state.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.vision_frame import FIELD_OF_VIEW, PIXELS, frames
from hawk.algo.frame import FrameInput
from hawk.algo.vision.app import VisionApp, VisionSettings
from hawk.algo.vision.blur import BLURRED, blur_of
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.network import StallNetwork
from hawk.algo.vision.picture import decode
from hawk.algo.vision.seen import SeenGround
from hawk.worlds.generate import generate_world
from hawk.worlds.world import World

HEIGHTS_M: Final = (20.0, 35.0)
SMEARS_M: Final = (0.0, 0.3, 0.6, 0.9, 1.3, 1.8, 2.5)
"""Ground that passes while the shutter is open."""
SOFT_M: Final = (0.1, 0.2, 0.3, 0.4, 0.5, 0.7)
"""Standard deviations of a soft picture, on the ground."""
_NEAR_M: Final = 1.0
_EDGE_M: Final = 3.0


@dataclass(frozen=True, slots=True)
class Line:
    """Figures of one kind of blur: ``metres`` of the ground; ``found``, ``right``: shares."""

    kind: str
    metres: float
    blur: tuple[float, float, float]
    found: float
    right: float


def smeared(image: NDArray[np.uint8], length_px: float, angle: float) -> NDArray[np.uint8]:
    """Return a picture as an open shutter leaves it while the ground passes by `length_px` pixels."""
    side = 2 * math.ceil(length_px / 2) + 1
    if side < 3:
        return image
    kernel = np.zeros((side, side), np.float32)
    half, middle = length_px / 2, side // 2
    for at in np.linspace(-half, half, 4 * side):
        column, row = middle + at * math.cos(angle), middle + at * math.sin(angle)
        left, top = math.floor(column), math.floor(row)
        for y, x in ((top, left), (top, left + 1), (top + 1, left), (top + 1, left + 1)):
            if 0 <= x < side and 0 <= y < side:
                kernel[y, x] += (1 - abs(column - x)) * (1 - abs(row - y))
    return np.asarray(cv2.filter2D(image, -1, kernel / kernel.sum()), np.uint8)


def _blurred(frame: FrameInput, kind: str, metres: float, rng: np.random.Generator) -> FrameInput:
    assert frame.pose is not None
    pixels = metres * PIXELS[0] / 2 / math.tan(FIELD_OF_VIEW / 2) / frame.pose.height
    image = decode(frame.jpeg)
    if kind == "smeared":
        image = smeared(image, pixels, rng.uniform(0, math.pi))
    elif pixels > 0:
        image = np.asarray(cv2.GaussianBlur(image, (0, 0), pixels), np.uint8)
    noisy = np.clip(image + rng.normal(0, 2, image.shape), 0, 255).astype(np.uint8)  # the sensor's comes last
    return replace(frame, jpeg=cv2.imencode(".jpg", noisy, [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes())


def _compared(world: World, ground: SeenGround) -> Iterator[tuple[bool, bool]]:
    """Yield of each stall of the world that lies in the frame whether it was found, and with the right state."""
    found = np.array([(each.north, each.east) for each in ground.stalls]).reshape(-1, 2)
    for stall in world.stalls:
        x, y = np.mean(stall.corners, axis=0)
        place = np.array([-y, x])
        column, row = np.round(ground.picture.pixel_points(place)).astype(int)
        edge = round(_EDGE_M / ground.picture.metres_per_pixel)
        valid = ground.picture.valid
        if not (edge <= row < valid.shape[0] - edge and edge <= column < valid.shape[1] - edge):
            continue
        if not valid[row - edge : row + edge, column - edge : column + edge].all():
            continue
        apart = np.hypot(*(found - place).T) if len(found) else np.array([math.inf])
        nearest = int(apart.argmin())
        is_found = bool(apart[nearest] < _NEAR_M)
        yield is_found, is_found and (ground.stalls[nearest].taken >= 0.5) == stall.taken


def measure(seeds: Sequence[int], count: int, network: StallNetwork) -> list[Line]:
    """Return a line a kind and strength of blur."""
    app = VisionApp(VisionSettings(), StallDetector(network))
    worlds = [(world, frames(world, height, count, lens=False)) for world in map(generate_world, seeds)
              for height in HEIGHTS_M]  # fmt: skip
    lines = []
    for kind, metres in [*(("smeared", each) for each in SMEARS_M), *(("soft", each) for each in SOFT_M)]:
        rng = np.random.default_rng(1)
        blurs, stalls = [], []
        for world, inputs in worlds:
            for frame in inputs:
                ground = app.see(_blurred(frame, kind, metres, rng)).ground
                assert ground is not None
                blurs.append(blur_of(ground.picture))
                stalls += list(_compared(world, ground))
        found, right = np.mean(stalls, axis=0).tolist()
        low, middle, high = np.quantile(blurs, (0.1, 0.5, 0.9)).tolist()
        lines.append(Line(kind, metres, (low, middle, high), found, right / max(found, 1e-9)))
        print(f"{kind} {metres:.2f} m: blur {low:.3f} {middle:.3f} {high:.3f}, found {found:.1%}, of these right "
              f"{lines[-1].right:.1%}", flush=True)  # fmt: skip
    return lines


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure by command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.blur", description=__doc__)
    parser.add_argument("--frames", type=int, default=3, help="a world and height")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--json", type=Path, help="write the figures here")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    lines = measure(options.seeds, options.frames, StallNetwork.load())
    print(f"a look is blurred from {BLURRED} on")
    if options.json is not None:
        rows = {f"{each.kind}_{each.metres:.2f}": [*each.blur, each.found, each.right] for each in lines}
        options.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
