"""Cost of coarser pictures: ``python -m benchmarks.perception.coarse --lots DIR --metres 0.12 0.15 0.2``.

Each place is averaged to these metres a pixel, as a coarser camera would, and looked at. Blur, haze and the JPEG of a
real coarse picture come on top. The folder is that of ``--lots`` or ``--regions`` of `benchmarks.perception`.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from benchmarks.perception.eyes import NetworkEye
from benchmarks.perception.measures import measure
from benchmarks.perception.places import Place, folder_option, read_lots
from hawk.algo.vision.network import StallNetwork

SHOWN = ("labels", "recall", "recall_whole", "precision", "precision_star", "state_accuracy")


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure by command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.perception.coarse", description=__doc__)
    parser.add_argument("--lots", type=folder_option, required=True)
    parser.add_argument("--metres", type=float, nargs="+", default=[0.12, 0.15, 0.2], help="a pixel (0.12 0.15 0.2)")
    parser.add_argument("--model", type=Path, help="an ONNX file in place of the package's")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    eye = NetworkEye(StallNetwork.load(options.model))
    places = list(read_lots(options.lots))
    for metres in (0.0, *options.metres):
        figures = measure(eye, [coarser(place, metres) for place in places])
        print(f"{metres:5.2f} m  " + "  ".join(f"{name} {figures[name]:.3f}" for name in SHOWN), flush=True)


def coarser(place: Place, metres: float) -> Place:
    """Return a place with pixels of this many metres; itself where its own are as coarse."""
    if place.metres_per_pixel >= metres:
        return place
    factor = place.metres_per_pixel / metres
    image = np.asarray(cv2.resize(place.image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA), np.uint8)
    missing = None
    if place.missing is not None:
        size = (image.shape[1], image.shape[0])
        missing = cv2.resize(place.missing.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
    return replace(place, image=image, metres_per_pixel=metres, missing=missing)


if __name__ == "__main__":
    main()
