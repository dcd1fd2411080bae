"""Longitudes of one flight, which may cross the 180th meridian: there they jump by 360 degrees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def unwrapped(longitudes: FloatArray) -> FloatArray:
    """Return longitudes (N,), degrees, within half a turn of the first one, so that they can be averaged."""
    return np.asarray(longitudes + 360.0 * np.rint((longitudes[0] - longitudes) / 360.0), np.float64)


def wrapped(longitudes: FloatArray) -> FloatArray:
    """Return longitudes (N,), degrees, from -180 to 180."""
    return np.asarray(longitudes - 360.0 * np.rint(longitudes / 360.0), np.float64)
