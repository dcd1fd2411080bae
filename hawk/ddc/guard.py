"""Automatic reactions: battery, operator, fence and ceiling, position, perception, in their order of rank."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hawk.ddc.energy import BatteryWatch, Reserve
from hawk.ddc.geofence import BREACH_TOLERANCE_M, outside_by
from hawk.ddc.ranks import Rank
from hawk.ddc.states.base import Cause, State
from hawk.ddc.topic_interface import POSE_TIMEOUT_S
from hawk.model import TASK_STATES, StateName, VehiclePose

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

SEEING_STATES = frozenset({StateName.AUTONOMOUS_EXPLORE, StateName.AUTONOMOUS_MOVE})
"""States that fly by what is seen."""
GUARDED_STATES = TASK_STATES | {StateName.TAKEOFF, StateName.HOVER, StateName.COMMUNICATION_LOST}
"""States in which fence, ceiling and battery reserve act."""
OPERATOR_STATES = TASK_STATES | {StateName.HOVER}
"""States that a lost operator ends (Takeoff looks itself, after its climb)."""
BATTERY_UNKNOWN_S = 30.0
RESERVE_CONFIRM_S = 3.0
"""The reserve must be reached for so long: a dip under load is none."""
FENCE_RETURN_S = 10.0
"""Not inside again after so many seconds: home."""
FAULT_CONFIRM_S = 1.0
"""A perception fault must last so long; one bad picture is none."""
POSITION_CONFIRM_S = 2.0
"""So long the autopilot must distrust its position."""


@dataclass(frozen=True, slots=True)
class Reaction:
    """What to do by itself, and what rank it has."""

    rank: Rank
    make: Callable[[], State]


class Guard:
    """Watches every tick; proposes the reaction of the highest rank that outranks what the state is doing."""

    def __init__(self, context: OperationsManager) -> None:
        self._context = context
        flight = context.settings.flight
        self._battery = BatteryWatch(flight.battery_reserve_percent, flight.speed_m_s)
        self._battery_known = context.now
        self._reserve: Reserve | None = None
        self._reserve_since: float | None = None
        self._breach_since: float | None = None
        self._fault_since: float | None = None
        self._fault = ""
        self._position_good = context.now

    @property
    def is_breached(self) -> bool:
        """Whether the drone is beyond our fence or ceiling."""
        return self._breach_since is not None

    @property
    def reserve(self) -> Reserve | None:
        """Battery against the way home; None on the ground or while something of it is not known."""
        return self._reserve

    def reset(self) -> None:
        """Another flight begins."""
        self._battery.reset()
        self._battery_known = self._context.now
        self._reserve_since = self._breach_since = self._fault_since = None

    def observe(self, airborne: bool) -> None:
        """Look at everything, once a tick."""
        pose = self._context.topics.get_fresh_pose()
        self._observe_battery(airborne, pose)
        self._observe_fence(airborne, pose)
        self._observe_perception()
        if self._context.topics.get_diagnostics().global_position_ok:
            self._position_good = self._context.now

    def reaction(self, state: State) -> Reaction | None:
        """Return the reaction that outranks this state, None when nothing is wrong enough."""
        for reaction in self._candidates(state.identity):
            if reaction.rank > state.rank:
                return reaction
        return None

    def _candidates(self, name: StateName) -> list[Reaction]:
        """Return what would have to be done in a state, highest rank first."""
        found: list[Reaction] = []
        states = self._context.states
        cause = self._cause_to_return() if name in GUARDED_STATES else None
        if cause is not None:
            found.append(Reaction(Rank.RETURN_TO_LAUNCH, lambda: states.return_to_launch(cause)))
        if name in OPERATOR_STATES and not self._context.operator_present:
            found.append(Reaction(Rank.COMMUNICATION_LOST, states.communication_lost))
        if self.is_breached and name in TASK_STATES | {StateName.TAKEOFF}:
            found.append(Reaction(Rank.FENCE, lambda: states.hover("Outside the fence.", level="warning")))
        if name in TASK_STATES and self._position_is_lost():
            found.append(Reaction(Rank.PERCEPTION, lambda: states.hover("The position was lost.", level="warning")))
        if name in SEEING_STATES and self._fault_lasts(FAULT_CONFIRM_S):
            found.append(Reaction(Rank.PERCEPTION, lambda: states.hover(self._fault, level="warning")))
        return found

    def _position_is_lost(self) -> bool:
        distrusted = self._context.now - self._position_good >= POSITION_CONFIRM_S
        return distrusted or self._context.topics.get_pose_age() > POSE_TIMEOUT_S

    def _cause_to_return(self) -> Cause | None:
        now = self._context.now
        if self._reserve_since is not None and now - self._reserve_since >= RESERVE_CONFIRM_S:
            return Cause("The battery is needed for the way home.", self._reserve_is_reached)
        if now - self._battery_known >= BATTERY_UNKNOWN_S:
            return Cause("The battery is not known.", lambda: self._context.topics.get_battery_info() is None)
        if self._breach_since is not None and now - self._breach_since >= FENCE_RETURN_S:
            return Cause("Still outside the fence.", lambda: self.is_breached)
        return None

    def _reserve_is_reached(self) -> bool:
        return self._reserve is not None and self._reserve.is_reached

    def _observe_battery(self, airborne: bool, pose: VehiclePose | None) -> None:
        now = self._context.now
        battery = self._context.topics.get_battery_info()
        percentage = None if battery is None else battery.percentage
        if percentage is not None or not airborne:
            self._battery_known = now
        home = self._context.topics.home_pub.value
        if percentage is None or not airborne or home is None or pose is None or pose.map is None:
            self._reserve = self._reserve if airborne else None
            self._reserve_since = self._reserve_since if airborne else None
            return
        self._battery.update(percentage, now)
        away = pose.map.point.distance(home)
        self._reserve = self._battery.reserve(percentage, away, pose.map.height, self._context.heights.maximum)
        if not self._reserve.is_reached:
            self._reserve_since = None
        elif self._reserve_since is None:
            self._reserve_since = now

    def _observe_fence(self, airborne: bool, pose: VehiclePose | None) -> None:
        fence = self._context.fence
        if not airborne or fence is None:
            self._breach_since = None
            return
        if pose is None or pose.map is None:
            return
        across = outside_by(fence, pose.map.point)
        if max(across, pose.map.height - fence.ceiling) > BREACH_TOLERANCE_M:
            if self._breach_since is None:
                self._breach_since = self._context.now
                self._context.log.add("warning", "Outside the fence: going back inside.")
        elif across <= 0.0 and pose.map.height <= fence.ceiling:
            self._breach_since = None

    def _observe_perception(self) -> None:
        self._fault = self._context.perception_fault()
        if not self._fault:
            self._fault_since = None
        elif self._fault_since is None:
            self._fault_since = self._context.now

    def _fault_lasts(self, seconds: float) -> bool:
        return self._fault_since is not None and self._context.now - self._fault_since >= seconds
