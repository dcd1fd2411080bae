"""Algorithm Topic Interface (specification section 9): what vision, mapper and path plan may read and say.

The secret is that nothing here touches a topic: the apps run on the worker thread, read one frozen `FrameInput`, and
their publications are collected until the frame is done. The loop publishes them afterwards.
"""

from __future__ import annotations

from typing import Generic, TypeVar

from hawk.algo.errors import AlgoError, NoImage
from hawk.algo.frame import FrameInput
from hawk.model import DesiredPose, Health, MapPose, OccupancyMap, PathPlan, StateName, Verdict

T = TypeVar("T")


class Publisher(Generic[T]):
    """Collects the last value that an app published."""

    def __init__(self, initial: T) -> None:
        self._value = initial

    def publish(self, value: T) -> None:
        """Replace the value."""
        self._value = value

    @property
    def value(self) -> T:
        """What was published last, the initial value before that."""
        return self._value


class AlgorithmTopicInterface:
    """Serves one frame's inputs to the apps and collects what they publish."""

    def __init__(self) -> None:
        waiting = Health.bad("no frame yet")
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
        """Serve this frame from here on."""
        self._frame = frame

    @property
    def frame(self) -> FrameInput:
        """The frame being worked on. Raises AlgoError when there is none."""
        if self._frame is None:
            raise AlgoError("no frame was given yet")
        return self._frame

    def get_drone_state(self) -> StateName:
        """Return the operation state at the time of the frame."""
        return self.frame.state

    def get_desired_pose(self) -> DesiredPose | None:
        """Return where the operator wants the drone (map frame, metres), None when nowhere."""
        return self.frame.desired

    def get_local_pose(self) -> MapPose | None:
        """Return the drone's pose when the frame's light was caught (map frame), None before the first arm."""
        return self.frame.pose


class FrameCamera:
    """The Drone Camera as the Vision App sees it: the picture of the frame being worked on."""

    def __init__(self, topic_interface: AlgorithmTopicInterface) -> None:
        self._topic_interface = topic_interface

    def get_image(self) -> bytes:
        """Return the frame's JPEG. Raises NoImage when it is empty."""
        jpeg = self._topic_interface.frame.jpeg
        if not jpeg:
            raise NoImage("the camera gave an empty picture")
        return jpeg
