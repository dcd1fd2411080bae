"""Our own recordings (``.mcap``) as films: each frame has its pose and camera."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np

from hawk.formats.image import NoImage, decode
from hawk.model.frames import place_at
from hawk.model.pictures import CameraModel, angles, rotation
from hawk.picture.film.course import Course
from hawk.picture.film.video import Picture
from hawk.picture.values import PictureError
from hawk.replay.flight import Origin, RecordedFlight, ReplayError
from hawk.replay.odm import camera_of, pose_of
from hawk.store.frame_codec import FRAME_INPUT, FrameFormatError, picture_of, values_of
from hawk.store.replay import Recorded, RecordingError, read_metadata

SUFFIX: Final = ".mcap"
_SIGMA_M: Final = (1.5, 1.0)


@dataclass(frozen=True, slots=True)
class RecordedFrames:
    """Frames of a recording that show the ground. ``numbers`` (N): theirs among all frames of the file, from 0.

    ``cameras`` (N) have a mount of zero. ``left_out``: number of those of the ground or without a place. ``damage``:
    why the rest is missing, "" for a whole file.
    """

    numbers: tuple[int, ...] = field(repr=False)
    course: Course = field(repr=False)
    cameras: tuple[CameraModel, ...] = field(repr=False)
    left_out: int
    damage: str


def read_frames(path: Path) -> RecordedFrames:
    """Return the frames of a recording with their poses. Raises PictureError where it cannot be read, or has none."""
    reader = _Reader()
    try:
        flight = RecordedFlight(path)
        flight.follow(reader.take)
        epoch = int(read_metadata(path).get("epoch_ns", "0")) / 1e9
    except (ReplayError, RecordingError, ValueError) as error:
        raise PictureError(str(error)) from error
    if not reader.rows:
        raise PictureError(
            f"{path}: holds no pictures from the air with a place; name the recording of a flight that mapped"
        )
    values = np.array(reader.rows)
    course = Course.of_rows(values[:, :5], values[:, 5:], _SIGMA_M, epoch or None)
    return RecordedFrames(tuple(reader.numbers), course, tuple(reader.cameras), reader.left_out, flight.damage)


class _Reader:
    """Keeps the pose of each frame."""

    def __init__(self) -> None:
        self.rows: list[tuple[float, ...]] = []
        self.numbers: list[int] = []
        self.cameras: list[CameraModel] = []
        self.left_out = 0
        self._count = 0
        self._origin = Origin()
        self._known: dict[CameraModel, CameraModel] = {}

    def take(self, message: Recorded) -> bool:
        """Take a message; return True for a frame. Raises ReplayError."""
        self._origin.look(message)
        if message.topic != FRAME_INPUT:
            return False
        number, self._count = self._count, self._count + 1
        try:
            frame = values_of(message.data)
            pose, camera, captured = pose_of(frame), camera_of(frame), float(frame["captured"])
            ground = float(frame.get("ground") or 0.0)
        except (FrameFormatError, LookupError, TypeError, ValueError) as error:
            raise ReplayError(f"the picture at {message.time:.2f} s cannot be read: {error!r}") from error
        if pose is None or self._origin.datum is None:
            self.left_out += 1
            return True
        mount = rotation(camera.mount_roll, camera.mount_pitch, camera.mount_yaw)
        turned = angles(rotation(pose.roll, pose.pitch, pose.yaw) @ mount)
        place = place_at(pose.north, pose.east, self._origin.datum)
        altitude = self._origin.arm_altitude + pose.height
        self.rows.append((captured, place.latitude, place.longitude, altitude, pose.height - ground, *turned))
        self.numbers.append(number)
        self.cameras.append(
            self._known.setdefault(camera, replace(camera, mount_roll=0.0, mount_pitch=0.0, mount_yaw=0.0))
        )
        return True


class RecordedPictures:
    """Pictures of a recording by the numbers of their frames, read forward; begins again to go back."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._number = -1
        self._message: Recorded | None = None
        self._messages = self._frames()

    def frame(self, number: int) -> Picture:
        """Return a picture (H, W, 3), BGR. Raises NoImage where it cannot be read."""
        try:
            self._go(number)
            if self._message is None:
                raise NoImage("it is not in the recording")
            return decode(picture_of(self._message.data))
        except (FrameFormatError, ReplayError, RecordingError) as error:
            raise NoImage(f"it cannot be read ({error})") from error

    def frames_of(self, numbers: Sequence[int]) -> Iterator[tuple[int, Picture]]:
        """Give the pictures of rising numbers; passes over those that cannot be read."""
        for number in numbers:
            try:
                yield number, self.frame(number)
            except NoImage:
                continue

    def close(self) -> None:
        """End the reading."""
        self._messages.close()

    def _go(self, number: int) -> None:
        if number < self._number:
            self._messages.close()
            self._messages, self._number = self._frames(), -1
        while self._number < number:
            self._message = next(self._messages, None)
            self._number += 1

    def _frames(self) -> Generator[Recorded, None, None]:
        return (message for message in RecordedFlight(self._path).messages() if message.topic == FRAME_INPUT)
