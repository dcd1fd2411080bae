"""The operator in control, and the names of those who send commands, as one tick knows them."""

from __future__ import annotations

from dataclasses import dataclass

from hawk.comm.protocol.authority import OperatorDesk, Tenure
from hawk.comm.protocol.heartbeat import ClientId
from hawk.ddc.readings.instant import Instant, Reading
from hawk.model.sentences import say

SOME_OPERATOR = say("the operator")
"""Stands for a name that is not known: recordings from before the names."""


@dataclass(frozen=True, slots=True)
class OperatorFacts:
    """The operator in control. ``clients`` are the connections of the session in control."""

    is_present: bool = False
    is_controlled: bool = False
    """True while any session has control, a lost one too."""
    clients: frozenset[ClientId] = frozenset()
    controller: str = ""
    """Name of the session in control; empty while nobody has it."""
    names: tuple[tuple[ClientId, str], ...] = ()
    """Each connection with the name of its session. Names are shown and decide nothing."""
    given_back_by: str = ""
    """Name of the one who gave control back, while nobody has taken it since; empty otherwise."""

    @property
    def tenure(self) -> Tenure:
        """State of control: free, held, or held by a lost operator."""
        if not self.is_controlled:
            return Tenure.FREE
        return Tenure.HELD if self.is_present else Tenure.LOST

    def name(self, client: ClientId) -> str:
        """Return the name of a connection's session; empty when it is not known."""
        return next((name for each, name in self.names if each == client), "")


NO_OPERATOR = OperatorFacts()


class OperatorReading(Reading):
    """Asks the desk who has control."""

    def __init__(self, desk: OperatorDesk) -> None:
        self._desk = desk

    def facts(self, instant: Instant) -> OperatorFacts:
        """Return what is known."""
        desk = self._desk
        controller = desk.controller()
        return OperatorFacts(
            is_present=desk.operator_present(instant.now),
            is_controlled=controller is not None,
            clients=desk.controlling_clients(),
            controller=controller or "",
            names=tuple(desk.names().items()),
            given_back_by=desk.given_back_by(),
        )
