"""Small pictures for slow links, and the choice between them and whole ones.

A picture that takes ten seconds to cross a link is ten seconds old when it arrives, whatever waits behind it.
"""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Final

import cv2

from hawk.comm.image import NoImage, decode
from hawk.model import AnnotatedFrame

SMALL_WIDTH: Final = 320
"""Pixels; with `SMALL_QUALITY` a picture of a lot has some 10 kB, an eighth of a whole one."""
SMALL_QUALITY: Final = 45
SLOW_S: Final = 1.0
"""Real seconds from sending a whole picture to its acknowledgement, above which small ones follow."""
FRESH_S: Final = 2.0
"""A whole picture is sent only where it arrives within this time, real seconds: the page marks older ones."""
STAY_SMALL_S: Final = 5.0
"""Real seconds between a whole picture that was slow and the next trial."""


class SmallFrames:
    """Shrinks each frame at most once, on a thread of its own, whatever the number of slow clients."""

    def __init__(self) -> None:
        self._executor = ThreadPoolExecutor(1, thread_name_prefix="web-small-frames")
        self._of: AnnotatedFrame | None = None
        self._small: asyncio.Future[AnnotatedFrame] | None = None

    async def of(self, frame: AnnotatedFrame) -> AnnotatedFrame:
        """Return the small form of a frame; the frame itself where it cannot be made smaller."""
        if self._small is None or self._of is not frame:
            self._of = frame
            self._small = asyncio.get_running_loop().run_in_executor(self._executor, shrink, frame)
        return await asyncio.shield(self._small)

    def close(self) -> None:
        """End the thread."""
        self._executor.shutdown(wait=False, cancel_futures=True)


def shrink(frame: AnnotatedFrame) -> AnnotatedFrame:
    """Return the frame with a small picture; the frame itself where it has none, or a smaller one already."""
    try:
        picture = decode(frame.jpeg)
    except NoImage:
        return frame
    height, width = picture.shape[:2]
    if width <= SMALL_WIDTH:
        return frame
    size = (SMALL_WIDTH, max(1, round(height * SMALL_WIDTH / width)))
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    encoded, data = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, SMALL_QUALITY])
    return replace(frame, jpeg=data.tobytes()) if encoded and len(data) < len(frame.jpeg) else frame


class LinkPace:
    """Decides whether one client's link takes whole pictures, by how fast the first, a small one, arrives."""

    def __init__(self, *, is_acknowledged: bool = True) -> None:
        """Without acknowledgements by the client buffers swallow a small picture: then a whole one is the first.

        After a slow one only small ones follow.
        """
        self.takes_whole = not is_acknowledged
        self._small_until = float("-inf")
        self._stay_small_s = STAY_SMALL_S if is_acknowledged else float("inf")

    def arrived(self, now: float, seconds: float, times_larger: float) -> None:
        """Note that a picture has arrived.

        Args:
            now: Real seconds.
            seconds: From sending it to its acknowledgement; delay counts as if it were lack of speed.
            times_larger: Bytes of the whole picture to those of the one that was sent.
        """
        if self.takes_whole and seconds > SLOW_S:
            self.takes_whole, self._small_until = False, now + self._stay_small_s
        elif not self.takes_whole and seconds * times_larger < FRESH_S and now >= self._small_until:
            self.takes_whole = True
