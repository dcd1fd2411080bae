"""Pictures of USB cameras, and of all others that are a ``/dev/video``, through OpenCV's V4L2 with the kernel's stamps.

A camera's own JPEG is passed on as it is. OpenCV gives the stamp of a buffer (``v4l2_buffer.timestamp``) as
CAP_PROP_POS_MSEC: the time at which the picture's first data came from the camera.
"""

from __future__ import annotations

import fcntl
import os
import struct
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Protocol

import cv2
import numpy as np

from hawk.comm.cameras.sources.source import CameraError, Give, SourceFrame, ThreadedSource, encoded
from hawk.comm.cameras.stamp_clock import captured_at
from hawk.config.addresses import V4l2Camera
from hawk.formats.image import whole_jpeg

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


SILENCE_S: Final = 2
"""Real seconds without a picture after which the device is opened again."""
_AGAIN_S: Final = 0.02
_JPEG: Final = frozenset(("MJPG", "JPEG"))
_MILLISECONDS: Final = 1e-3


class Capture(Protocol):
    """The part of ``cv2.VideoCapture`` that is used."""

    def isOpened(self) -> bool:  # noqa: N802, D102
        ...

    def set(self, propId: int, value: float) -> bool:  # noqa: N803, D102
        ...

    def get(self, propId: int) -> float:  # noqa: N803, D102
        ...

    def read(self) -> tuple[bool, Any]:  # noqa: D102
        ...

    def release(self) -> None:  # noqa: D102
        ...


def open_capture(device: Path) -> Capture:
    """Open the device by OpenCV, which waits for a picture for SILENCE_S in place of 10 s."""
    os.environ.setdefault("OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT", f"{SILENCE_S}")  # OpenCV has no argument for it
    return cv2.VideoCapture(str(device), cv2.CAP_V4L2)


class V4l2Source(ThreadedSource):
    """``v4l2:///dev/DEVICE?OPTIONS``. The device is looked up by its path each time that it is opened."""

    def __init__(
        self,
        camera: V4l2Camera,
        clock: Callable[[], float],
        open_device: Callable[[Path], Capture] = open_capture,
        formats: Callable[[Path], Sequence[V4l2Format]] = read_formats,
        silence_s: float = SILENCE_S,
    ) -> None:
        super().__init__(f"v4l2://{camera.device}")
        self._camera = camera
        self._clock = clock
        self._open_device = open_device
        self._formats = formats
        self._silence_s = silence_s

    def capture(self, give: Give, stopping: threading.Event) -> None:
        """Open the device and read it. Raises CameraError when it is unplugged, silent, or not as it is asked to be."""
        device = self._camera.device
        if not device.exists():
            raise CameraError("there is no such device (is the camera plugged in?)")
        try:
            formats = self._formats(device)
        except PermissionError:
            raise CameraError("may not be opened; join the group video: sudo usermod -aG video hawk") from None
        except OSError as error:
            raise CameraError(f"cannot be opened: {error.strerror}") from error
        code = choose_format(self._camera, formats)
        capture = self._open_device(device)
        try:
            if not capture.isOpened():
                raise CameraError(f"cannot be opened; does another program use it? fuser {device} names it")
            self._set_up(capture, code, formats)
            self._read(capture, code in _JPEG, give, stopping)
        finally:
            capture.release()

    def _set_up(self, capture: Capture, code: str | None, formats: Sequence[V4l2Format]) -> None:
        camera = self._camera
        if code:
            capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*code.ljust(4)))
        if camera.width and camera.height:
            capture.set(cv2.CAP_PROP_FRAME_WIDTH, camera.width)
            capture.set(cv2.CAP_PROP_FRAME_HEIGHT, camera.height)
            given = tuple(int(capture.get(each)) for each in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT))
            if given != (camera.width, camera.height):
                has = "; ".join(map(str, formats)) or "others"
                raise CameraError(
                    f"the camera gives {given[0]} x {given[1]}, not {camera.width} x {camera.height}; it has {has}"
                )
        if camera.framerate:
            capture.set(cv2.CAP_PROP_FPS, camera.framerate)
        if code in _JPEG:
            capture.set(cv2.CAP_PROP_CONVERT_RGB, 0)

    def _read(self, capture: Capture, is_jpeg: bool, give: Give, stopping: threading.Event) -> None:
        last = time.monotonic()
        while not stopping.is_set():
            whole, picture = capture.read()
            arrival = self._clock()
            if whole and picture is not None:
                last = time.monotonic()
                self._take(picture, is_jpeg, arrival, capture.get(cv2.CAP_PROP_POS_MSEC) * _MILLISECONDS, give)
            elif not self._camera.device.exists():
                raise CameraError("the camera was unplugged")
            elif time.monotonic() - last >= self._silence_s:
                raise CameraError(f"no picture for {self._silence_s:g} s")
            else:
                stopping.wait(_AGAIN_S)

    def _take(self, picture: Any, is_jpeg: bool, arrival: float, stamp: float, give: Give) -> None:
        if is_jpeg:
            whole = whole_jpeg(np.asarray(picture, np.uint8).tobytes())  # a buffer may be longer than its picture
            if whole is None:
                self.torn += 1
                return
            jpeg = whole
        else:
            jpeg = encoded(np.asarray(picture, np.uint8))
        captured = captured_at(stamp, self._clock) if stamp > 0 else None
        give(SourceFrame(jpeg, arrival, stamp if stamp > 0 else None, captured))
