"""The detector that writes down each look, so that repeated ones are counted."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.detector import ALL_ENDS, Ends
from hawk.algo.vision.network import Engine, EngineChoice
from hawk.picture.orthophoto.tile_detector import TileDetections, TileDetector

LOOKS: Final = "HAWK_CITY_LOOKS"
"""Environment variable with the file that gets a line for each look."""


class CountedDetector(TileDetector):
    """Looks as another detector does, and counts."""

    def __init__(self, detector: TileDetector, looks: Path) -> None:
        """``looks``: the file that gets a line for each look."""
        self._counted = detector
        self._looks = looks
        self.model = detector.model

    @property
    def engine(self) -> Engine:
        """The engine of the other detector."""
        return self._counted.engine

    def detect(
        self,
        image: NDArray[np.uint8],
        metres_per_pixel: float | tuple[float, float],
        valid: NDArray[np.bool_] | None = None,
        ends: Ends = ALL_ENDS,
    ) -> TileDetections:
        """Write a line, then look: a look that is cut off counts."""
        with self._looks.open("a") as file:
            file.write(f"{os.getpid()}\n")
        return self._counted.detect(image, metres_per_pixel, valid, ends)


def load_counted(model: Path | None, engine: EngineChoice) -> TileDetector:
    """Load the detector; one that counts where the environment names a file."""
    detector = TileDetector.load(model, engine)
    return CountedDetector(detector, Path(os.environ[LOOKS])) if LOOKS in os.environ else detector
