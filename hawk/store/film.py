"""A film of a flight: the recording's pictures as Motion JPEG in an AVI file, which every player shows.

It is made from a recording on the disk, never in flight. Recordings are always on (`store.record`), so that no flight
is lost because nobody began a film.
"""

from __future__ import annotations

import shutil
import statistics
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from hawk.formats.image import NoImage, decode
from hawk.store.frame_codec import FRAME_INPUT, FrameFormatError, picture_of
from hawk.store.replay import read_recording

MOST_FPS: Final = 60.0
QUALITY: Final = 90
"""Of the film's JPEGs: OpenCV's writer encodes each picture again."""
SPARE_BYTES: Final = 50_000_000
"""Bytes that stay free on the disk."""
LONGEST_GAP_S: Final = 5.0
"""A longer time without a picture is cut to this, seconds of the recording's clock."""


class FilmError(Exception):
    """The film was not made; the text says why, and the remedy."""


@dataclass(frozen=True, slots=True)
class Film:
    """Contents of a film: pictures of the camera, those that could not be read, and seconds of film."""

    pictures: int
    unreadable: int
    seconds: float


def write_film(
    recording: Path,
    film: Path,
    *,
    free_bytes: Callable[[Path], int] = lambda path: shutil.disk_usage(path).free,
) -> Film:
    """Write the pictures of a recording (`.mcap`) as a film (`.avi`); a torn end of the recording is left out.

    Pictures stand still until the next one, so that the film runs as fast as the recording's clock. Raises FilmError,
    `hawk.store.replay.RecordingError`.
    """
    if film.suffix.lower() != ".avi":
        raise FilmError(f"{film}: the name of a film ends in .avi")
    if _is_there(film):
        raise FilmError(f"{film}: exists already; name another file")
    times, size = _survey(recording)
    if not times:
        raise FilmError(f"{recording}: has no pictures")
    fps = _rate(times)
    _check_space(film, size, free_bytes)
    unfinished = film.with_name(f".{film.stem}.unfinished.avi")
    try:
        made = _write(recording, unfinished, fps)
        unfinished.rename(film)
    finally:
        unfinished.unlink(missing_ok=True)
    return made


def _is_there(film: Path) -> bool:
    try:
        return film.exists()
    except OSError as error:
        raise FilmError(f"{film}: {error.strerror or error}; name a folder that this user may write") from error


def _survey(recording: Path) -> tuple[list[float], int]:
    """Return the time of each picture, and the bytes of all."""
    times, size = [], 0
    for at, jpeg in _pictures(recording):
        times.append(at)
        size += len(jpeg)
    return times, size


def _pictures(recording: Path) -> Iterator[tuple[float, bytes]]:
    for recorded in read_recording(recording):
        if recorded.topic == FRAME_INPUT:
            try:
                yield recorded.time, picture_of(recorded.data)
            except FrameFormatError:
                yield recorded.time, b""


def _rate(times: list[float]) -> float:
    """Return pictures a second, by the usual time between two."""
    gaps = [later - earlier for earlier, later in pairwise(times) if later > earlier]
    return min(MOST_FPS, max(1.0, float(round(1.0 / statistics.median(gaps))))) if gaps else 1.0


def _check_space(film: Path, size: int, free_bytes: Callable[[Path], int]) -> None:
    """Raise FilmError when the disk has no room for twice the pictures, since they are encoded again."""
    if not film.parent.is_dir():
        raise FilmError(f"{film.parent}: is no folder")
    free = free_bytes(film.parent)
    if free < 2 * size + SPARE_BYTES:
        needed = (2 * size + SPARE_BYTES) // 1_000_000
        raise FilmError(f"{film.parent}: {free // 1_000_000} MB are free, a film may need {needed}; delete old files")


def _write(recording: Path, film: Path, fps: float) -> Film:
    writer: cv2.VideoWriter | None = None
    shape: tuple[int, int] = (0, 0)
    shown: np.ndarray | None = None
    before, slots, pictures, unreadable = 0.0, 0.0, 0, 0
    written = 0
    try:
        for at, jpeg in _pictures(recording):
            try:
                picture = decode(jpeg)
            except NoImage:
                unreadable += 1
                continue
            if writer is None:
                shape = (picture.shape[1], picture.shape[0])
                writer = _open(film, fps, shape)
            else:
                slots += min(max(0.0, at - before), LONGEST_GAP_S) * fps
                while shown is not None and written < round(slots):
                    writer.write(shown)
                    written += 1
            before, pictures = at, pictures + 1
            shown = picture if (picture.shape[1], picture.shape[0]) == shape else cv2.resize(picture, shape)
        if writer is None or shown is None:
            raise FilmError(f"{recording}: none of its pictures can be read")
        writer.write(shown)
        written += 1
    finally:
        if writer is not None:
            writer.release()
    return Film(pictures, unreadable, written / fps)


def _open(film: Path, fps: float, size: tuple[int, int]) -> cv2.VideoWriter:
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter.fourcc(*"MJPG"), fps, size)
    if not writer.isOpened():
        raise FilmError(f"{film.parent}: OpenCV cannot write a film there")
    writer.set(cv2.VIDEOWRITER_PROP_QUALITY, QUALITY)
    return writer
