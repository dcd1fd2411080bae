"""Affines of the map plane, (2, 3) as OpenCV has them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def transform_points(affine: Floats, points: Floats) -> Floats:
    """Apply an affine to points (..., 2)."""
    return np.asarray(points @ affine[:, :2].T + affine[:, 2])


def compose(outer: Floats, inner: Floats) -> Floats:
    """Return the affine that applies ``inner`` first, then ``outer``."""
    result = outer[:, :2] @ inner
    result[:, 2] += outer[:, 2]
    return np.asarray(result)
