"""What one tick knew, for the recording."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager


def tick_inputs(context: OperationsManager) -> dict[str, Any]:
    """Return every value that this tick's decisions rest on, as plain JSON types (metres, radians, seconds)."""
    topics = context.topics
    vehicle = topics.get_state()
    pose = topics.get_pose()
    battery = topics.vehicle.battery.value
    plan = topics.get_path_plan()
    desired = topics.des_pose_pub.value
    verdict = None if desired is None else topics.get_verdict(desired.number)
    return {
        "time": context.now,
        "state": context.state.get_identity(),
        "connected": vehicle.connected,
        "armed": vehicle.armed,
        "mode": vehicle.custom_mode,
        "landed": int(vehicle.landed),
        "heartbeat": _finite(vehicle.time),
        "pose_time": None if pose is None else pose.time,
        "map": None
        if pose is None or pose.map is None
        else [pose.map.north, pose.map.east, pose.map.height, pose.map.roll, pose.map.pitch, pose.map.yaw],
        "velocity": None if pose is None else list(pose.velocity),
        "battery": None if battery is None else battery.percentage,
        "operator": context.operator_present,
        "lot": topics.has_lot_word(),
        "target": None if plan is None or plan.target is None else [plan.target.north, plan.target.east],
        "done": None if plan is None else plan.explore.done,
        "verdict": None if verdict is None else verdict.inbound.value,
        "health": {name: health.reason for name, health in topics.get_part_healths() if not health.is_healthy},
    }


def _finite(value: float) -> float | None:
    return value if value not in (float("inf"), float("-inf")) else None
