"""The views so far as text for a terminal, and as a picture.

The text is plain ASCII: it works over a serial line and ssh.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.calibrate.coverage import CELL_CORNERS, CELLS, LEAST_VIEWS, Coverage, View
from hawk.calibrate.lens import NAMES, Lens

_WIDTH: Final = 640  # pixels of the preview
_GREEN: Final = (90, 200, 60)
_RED: Final = (60, 60, 230)


def coverage_lines(there: Coverage, note: str) -> list[str]:
    """Return the parts of the picture (``##`` enough, ``..`` nothing yet), the tilts and distances, what to do next."""
    rows = ["  ".join(_cell(int(corners)) for corners in row) for row in there.cells]
    tilts = " ".join(
        f"{name}{'+' if seen else '-'}"
        for name, seen in zip(("left", "right", "top", "bottom"), there.leans, strict=True)
    )
    distances = f"near{'+' if there.is_near else '-'} far{'+' if there.is_far else '-'}"
    return [
        *(f"  {row}" for row in rows),
        f"  views {there.views}/{LEAST_VIEWS}   tilt: {tilts}   distance: {distances}   {there.share:.0%}",
        f"  next: {there.missing or 'nothing'}{f'  ({note})' if note else ''}",
    ]


def _cell(corners: int) -> str:
    return "##" if corners >= CELL_CORNERS else ".." if corners == 0 else f"{corners:>2}"


def lens_lines(lens: Lens) -> list[str]:
    """Return a lens with its spreads, for a person."""
    left_out = f", {lens.left_out} left out" if lens.left_out else ""
    rows = [f"{lens.width} x {lens.height}, {lens.views} views{left_out}, error {lens.rms:.3f} px"]
    for name, value, spread in zip(NAMES, lens.values, lens.spreads, strict=True):
        digits = 5 if name[0] in "kp" else 2
        rows.append(f"  {name}  {value:>10.{digits}f} ± {spread:.{digits}f}")
    return rows


def preview(image: NDArray[np.uint8], view: View | None, there: Coverage) -> NDArray[np.uint8]:
    """Return the picture, 640 wide, with the board's corners, and a red frame about each part that is still needed."""
    scale = _WIDTH / image.shape[1]
    small = np.asarray(cv2.resize(image, (_WIDTH, max(1, round(image.shape[0] * scale))), interpolation=cv2.INTER_AREA))
    columns, rows = CELLS
    for row, column in np.argwhere(there.cells < CELL_CORNERS):
        first = (round(column * _WIDTH / columns) + 2, round(row * small.shape[0] / rows) + 2)
        last = (round((column + 1) * _WIDTH / columns) - 3, round((row + 1) * small.shape[0] / rows) - 3)
        cv2.rectangle(small, first, last, _RED, 1)
    for x, y in () if view is None else view.corners * scale:
        cv2.circle(small, (round(x), round(y)), 3, _GREEN, -1)
    return np.asarray(small, np.uint8)


def write_preview(path: Path, picture: NDArray[np.uint8]) -> None:
    """Write a JPEG, whole or not at all, for a viewer that reads the file again and again. Raises OSError."""
    done, data = cv2.imencode(".jpg", picture)
    if not done:
        raise OSError(f"{path}: the picture cannot be encoded")
    temporary = path.with_name(f".{path.name}.new")
    temporary.write_bytes(data.tobytes())
    temporary.replace(path)
