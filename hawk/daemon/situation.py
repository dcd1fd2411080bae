"""The situation of the drone at a frame, for vision, mapper and planner."""

from __future__ import annotations

from hawk.algo.loop import Situation
from hawk.comm.autopilot.autopilot import MavsdkAutopilot
from hawk.comm.autopilot.terrain import FRESH_S, ground_below
from hawk.comm.cameras.drone_camera import DroneCamera
from hawk.comm.clock import Clock
from hawk.daemon.lots.parts import LotParts
from hawk.ddc.fence.keepers import OutlineKeeper
from hawk.ddc.readings.topic_interface import DdcTopicInterface
from hawk.model.operation import StateName


class SituationReader:
    """Reads the parts when a frame is there."""

    def __init__(
        self,
        clock: Clock,
        autopilot: MavsdkAutopilot,
        camera: DroneCamera,
        topics: DdcTopicInterface,
        outlines: OutlineKeeper,
        lots: LotParts,
    ) -> None:
        self._clock = clock
        self._autopilot = autopilot
        self._camera = camera
        self._topics = topics
        self._outlines = outlines
        self._lots = lots

    def __call__(self) -> Situation:
        """Return the situation now. The camera has given a frame: its model is known."""
        model, topics = self._camera.model, self._topics
        assert model is not None  # noqa: S101 - asked for a frame only
        fence = topics.fence_pub.value
        return Situation(
            camera=model,
            state=topics.curr_state_pub.value or StateName.IDLE,
            desired=topics.des_pose_pub.value,
            heights=topics.get_heights(),
            fence=fence,
            home=topics.home_pub.value,
            asked=topics.asked_place_pub.value,
            asked_ground=self._outlines.ground(self._autopilot.datum, fence),
            map_problem=self._map_problem(),
            ground=ground_below(topics.vehicle.terrain.fresh(FRESH_S)),
            known=self._lots.known.current,
            tours=self._lots.tours.current,
            private=self._lots.known.private,
        )

    def _map_problem(self) -> str:
        doubt = "the position is doubted: nothing is mapped by it" if self._topics.doubt_pub.value else ""
        return self._autopilot.telemetry.map_problem(self._clock()) or doubt
