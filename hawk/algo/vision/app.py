"""Vision App (specification section 10): from a camera's picture to stalls on the ground."""

from __future__ import annotations

import contextlib
import logging
from dataclasses import dataclass, fields, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.frame import AlgoError, FrameInput
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.algo.vision.blur import BLURRED, blur_of
from hawk.algo.vision.detection import Found, FrameGround, VisionResult
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.network import EngineChoice, StallNetwork
from hawk.algo.vision.network_file import VisionModelError
from hawk.algo.vision.picture import decode
from hawk.algo.vision.rectify import Rectifier, RectifyError
from hawk.formats.image import DamagedImage, NoImage
from hawk.model.operation import Health, HealthStatus
from hawk.model.poses import MapPose
from hawk.model.sentences import say, words_of

_LOG = logging.getLogger(__name__)

_SURE_SCORE = 0.5
_LOT_SHARE = 0.3
_FRAMES_TO_DETECT = 2
_FRAMES_TO_LOSE = 8


@dataclass(frozen=True, slots=True)
class VisionSettings:
    """Settings of the Vision App.

    ``model``: an ONNX file of the user's own, None for the one in the package. ``engine`` runs it, in ``threads``
    threads. Below ``minimum_height_m`` metres above the ground pictures are only shown. ``minimum_stalls`` make a lot.
    """

    model: Path | None = None
    engine: EngineChoice = "auto"
    threads: int = 1
    minimum_height_m: float = 6.0
    minimum_stalls: int = 3


class VisionApp:
    """Rectifies each frame, finds stalls in it and decides whether a lot is in sight."""

    def __init__(self, settings: VisionSettings | None = None, finder: StallDetector | None = None) -> None:
        """Make the app. Where the package's network cannot be used, pictures are shown only, and the health is bad.

        Args:
            settings: Settings; None for the defaults.
            finder: Replaces the finder that the settings name.

        Raises:
            VisionModelError: The settings name a network or an engine that cannot be used.
        """
        self._settings = settings or VisionSettings()
        self._problem = ""
        self._finder = finder or self._make_finder()
        self._rectifier = Rectifier()
        self._camera: FrameCamera | None = None
        self._topics: AlgorithmTopicInterface | None = None
        self._reset()

    def init(self, drone_camera: FrameCamera, topic_interface: AlgorithmTopicInterface) -> None:
        """Take the camera and the topics, and forget all frames (specification: init)."""
        self._camera, self._topics = drone_camera, topic_interface
        cv2.setNumThreads(self._settings.threads)
        self._reset()

    def see(self, frame: FrameInput) -> VisionResult:
        """Return what a frame shows; without a pose, or too low, its picture only.

        Raises:
            NoImage: The picture cannot be used; DamagedImage: a part of it was lost.
            AlgoError: The picture cannot be projected onto the ground, or the network fails.
        """
        self._seen = VisionResult()
        try:
            image = decode(frame.jpeg)
            self._seen = VisionResult(image=image)
            ground, health = self._look(frame, image)
        except Exception as error:
            self._note_lot(sees_lot=False)
            damaged = isinstance(error, DamagedImage)
            self._seen = replace(
                self._seen, park_lot_detected=self._detected, health=Health.bad(words_of(error)), is_damaged=damaged
            )
            raise
        self._seen = VisionResult(self._detected, health, image, ground)
        return self._seen

    def fail(self, reason: str) -> VisionResult:
        """Return the result of a frame that failed: nothing on the ground, the reason as health.

        The lot stays in sight over single frames that fail, as over single ones that do not show it.
        """
        self._seen = replace(self._seen, park_lot_detected=self._detected, health=Health.bad(reason), ground=None)
        return self._seen

    def process(self) -> None:
        """See the frame that the topic interface serves (specification: process). Raises NoImage, AlgoError."""
        if self._topics is None or self._camera is None:
            raise AlgoError(say("vision: init() was not called"))
        jpeg = b""
        with contextlib.suppress(NoImage):  # see() raises it and keeps the health
            jpeg = self._camera.get_image()
        self.see(replace(self._topics.frame, jpeg=jpeg))

    def publish(self) -> None:
        """Publish the lot's detection and the health (specification: publish)."""
        if self._topics is None:
            raise AlgoError(say("vision: init() was not called"))
        self._topics.park_lot_detected_pub.publish(self.get_park_lot_detected())
        self._topics.vision_app_health_pub.publish(self.get_health())

    def get_park_lot_detected(self) -> bool:
        """Return True while a parking lot is in sight; steady over single frames."""
        return self._seen.park_lot_detected

    def get_health(self) -> Health:
        """Return the health of the last frame's results."""
        return self._seen.health

    @property
    def seen(self) -> VisionResult:
        """The last result."""
        return self._seen

    def _make_finder(self) -> StallDetector | None:
        wanted = self._settings
        try:
            network = StallNetwork.load(wanted.model, wanted.engine, wanted.threads)
            _LOG.info("the network runs in %s, threads: %d", network.engine, wanted.threads)
            return StallDetector(network)
        except VisionModelError as error:
            if wanted.model is not None or wanted.engine == "onnxruntime":
                raise
            self._problem = str(error)  # a start in the air goes on without
            return None

    def _reset(self) -> None:
        self._seen, self._detected, self._streak = VisionResult(), False, 0

    def _look(self, frame: FrameInput, image: NDArray[np.uint8]) -> tuple[FrameGround | None, Health]:
        finder = self._finder
        if finder is None:
            raise AlgoError(self._problem)
        reason, pose = "", frame.over_ground
        if pose is None:
            reason = say("no pose for this frame (the map begins when the drone is armed)")
        elif pose.is_finite() and pose.height < self._settings.minimum_height_m:
            reason = say("below {height:g} m", height=self._settings.minimum_height_m)
        if pose is None or reason:
            self._note_lot(sees_lot=False)
            return None, Health(HealthStatus.HEALTHY, say("pictures are shown only: {reason}", reason=reason))
        return self._project(finder, frame, pose, image), Health()

    def _project(
        self, finder: StallDetector, frame: FrameInput, pose: MapPose, image: NDArray[np.uint8]
    ) -> FrameGround:
        try:
            picture = self._rectifier.rectify(image, frame.camera, pose)
            found = finder.detect(picture, None if frame.sun is None else frame.sun.shadow())
        except (RectifyError, VisionModelError) as error:
            raise AlgoError(str(error)) from error
        sure = sum(s.score >= _SURE_SCORE for s in found.stalls)
        share = float(found.lot.values[found.lot.valid].mean()) if found.lot.valid.any() else 0.0
        self._note_lot(sees_lot=sure >= self._settings.minimum_stalls or (sure > 0 and share >= _LOT_SHARE))
        parts = {f.name: getattr(found, f.name) for f in fields(Found)}
        return FrameGround(
            **parts, picture=picture, pose=pose, captured=frame.captured, is_blurred=blur_of(picture) >= BLURRED
        )

    def _note_lot(self, *, sees_lot: bool) -> None:
        """Change the verdict only after some frames in a row that contradict it."""
        self._streak = self._streak + 1 if sees_lot != self._detected else 0
        if self._streak >= (_FRAMES_TO_LOSE if self._detected else _FRAMES_TO_DETECT):
            self._detected, self._streak = sees_lot, 0
