"""Writes a trained network as ONNX and checks that OpenCV runs it alike."""

from __future__ import annotations

import warnings
from pathlib import Path

import cv2
import numpy as np
import torch

from training.network import StallNet, set_memory_format

OPSET = 17
LARGEST_DIFFERENCE = 1e-4


def export(network: StallNet, path: Path) -> float:
    """Write the network to ``path`` and return the largest difference between torch and OpenCV.

    Raises RuntimeError when they differ by more than LARGEST_DIFFERENCE; the file is then removed.
    """
    network = set_memory_format(network, torch.contiguous_format).eval()
    path.parent.mkdir(parents=True, exist_ok=True)
    axes = {"image": {2: "height", 3: "width"}, "maps": {2: "half_height", 3: "half_width"}}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        torch.onnx.export(
            network,
            (torch.zeros(1, 3, 256, 320), torch.zeros(1, 2)),
            str(path),
            opset_version=OPSET,
            input_names=["image", "sun"],
            output_names=["maps"],
            dynamic_axes=axes,
            dynamo=False,
        )
    difference = max(_difference(network, path, size) for size in ((384, 640), (288, 512), (64, 96)))
    if difference > LARGEST_DIFFERENCE:
        path.unlink()
        raise RuntimeError(f"OpenCV and torch differ by {difference:.2g} on the exported network")
    return difference


def _difference(network: StallNet, path: Path, size: tuple[int, int]) -> float:
    picture = np.random.default_rng(0).random((1, 3, *size), np.float32) - np.float32(0.5)
    loaded = cv2.dnn.readNetFromONNX(str(path))
    sun = np.array([[0.3, -0.5]], np.float32)
    loaded.setInput(picture, "image")
    loaded.setInput(sun, "sun")
    with torch.no_grad():
        expected = network(torch.from_numpy(picture), torch.from_numpy(sun)).numpy()
    return float(np.abs(loaded.forward() - expected).max())
