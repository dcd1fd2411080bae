"""A film's frames by their numbers, read forward; seeks only to go back."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.formats.image import NoImage
from hawk.formats.kind import kind_of_file
from hawk.picture.values import PictureError

SUFFIXES: Final = (".mp4", ".mov", ".m4v", ".mkv", ".avi")
Picture = NDArray[np.uint8]
_RATES: Final = (0.5, 1000.0)
_MOST_PIXELS: Final = 67_000_000
"""Of a frame: twice those of a film in 8K."""
_KINDS: Final = frozenset({"MP4", "Matroska", "AVI"})
_DAMAGED: Final = "copy it again from the camera's card, or repair it by ffmpeg"


class Video:
    """A film on the disk. Frames are as the sensor gave them: the file's turn for players is not applied."""

    def __init__(self, path: Path) -> None:
        """Open a film. Raises PictureError when it is none, or holds no frame."""
        self.path = path
        self._next = 0
        self._capture = self._opened()
        fps = float(self._capture.get(cv2.CAP_PROP_FPS))
        frames = int(self._capture.get(cv2.CAP_PROP_FRAME_COUNT))
        size = [int(self._capture.get(each)) for each in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT)]
        if not (math.isfinite(fps) and _RATES[0] <= fps <= _RATES[1]) or frames < 1 or min(size) < 1:
            self.close()
            raise PictureError(f"{path}: no frame of it can be read: it is torn or no film; {_DAMAGED}")
        if size[0] * size[1] > _MOST_PIXELS:
            self.close()
            words = f"its frames have {size[0]} by {size[1]} pixels, {_MOST_PIXELS / 1e6:.0f} million are the most"
            raise PictureError(f"{path}: {words}; make it smaller by ffmpeg")
        self.fps = fps
        """Frames a second."""
        self.frames = frames
        """Number of frames by its head; a torn film has fewer."""
        self.size = (size[0], size[1])
        """Width and height, pixels."""

    def frame(self, number: int) -> Picture:
        """Return a frame (H, W, 3), BGR. Raises NoImage where it cannot be read."""
        if not self._go(number):
            raise NoImage("it cannot be read: the film is torn before it")
        picture = self._retrieved()
        if picture is None:
            raise NoImage("it is damaged")
        return picture

    def frames_of(self, numbers: Sequence[int]) -> Iterator[tuple[int, Picture]]:
        """Give the frames of rising numbers; ends where the film is torn, and passes over damaged ones."""
        for number in numbers:
            if not self._go(number):
                return
            picture = self._retrieved()
            if picture is not None:
                yield number, picture

    def close(self) -> None:
        """Close the file."""
        self._capture.release()

    def _opened(self) -> cv2.VideoCapture:
        _check_kind(self.path)
        with _quiet():
            capture = cv2.VideoCapture(str(self.path), cv2.CAP_FFMPEG)
        if not capture.isOpened():
            capture.release()
            raise PictureError(f"{self.path}: cannot be read as a film: it is torn or of an unknown kind; {_DAMAGED}")
        capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
        return capture

    def _go(self, number: int) -> bool:
        """Make a frame the present one; return False where the film ends before it."""
        with _quiet():
            if number < self._next - 1:
                self._capture.set(cv2.CAP_PROP_POS_FRAMES, number)
                self._next = number
            while self._next <= number:
                if not self._capture.grab():
                    return False
                self._next += 1
        return True

    def _retrieved(self) -> Picture | None:
        with _quiet():
            done, picture = self._capture.retrieve()
        if not done or picture is None or picture.shape[:2] != (self.size[1], self.size[0]):
            return None
        return np.asarray(picture, np.uint8)


def _check_kind(path: Path) -> None:
    """Refuse what is no film by its first bytes: ffmpeg would follow a list to other files. Raises PictureError."""
    try:
        kind = kind_of_file(path)
    except OSError as error:
        raise PictureError(f"{path} cannot be read ({error.strerror or error}); {_DAMAGED}") from None
    if kind.name not in _KINDS:
        raise PictureError(f"{path}: cannot be read as a film: it {kind.words}; {kind.remedy or _DAMAGED}")


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep OpenCV's warnings about damaged films from the terminal: we report them."""
    before = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        cv2.utils.logging.setLogLevel(before)
