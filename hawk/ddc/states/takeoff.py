"""Takeoff: climbs to the desired height."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hawk.ddc.mapping import is_on_ground
from hawk.ddc.motion import Goal
from hawk.ddc.requests import Request
from hawk.ddc.states.airborne import AirborneState
from hawk.ddc.states.base import State
from hawk.ddc.words import metres
from hawk.model import StateName, VehiclePose

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

REACHED_SHARE = 0.95
"""The climb is done at this share of the desired height."""
GROUND_S = 8.0
"""Still on the ground after so many seconds: it did not take off."""
NO_CLIMB_S = 5.0
CLIMB_STEP_M = 0.5
"""Less than this gained in NO_CLIMB_S is no climb."""


class Takeoff(AirborneState):
    """The autopilot's take-off, watched."""

    identity = StateName.TAKEOFF

    def __init__(self, context: OperationsManager) -> None:
        super().__init__(context)
        self._request: Request | None = None
        self._airborne = False
        self._best = -math.inf
        self._best_at = context.now

    @property
    def detail(self) -> str:
        """How high it shall go."""
        return f"Climbing to {metres(self.context.heights.desired)}."

    def enter(self) -> None:
        """Ask for the take-off."""
        super().enter()
        self._best_at = self.context.now
        height = self.context.heights.desired
        self._request = self.context.ask("take off", self.context.service.send_takeoff_cmd(height))

    def process(self) -> None:
        """Note when the drone leaves the ground, and how far it climbs."""
        if not self._airborne and not is_on_ground(self.context.topics.get_state().landed):
            self._airborne = True
            self._best_at = self.context.now
            self.context.log.add("info", "Took off.")
        height = self.context.topics.get_rel_alt()
        if height is not None and height >= self._best + CLIMB_STEP_M:
            self._best, self._best_at = height, self.context.now

    def _decide(self) -> State:
        height = self.context.topics.get_rel_alt()
        wanted = self.context.heights.desired
        pose = self.context.topics.get_fresh_pose()
        if self._airborne and height is not None and height >= REACHED_SHARE * wanted:
            if not self.context.operator_present:
                return self.context.states.communication_lost()
            return self.context.states.hover(f"At {metres(wanted)}.", _above(pose, wanted))
        if not self._airborne:
            return self._decide_on_ground()
        if self.context.now - self._best_at > NO_CLIMB_S:
            return self.context.states.hover("The climb stopped.", level="warning")
        return self

    def _decide_on_ground(self) -> State:
        if self._request is not None and self._request.has_failed:
            return self._refuse("Take-off was refused.", self._request.reason)
        if self.age > GROUND_S:
            return self._refuse("It did not take off.", self.context.log.autopilot_reason())
        return self

    def _refuse(self, text: str, details: str) -> State:
        self.context.log.add("error", text, details)
        if self.context.topics.get_state().armed:
            return self.context.states.arm(armed=True, reason=text)
        return self.context.states.idle(text)


def _above(pose: VehiclePose | None, height: float) -> Goal | None:
    if pose is None or pose.map is None:
        return None
    return Goal(pose.map.north, pose.map.east, height, pose.map.yaw)
