"""Asking the planner whether a place lies inside the lot before an Autonomous Move is taken."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from hawk.comm.messages import AutonomousMove
from hawk.comm.status import ClientId
from hawk.ddc.commands import Refusal
from hawk.ddc.states.base import MoveOrder
from hawk.ddc.topic_interface import VERDICT_AGE_S
from hawk.model import Inbound, UserError, Verdict

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

NOT_TOLD = "X, Y: whether the place is inside the lot could not be told within a second."
_REASONS = {
    Inbound.OUTSIDE: "X, Y: the place is outside the lot: choose one inside, or Compulsive Move.",
    Inbound.UNKNOWN: "X, Y: nobody has seen that place yet: explore first, or Compulsive Move.",
}


@dataclass(frozen=True, slots=True)
class _Inquiry:
    client: ClientId
    command: AutonomousMove
    order: MoveOrder
    asked: float


class Inquiries:
    """At most one inquiry is open; its answer goes to the client within a second."""

    def __init__(self, context: OperationsManager) -> None:
        self._context = context
        self._open: _Inquiry | None = None

    @property
    def is_open(self) -> bool:
        """Whether an answer of the planner is waited for."""
        return self._open is not None

    def open(self, client: ClientId, command: AutonomousMove, order: MoveOrder) -> None:
        """Ask about the order's place; an older inquiry ends refused."""
        self.supersede()
        number = self._context.desire(order.place)
        self._open = _Inquiry(client, command, replace(order, number=number), self._context.now)

    def supersede(self) -> None:
        """Another command, or another state, came first: the open inquiry ends refused."""
        if self._open is not None:
            self._refuse(self._open, Refusal("Something else came first."))

    def tick(self) -> None:
        """Look for the verdict."""
        inquiry = self._open
        if inquiry is None:
            return
        verdict = self._context.topics.get_verdict(inquiry.order.number)
        error = UserError.DESIRED_LOCATION_OUT_OF_BOUNDS
        if verdict is not None:
            reason = place_refusal(verdict)
            if reason:
                self._refuse(inquiry, Refusal(reason, error))
            else:
                self._accept(replace(inquiry, order=replace(inquiry.order, route=verdict.route)))
        elif self._context.now - inquiry.asked > VERDICT_AGE_S:
            self._refuse(inquiry, Refusal(NOT_TOLD, error))

    def _accept(self, inquiry: _Inquiry) -> None:
        self._open = None
        refusal = self._context.judge.refusal(inquiry.client, inquiry.command)
        refusal = refusal or self._context.judge.route_refusal(inquiry.order.route)
        if refusal is not None:
            self._refuse(inquiry, refusal)
            return
        answer = self._context.commands.accept(inquiry.command, inquiry.order)
        self._context.commands.answer_later(inquiry.client, inquiry.command, answer)

    def _refuse(self, inquiry: _Inquiry, refusal: Refusal) -> None:
        self._open = None
        self._context.forget_desired(inquiry.order.number)
        answer = self._context.commands.refuse(inquiry.command, refusal)
        self._context.commands.answer_later(inquiry.client, inquiry.command, answer)


def place_refusal(verdict: Verdict) -> str:
    """Return why an Autonomous Move to the place of this verdict is refused; empty when it has a route."""
    if verdict.inbound is not Inbound.INSIDE:
        return _REASONS[verdict.inbound]
    if len(verdict.route.points) >= 2:
        return ""
    return f"X, Y: {verdict.route.refused or 'no way there is known'}: choose another place, or Compulsive Move."
