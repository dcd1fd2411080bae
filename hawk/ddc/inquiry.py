"""Asking the planner whether a place lies inside the lot before an Autonomous Move is taken."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from hawk.comm.messages import AutonomousMove
from hawk.comm.status import ClientId
from hawk.ddc.commands import Refusal
from hawk.ddc.states.base import MoveOrder
from hawk.ddc.topic_interface import VERDICT_AGE_S
from hawk.model import Inbound, UserError

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

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
        if verdict is not None and verdict.inbound is Inbound.INSIDE:
            self._accept(inquiry)
        elif verdict is not None:
            error = UserError.DESIRED_LOCATION_OUT_OF_BOUNDS
            self._refuse(inquiry, Refusal(_REASONS[verdict.inbound], error))
        elif self._context.now - inquiry.asked > VERDICT_AGE_S:
            reason = "X, Y: whether the place is inside the lot could not be told within a second."
            self._refuse(inquiry, Refusal(reason, UserError.DESIRED_LOCATION_OUT_OF_BOUNDS))

    def _accept(self, inquiry: _Inquiry) -> None:
        self._open = None
        refusal = self._context.judge.refusal(inquiry.client, inquiry.command)
        refusal = refusal or self._context.judge.move_refusal(inquiry.order.place)
        if refusal is not None:
            self._refuse(inquiry, refusal)
            return
        answer = self._context.accept(inquiry.command, inquiry.order)
        self._context.answer_later(inquiry.client, inquiry.command, answer)

    def _refuse(self, inquiry: _Inquiry, refusal: Refusal) -> None:
        self._open = None
        self._context.forget_desired(inquiry.order.number)
        answer = self._context.refuse(inquiry.command, refusal)
        self._context.answer_later(inquiry.client, inquiry.command, answer)
