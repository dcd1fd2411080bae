"""Algorithm Manager App (specification section 13): one frame goes through vision, mapper and planner to the page.

It runs on the worker thread and knows one frame at a time; `hawk.algo.loop` is the part on the loop.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final, TypeVar

from hawk.algo.frame import AlgoError, FrameInput, FrameOutput
from hawk.algo.mapper.app import Fused, MapperApp
from hawk.algo.path_plan.app import PathPlanApp, Plan
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.algo.vision.camera_check import CameraCheck
from hawk.algo.vision.detection import FrameVision, VisionResult, stall_size
from hawk.algo.vision.odometry import Odometry
from hawk.algo.vision.picture import PictureStyle, annotate
from hawk.algo.vision.private_ground import hidden, recorded_jpeg
from hawk.algo.vision.rectify import ground_footprint
from hawk.formats.image import NoImage
from hawk.model.operation import Health
from hawk.model.pictures import GroundStep
from hawk.model.sentences import say, words_of

T = TypeVar("T")
_LOG = logging.getLogger(__name__)
_DRAWN_M = 90.0  # stalls farther from the drone are not in any picture
TURNED: Final = math.radians(15.0)
"""A picture that turned by more beyond its heading is not mapped: one that is 0.1 s late turns by 6° at 1 rad/s."""
TURNED_S: Final = 2.0
"""Nor is one within this time after it, seconds: the witness of the heading decides meanwhile."""


@dataclass(frozen=True, slots=True)
class Perception:
    """A frame's picture as it was seen, what it shows of the camera and the drone's motion, and what failed."""

    seen: VisionResult = field(repr=False)
    camera: Health
    step: GroundStep | None
    failures: tuple[str, ...]


class AlgorithmManagerApp:
    """Vision, mapper and path plan in the order of the specification; a failure of one never stops the others."""

    def __init__(
        self,
        timer: Callable[[], float] = time.perf_counter,
        style: PictureStyle | None = None,
        camera_check: CameraCheck | None = None,
        odometry: Odometry | None = None,
    ) -> None:
        """``timer`` (seconds) measures the steps; no result depends on it. ``style``: how pictures are sent."""
        self._timer = timer
        self._style = style or PictureStyle()
        self._camera_check = camera_check or CameraCheck()
        self._odometry = odometry or Odometry()
        self._turned_at = -math.inf

    def init(
        self,
        algo_topic_interface: AlgorithmTopicInterface,
        vision_app: FrameVision,
        mapper_app: MapperApp,
        path_plan_app: PathPlanApp,
        drone_camera: FrameCamera,
    ) -> None:
        """Take the parts and initialise them."""
        self._topic_interface = algo_topic_interface
        self._vision_app = vision_app
        self.mapper_app = mapper_app
        """The mapper, for journal and restart. To be used on the worker thread only."""
        self._path_plan_app = path_plan_app
        algo_topic_interface.init()
        vision_app.init(drone_camera, algo_topic_interface)
        mapper_app.init(vision_app, algo_topic_interface)
        path_plan_app.init(mapper_app, algo_topic_interface)

    def begin_survey(self, map_id: str) -> None:
        """Begin an empty map under another id. To be used on the worker thread only."""
        self.mapper_app.begin(map_id)
        self._path_plan_app.begin()

    def process(self) -> None:
        """Run all three on the topic interface's frame, then publish (specification: process).

        Raises:
            AlgoError: Names each app that failed; the others ran and their results are published.
        """
        frame = self._topic_interface.frame
        looked = self.look(frame)
        self._vision_app.publish()
        self.go_on(frame, looked)

    def look(self, frame: FrameInput) -> Perception:
        """Do the first half of `process`, which needs the picture alone. Never raises for what is in the frame.

        A thread may look at the next frames, in their order, while another one goes on with those before.
        """
        steps = _Steps(self._timer)
        seen, camera, step = self._look(frame, steps)
        return Perception(seen, camera, step, tuple(steps.failures))

    def go_on(self, frame: FrameInput, looked: Perception) -> None:
        """Do the second half of `process`: map and plan, then publish.

        Raises:
            AlgoError: As `process` does, also for what failed in the first half.
        """
        steps = _Steps(self._timer)
        self._go_on(frame, looked.seen, steps)
        for app in (self.mapper_app, self._path_plan_app):
            app.publish()
        if failures := (*looked.failures, *steps.failures):
            raise AlgoError("; ".join(failures))

    def run(self, frame: FrameInput) -> FrameOutput:
        """Return all results of a frame. Never raises for what is in the frame."""
        steps = _Steps(self._timer)
        started = self._timer()
        seen, camera, step = self._look(frame, steps)
        recorded = recorded_jpeg(frame, self._vision_app.seen, seen)
        fused, plan = self._go_on(frame, seen, steps)
        size = steps.do("stall size", lambda: stall_size(frame, seen), _nothing)
        if steps.failures:
            _LOG.info("frame %d: %s", frame.sequence, "; ".join(steps.failures))
        annotated = steps.do("annotate", lambda: self._annotated(frame, seen, fused), lambda _: b"")
        return FrameOutput(
            sequence=frame.sequence,
            captured=frame.captured,
            park_lot_detected=seen.park_lot_detected,
            annotated_jpeg=annotated,
            occupancy_map=fused.occupancy_map,
            path_plan=plan.path,
            footprint=() if frame.over_ground is None else ground_footprint(frame.camera, frame.over_ground),
            vision_health=seen.health,
            mapper_health=fused.health,
            path_plan_health=plan.health,
            timings=(*steps.timings, ("all", (self._timer() - started) * 1e3)),
            camera_health=camera,
            is_damaged=seen.is_damaged,
            ground_step=step if camera.is_healthy else None,
            stall_size=size,
            recorded_jpeg=recorded,
        )

    def _look(self, frame: FrameInput, steps: _Steps) -> tuple[VisionResult, Health, GroundStep | None]:
        vision = self._vision_app
        seen = steps.do("vision", lambda: vision.see(frame), vision.fail)
        camera = steps.do("camera", lambda: self._camera_check.look(frame, seen.image), Health.bad)
        step = steps.do("odometry", lambda: self._odometry.look(frame, seen.image), _nothing)
        if self._has_turned(frame, step) or not camera.is_healthy:
            seen = replace(seen, ground=None)  # the ground is not where the picture shows it
        return hidden(seen, frame), camera, step

    def _go_on(self, frame: FrameInput, seen: VisionResult, steps: _Steps) -> tuple[Fused, Plan]:
        mapper, planner = self.mapper_app, self._path_plan_app
        fused = steps.do("mapper", lambda: mapper.fuse(frame, seen), mapper.fail)
        return fused, steps.do("path plan", lambda: planner.plan(frame, mapper), planner.fail)

    def _has_turned(self, frame: FrameInput, step: GroundStep | None) -> bool:
        """Return True while the picture lies on the ground otherwise than the reported heading says."""
        if step is not None and abs(step.turn) > TURNED:
            self._turned_at = step.until
        return 0.0 <= frame.captured - self._turned_at < TURNED_S

    def _annotated(self, frame: FrameInput, seen: VisionResult, fused: Fused) -> bytes:
        if seen.image is None:
            return b""
        if seen.ground is None:
            return annotate(seen.image, frame.camera, None, style=self._style)
        pose = seen.ground.pose
        stalls = self.mapper_app.stalls_near(pose.north, pose.east, _DRAWN_M)
        return annotate(seen.image, frame.camera, fused.shift.applied(pose), stalls, style=self._style)


def _nothing(_reason: str) -> None:
    return None


class _Steps:
    """Runs the steps of one frame; keeps the milliseconds of each, and the reasons of those that failed."""

    def __init__(self, timer: Callable[[], float]) -> None:
        self._timer = timer
        self.timings: list[tuple[str, float]] = []
        self.failures: list[str] = []

    def do(self, name: str, work: Callable[[], T], fail: Callable[[str], T]) -> T:
        """Return the step's result, that of ``fail`` (given the reason) when it raises."""
        started = self._timer()
        try:
            return work()
        except (AlgoError, NoImage) as error:
            reason = words_of(error)
        except Exception as error:
            _LOG.exception("%s failed", name)
            reason = say("unexpected {name}: {error}", name=type(error).__name__, error=str(error))
        finally:
            self.timings.append((name, (self._timer() - started) * 1e3))
        self.failures.append(f"{name}: {reason}")
        return fail(reason)
