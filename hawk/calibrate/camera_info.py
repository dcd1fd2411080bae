"""Writing a lens as ROS's ``camera_info`` YAML, which `hawk.comm.cameras.calibration` reads.

Format: https://wiki.ros.org/camera_calibration_parsers
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from hawk.calibrate.lens import NAMES, Lens
from hawk.runtime.files import write_atomically


def camera_info(lens: Lens, made: datetime) -> str:
    """Return the file's text; error and spreads stand in its remarks."""
    fx, fy, cx, cy = lens.values[:4]
    spreads = ", ".join(f"{name} {spread:.3g}" for name, spread in zip(NAMES, lens.spreads, strict=True))
    return "\n".join(
        [
            f"# hawk-drone calibrate, {made:%Y-%m-%d %H:%M} UTC: {lens.views} views, error {lens.rms:.3f} px",
            f"# standard deviations: {spreads}",
            f"image_width: {lens.width}",
            f"image_height: {lens.height}",
            "camera_name: hawk",
            *_matrix("camera_matrix", 3, 3, (fx, 0, cx, 0, fy, cy, 0, 0, 1)),
            "distortion_model: plumb_bob",
            *_matrix("distortion_coefficients", 1, 5, lens.values[4:]),
            *_matrix("rectification_matrix", 3, 3, (1, 0, 0, 0, 1, 0, 0, 0, 1)),
            *_matrix("projection_matrix", 3, 4, (fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0)),
            "",
        ]
    )


def write_camera_info(lens: Lens, path: Path, made: datetime) -> None:
    """Write the file, whole or not at all. Raises OSError."""
    write_atomically(path, camera_info(lens, made))


def _matrix(name: str, rows: int, columns: int, data: Sequence[float]) -> list[str]:
    return [f"{name}:", f"  rows: {rows}", f"  cols: {columns}", f"  data: [{', '.join(repr(float(v)) for v in data)}]"]
