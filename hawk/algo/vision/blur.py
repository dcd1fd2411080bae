"""Blur of a picture, measured in the picture alone: by a long exposure, a wrong focus, fog or drops on the lens.

A picture that is smoothed once more changes little where it was blurred before: its share of the differences between
neighbours that smoothing leaves is the blur (Crete, Dolmiere, Ladret, Nicolas: *The blur effect: perception and
estimation with a new no-reference perceptual blur metric*, SPIE 6492, 2007).
"""

from __future__ import annotations

from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.detection import GroundImage

_SIDE: Final = 9
"""Pixels that are averaged to smooth a picture, as in the paper: 0.9 m of the ground at 0.1 m."""
_MOST: Final = 400
"""Pixels of the middle of a picture, along each side, that are looked at: the whole of one from 30 m."""
BLURRED: Final = 0.5
"""Blur from which a look counts as blurred."""


def blur_of(picture: GroundImage) -> float:
    """Return the blur of a rectified picture (uint8 BGR at 0.1 m), 0 to 1; 0 where nothing of it can be measured.

    The axis along which it is the greater counts: a moving camera blurs along its path. Takes 2 ms.
    """
    part = tuple(slice(max(0, (side - _MOST) // 2), (side + _MOST) // 2) for side in picture.valid.shape)
    grey = cv2.cvtColor(picture.values[part], cv2.COLOR_BGR2GRAY).astype(np.float32)
    inside = cv2.erode(
        picture.valid[part].astype(np.uint8),
        np.ones((_SIDE, _SIDE), np.uint8),
        borderType=cv2.BORDER_CONSTANT,
        borderValue=0,
    )
    along = _left(grey, cv2.blur(grey, (_SIDE, 1)), inside, (slice(None), slice(1, None)), (slice(None), slice(-1)))
    return max(along, _left(grey, cv2.blur(grey, (1, _SIDE)), inside, (slice(1, None),), (slice(-1),)))


def _left(
    grey: NDArray[Any], smooth: NDArray[Any], inside: NDArray[Any], later: tuple[slice, ...], former: tuple[slice, ...]
) -> float:
    """Return the share of the differences between former and later neighbours that is left in the smoothed picture."""
    before = np.asarray(cv2.absdiff(grey[later], grey[former]))
    after = np.asarray(cv2.absdiff(smooth[later], smooth[former]))
    total = cv2.mean(before, inside[later])[0]
    return float(cv2.mean(cv2.min(before, after), inside[later])[0] / total) if total > 0 else 0.0
