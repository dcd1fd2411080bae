"""Follows what the autopilot does: found, lost, armed, changed by somebody else, position jumped."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from hawk.ddc.geofence import to_map
from hawk.ddc.mapping import is_on_ground, state_from_autopilot
from hawk.ddc.ranks import Rank
from hawk.ddc.restart import RestartRule, restart_rule
from hawk.ddc.states.base import Cause
from hawk.ddc.states.holding import Holding
from hawk.ddc.states.homing import Homing
from hawk.ddc.vehicle_watch import VehicleEvent, VehicleWatch
from hawk.model import GROUND_STATES, TASK_STATES, ArmPlace, LandedState, State, StateName

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

ABANDONED_S = 15.0
"""So long after an arming that was given up, "armed" is answered by a disarm, seconds."""
DISARM_RETRY_S = 2.0

LEFT_ALONE = frozenset({StateName.MANUAL, StateName.RETURN_TO_LAUNCH, StateName.LAND})
"""States that neither a restart nor the end of the program changes."""


class VehicleFollower:
    """Puts the operation state in line with the autopilot. ``count_start`` journals a start in the air."""

    def __init__(self, context: OperationsManager, watch: VehicleWatch, count_start: Callable[[], int]) -> None:
        self._context = context
        self._watch = watch
        self._count_start = count_start
        self._abandoned: float | None = None
        self._disarm_asked = float("-inf")
        self._frame_jump = 0.0
        self.started_in_air = False
        """Whether this program found the drone in the air."""

    @property
    def is_airborne(self) -> bool:
        """Whether the drone is armed and not known to stand on the ground."""
        vehicle = self._context.topics.get_state()
        return vehicle.armed and not is_on_ground(vehicle.landed)

    def begin_arming(self) -> None:
        """An arming was asked for: "armed" is expected."""
        self._abandoned = None

    def abandon_arming(self) -> None:
        """An arming was given up: an "armed" that comes late is answered by a disarm."""
        self._abandoned = self._context.now

    def follow(self) -> None:
        """Answer what happened since the last tick."""
        for event in self._watch.observe():
            self._context.record("vehicle", {"event": event.name, "mode": self._context.topics.get_state().mode})
            self._answer_event(event)
        self._ensure_fence()
        if self._context.has_link:
            self._follow_arming(self._context.topics.get_state())
        self._follow_frame_jump()

    def _answer_event(self, event: VehicleEvent) -> None:
        if event is VehicleEvent.LINK_LOST:
            self._context.log.add("error", "No word from the autopilot.")
            self._context.service.forget_asked_modes()
            self._context.preflight.forget()
            return
        if event is VehicleEvent.FOUND:
            self._context.log.add("ok", "Autopilot found.")
            self.take_up(at_start=True)
        elif event is VehicleEvent.LINK_BACK:
            self._context.log.add("ok", "The autopilot is heard again.")
            self.take_up(at_start=False, keeps_rank=True)
        elif self._context.topics.get_state().armed:
            self._context.service.forget_asked_modes()
            self.take_up(at_start=False)

    def _mapped(self, at_start: bool) -> StateName:
        vehicle = self._context.topics.get_state()
        return state_from_autopilot(vehicle.armed, vehicle.landed, vehicle.custom_mode, at_start)

    def take_up(self, at_start: bool, keeps_rank: bool = False) -> None:
        """Take the state from the autopilot. ``keeps_rank``: what outranks it, and the same state, goes on."""
        name = self._mapped(at_start)
        current = self._context.state.identity
        if name is StateName.IDLE:
            if current not in GROUND_STATES:
                self._land_in_idle()
            elif at_start:
                self._context.switch(self._context.states.idle())
            return
        if keeps_rank and (name is current or self._outranks_hover(name)):
            if isinstance(holding := getattr(self._context.state, "holding", None), Holding):
                holding.restart()
            elif isinstance(state := self._context.state, Homing):
                state.restart()
            return
        if current is StateName.ARM and name is StateName.ARM:
            return
        self._context.switch(self._context.states.taken_up(name))
        if at_start and self.is_airborne:
            self._begin_in_air()

    def _outranks_hover(self, name: StateName) -> bool:
        own_reaction = Rank.COMMUNICATION_LOST <= self._context.state.rank <= Rank.LAND
        return name is StateName.HOVER and own_reaction

    def _begin_in_air(self) -> None:
        self.started_in_air = True
        self._context.take_up_flight()
        starts = self._count_start()
        self._context.record("start in the air", {"starts": starts})
        self._context.log.add("warning", "The program started while the drone was in the air.")
        if restart_rule(starts) is not RestartRule.TAKE_UP and self._context.state.identity not in LEFT_ALONE:
            cause = Cause("The program stopped twice in a minute.", lambda: False)
            self._context.switch(self._context.states.return_to_launch(cause))

    def _follow_arming(self, vehicle: State) -> None:
        current = self._context.state.identity
        if self._context.kill.is_sending:
            return
        if not vehicle.armed:
            if current not in GROUND_STATES:
                self._land_in_idle()
            return
        if current is StateName.ARM and vehicle.landed in (LandedState.IN_AIR, LandedState.TAKING_OFF):
            self.take_up(at_start=False)  # taken off by somebody else
        if current is not StateName.IDLE:
            return
        abandoned = self._abandoned is not None and self._context.now - self._abandoned <= ABANDONED_S
        if abandoned and not self.is_airborne:
            if self._context.now - self._disarm_asked >= DISARM_RETRY_S:
                self._disarm_asked = self._context.now
                self._context.log.add("warning", "Armed after it was given up: motors off.")
                self._context.ask("disarm", self._context.service.set_arm(False))
            return
        self.take_up(at_start=False)

    def _land_in_idle(self) -> None:
        self._context.log.add("ok", "Landed. Motors off.")
        self._context.switch(self._context.states.idle("Landed. Motors off."))

    def note_frame_jump(self, metres: float) -> None:
        """EKF-local jumped by so many metres: answered at the next tick."""
        self._frame_jump = max(self._frame_jump, abs(metres))

    def _follow_frame_jump(self) -> None:
        jump, self._frame_jump = self._frame_jump, 0.0
        if jump <= 0 or self._context.state.identity in GROUND_STATES:
            return
        self._context.log.add("warning", f"The position jumped by {jump:.1f} m.")
        if self._context.state.identity in TASK_STATES:
            self._context.switch(self._context.states.hover("The position jumped.", level="warning"))
        elif isinstance(holding := getattr(self._context.state, "holding", None), Holding):
            holding.restart()

    def note_arm_place(self, place: ArmPlace) -> None:
        """Home is the arm place."""
        datum = self._context.service.datum
        if datum is not None:
            self._context.topics.home_pub.publish(to_map(datum, place.latitude, place.longitude))

    def _ensure_fence(self) -> None:
        """After a restart in the air the fence is that around the arm place of the earlier run."""
        place, datum = self._context.topics.vehicle.arm_place.value, self._context.service.datum
        if place is None or datum is None:
            return
        if self._context.topics.home_pub.value is None:
            self.note_arm_place(place)
        if self._context.fence is None and self._context.state.identity not in GROUND_STATES:
            self._context.fences.put_in_force(self._context.fences.build(datum, place.latitude, place.longitude))
