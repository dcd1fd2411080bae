"""Pictures: the one reader of their size, orientation and soundness, for camera, calibration, worlds and page.

A JPEG's bytes are read up to its end marker (ITU-T T.81); what follows is no part of it. Its pixels are those that the
sensor gave: the orientation in EXIF is read and never applied, since it would turn the pixels and not the lens's
calibration, and a camera's turn is its mount's (`[camera] mount`). Only `upright` applies it, for pictures that people
look at. The decoder stops at libjpeg's first warning: a picture that lost bytes is damaged, however whole it looks.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
import simplejpeg
from numpy.typing import NDArray

from hawk.model.sentences import say

_LEAST: Final = 5.0
"""Grey levels of a step that is reported: smaller ones change no stall."""
_AGREE: Final = 0.75
"""Share of a row's blocks that must step in the same direction."""
_SHARPER: Final = 1.8
"""Times by which the step is larger than the changes within the blocks beside it; colour is smoothed over 4 lines."""
_LEAST_BLOCKS: Final = 12
_FROM_ROW: Final = 1
"""Blocks that it must have in either of the two rows: an edge of what the camera saw has all in one."""
_PART: Final = 0.5
"""Share of the whole step that each of the two parts must have."""
_COLUMN: Final = 16
"""Pixels over whose width changes are averaged."""


def largest_step(image: NDArray[np.uint8], block: int) -> float:
    """Return the largest step of that kind in grey levels, 0.0 where there is none.

    Args:
        image: The whole picture, uint8 (H, W, 3).
        block: Rows of a block as it was stored (an MCU): 8 or 16.
    """
    rows, columns = image.shape[0] // block, image.shape[1] // _COLUMN
    if rows < 3 or columns < _LEAST_BLOCKS:
        return 0.0
    first = np.arange(1, rows) * block
    lines = [_means(image[first + offset], columns) for offset in (-2, -1, 0, 1)]
    at, above, below = lines[2] - lines[1], lines[1] - lines[0], lines[3] - lines[2]
    step = _over_a_row(at, columns)
    agree = _over_a_row(np.sign(at), columns)
    beside = np.maximum(np.abs(_over_a_row(above, columns)), np.abs(_over_a_row(below, columns)))
    size = np.abs(step)
    found = (size >= _LEAST) & (np.abs(agree) >= 2 * _AGREE - 1) & (size >= _SHARPER * beside)
    sizes_found = np.where(found, size, 0.0)
    best = sizes_found.argmax(axis=0)
    sizes = [
        float(sizes_found[begin, colour])
        for colour, begin in enumerate(best.tolist())
        if _goes_on(at[begin : begin + columns, colour], columns - begin % columns)
    ]
    return max(sizes, default=0.0)


def _goes_on(changes: NDArray[np.float32], in_first: int) -> bool:
    """Return True when a run of changes steps in both rows of blocks that it belongs to, ``in_first`` of it in one."""
    if not _FROM_ROW <= in_first <= len(changes) - _FROM_ROW:
        return False
    mean = float(changes.mean())
    parts = (changes[:in_first], changes[in_first:])
    return all(part.mean() / mean >= _PART and np.mean(np.sign(part) == np.sign(mean)) >= _AGREE for part in parts)


def _means(lines: NDArray[np.uint8], columns: int) -> NDArray[np.float32]:
    """Return the means of pieces of lines (N, W, 3), in reading order: (N * columns, 3)."""
    whole = lines[:, : columns * _COLUMN].astype(np.float32)
    means = cv2.resize(whole, (columns, len(lines)), interpolation=cv2.INTER_AREA)
    return np.asarray(means.reshape(-1, 3), np.float32)


def _over_a_row(values: NDArray[np.float32], columns: int) -> NDArray[np.float32]:
    """Return the mean of each run as long as a row, in reading order: (N - columns + 1, 3)."""
    sums = np.cumsum(np.concatenate((np.zeros((1, 3), np.float64), values)), axis=0)
    return np.asarray((sums[columns:] - sums[:-columns]) / columns, np.float32)


Picture = NDArray[np.uint8]

MOST_PIXELS: Final = 200_000_000
"""Of a JPEG that is decoded: the largest sensors in the air have 151 million. A file of 1 MB may say 4,000 million."""
JPEG_START: Final = b"\xff\xd8"
_SCAN: Final = 0xDA
_EXIF: Final = 0xE1
_RESTART_INTERVAL: Final = 0xDD
_END_MARKER: Final = 0xD9
_START_MARKER: Final = 0xD8
_FRAME_HEADERS: Final = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_BARE_MARKERS: Final = frozenset((0x01, *range(0xD0, 0xD8)))
"""Markers without a length (B.1.1.3)."""
_FRAME_BYTES: Final = 6
"""Of a frame header before its components: precision, height, width, their number (B.2.2)."""
_RESTART: Final = re.compile(rb"\xff([\xd0-\xd7])")
_EXIF_NAME: Final = b"Exif\x00\x00"
_ORIENTATION: Final = 0x0112
_SHORT: Final = 3
_EXTRA: Final = re.compile(r"(\d+) extraneous bytes before marker 0x([0-9a-f]{2})")
_MOST_EXTRA: Final = 16
"""Bytes too many that sound pictures have before a restart marker: Logitech's C270 and C910 send 1 to 10 of them."""
_MOST_EXTRA_AT_END: Final = 3
"""The same at a picture's end, where more of them are a part of the picture that was decoded to another place."""
_PADDING: Final = b"\x00\xff"
_UPRIGHT: Final = {
    2: (False, 1),
    3: (False, -1),
    4: (False, 0),
    5: (True, None),
    6: (True, 1),
    7: (True, -1),
    8: (True, 0),
}
"""By orientation: whether rows and columns are exchanged, then OpenCV's code of the flip."""


class NoImage(Exception):  # noqa: N818 - the specification's name
    """There is no fresh, usable picture; the text gives the reason.

    Specification sections 7, 8 and 10: cameras raise it, Vision App passes it on.
    """


class DamagedImage(NoImage):
    """A picture came, but a part of it was lost or changed in transit."""


@dataclass(frozen=True, slots=True)
class JpegHead:
    """Description that a JPEG gives of itself.

    ``size`` is (width, height) of the stored pixels, whatever the orientation is. ``orientation`` is EXIF's, 1 to 8; 1
    where there is none. ``block`` is the height of the blocks (MCU) in which it is stored, pixels. ``restarts`` is the
    number of restart markers that its one scan must have. ``end`` is the number of bytes up to and with the end marker,
    None for a torn picture, which has none.
    """

    size: tuple[int, int]
    orientation: int
    block: int
    restarts: int
    end: int | None


def read_jpeg(data: bytes) -> JpegHead:
    """Return size, orientation and end of a JPEG, without decoding it (B.2.2).

    Raises ValueError when the bytes are no JPEG.
    """
    if data[:2] != JPEG_START:
        raise ValueError(say("not a JPEG: it does not start with FFD8"))
    frame, interval, orientation, at = b"", 0, 1, 2
    while at + 4 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker == 0xFF:  # a fill byte
            at += 1
            continue
        if marker in _BARE_MARKERS:
            at += 2
            continue
        if marker in (_END_MARKER, _START_MARKER):
            break
        behind = at + 2 + int.from_bytes(data[at + 2 : at + 4], "big")
        segment = data[at + 4 : behind]
        if marker in _FRAME_HEADERS:
            frame = segment
        elif marker == _EXIF:
            orientation = _orientation(segment) or orientation
        elif marker == _RESTART_INTERVAL:
            interval = int.from_bytes(segment[:2], "big")
        at = behind
        if marker == _SCAN:
            at = _behind_scan(data, at)
    if len(frame) < _FRAME_BYTES:
        raise ValueError(say("not a JPEG, or torn: it has no frame header"))
    size = (int.from_bytes(frame[3:5], "big"), int.from_bytes(frame[1:3], "big"))
    end = at + 2 if data[at : at + 2] == b"\xff\xd9" else None
    across, down = _block(frame)
    units = -(-size[0] // across) * -(-size[1] // down)
    restarts = max(0, -(-units // interval) - 1) if interval else 0
    return JpegHead(size, orientation, down, restarts, end)


def jpeg_size(data: bytes) -> tuple[int, int]:
    """Return width and height of a JPEG's stored pixels. Raises ValueError when the bytes are no JPEG."""
    return read_jpeg(data).size


def whole_jpeg(data: bytes) -> bytes | None:
    """Return the bytes from a JPEG's start to its end marker, without what follows; None for no JPEG or a torn one."""
    try:
        end = read_jpeg(data).end
    except ValueError:
        return None
    return None if end is None else data[:end]


def decode(data: bytes, reduction: int = 1) -> Picture:
    """Return a JPEG's stored pixels as (height, width, 3) BGR, not turned by its orientation.

    ``reduction`` 2 and 4 give a half and a quarter of its width and height, rounded up, for less time than the whole.

    Raises:
        DamagedImage: Its end is missing, the decoder met what no encoder writes, or all behind some place is darker,
            brighter or of another colour (`hawk.formats.image`; whole pictures only).
        NoImage: It is no JPEG that can be decoded.
    """
    try:
        head = read_jpeg(data)
    except ValueError as error:
        raise NoImage(say("the picture cannot be decoded: {error}", error=str(error))) from None
    if head.size[0] * head.size[1] > MOST_PIXELS * reduction**2:
        size = {"width": head.size[0], "height": head.size[1], "millions": MOST_PIXELS // 1_000_000}
        raise NoImage(say("the picture is {width} x {height} pixels; at most {millions} million fit", **size))
    if head.end is None:
        raise DamagedImage(say("the picture is torn: its end is missing"))
    image = _decoded(data[: head.end], head, reduction)
    step = largest_step(image, head.block) if reduction == 1 else 0.0
    if step:
        raise DamagedImage(say("the picture is damaged: a part of it is {step:.0f} grey levels off", step=step))
    return image


def decode_any(data: bytes) -> Picture:
    """Return a picture of any kind that OpenCV reads (JPEG, PNG, TIFF) as stored, (height, width, 3) BGR.

    Raises:
        DamagedImage: It is a JPEG that was damaged.
        NoImage: It cannot be decoded.
    """
    if data.startswith(JPEG_START):
        return decode(data)
    if not data:
        raise NoImage(say("the picture is empty"))
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    except cv2.error as error:
        raise NoImage(say("the picture cannot be decoded: {error}", error=str(error))) from error
    if image is None:
        raise NoImage(say("the picture cannot be decoded"))
    return np.asarray(image, np.uint8)


def upright(image: Picture, orientation: int) -> Picture:
    """Return a picture as viewers show it, by EXIF's orientation (1 to 8; EXIF 2.32, 4.6.4)."""
    exchanged, flip = _UPRIGHT.get(orientation, (False, None))
    turned = cv2.transpose(image) if exchanged else image
    return np.asarray(turned if flip is None else cv2.flip(turned, flip), np.uint8)


def _decoded(data: bytes, head: JpegHead, reduction: int) -> Picture:
    """Return a whole JPEG's pixels. Raises DamagedImage for the decoder's first warning, NoImage for its errors."""
    try:
        return _pixels(data, head, reduction, strict=True)
    except ValueError as error:
        said = str(error)
    if not said.startswith(("Corrupt JPEG data", "Unsupported marker type")):
        raise NoImage(say("the picture cannot be decoded: {error}", error=said))
    if not _is_harmless(said, data, head.restarts):
        raise DamagedImage(say("the picture is damaged: {error}", error=said))
    try:
        return _pixels(data, head, reduction, strict=False)
    except ValueError as error:
        raise NoImage(say("the picture cannot be decoded: {error}", error=str(error))) from None


def _pixels(data: bytes, head: JpegHead, reduction: int, *, strict: bool) -> Picture:
    width, height = (-(-side // reduction) for side in head.size)
    pixels = simplejpeg.decode_jpeg(
        data, "BGR", min_width=width, min_height=height, min_factor=reduction, strict=strict
    )
    return np.asarray(pixels, np.uint8)


def _is_harmless(said: str, data: bytes, restarts: int) -> bool:
    """Return True for a warning that sound pictures of some cameras cause: a few bytes too many."""
    found = _EXTRA.search(said)
    if found is None:
        return False
    count, marker = int(found[1]), int(found[2], 16)
    if marker == _END_MARKER:
        return count <= _MOST_EXTRA_AT_END or not data[-2 - count : -2].strip(_PADDING)
    numbers = [each[1][0] - 0xD0 for each in _RESTART.finditer(data, data.rfind(b"\xff\xda"))]
    return count <= _MOST_EXTRA and numbers == [each % 8 for each in range(restarts)]


def _behind_scan(data: bytes, start: int) -> int:
    """Return where the marker behind a scan is; the length of the data where there is none.

    In a scan an FF of the picture's own is followed by 00, a fill byte by another FF; D0 to D7 are restarts (B.1.1.5).
    """
    scan = np.frombuffer(data, np.uint8)[start:]
    at = np.flatnonzero(scan[:-1] == 0xFF)
    following = scan[at + 1]
    markers = at[(following != 0) & (following != 0xFF) & ((following & 0xF8) != 0xD0)]
    return start + int(markers[0]) if len(markers) else len(data)


def _block(frame: bytes) -> tuple[int, int]:
    """Return width and height in pixels of the blocks of a scan of all components (MCU; A.2)."""
    factors = [(each >> 4, each & 15) for each in frame[_FRAME_BYTES + 1 :: 3]]
    if len(factors) <= 1:
        return 8, 8
    return 8 * max(1, *(across for across, _ in factors)), 8 * max(1, *(down for _, down in factors))


def _orientation(segment: bytes) -> int | None:
    """Return the orientation that an APP1 segment gives, 1 to 8 (EXIF 2.32, 4.6.2); None where it gives none."""
    tiff = segment[len(_EXIF_NAME) :]
    order = {b"II": "<", b"MM": ">"}.get(tiff[:2])
    if not segment.startswith(_EXIF_NAME) or order is None:
        return None
    try:
        (directory,) = struct.unpack_from(f"{order}I", tiff, 4)
        (entries,) = struct.unpack_from(f"{order}H", tiff, directory)
        for entry in range(entries):
            tag, kind, count, value = struct.unpack_from(f"{order}HHIH", tiff, directory + 2 + 12 * entry)
            if (tag, kind, count) == (_ORIENTATION, _SHORT, 1):
                return value if 1 <= value <= 8 else None
    except struct.error:  # it leads beyond the segment
        return None
    return None
