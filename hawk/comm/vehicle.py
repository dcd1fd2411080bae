"""The boundary to the autopilot: what the rest of the daemon may ask of it, whoever answers.

`hawk.comm.autopilot.MavsdkAutopilot` is the real one; unit tests put a fake here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from hawk.comm.topic import Topic
from hawk.model import (
    ArmPlace,
    BatteryInfo,
    CopterMode,
    Diagnostics,
    Fence,
    GlobalPose,
    State,
    StatusText,
    VehiclePose,
)


class AutopilotError(Exception):
    """The autopilot refused or did not answer; the text is its own words where it gave any."""


@dataclass(frozen=True, slots=True)
class VehicleTopics:
    """What the autopilot publishes. Every one is drained to the latest value."""

    state: Topic[State]
    pose: Topic[VehiclePose]
    battery: Topic[BatteryInfo]
    diagnostics: Topic[Diagnostics]
    status_text: Topic[StatusText]
    arm_place: Topic[ArmPlace]
    """Published when "armed" is first seen, and again when EKF-local jumped and was anchored anew."""
    frame_jump: Topic[float]
    """Metres by which EKF-local jumped against the world (EKF reset); the pose is anchored again already."""

    @classmethod
    def create(cls, clock: Callable[[], float]) -> VehicleTopics:
        """Make a set of empty topics."""
        return cls(
            state=Topic("state", clock),
            pose=Topic("pose", clock),
            battery=Topic("battery", clock),
            diagnostics=Topic("diagnostics", clock),
            status_text=Topic("status_text", clock),
            arm_place=Topic("arm_place", clock),
            frame_jump=Topic("frame_jump", clock),
        )


class Autopilot(Protocol):
    """Commands to the autopilot. All raise AutopilotError; none is repeated unless it says so."""

    topics: VehicleTopics

    async def arm(self) -> None:
        """Arm. Returns on the acknowledgement; "armed" shows up in `VehicleTopics.state` up to 0.9 s later."""
        ...

    async def disarm(self) -> None:
        """Disarm (refused by the autopilot in the air)."""
        ...

    async def set_mode(self, mode: CopterMode) -> None:
        """Ask for a flight mode by DO_SET_MODE."""
        ...

    async def takeoff(self, relative_altitude: float) -> None:
        """Climb to metres above the arm place."""
        ...

    async def set_rtl_altitude(self, metres: float) -> float:
        """Set the return altitude and return what the autopilot says when asked back, metres."""
        ...

    async def get_parameter(self, name: str) -> float | int:
        """Read one parameter. An unknown name is an AutopilotError."""
        ...

    async def set_parameter(self, name: str, value: float) -> None:
        """Set one parameter with the type that the autopilot gave it, and read it back."""
        ...

    async def upload_fence(self, fence: Fence) -> None:
        """Upload `Fence.autopilot_polygon` and set ceiling, type, action and FENCE_ENABLE."""
        ...

    async def kill(self) -> None:
        """Cut the motors at once (MAV_CMD_DO_FLIGHTTERMINATION), through an executor that nothing else uses."""
        ...

    def send_target(self, north: float, east: float, height: float, yaw: float) -> None:
        """Send one SET_POSITION_TARGET_LOCAL_NED (map frame, height above the arm place). Never blocks.

        Raises AutopilotError when a number is not finite, when there is no arm place, or when the link is down.
        """
        ...

    def pose_at(self, time: float) -> VehiclePose | None:
        """Return the pose interpolated to that moment, None when the buffer does not reach it (more than 0.3 s off)."""
        ...

    def set_datum(self, datum: GlobalPose | None) -> None:
        """Lay the map frame's origin; None: the next arm place becomes it."""
        ...

    @property
    def datum(self) -> GlobalPose | None:
        """Origin of the map frame."""
        ...

    def restore_arm_place(self, place: ArmPlace) -> None:
        """Take up the arm place of an earlier run of the daemon (ignored when the autopilot has booted since)."""
        ...

    @property
    def parameters(self) -> Mapping[str, float | int]:
        """Parameters read so far."""
        ...
