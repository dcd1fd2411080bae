"""The eye that writes down each look, so that repeated ones are counted."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.network import Engine, EngineChoice
from hawk.picture.nadir import ALL_ENDS, Ends, Eye, Found

LOOKS: Final = "HAWK_CITY_LOOKS"
"""Environment variable with the file that gets a line for each look."""


class CountedEye(Eye):
    """Looks as another eye does, and counts."""

    def __init__(self, eye: Eye, looks: Path) -> None:
        """``looks``: the file that gets a line for each look."""
        self._eye = eye
        self._looks = looks
        self.model = eye.model

    @property
    def engine(self) -> Engine:
        """The engine of the other eye."""
        return self._eye.engine

    def look(
        self,
        image: NDArray[np.uint8],
        metres_per_pixel: float | tuple[float, float],
        valid: NDArray[np.bool_] | None = None,
        ends: Ends = ALL_ENDS,
    ) -> Found:
        """Write a line, then look: a look that is cut off counts."""
        with self._looks.open("a") as file:
            file.write(f"{os.getpid()}\n")
        return self._eye.look(image, metres_per_pixel, valid, ends)


def load_counted(model: Path | None, engine: EngineChoice) -> Eye:
    """Load the eye; one that counts where the environment names a file."""
    eye = Eye.load(model, engine)
    return CountedEye(eye, Path(os.environ[LOOKS])) if LOOKS in os.environ else eye
