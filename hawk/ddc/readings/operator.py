"""The operator in control, and the names of those who send commands, as one tick knows them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from hawk.comm.protocol.authority import OperatorDesk, Tenure
from hawk.comm.protocol.heartbeat import ClientId
from hawk.ddc.readings.instant import Instant, Reading
from hawk.model.sentences import say

HIDDEN_S: Final = 30.0
"""A page that is hidden for so long in a task is as good as lost, seconds: its sign of life comes from a worker, also
in a pocket."""
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
    hidden_s: float | None = None
    """Seconds for which nobody sees a page of the session in control; None while one is shown, and for a program."""

    @property
    def tenure(self) -> Tenure:
        """State of control: free, held, or held by a lost operator."""
        if not self.is_controlled:
            return Tenure.FREE
        return Tenure.HELD if self.is_present else Tenure.LOST

    @property
    def is_away(self) -> bool:
        """True when nobody has seen a page of the session in control for `HIDDEN_S`."""
        return self.hidden_s is not None and self.hidden_s >= HIDDEN_S

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
        controller, hidden_since = desk.controller(), desk.hidden_since()
        return OperatorFacts(
            is_present=desk.operator_present(instant.now),
            is_controlled=controller is not None,
            clients=desk.controlling_clients(),
            controller=controller or "",
            names=tuple(desk.names().items()),
            given_back_by=desk.given_back_by(),
            hidden_s=None if hidden_since is None else max(0.0, instant.now - hidden_since),
        )
