"""Vision App (specification section 10): from a camera's picture to what is seen on the ground."""

from __future__ import annotations

from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.errors import AlgoError, NoImage
from hawk.algo.frame import FrameInput
from hawk.algo.vision.annotate import annotate
from hawk.algo.vision.classical import ClassicalFinder
from hawk.algo.vision.finder import Finder, NetworkFinder
from hawk.algo.vision.network import StallNetwork, VisionModelError
from hawk.algo.vision.picture import decode as decode_picture
from hawk.algo.vision.rectify import Rectifier, RectifyError
from hawk.algo.vision.seen import Seen, StallSeen
from hawk.algo.vision.settings import VisionSettings
from hawk.model import Health, HealthStatus, MapPose

_SURE_SCORE = 0.5
_LOT_SHARE = 0.3
_FRAMES_TO_DETECT = 2
_FRAMES_TO_LOSE = 8
_USUAL_SIZE_M = (2.62, 5.35)
_STALLS_FOR_SCALE = 8


class PictureSource(Protocol):
    """The Drone Camera as this module uses it."""

    def get_image(self) -> bytes:
        """Return the frame's JPEG. Raises NoImage."""
        ...


class Publishes(Protocol):
    """Takes what this module says on one topic."""

    def publish(self, value: Any) -> None:
        """Replace the value."""
        ...


class VisionTopics(Protocol):
    """The Algorithm Topic Interface as this module uses it."""

    @property
    def frame(self) -> FrameInput:
        """The frame being worked on."""
        ...

    @property
    def park_lot_detected_pub(self) -> Publishes:
        """Topic of the lot's detection."""
        ...

    @property
    def vision_app_health_pub(self) -> Publishes:
        """Topic of this module's health."""
        ...


class VisionApp:
    """Rectifies each frame, finds stalls in it and says whether a lot is in sight."""

    def __init__(self, settings: VisionSettings | None = None, finder: Finder | None = None) -> None:
        """Make the app; ``finder`` stands in for the one that the settings name.

        Raises VisionModelError when the settings name a network that cannot be used. Without the network of the package
        it goes on with classical line geometry and says so in its health.
        """
        self._settings = settings or VisionSettings()
        self._notice = ""
        self._finder = finder or self._make_finder()
        self._rectifier = Rectifier()
        self._camera: PictureSource | None = None
        self._topics: VisionTopics | None = None
        self._frame: FrameInput | None = None
        self._image: NDArray[np.uint8] | None = None
        self._seen: Seen | None = None
        self._health = Health()
        self._detected = False
        self._streak = 0

    def init(self, drone_camera: PictureSource, topic_interface: VisionTopics) -> None:
        """Take the camera and the topics, and forget all frames (specification: init)."""
        self._camera, self._topics = drone_camera, topic_interface
        cv2.setNumThreads(self._settings.threads)
        self._reset()

    def process(self) -> None:
        """Work on the frame that the topic interface serves (specification: process).

        Raises NoImage when its picture cannot be used, AlgoError when it cannot be looked at; the health tells why.
        """
        frame, camera = self._inputs()
        self._image, self._seen, self._frame = None, None, frame
        try:
            self._image = decode_picture(camera.get_image())
            self._seen = self._look(frame, self._image)
        except (NoImage, AlgoError) as error:
            self._note_lot(sees_lot=False)
            self._health = Health.bad(str(error))
            raise

    def publish(self) -> None:
        """Share whether a lot is seen, and the health (specification: publish)."""
        if self._topics is None:
            raise AlgoError("vision: init() was not called")
        self._topics.park_lot_detected_pub.publish(self.get_park_lot_detected())
        self._topics.vision_app_health_pub.publish(self.get_health())

    def get_park_lot_detected(self) -> bool:
        """Return whether a parking lot is in sight; steady over single frames."""
        return self._detected

    def get_health(self) -> Health:
        """Return whether the last frame's results can be trusted, and why not."""
        return self._health

    @property
    def seen(self) -> Seen | None:
        """What the last frame says, None when it could not be laid on the ground."""
        return self._seen

    @property
    def image(self) -> NDArray[np.uint8] | None:
        """The last frame's picture, uint8 BGR, None when it could not be decoded."""
        return self._image

    @property
    def annotated_image(self) -> bytes:
        """JPEG of the last frame with the stalls that it alone shows; empty when it could not be decoded."""
        if self._image is None or self._frame is None:
            return b""
        pose = self._seen.pose if self._seen else None
        return annotate(self._image, self._frame.camera, pose, self._seen.stalls if self._seen else ())

    def _make_finder(self) -> Finder:
        if not self._settings.use_network:
            return ClassicalFinder()
        try:
            return NetworkFinder(StallNetwork.load(self._settings.model))
        except VisionModelError as error:
            if self._settings.model is not None:
                raise
            self._notice = f"classical line geometry only: {error}"
            return ClassicalFinder()

    def _reset(self) -> None:
        self._frame, self._image, self._seen = None, None, None
        self._health, self._detected, self._streak = Health(), False, 0

    def _inputs(self) -> tuple[FrameInput, PictureSource]:
        if self._topics is None or self._camera is None:
            raise AlgoError("vision: init() was not called")
        return self._topics.frame, self._camera

    def _look(self, frame: FrameInput, image: NDArray[np.uint8]) -> Seen | None:
        if frame.pose is None or (frame.pose.is_finite() and frame.pose.height < self._settings.minimum_height_m):
            self._note_lot(sees_lot=False)
            self._health = Health(HealthStatus.HEALTHY, self._why_not(frame.pose))
            return None
        seen = self._see(frame, frame.pose, image)
        self._health = Health.bad(self._notice) if self._notice else Health()
        return seen

    def _why_not(self, pose: MapPose | None) -> str:
        if pose is None:
            return "pictures are shown only: no pose for this frame (the map begins when the drone is armed)"
        return f"pictures are shown only: below {self._settings.minimum_height_m:g} m"

    def _see(self, frame: FrameInput, pose: MapPose, image: NDArray[np.uint8]) -> Seen:
        try:
            picture = self._rectifier.rectify(image, frame.camera, pose)
            found = self._finder.find(picture)
        except (RectifyError, VisionModelError) as error:
            raise AlgoError(str(error)) from error
        sure = sum(s.score >= _SURE_SCORE for s in found.stalls)
        share = float(found.lot.values[found.lot.valid].mean()) if found.lot.valid.any() else 0.0
        self._note_lot(sees_lot=sure >= self._settings.minimum_stalls or (sure > 0 and share >= _LOT_SHARE))
        return Seen(
            stalls=found.stalls,
            lot=found.lot,
            car=found.car,
            core=found.core,
            picture=picture,
            park_lot_detected=self._detected,
            scale=stall_scale(found.stalls),
            pose=pose,
            captured=frame.captured,
        )

    def _note_lot(self, *, sees_lot: bool) -> None:
        """Change the verdict only after some frames in a row that contradict it."""
        self._streak = self._streak + 1 if sees_lot != self._detected else 0
        if self._streak >= (_FRAMES_TO_LOSE if self._detected else _FRAMES_TO_DETECT):
            self._detected, self._streak = sees_lot, 0


def stall_scale(stalls: tuple[StallSeen, ...]) -> float:
    """Return the size of whole, sure stalls relative to the usual one (geometric mean of the medians of width and
    length); 1.0 when fewer than eight are seen."""
    sizes = np.array([(s.width, s.length) for s in stalls if s.score >= _SURE_SCORE and s.visible > 0.95])
    if len(sizes) < _STALLS_FOR_SCALE:
        return 1.0
    return float(np.sqrt(np.prod(np.median(sizes, axis=0) / _USUAL_SIZE_M)))
