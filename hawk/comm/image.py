"""Pictures as arrays, and the one error for there being none."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


class NoImage(Exception):  # noqa: N818 - the specification's name
    """There is no picture, none that is fresh or none that can be used; the text says why.

    Specification sections 7, 8 and 10: cameras raise it, Vision App passes it on.
    """


def decode(data: bytes) -> NDArray[np.uint8]:
    """Return a JPEG as (height, width, 3) BGR. Raises NoImage; OpenCV's own errors never escape."""
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error as error:
        raise NoImage(f"the picture cannot be decoded: {error}") from error
    if image is None:
        raise NoImage("the picture cannot be decoded")
    return np.asarray(image, np.uint8)
