"""What becomes of a command: refused with its reason, or acted on; answered now or, when the planner is asked, later.

Whether it is taken is the business of `hawk.ddc.commands`; what flying it means is that of the states.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hawk.comm.fence_messages import CheckFence, ClearFence, SetFence
from hawk.comm.messages import (
    Ack,
    AutonomousMove,
    ClearKill,
    Command,
    CompulsiveMove,
    Configure,
    Control,
    Kill,
    KillRequest,
    KillToken,
    MapResync,
    OperatorHeartbeat,
    Outgoing,
    RouteRequest,
    SetFailsafes,
)
from hawk.comm.status import ClientId
from hawk.ddc.commands import Refusal, command_type
from hawk.ddc.fence_desk import answer_check, plan_of
from hawk.ddc.kill import TOKEN_VALID_S, KillRefused
from hawk.ddc.states.base import ConfigureOrder, FenceOrder, MoveOrder, Order
from hawk.model import HeightParameters, MapPoint, UserError

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager


class CommandDesk:
    """Takes commands, one after the other."""

    def __init__(self, context: OperationsManager) -> None:
        self._context = context

    def handle(self, client: ClientId, command: Command) -> Outgoing | None:
        """Decide on a command, act on it, and return the answer; None: the answer follows through the socket."""
        if isinstance(command, OperatorHeartbeat):
            return Ack(id=command.id, accepted=True)
        if isinstance(command, Control | MapResync):
            return Ack(id=command.id, accepted=False, reason=f"{command.type}: is answered by the web server.")
        if isinstance(command, CheckFence):
            return answer_check(self._context, command)
        self._context.record("command", {"client": client, **command.model_dump(by_alias=True, exclude={"token"})})
        if isinstance(command, RouteRequest):
            self._context.route_requests.ask(client, command)
            return None
        refusal = self._context.judge.refusal(client, command)
        answer = self.refuse(command, refusal) if refusal is not None else self._accept(client, command)
        if isinstance(answer, Ack):
            self._record_answer(client, command, answer)
        return answer

    def refuse(self, command: Command, refusal: Refusal) -> Ack:
        """Return the refusing answer; show the User Error that the command caused."""
        if refusal.error is not UserError.NONE:
            self._context.set_user_error(refusal.error, refusal.reason)
        return Ack(id=command.id, accepted=False, reason=refusal.reason)

    def accept(self, command: Command, order: Order) -> Ack:
        """Hand an accepted command to the state, which follows it at once."""
        self._begin()
        self._context.give(order)
        return Ack(id=command.id, accepted=True)

    def answer_later(self, client: ClientId, command: Command, answer: Ack) -> None:
        """Send an answer that had to wait."""
        self._record_answer(client, command, answer)
        self._context.socket.reply(client, answer)

    def place_of(self, command: AutonomousMove | CompulsiveMove | RouteRequest) -> MapPoint | None:
        """Return the place in the map that a Move or Route Request means, None while the position is not known."""
        if command.frame == "Map":
            return MapPoint(command.x, command.y)
        pose = self._context.topics.get_fresh_pose()
        if pose is None or pose.map is None:
            return None
        return MapPoint(pose.map.north + command.x, pose.map.east + command.y)

    def _begin(self) -> None:
        """An accepted command clears the User Error of an earlier one, and takes the place of a Move still judged."""
        self._context.set_user_error(UserError.NONE, "")
        self._context.inquiries.supersede()

    def _accept(self, client: ClientId, command: Command) -> Outgoing | None:
        if isinstance(command, KillRequest):
            return KillToken(id=command.id, token=self._context.kill.request(client), valid_for=TOKEN_VALID_S)
        if isinstance(command, Kill):
            return self._kill(client, command)
        if isinstance(command, ClearKill):
            return self._clear_kill(command)
        if isinstance(command, SetFailsafes):
            self._context.set_user_error(UserError.NONE, "")
            self._context.preflight.set_failsafes()
            return Ack(id=command.id, accepted=True)
        if isinstance(command, AutonomousMove):
            self._context.inquiries.open(client, command, self._move_order(command))
            return None
        if isinstance(command, CompulsiveMove):
            return self.accept(command, self._move_order(command))
        if isinstance(command, Configure):
            return self.accept(command, ConfigureOrder(HeightParameters(command.min, command.des, command.max)))
        if isinstance(command, SetFence | ClearFence):
            return self.accept(command, FenceOrder(plan_of(command) if isinstance(command, SetFence) else None))
        return self.accept(command, command)

    def _move_order(self, command: AutonomousMove | CompulsiveMove) -> MoveOrder:
        place, pose = self.place_of(command), self._context.topics.get_fresh_pose()
        if place is None or pose is None or pose.map is None:
            raise ValueError("a move was accepted without a position")
        heights = self._context.heights
        wanted = command.height if isinstance(command, CompulsiveMove) else None
        height = heights.bounded(wanted or pose.map.height)
        return MoveOrder(place, height, pose.map.yaw, isinstance(command, AutonomousMove), number=0)

    def _kill(self, client: ClientId, command: Kill) -> Ack:
        try:
            self._context.kill.kill(client, command.token, self._context.topics.get_state().armed)
        except KillRefused as refused:
            return Ack(id=command.id, accepted=False, reason=str(refused))
        self._begin()
        self._context.log.add("error", "Motors are being cut by you.")
        return Ack(id=command.id, accepted=True)

    def _clear_kill(self, command: ClearKill) -> Ack:
        self._context.set_user_error(UserError.NONE, "")
        self._context.kill.clear()
        self._context.log.add("info", "The cut of the motors was cleared.")
        return Ack(id=command.id, accepted=True)

    def _record_answer(self, client: ClientId, command: Command, answer: Ack) -> None:
        payload = {"client": client, "command": command_type(command), "accepted": answer.accepted}
        self._context.record("answer to operator", {**payload, "reason": answer.reason})
