"""Arm: fence, GUIDED, arm, and the wait for take-off."""

from __future__ import annotations

from enum import Enum, auto
from typing import TYPE_CHECKING

from hawk.comm.messages import Disarm, Takeoff
from hawk.ddc.requests import Request
from hawk.ddc.states.base import State
from hawk.ddc.states.mode_keeper import ModeKeeper
from hawk.ddc.words import seconds
from hawk.model import CopterMode, StateName

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

TIMEOUT_S = 20.0
"""From the command to "armed", fence upload included."""
ARMED_WAIT_S = 3.0
""""Armed" follows the acknowledgement by up to 0.9 s."""
AUTO_DISARM_S = 10.0
"""ArduCopter's DISARM_DELAY: motors stop without take-off."""


class _Step(Enum):
    FENCE = auto()
    MODE = auto()
    ARM = auto()
    WAIT = auto()
    ARMED = auto()


class Arm(State):
    """Arms on command, or is taken up from a drone that is armed on the ground in GUIDED (``armed``)."""

    identity = StateName.ARM

    def __init__(self, context: OperationsManager, armed: bool = False, reason: str = "") -> None:
        super().__init__(context)
        self._step = _Step.ARMED if armed else _Step.FENCE
        self._armed_at = context.now
        self._reason = reason
        self._failure: tuple[str, str] | None = None
        self._request: Request | None = None
        self._disarming: Request | None = None
        self._guided = ModeKeeper(context, CopterMode.GUIDED)
        self._step_began = context.now

    @property
    def is_armed(self) -> bool:
        """Whether "armed" was seen: Takeoff may follow."""
        return self._step is _Step.ARMED

    @property
    def detail(self) -> str:
        """What is waited for; the countdown once armed."""
        if self._step is not _Step.ARMED:
            return "Arming."
        left = AUTO_DISARM_S - (self.context.now - self._armed_at)
        countdown = f"Motors stop in {seconds(left)} without take-off."
        return f"{self._reason} {countdown}" if self._reason else f"Armed. {countdown}"

    def enter(self) -> None:
        """Begin with the fence, unless the drone is armed already."""
        super().enter()
        self._step_began = self._armed_at = self.context.now
        if self._step is _Step.FENCE:
            self._begin_fence()

    def process(self) -> None:
        """Take the next step when the one before is done."""
        if self._step is _Step.FENCE and self._request is not None and self._request.is_done:
            self.context.fence_uploaded()
            self._next(_Step.MODE)
        if self._step is _Step.MODE and self._guided.reach():
            self._next(_Step.ARM)
            self._request = self.context.ask("arm", self.context.service.set_arm(True))
        if self._step is _Step.ARM and self._request is not None and self._request.is_done:
            self._next(_Step.WAIT)
        if self._step in (_Step.ARM, _Step.WAIT) and self.context.topics.get_state().armed:
            self._next(_Step.ARMED)
            self._armed_at = self.context.now
            self.context.log.add("ok", f"Armed by you. {self.context.preflight.passed_count} checks passed.")

    def transition_next_state(self) -> State:
        """Follow Takeoff and Disarm; give up when refused, timed out or without an operator."""
        order = self._take_order()
        if isinstance(order, Takeoff):
            return self.context.states.takeoff()
        if isinstance(order, Disarm):
            return self._disarm()
        if not self.context.operator_present:
            return self._give_up("The operator was lost: motors off.", "")
        if self._step is _Step.ARMED:
            return self._watch_armed()
        return self._watch_arming()

    def _watch_armed(self) -> State:
        if not self.context.topics.get_state().armed:
            return self.context.states.idle("Motors off.")
        if self.context.topics.get_state().custom_mode != CopterMode.GUIDED:
            return self.context.states.taken_up(StateName.MANUAL)
        if self._disarming is not None and self._disarming.has_failed:
            self.context.log.add("error", "Disarm was refused.", self._disarming.reason)
            self._disarming = None
        return self

    def _watch_arming(self) -> State:
        waited = self.context.now - self._step_began
        if self._failure is not None:
            return self._give_up(*self._failure)
        if self._request is not None and self._request.has_failed:
            what = "The fence was not taken." if self._step is _Step.FENCE else "Arm was refused."
            return self._give_up(what, self._request.reason)
        if self._step is _Step.WAIT and waited > ARMED_WAIT_S:
            return self._give_up("Arm was taken, but the drone does not arm.", self.context.log.autopilot_reason())
        if self.age > TIMEOUT_S:
            return self._give_up("Arming took too long.", self._guided.reason or self.context.log.autopilot_reason())
        return self

    def _begin_fence(self) -> None:
        try:
            fence = self.context.prepare_fence()
        except ValueError as error:
            self._failure = ("There is no fence to fly in.", str(error))
            return
        self._request = self.context.ask("upload fence", self.context.service.upload_fence(fence))

    def _disarm(self) -> State:
        if self._step is not _Step.ARMED:
            return self._give_up("Arming was stopped by you.", "")
        self._disarming = self.context.ask("disarm", self.context.service.set_arm(False))
        return self

    def _give_up(self, text: str, details: str) -> State:
        self.context.log.add("error", text, details)
        self.context.abandon_arming()
        return self.context.states.idle(f"{text} {details}".strip())

    def _next(self, step: _Step) -> None:
        self._step = step
        self._step_began = self.context.now
