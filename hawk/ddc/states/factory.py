"""Makes the states, so that none of them must import another."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hawk.ddc.fence_plan import FencePlan
from hawk.ddc.flight_log import Level
from hawk.ddc.motion import Goal
from hawk.ddc.states.arm import Arm
from hawk.ddc.states.base import Cause, MoveOrder, State
from hawk.ddc.states.communication_lost import CommunicationLost
from hawk.ddc.states.configure import Configure
from hawk.ddc.states.explore import AutonomousExplore
from hawk.ddc.states.fencing import ConfigureFence
from hawk.ddc.states.homing import Land, ReturnToLaunch
from hawk.ddc.states.hover import Hover
from hawk.ddc.states.idle import Idle
from hawk.ddc.states.manual import Manual
from hawk.ddc.states.moves import AutonomousMove, CompulsiveMove, Move
from hawk.ddc.states.takeoff import Takeoff
from hawk.ddc.words import direction, metres, seconds
from hawk.model import HeightParameters, StateName

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager


class StateFactory:
    """Makes a state and tells the operator in words why it is entered."""

    def __init__(self, context: OperationsManager) -> None:
        self._context = context

    def idle(self, reason: str = "") -> State:
        """Disarmed, on the ground."""
        return Idle(self._context, reason)

    def configure(self, heights: HeightParameters) -> State:
        """Store these heights."""
        return Configure(self._context, heights)

    def configure_fence(self, plan: FencePlan | None) -> State:
        """Store this fence; None: put the drawn one aside."""
        return ConfigureFence(self._context, plan)

    def arm(self, armed: bool = False, reason: str = "") -> State:
        """Arm; or wait for take-off with a drone that is armed already."""
        return Arm(self._context, armed, reason)

    def takeoff(self) -> State:
        """Climb to the desired height."""
        return Takeoff(self._context)

    def hover(
        self, reason: str = "", goal: Goal | None = None, *, passive: bool = False, level: Level = "info"
    ) -> State:
        """Hold a goal, else the stopping point."""
        self._context.log.add(level, f"{reason} Holding.".strip())
        return Hover(self._context, reason, goal, passive)

    def explore(self) -> State:
        """See the whole lot."""
        self._context.log.add("info", "Lot found. Exploring.")
        return AutonomousExplore(self._context)

    def move(self, order: MoveOrder) -> Move:
        """Go to a place."""
        pose = self._context.topics.get_pose()
        if pose is not None and pose.map is not None:
            where = direction(order.place.north - pose.map.north, order.place.east - pose.map.east)
            self._context.log.add("info", f"Moving {metres(pose.map.point.distance(order.place))} {where}.")
        return AutonomousMove(self._context, order) if order.autonomous else CompulsiveMove(self._context, order)

    def return_to_launch(self, cause: Cause | None = None) -> State:
        """Fly home."""
        self._context.log.add("warning" if cause else "info", _why("Returning home.", cause))
        return ReturnToLaunch(self._context, cause)

    def land(self, cause: Cause | None = None) -> State:
        """Straight down."""
        self._context.log.add("warning" if cause else "info", _why("Landing.", cause))
        return Land(self._context, cause)

    def communication_lost(self, passive: bool = False) -> State:
        """Hold, then return home."""
        hold = seconds(self._context.settings.operator.operator_hold_s)
        self._context.log.add("warning", f"No word from the operator. Holds for {hold}, then returns home.")
        return CommunicationLost(self._context, passive)

    def taken_up(self, name: StateName) -> State:
        """Return the state that stands for what the autopilot does: taking it up sends nothing."""
        words = self._context.log.autopilot_reason()
        own = Cause("", lambda: True, words)
        mode = self._context.topics.get_state().mode or "an unknown mode"
        if name is StateName.RETURN_TO_LAUNCH:
            self._context.log.add("warning", "The autopilot returns home by itself.", words)
            return ReturnToLaunch(self._context, own, taken_up=True)
        if name is StateName.LAND:
            self._context.log.add("warning", "The autopilot lands by itself.", words)
            return Land(self._context, own, taken_up=True)
        if name is StateName.MANUAL:
            self._context.log.add("warning", f"Someone else flies, in {mode}.", words)
            return Manual(self._context)
        if name is StateName.HOVER:
            return self.hover(f"The autopilot went to {mode} by itself.", passive=True, level="warning")
        if name is StateName.COMMUNICATION_LOST:
            return self.communication_lost(passive=True)
        if name is StateName.ARM:
            return self.arm(armed=True)
        return self.idle()


def _why(text: str, cause: Cause | None) -> str:
    return text if cause is None else f"{cause.text} {text}"
