"""Makes one status, the heartbeat's content, of all that is known: what is not known is None, never NaN."""

from __future__ import annotations

import math
from datetime import UTC
from typing import TYPE_CHECKING, Any

from hawk.comm.messages import HealthItem
from hawk.comm.status import DroneStatus
from hawk.ddc.geofence import Ring
from hawk.ddc.states.communication_lost import CommunicationLost
from hawk.model import GROUND_STATES, HealthStatus, MapPoint, StateName

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager


class StatusBuilder:
    """Numbers the statuses."""

    def __init__(self, context: OperationsManager) -> None:
        self._context = context
        self._sequence = 0

    def build(self) -> DroneStatus:
        """Return the status of this moment."""
        context = self._context
        self._sequence += 1
        utc = context.utc().astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
        return DroneStatus(
            sequence=self._sequence,
            time=context.now,
            utc=utc,
            state=context.state.identity,
            detail=context.state.detail,
            user_error=context.user_error,
            user_error_text=context.user_error_text,
            options=context.judge.options(),
            checks=context.preflight.items() if context.state.identity in GROUND_STATES else (),
            killed=context.kill.is_killed,
            kill_state=context.kill.state,
            return_in=context.state.return_in if isinstance(context.state, CommunicationLost) else None,
            log=context.log.entries,
            trail=context.trail.points,
            trail_id=context.trail.identity,
            flight_time=context.trail.flight_time(context.now),
            way=context.trail.way,
            heights=(context.heights.minimum, context.heights.desired, context.heights.maximum),
            **self._vehicle(),
            **self._pose(),
            **self._place(),
            **self._perception(),
            **self._health(),
        )

    def _vehicle(self) -> dict[str, Any]:
        topics = self._context.topics
        state = topics.vehicle.state.value
        battery = topics.get_battery_info()
        reserve = self._context.guard.reserve
        return {
            "ardupilot_state": None if state is None else state.mode,
            "armed": None if state is None else state.armed,
            "connected": self._context.has_link,
            "landed": "UNDEFINED" if state is None else state.landed.name,
            "link_age": _finite(topics.get_link_age()),
            "battery_percentage": None if battery is None else _finite(battery.percentage),
            "battery_age": _finite(topics.get_battery_age()),
            "voltage": None if battery is None else _finite(battery.voltage),
            "battery_time_left": None if reserve is None else _finite(reserve.time_left),
            "satellites": topics.get_diagnostics().satellites,
        }

    def _pose(self) -> dict[str, Any]:
        pose = self._context.topics.get_pose()
        if pose is None:
            return {}
        north, east, down = pose.velocity
        known: dict[str, Any] = {
            "pose_age": _finite(self._context.topics.get_pose_age()),
            "relative_altitude": _finite(pose.relative_altitude),
            "latitude": _finite(pose.global_.latitude),
            "longitude": _finite(pose.global_.longitude),
            "yaw": _finite(pose.yaw),
            "roll": _finite(pose.roll),
            "pitch": _finite(pose.pitch),
            "speed": _finite(math.hypot(north, east)),
            "climb": _finite(-down),
        }
        if pose.local is not None:
            known |= {"local_position_x": _finite(pose.local.x), "local_position_y": _finite(pose.local.y)}
        if pose.map is not None:
            known |= {"north": _finite(pose.map.north), "east": _finite(pose.map.east)}
        return known

    def _place(self) -> dict[str, Any]:
        context = self._context
        fence, datum = context.fence, context.service.datum
        return {
            "home": context.topics.home_pub.value,
            "datum": None if datum is None else (datum.latitude, datum.longitude),
            "fence": () if fence is None else _ring(fence.polygon),
            "fence_limit": () if fence is None else _ring(fence.autopilot_polygon),
            "fence_setup": context.fences.setup,
            "ceiling": context.ceiling,
            "target": context.target_place,
            "footprint": context.topics.get_footprint(),
        }

    def _perception(self) -> dict[str, Any]:
        topics = self._context.topics
        occupancy, plan = topics.get_occupancy_map(), topics.get_path_plan()
        known: dict[str, Any] = {
            "lot_area": _finite(occupancy.lot_area_m2),
            "park_lot_detected": topics.has_lot_word(),
            "free": occupancy.counts.free,
            "taken": occupancy.counts.taken,
            "unknown": occupancy.counts.unknown,
            "vision_rate": _finite(topics.get_vision_rate()),
            "camera_age": _finite(topics.get_camera_age()),
        }
        if plan is not None:
            exploring = self._context.state.identity is StateName.AUTONOMOUS_EXPLORE
            known |= {
                "route": plan.route if exploring else getattr(self._context.state, "route", ()),
                "explored": _finite(plan.explore.seen),
                "explore_done": plan.explore.done,
                "remaining_m": _finite(plan.explore.remaining_m),
            }
        return known

    def _health(self) -> dict[str, Any]:
        own = self._context.own_health
        parts = self._context.topics.get_part_healths()
        shown = tuple((name, own if name == "loop" and not own.is_healthy else health) for name, health in parts)
        items = tuple(HealthItem(name=name, healthy=h.is_healthy, reason=h.reason) for name, h in shown)
        well = own.is_healthy and all(item.healthy for item in items if item.name != "loop")
        return {"health": items, "health_status": HealthStatus.HEALTHY if well else HealthStatus.UNHEALTHY}


def _ring(corners: Ring) -> tuple[MapPoint, ...]:
    """Return corners to the centimetre: they are told five times a second."""
    return tuple(MapPoint(round(north, 2), round(east, 2)) for north, east in corners)


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
