"""Smaller forms of the live pictures, for slow links: each one is made at most once, for all viewers that need it."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.formats.image import NoImage, decode, jpeg_size
from hawk.model.pictures import AnnotatedFrame
from hawk.web.video.link_pace import STEPS

SMALL_WIDTH: Final = 320
"""Pixels of the smallest step; with its quality a picture of a lot has some 10 kB, an eighth of a whole one."""
QUALITIES: Final = (75, 67, 60, 52, 45)
"""JPEG qualities by step; that of step 0 is not used: whole pictures come encoded."""

_REDUCTIONS: Final = (1, 2, 4)
"""Parts of its size at which a JPEG is decoded for less time."""


class SmallFrames:
    """Makes the smaller forms of frames on a thread of its own."""

    def __init__(self) -> None:
        self._executor = ThreadPoolExecutor(1, thread_name_prefix="web-small-frames")
        self._maker = _Maker()
        self._of: AnnotatedFrame | None = None
        self._made: dict[int, asyncio.Future[AnnotatedFrame]] = {}

    def of(self, frame: AnnotatedFrame, step: int) -> asyncio.Future[AnnotatedFrame]:
        """Return the form of a frame at a step from 1 to `STEPS`; the frame itself where it cannot be made smaller.

        The future is shared by all who ask: do not cancel it.
        """
        if self._of is not frame:
            self._of, self._made = frame, {}
        made = self._made.get(step)
        if made is None:
            made = asyncio.get_running_loop().run_in_executor(self._executor, self._maker.make, frame, step)
            self._made[step] = made
        return made

    def close(self) -> None:
        """End the thread."""
        self._executor.shutdown(wait=False, cancel_futures=True)


class _Maker:
    """Decodes each frame at most once for the steps that need the same size; used by one thread."""

    def __init__(self) -> None:
        self._of: AnnotatedFrame | None = None
        self._pictures: dict[int, NDArray[np.uint8]] = {}

    def make(self, frame: AnnotatedFrame, step: int) -> AnnotatedFrame:
        if self._of is not frame:
            self._of, self._pictures = frame, {}
        try:
            width, height = jpeg_size(frame.jpeg)
            size = (width_at(width, step), max(1, round(height * width_at(width, step) / width)))
            reduction = max(each for each in _REDUCTIONS if width >= each * size[0])
            if reduction not in self._pictures:
                self._pictures[reduction] = decode(frame.jpeg, reduction)
        except (NoImage, ValueError):
            return frame
        return frame if size[0] >= width else _encoded(frame, self._pictures[reduction], size, QUALITIES[step])


def shrink(frame: AnnotatedFrame, step: int = STEPS) -> AnnotatedFrame:
    """Return the frame at a step from 1 to `STEPS`; the frame itself where it has no picture, or one small already."""
    return _Maker().make(frame, step)


def width_at(whole: int, step: int) -> int:
    """Return the width in pixels at a step: from step to step by the same share, down to `SMALL_WIDTH`."""
    return whole if whole <= SMALL_WIDTH else round(whole * (SMALL_WIDTH / whole) ** (step / STEPS))


def _encoded(frame: AnnotatedFrame, picture: NDArray[np.uint8], size: tuple[int, int], quality: int) -> AnnotatedFrame:
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    done, data = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, quality])
    return replace(frame, jpeg=data.tobytes()) if done and len(data) < len(frame.jpeg) else frame
