"""Answers what never reaches the operations manager: signs of life, control, the map again, and who may not command."""

from __future__ import annotations

from hawk.comm.messages import Ack, Command, Control, MapResync, OperatorHeartbeat, Outgoing, RouteRequest
from hawk.comm.status import ClientId
from hawk.web.hub import ClientHub
from hawk.web.sessions import ControlDesk


class Gate:
    """A `hawk.comm.message_socket.Gate`."""

    def __init__(self, desk: ControlDesk, hub: ClientHub) -> None:
        self._desk = desk
        self._hub = hub

    def __call__(self, client: ClientId, command: Command) -> Outgoing | None:
        """Return the answer, or None to let the command through."""
        self._desk.sign_of_life(client)
        if isinstance(command, OperatorHeartbeat):
            return Ack(id=command.id, accepted=True)
        if isinstance(command, RouteRequest):
            return None  # who only watches may ask: nothing is flown
        if isinstance(command, Control):
            act = self._desk.request if command.action == "Request" else self._desk.release
            reason = act(client)
        elif isinstance(command, MapResync):
            self._hub.forget_map(client)
            reason = None
        else:
            reason = self._desk.refusal(client, command)
            if reason is None:
                return None
        return Ack(id=command.id, accepted=reason is None, reason=reason or "")
