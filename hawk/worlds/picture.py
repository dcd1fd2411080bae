"""Worlds from a picture of the user's own."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from hawk.worlds.world import Truth, World, WorldError, load_truth

_LARGEST_PX = 20000
_FINEST_M, _COARSEST_M = 0.005, 1.0


def picture_world(path: str | Path, metres_per_pixel: float, truth_path: str | Path | None = None) -> World:
    """Make a world of an orthophoto (PNG, JPEG, TIFF; north up) and, if there is one, its truth.

    Everything in the picture lies flat. Raises WorldError naming the file or option and the remedy.
    """
    path = Path(path)
    if not _FINEST_M <= metres_per_pixel <= _COARSEST_M:
        raise WorldError(
            f"metres_per_pixel: must lie between {_FINEST_M} and {_COARSEST_M}, not {metres_per_pixel}; "
            "it is the side of one pixel on the ground"
        )
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise WorldError(f"world {path}: cannot be read ({error.strerror}); name a picture that exists") from error
    ground = cv2.imdecode(data, cv2.IMREAD_COLOR) if data.size else None
    if ground is None:
        raise WorldError(f"world {path}: is not a picture that can be read; use PNG, JPEG or TIFF")
    if max(ground.shape[:2]) > _LARGEST_PX or min(ground.shape[:2]) < 16:
        raise WorldError(
            f"world {path}: must be 16 to {_LARGEST_PX} pixels a side, not {ground.shape[1::-1]}; resize it"
        )
    truth = load_truth(truth_path) if truth_path is not None else Truth()
    return World(
        name=path.stem,
        metres_per_pixel=metres_per_pixel,
        ground=np.asarray(ground, np.uint8),
        stalls=truth.stalls,
        lots=truth.lots,
        start_m=truth.start,
    )
