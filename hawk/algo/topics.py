"""The topics that the algorithms publish on the loop: everybody else sees their results here only."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from hawk.algo.frame import FrameOutput
from hawk.comm.topic import Topic
from hawk.model import Health, MapPoint, OccupancyMap, PathPlan, Verdict


@dataclass(frozen=True, slots=True)
class AnnotatedFrame:
    """An annotated picture as it is sent to the operators; ``captured`` is seconds of the daemon's clock."""

    sequence: int
    captured: float
    jpeg: bytes = field(repr=False)


@dataclass(frozen=True, slots=True)
class AlgorithmTopics:
    """Latest results of vision, mapper and path plan."""

    frame_output: Topic[FrameOutput]
    park_lot_detected: Topic[bool]
    des_loc_inbound: Topic[Verdict]
    occupancy_map: Topic[OccupancyMap]
    local_pos: Topic[PathPlan]
    annotated: Topic[AnnotatedFrame]
    footprint: Topic[tuple[MapPoint, ...]]
    vision_app_health: Topic[Health]
    mapper_app_health: Topic[Health]
    path_plan_app_health: Topic[Health]

    @classmethod
    def create(cls, clock: Callable[[], float]) -> AlgorithmTopics:
        """Make a set of empty topics."""
        return cls(
            frame_output=Topic("frame_output", clock),
            park_lot_detected=Topic("park_lot_detected", clock),
            des_loc_inbound=Topic("des_loc_inbound", clock),
            occupancy_map=Topic("occupancy_map", clock),
            local_pos=Topic("local_pos", clock),
            annotated=Topic("annotated", clock),
            footprint=Topic("footprint", clock),
            vision_app_health=Topic("vision_app_health", clock),
            mapper_app_health=Topic("mapper_app_health", clock),
            path_plan_app_health=Topic("path_plan_app_health", clock),
        )

    def publish(self, output: FrameOutput) -> None:
        """Publish the parts of one frame's results, healths first, the whole last."""
        self.vision_app_health.publish(output.vision_health)
        self.mapper_app_health.publish(output.mapper_health)
        self.path_plan_app_health.publish(output.path_plan_health)
        self.park_lot_detected.publish(output.park_lot_detected)
        self.occupancy_map.publish(output.occupancy_map)
        self.local_pos.publish(output.path_plan)
        if output.path_plan.verdict is not None:
            self.des_loc_inbound.publish(output.path_plan.verdict)
        self.footprint.publish(output.footprint)
        if output.annotated_jpeg:
            self.annotated.publish(AnnotatedFrame(output.sequence, output.captured, output.annotated_jpeg))
        self.frame_output.publish(output)
