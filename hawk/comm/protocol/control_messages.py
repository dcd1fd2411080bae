"""Commands that concern the sender's session: its name, and control. The web server answers them."""

from __future__ import annotations

from typing import Literal

from hawk.comm.protocol.base import Command
from hawk.comm.protocol.names import PersonName


class Control(Command):
    """Control: Request it, Release it; Ask the one who has it, Withdraw that; answer such a question by Give or Keep.

    Request is granted while control is free, its holder is lost, or a question of this client was not answered in time.
    """

    type: Literal["Control"] = "Control"
    action: Literal["Request", "Release", "Ask", "Withdraw", "Give", "Keep"]


class OperatorName(Command):
    """The name by which the others know the sender; null: none. It is shown, and proves nothing."""

    type: Literal["Name"] = "Name"
    name: PersonName | None
