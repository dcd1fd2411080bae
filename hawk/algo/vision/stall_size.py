"""The usual size of the stalls that a picture shows: twice as large as others where the height is truly half."""

from __future__ import annotations

from statistics import median
from typing import Final

from hawk.algo.frame import FrameInput
from hawk.algo.vision.seen import Seen
from hawk.model.ground_motion import StallSize

LEAST_STALLS: Final = 6
WHOLE: Final = 0.95
"""Share of a stall that the picture must show."""


def stall_size(frame: FrameInput, seen: Seen) -> StallSize | None:
    """Return the usual size in this frame.

    None where fewer stalls than `LEAST_STALLS` are whole, and where a rangefinder gives the picture its scale: the
    reported height has no part in it then.
    """
    if seen.ground is None or frame.ground:
        return None
    widths = [stall.width for stall in seen.ground.stalls if stall.visible >= WHOLE]
    if len(widths) < LEAST_STALLS:
        return None
    return StallSize(frame.captured, median(widths), seen.ground.pose.height)
