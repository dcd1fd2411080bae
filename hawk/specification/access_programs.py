"""Access programs of the topic interfaces and the Path Plan App (specification, sections 9, 12 and 15).

The product reads the same values by the names that its parts have for them.
"""

from __future__ import annotations

from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.topic_interface import AlgorithmTopicInterface
from hawk.ddc.readings.topic_interface import DdcTopicInterface
from hawk.model.operation import Health, StateName
from hawk.model.plans import DesiredPose, Inbound
from hawk.model.poses import LocalPose, MapPose


class AlgorithmAccess:
    """Of Algorithm Topic Interface: the inputs of the present frame. Each raises AlgoError when there is none."""

    def __init__(self, topics: AlgorithmTopicInterface) -> None:
        self._topics = topics

    def get_drone_state(self) -> StateName:
        """Return the operation state at the time of the frame."""
        return self._topics.frame.state

    def get_desired_pose(self) -> DesiredPose | None:
        """Return the operator's desired pose (map frame, metres), None without one."""
        return self._topics.frame.desired

    def get_local_pose(self) -> MapPose | None:
        """Return the drone's pose at the frame's time of exposure (map frame), None before the first arm."""
        return self._topics.frame.pose


class PathPlanAccess:
    """Of Path Plan App."""

    def __init__(self, app: PathPlanApp) -> None:
        self._app = app

    def get_des_pose_inbound(self) -> bool:
        """Return True when the desired pose lies inside the lot; False outside, unknown, and without one."""
        verdict = self._app.get_local_pose().verdict
        return verdict is not None and verdict.inbound is Inbound.INSIDE


class DdcAccess:
    """Of DDC Topic Interface."""

    def __init__(self, topics: DdcTopicInterface) -> None:
        self._topics = topics

    def get_local_pose(self) -> LocalPose | None:
        """Return the pose about the arm place, None before the first arm."""
        pose = self._topics.get_pose()
        return None if pose is None else pose.local

    def get_rel_alt(self) -> float | None:
        """Return metres above the arm place, None before the first arm."""
        pose = self._topics.get_pose()
        return None if pose is None else pose.relative_altitude

    def get_park_lot_detected(self) -> bool:
        """Return True when a parking lot is in sight; False when vision is silent."""
        return bool(self._topics.has_lot_word())

    def get_des_loc_inbound(self) -> bool:
        """Return True when the desired pose lies inside the lot by a verdict of its number, no older than 1 s."""
        desired, verdict = self._topics.des_pose_pub.value, self._topics.get_fresh_verdict()
        if desired is None or verdict is None:
            return False
        return verdict.number == desired.number and verdict.inbound is Inbound.INSIDE

    def get_health_status(self) -> Health:
        """Return the overall health: the first part that is not well, with its reason."""
        for name, health in self._topics.get_part_healths():
            if not health.is_healthy:
                return Health.bad(f"{name}: {health.reason}")
        return Health()
