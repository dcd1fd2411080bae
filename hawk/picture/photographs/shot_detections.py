"""Pictures of shots looked at, one at a time: features for the adjustment, levelled ground for the map."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from hawk.algo.vision.detection import WHOLE, GroundImage
from hawk.algo.vision.detector import StallDetector, one_thread
from hawk.algo.vision.private_ground import blackened
from hawk.formats.image import NoImage, decode
from hawk.model.lot_map import OccupancyMap
from hawk.picture.checkpoints import Checkpoints
from hawk.picture.photographs.frame_merger import FrameMerger
from hawk.picture.photographs.orthorectification import orthorectify
from hawk.picture.reconstruction.alignment import Reconstruction
from hawk.picture.reconstruction.camera_pose import CameraPose
from hawk.picture.reconstruction.features import Features, features
from hawk.picture.values import LeftOut, Progress, Shot

_IN_MEMORY: Final = 64
"""Photographs whose features are in memory where files have them all: twice the neighbours of one."""
_LOOKS: Final = 3
"""Photographs that show how wide stalls are."""
_AGAIN: Final = "copy it from the card again"


class Pictures(Protocol):
    """Gives the pictures of shots."""

    def picture(self, shot: Shot) -> NDArray[np.uint8]:
        """Return a shot's picture, BGR. Raises NoImage with the reason when it cannot be used."""
        ...


class Files:
    """Pictures of shots that have a JPEG each."""

    def picture(self, shot: Shot) -> NDArray[np.uint8]:
        """Return a shot's picture, BGR, as the sensor gave it. Raises NoImage, DamagedImage."""
        try:
            return decode(shot.path.read_bytes())
        except OSError as error:
            raise NoImage(f"it cannot be read: {error.strerror or error}") from error


class _OtherSizeError(ValueError):
    """A picture is not of the size that its tags say."""


class ShotReader:
    """The pictures of one survey. ``lost``: those that could not be read any more when the map was made."""

    def __init__(self, pictures: Pictures, work: Checkpoints, *, has_private: bool = False) -> None:
        """``work`` keeps the results; of whole pictures none, where ground is private."""
        self._has_private = has_private
        self._pictures = pictures
        self._work = work
        self._features: list[Features] = []
        self.lost: list[LeftOut] = []

    def read(self, shots: Sequence[Shot], progress: Progress) -> tuple[list[int], list[LeftOut]]:
        """Return the numbers of the shots that can be read, and the others with the reason."""
        usable: list[int] = []
        left_out: list[LeftOut] = []
        for number, shot in enumerate(shots):
            progress("read", number, len(shots))
            try:
                found = self._look(shot)
            except NoImage as error:
                left_out.append(LeftOut(shot.name, f"{error}; {_AGAIN}"))
                continue
            except _OtherSizeError as error:
                left_out.append(LeftOut(shot.name, str(error)))
                continue
            usable.append(number)
            if not self._work.keeps:
                self._features.append(found)
        return usable, left_out

    def features_of(self, shots: Sequence[Shot]) -> Callable[[int], Features]:
        """Return the function that gives the features of usable shots by their numbers: from files where they are."""
        if not self._work.keeps:
            return self._features.__getitem__
        return lru_cache(_IN_MEMORY)(lambda number: self._look(shots[number]))

    def only(self, numbers: Sequence[int], shots: Sequence[Shot]) -> list[Shot]:
        """Return the shots of these numbers; the others are not looked at any more."""
        if self._features:
            self._features = [self._features[number] for number in numbers]
        return [shots[number] for number in numbers]

    def picture(self, shot: Shot) -> NDArray[np.uint8]:
        """Return a shot's picture. Raises NoImage."""
        return self._pictures.picture(shot)

    def widths(self, shots: Sequence[Shot], adjusted: Reconstruction, finder: StallDetector) -> list[float]:
        """Return the widths of the stalls that a few photographs in the middle show whole, metres."""
        places = np.array([(one.north, one.east) for one in adjusted.posed])
        good = np.flatnonzero(adjusted.is_adjusted) if adjusted.is_adjusted.any() else np.arange(len(shots))
        apart = np.hypot(*(places[good] - np.median(places[good], axis=0)).T)
        found: list[float] = []
        with one_thread():
            for number in good[np.argsort(apart, kind="stable")][:_LOOKS].tolist():
                shot, posed = shots[number], adjusted.posed[number]
                try:
                    picture = orthorectify(self._pictures.picture(shot), posed)
                except NoImage:  # the map says so
                    continue
                if picture is not None:
                    look = partial(finder.detect, picture)
                    seen = look() if self._has_private else self._work.found(shot, posed, look)
                    found += [stall.width for stall in seen.stalls if stall.visible >= WHOLE]
        return found

    def mapped(
        self,
        name: str,
        shots: Sequence[Shot],
        adjusted: Reconstruction,
        finder: StallDetector,
        progress: Progress,
        private: BaseGeometry,
    ) -> OccupancyMap:
        """Return the map of all shots by their adjusted poses.

        ``private``: ground that nobody may look at, (north, east) metres: nothing is found there, and no result kept.
        """
        self._features.clear()
        built = FrameMerger(name)
        with one_thread():
            for number, (shot, posed) in enumerate(zip(shots, adjusted.posed, strict=True)):
                progress("map", number, len(shots))
                self._add(built, finder, shot, posed, float(number), private)
            progress("finish", 0, 1)
            finished = built.finish()
        progress("finish", 1, 1)
        return finished

    def _levelled(self, shot: Shot, posed: CameraPose, private: BaseGeometry) -> GroundImage | None:
        picture = orthorectify(self._pictures.picture(shot), posed)
        return picture if picture is None or private.is_empty else blackened(picture, private)

    def _add(
        self,
        built: FrameMerger,
        finder: StallDetector,
        shot: Shot,
        posed: CameraPose,
        time: float,
        private: BaseGeometry,
    ) -> None:
        try:
            picture = self._levelled(shot, posed, private)
        except NoImage as error:
            self.lost.append(LeftOut(shot.name, f"{error}; {_AGAIN}"))
            return
        if picture is not None:
            built.add(picture, self._work.found(shot, posed, partial(finder.detect, picture)), posed.pose, time)

    def _look(self, shot: Shot) -> Features:
        return self._work.features(shot, partial(self._features_in, shot))

    def _features_in(self, shot: Shot) -> Features:
        image = self._pictures.picture(shot)
        if image.shape[:2] != (shot.camera.height, shot.camera.width):
            raise _OtherSizeError("its size is not that of its tags; use the camera's own file")
        return features(image)
