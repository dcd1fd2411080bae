"""Control of the drone as the operations manager asks the web server about it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from hawk.comm.protocol.heartbeat import ClientId


class OperatorDesk(Protocol):
    """Control, as the web server knows it."""

    def operator_present(self, now: float) -> bool:
        """Return True when a session with control showed a sign of life within ``operator_timeout_s``."""

    def controller(self) -> str | None:
        """Return the name of the session that has control."""

    def controlling_clients(self) -> frozenset[ClientId]:
        """Return the connections of the session that has control."""

    def names(self) -> Mapping[ClientId, str]:
        """Return the name of each connection's session."""

    def given_back_by(self) -> str:
        """Return the name of the session that gave control back, while nobody has taken it since; else empty."""
