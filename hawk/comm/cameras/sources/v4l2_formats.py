"""Formats and sizes that a V4L2 camera has, for the choice of one and for errors that name them.

OpenCV captures, but lists nothing. linuxpy lists them, but is under the GPL, which would bind the whole package. Two
calls of the kernel's interface (``linux/videodev2.h``) are all that is needed.
"""

from __future__ import annotations

import fcntl
import os
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from hawk.comm.cameras.sources.source import CameraError
from hawk.config.camera_address import V4l2Camera

_ENUM_FMT: Final = 0xC0405602
_ENUM_FRAMESIZES: Final = 0xC02C564A
_FMTDESC: Final = struct.Struct("III32sI16x")
"""Of v4l2_fmtdesc: index, type, flags, description, pixelformat."""
_FRMSIZEENUM: Final = struct.Struct("III6I8x")
"""Of v4l2_frmsizeenum: index, pixel_format, type, then width and height; or least, most, step of width and height."""
_CAPTURE: Final = 1
_DISCRETE: Final = 1
_MOST: Final = 128
_PREFERRED: Final = ("MJPG", "YUYV")
"""JPEG as the camera makes it needs no encoding here, and a tenth of USB's bandwidth."""

Ioctl = Callable[[int, int, bytearray], object]


@dataclass(frozen=True, slots=True)
class SizeRange:
    """Sizes from least to most by a step, pixels; a single size has equal ends."""

    width: tuple[int, int, int]
    height: tuple[int, int, int]

    def __contains__(self, size: tuple[int, int]) -> bool:
        """Return True for a width and height of this range."""
        return all(
            least <= wanted <= most and (wanted - least) % max(step, 1) == 0
            for wanted, (least, most, step) in zip(size, (self.width, self.height), strict=True)
        )

    def __str__(self) -> str:
        ends = [f"{width} x {height}" for width, height in zip(self.width[:2], self.height[:2], strict=True)]
        return ends[0] if ends[0] == ends[1] else f"{ends[0]} to {ends[1]}"


@dataclass(frozen=True, slots=True)
class V4l2Format:
    """A pixel format by its four letters, with its sizes; none where the driver does not list them."""

    code: str
    sizes: tuple[SizeRange, ...]

    def __str__(self) -> str:
        return f"{self.code} {', '.join(map(str, self.sizes))}".rstrip()


def read_formats(device: Path, ioctl: Ioctl = fcntl.ioctl) -> list[V4l2Format]:
    """Return the camera's formats. Raises OSError."""
    descriptor = os.open(device, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        return [V4l2Format(code, tuple(_sizes(descriptor, code, ioctl))) for code in _codes(descriptor, ioctl)]
    finally:
        os.close(descriptor)


def choose_format(camera: V4l2Camera, formats: Sequence[V4l2Format]) -> str | None:
    """Return the four letters of the format to ask for, None to leave it to the driver.

    Raises CameraError naming the formats and sizes that the camera has, when it lacks the wanted one.
    """
    if not formats:
        return camera.format
    size = None if camera.width is None or camera.height is None else (camera.width, camera.height)
    wanted = (camera.format,) if camera.format else (*_PREFERRED, *(each.code for each in formats))
    for code in wanted:
        for each in formats:
            if each.code == code and (size is None or not each.sizes or any(size in some for some in each.sizes)):
                return code
    words = f"{camera.format or ''}{f' {size[0]} x {size[1]}' if size else ''}".strip()
    raise CameraError(f"the camera has no {words}; it has {'; '.join(map(str, formats))}")


def _codes(descriptor: int, ioctl: Ioctl) -> Iterator[str]:
    for index in range(_MOST):
        found = _ask(_FMTDESC, (index, _CAPTURE, 0, b"", 0), descriptor, _ENUM_FMT, ioctl)
        if found is None:
            return
        yield found[4].to_bytes(4, "little").decode("latin-1").strip()


def _sizes(descriptor: int, code: str, ioctl: Ioctl) -> Iterator[SizeRange]:
    number = int.from_bytes(code.ljust(4).encode("latin-1"), "little")
    for index in range(_MOST):
        found = _ask(_FRMSIZEENUM, (index, number, 0, 0, 0, 0, 0, 0, 0), descriptor, _ENUM_FRAMESIZES, ioctl)
        if found is None:
            return
        _, _, kind, *numbers = found
        if kind == _DISCRETE:
            width, height = numbers[:2]
            yield SizeRange((width, width, 1), (height, height, 1))
        else:  # one answer for all sizes
            yield SizeRange((numbers[0], numbers[1], numbers[2]), (numbers[3], numbers[4], numbers[5]))
            return


def _ask(
    layout: struct.Struct, values: tuple[int | bytes, ...], descriptor: int, call: int, ioctl: Ioctl
) -> tuple[int, ...] | None:
    """Return the answer's fields; None after the last (EINVAL), or where the driver has no such list (ENOTTY)."""
    data = bytearray(layout.pack(*values))
    try:
        ioctl(descriptor, call, data)
    except OSError:
        return None
    return layout.unpack(bytes(data))
