"""Algorithm Topic Interface (specification section 9), and the topics that carry its publications on the loop.

The apps run on the worker thread: the interface serves them one frozen `FrameInput` and keeps what they publish. Topics
live on the loop, which publishes a frame's results when it is done.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from hawk.algo.frame import AlgoError, FrameInput, FrameOutput
from hawk.comm.topic import Topic
from hawk.formats.image import NoImage
from hawk.model.lot_map import OccupancyMap
from hawk.model.operation import Health
from hawk.model.pictures import AnnotatedFrame, GroundStep, StallSize
from hawk.model.plans import PathPlan, Verdict
from hawk.model.poses import MapPoint
from hawk.model.sentences import say

T = TypeVar("T")


class Publisher(Generic[T]):
    """Keeps the last published ``value``."""

    def __init__(self, initial: T) -> None:
        self.value = initial

    def publish(self, value: T) -> None:
        """Replace the value."""
        self.value = value


class AlgorithmTopicInterface:
    """Serves one frame's inputs to the apps and keeps what they publish."""

    def __init__(self) -> None:
        waiting = Health.bad(say("no frame yet"))
        self._frame: FrameInput | None = None
        self.park_lot_detected_pub: Publisher[bool] = Publisher(False)
        self.des_loc_inbound_pub: Publisher[Verdict | None] = Publisher(None)
        self.occupancy_map_pub: Publisher[OccupancyMap] = Publisher(OccupancyMap())
        self.local_pos_pub: Publisher[PathPlan] = Publisher(PathPlan())
        self.vision_app_health_pub: Publisher[Health] = Publisher(waiting)
        self.mapper_app_health_pub: Publisher[Health] = Publisher(waiting)
        self.path_plan_app_health_pub: Publisher[Health] = Publisher(waiting)

    def init(self) -> None:
        """Forget the frame; the publishers keep their last values."""
        self._frame = None

    def begin(self, frame: FrameInput) -> None:
        """Serve this frame from now on."""
        self._frame = frame

    @property
    def frame(self) -> FrameInput:
        """The present frame. Raises AlgoError when there is none."""
        if self._frame is None:
            raise AlgoError(say("no frame was given yet"))
        return self._frame


class FrameCamera:
    """The Drone Camera for the Vision App: the picture of the present frame."""

    def __init__(self, topic_interface: AlgorithmTopicInterface) -> None:
        self._topic_interface = topic_interface

    def get_image(self) -> bytes:
        """Return the frame's JPEG. Raises NoImage when it is empty."""
        jpeg = self._topic_interface.frame.jpeg
        if not jpeg:
            raise NoImage(say("the camera gave an empty picture"))
        return jpeg


@dataclass(frozen=True, slots=True)
class AlgorithmTopics:
    """Latest results of vision, mapper and path plan, for the rest of the daemon."""

    frame_output: Topic[FrameOutput]
    park_lot_detected: Topic[bool]
    des_loc_inbound: Topic[Verdict]
    occupancy_map: Topic[OccupancyMap]
    local_pos: Topic[PathPlan]
    annotated: Topic[AnnotatedFrame]
    footprint: Topic[tuple[MapPoint, ...]]
    camera_check: Topic[Health]
    ground_step: Topic[GroundStep]
    stall_size: Topic[StallSize]
    vision_app_health: Topic[Health]
    mapper_app_health: Topic[Health]
    path_plan_app_health: Topic[Health]

    @classmethod
    def create(cls, clock: Callable[[], float]) -> AlgorithmTopics:
        """Make a set of empty topics."""
        return cls(**{name: Topic(name, clock) for name in cls.__slots__})

    def publish(self, output: FrameOutput) -> None:
        """Publish the parts of one frame's results, healths first, the whole last."""
        self.camera_check.publish(output.camera_health)
        self.vision_app_health.publish(output.vision_health)
        self.mapper_app_health.publish(output.mapper_health)
        self.path_plan_app_health.publish(output.path_plan_health)
        self.park_lot_detected.publish(output.park_lot_detected)
        self.occupancy_map.publish(output.occupancy_map)
        self.local_pos.publish(output.path_plan)
        if output.path_plan.verdict is not None:
            self.des_loc_inbound.publish(output.path_plan.verdict)
        self.footprint.publish(output.footprint)
        if output.ground_step is not None:
            self.ground_step.publish(output.ground_step)
        if output.stall_size is not None:
            self.stall_size.publish(output.stall_size)
        if output.annotated_jpeg:
            self.annotated.publish(AnnotatedFrame(output.sequence, output.captured, output.annotated_jpeg))
        self.frame_output.publish(output)
