"""A person's session, and control as it sees it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from hawk.comm.protocol.authority import Role


@dataclass(slots=True, eq=False, weakref_slot=True)
class Session:
    """``name`` is shown to everyone; ``secret`` is the cookie and known to its owner only."""

    name: str
    secret: str = field(repr=False)
    role: Role = Role.OPERATOR
    number: str = ""
    """The name of those who give none."""
    given: str = ""
    """The name that was given; ``name`` may have a number behind it."""
    renamed: float = -math.inf
    last_sign: float = -math.inf
    connections: int = 0
    successor: Session | None = field(default=None, repr=False)
    """The session that took control while this one was lost."""


@dataclass(frozen=True, slots=True)
class ControlView:
    """Control as one client sees it.

    ``controller`` is the name of the session that has control, ``taken_by`` of the one that took it from this client's
    session while that was lost and has it still.
    """

    controller: str | None = None
    in_control: bool = False
    controller_lost: bool = False
    taken_by: str | None = None
    name: str = ""
    """Of this client's session."""
    asked_by: str | None = None
    free_in: float | None = None
    """Seconds until the session that asks may take control."""
    kept: bool = False
    """This client's session asked, and control was kept."""
