"""Algorithm Manager App (specification section 13): runs vision, mapper and path plan on one frame, in this order.

What is here runs on the worker thread and knows one frame at a time; `hawk.algo.loop` is the part on the loop.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hawk.algo.errors import AlgoError, NoImage
from hawk.algo.footprint import ground_footprint
from hawk.algo.frame import FrameInput, FrameOutput
from hawk.algo.mapper.app import MapperApp
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.algo.vision.annotate import PictureStyle, annotate
from hawk.algo.vision.seen import Seen
from hawk.model import Health, MapPoint, Stall

_LOG = logging.getLogger(__name__)
_DRAWN_M = 90.0  # stalls farther from the drone are not in any picture


class LooksAtFrames(Protocol):
    """The Vision App as the manager uses it."""

    def init(self, drone_camera: Any, topic_interface: Any) -> None:
        """Take camera and topics."""
        ...

    def process(self) -> None:
        """Work on the frame. Raises NoImage, AlgoError."""
        ...

    def publish(self) -> None:
        """Publish what was seen."""
        ...

    def get_park_lot_detected(self) -> bool:
        """Whether a lot is in sight."""
        ...

    def get_health(self) -> Health:
        """Whether it can be trusted."""
        ...

    @property
    def seen(self) -> Seen | None:
        """The last frame's results."""
        ...

    @property
    def image(self) -> NDArray[np.uint8] | None:
        """The last frame's picture."""
        ...


class AlgorithmManagerApp:
    """Vision, mapper and path plan in the order of the specification; a failure of one never stops the others."""

    def __init__(self, timer: Callable[[], float] = time.perf_counter, style: PictureStyle | None = None) -> None:
        """``timer`` (seconds) measures the steps; no result depends on it. ``style``: how pictures are sent."""
        self._timer = timer
        self._style = style or PictureStyle()
        self._timings: list[tuple[str, float]] = []

    def init(
        self,
        algo_topic_interface: AlgorithmTopicInterface,
        vision_app: LooksAtFrames,
        mapper_app: MapperApp,
        path_plan_app: PathPlanApp,
        drone_camera: FrameCamera,
    ) -> None:
        """Take the parts and initialise them."""
        self._topic_interface = algo_topic_interface
        self._vision_app = vision_app
        self._mapper_app = mapper_app
        self._path_plan_app = path_plan_app
        algo_topic_interface.init()
        vision_app.init(drone_camera, algo_topic_interface)
        mapper_app.init(vision_app, algo_topic_interface)
        path_plan_app.init(mapper_app, algo_topic_interface)

    @property
    def mapper_app(self) -> MapperApp:
        """The mapper, for journal and restart. To be used on the worker thread only."""
        return self._mapper_app

    def process(self) -> None:
        """Run all three on the frame that the topic interface serves, then publish.

        Raises AlgoError naming each that failed; the others ran and their results are published.
        """
        interface = self._topic_interface
        self._timings = []
        failures = [
            *self._step("vision", self._vision_app.process),
            *self._step("mapper", self._mapper_app.process, self._mapper_app.fail),
            *self._step("path plan", self._path_plan_app.process, self._path_plan_app.fail),
        ]
        for app in (self._vision_app, self._mapper_app, self._path_plan_app):
            app.publish()
        for name, reason in failures:
            if name == "vision":
                interface.vision_app_health_pub.publish(Health.bad(reason))
                interface.park_lot_detected_pub.publish(False)
        if failures:
            raise AlgoError("; ".join(f"{name}: {reason}" for name, reason in failures))

    def run(self, frame: FrameInput) -> FrameOutput:
        """Return everything that the algorithms make of a frame. Never raises for what is in the frame."""
        interface = self._topic_interface
        interface.begin(self._mapper_app.levelled(frame))
        started = self._timer()
        try:
            self.process()
        except AlgoError as error:
            _LOG.info("frame %d: %s", frame.sequence, error)
        annotated: list[bytes] = []
        self._step("annotate", lambda: annotated.append(self._annotated(frame)))
        self._timings.append(("all", (self._timer() - started) * 1e3))
        return FrameOutput(
            sequence=frame.sequence,
            captured=frame.captured,
            park_lot_detected=interface.park_lot_detected_pub.value,
            annotated_jpeg=annotated[0] if annotated else b"",
            occupancy_map=interface.occupancy_map_pub.value,
            path_plan=interface.local_pos_pub.value,
            footprint=_footprint(frame),
            vision_health=interface.vision_app_health_pub.value,
            mapper_health=interface.mapper_app_health_pub.value,
            path_plan_health=interface.path_plan_app_health_pub.value,
            timings=tuple(self._timings),
        )

    def _step(
        self, name: str, work: Callable[[], None], fail: Callable[[str], None] | None = None
    ) -> list[tuple[str, str]]:
        """Do one step and time it; return its name and the reason when it failed."""
        started = self._timer()
        try:
            work()
        except (AlgoError, NoImage) as error:
            return [(name, str(error))]
        except Exception as error:
            _LOG.exception("%s failed", name)
            reason = f"unexpected {type(error).__name__}: {error}"
            if fail is not None:
                fail(reason)
            return [(name, reason)]
        finally:
            self._timings.append((name, (self._timer() - started) * 1e3))
        return []

    def _annotated(self, frame: FrameInput) -> bytes:
        image = self._vision_app.image
        if image is None:
            return b""
        seen = self._vision_app.seen
        pose = frame.pose if seen is not None and seen.captured == frame.captured else None
        stalls: Sequence[Stall] = ()
        if pose is not None:
            stalls = self._mapper_app.stalls_near(pose.north, pose.east, _DRAWN_M)
            pose = self._mapper_app.corrected(pose)
        return annotate(image, frame.camera, pose, stalls, style=self._style)


def _footprint(frame: FrameInput) -> tuple[MapPoint, ...]:
    return () if frame.pose is None else ground_footprint(frame.camera, frame.pose)
