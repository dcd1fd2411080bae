"""The instant that every reading is given, and the shape of a reading.

A reading keeps its own memory and returns its own facts, by a method ``facts``; `hawk.ddc.senses` only collects them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from hawk.comm.topic import Stamped
from hawk.ddc.readings.belief import Belief
from hawk.ddc.readings.topic_interface import POSE_TIMEOUT_S, usable_pose
from hawk.model.operation import Health
from hawk.model.plans import Fence, HeightParameters
from hawk.model.poses import ArmPlace, GlobalPose, VehiclePose
from hawk.model.vehicle import VehicleState

Parts = tuple[tuple[str, Health], ...]
"""Names of parts, each with its health."""


@dataclass(frozen=True, slots=True)
class Instant:
    """One moment as every reading sees it. Times in seconds of the daemon's clock, heights in metres."""

    now: float
    utc: float = 0.0
    """Wall clock, Unix seconds."""
    belief: Belief = field(default_factory=Belief)
    """Armed, landed, height and climb as they are believed."""
    is_linked: bool = False
    """The autopilot was found and is heard."""
    pose: VehiclePose | None = None
    """The latest pose however old it is."""
    pose_age: float = math.inf
    arm: Stamped[ArmPlace] | None = None
    """The arm place, and when it was published."""
    datum: GlobalPose | None = None
    """Origin of the map frame."""
    fence: Fence | None = None
    """The fence in force."""
    held_fence: Fence | None = None
    """The fence that the autopilot holds; None while that is not known."""
    heights: HeightParameters = HeightParameters()
    parameters: Mapping[str, float] = field(default_factory=dict)
    """Latest values that the autopilot sent, by name."""
    healths: Mapping[str, Health] = field(default_factory=dict)
    """Health of each part as its topic reports it, by name, in the order of dependence."""

    @property
    def vehicle(self) -> VehicleState:
        """The autopilot's state as it is believed."""
        return self.belief.vehicle

    @property
    def is_airborne(self) -> bool:
        """True when the drone is believed armed and not believed on the ground."""
        return self.belief.is_airborne

    @property
    def is_armed_and_heard(self) -> bool:
        """True when the drone is believed armed by an autopilot that is heard."""
        return self.vehicle.armed and self.is_linked

    @property
    def fresh_pose(self) -> VehiclePose | None:
        """The pose if it is young and whole enough to send a target on."""
        return usable_pose(self.pose, self.pose_age)

    @property
    def place(self) -> GlobalPose | None:
        """The drone's place of the last second, WGS-84."""
        return None if self.pose is None or self.pose_age > POSE_TIMEOUT_S else self.pose.global_

    @property
    def arm_place(self) -> ArmPlace | None:
        """The latest arm place."""
        return None if self.arm is None else self.arm.value


class Reading:
    """Base of the readings. `update` alone changes the memory: a look between two ticks calls ``facts`` and `parts`."""

    _stops: tuple[Callable[[], None], ...] = ()
    """Each ends the listening to one topic."""

    def update(self, instant: Instant) -> None:
        """Take the instant of a tick."""

    def parts(self, instant: Instant) -> Parts:
        """Return the parts whose health it knows; none for most readings."""
        return ()

    def close(self) -> None:
        """Stop listening."""
        for stop in self._stops:
            stop()
