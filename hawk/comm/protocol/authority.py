"""Authority over the drone: which command a client may send, by its role and by who has control; operators' names.

`hawk.comm.protocol.command_table` says for each command who may send it. The web server authenticates sessions and asks
`role_refusal` before anything else about a command: it is the one place where a viewer's commands end. The operations
manager asks `authority_refusal` before anything else about a command.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping
from enum import Enum, StrEnum
from typing import Annotated, Final, Protocol

from pydantic import AfterValidator, Field

from hawk.comm.protocol.heartbeat import ClientId
from hawk.model.sentences import say


class OperatorDesk(Protocol):
    """Control, as the web server knows it."""

    def operator_present(self, now: float) -> bool:
        """Return True when a session with control showed a sign of life within ``operator_timeout_s``."""

    def hidden_since(self) -> float | None:
        """Return since when each page of the session with control is hidden, seconds; None while one is shown."""

    def controller(self) -> str | None:
        """Return the name of the session that has control."""

    def controlling_clients(self) -> frozenset[ClientId]:
        """Return the connections of the session that has control."""

    def names(self) -> Mapping[ClientId, str]:
        """Return the name of each connection's session."""

    def given_back_by(self) -> str:
        """Return the name of the session that gave control back, while nobody has taken it since; else empty."""


LONGEST_PERSON: Final = 24
"""Characters of a name: it stands in a line of the log and in a button's row."""
_LONGEST_SENT: Final = 100
_NUMBERED: Final = re.compile(r"(operator|viewer)\d*")
_TAKEN: Final = frozenset(
    {"you", "nobody", "someoneelse", "theoperator", "anoperator", "pilot", "thepilot", "autopilot", "theautopilot"}
    | {"drone", "thedrone", "theprogram", "hawk"}
)
"""Words of the log's own sentences, as `_key` spells them: "Stopped by you." would be said to everybody."""


def cleaned(name: str) -> str:
    """Return a name as it is shown: composed characters, single spaces.

    Raises:
        ValueError: The name cannot be shown, or would be read as something else; the text gives the remedy.
    """
    if not name.isprintable():
        raise ValueError("has characters that cannot be shown: leave out line breaks and control characters")
    name = " ".join(unicodedata.normalize("NFC", name).split())
    if len(name) > LONGEST_PERSON:
        raise ValueError(f"must have at most {LONGEST_PERSON} characters, not {len(name)}")
    marks = sum(unicodedata.category(each).startswith("M") for each in name)
    if not any(each.isalnum() for each in name) or marks > len(name) - marks:
        raise ValueError("must have a letter or a digit, and no more accents than letters")
    if _NUMBERED.fullmatch(_key(name)) or _key(name) in _TAKEN:
        raise ValueError(f"{name} is a word of the log itself: send another name")
    return name


def distinct(name: str, others: Iterable[str]) -> str:
    """Return the name, with a number behind it when one of the others looks the same."""
    taken = {_key(other) for other in others}
    shown, count = name, 1
    while _key(shown) in taken:
        count += 1
        shown = f"{name} {count}"
    return shown


def _key(name: str) -> str:
    """Return what two names have in common that look alike: letters and digits, without case and width."""
    folded = unicodedata.normalize("NFKC", name).casefold()
    return "".join(each for each in folded if each.isalnum())


PersonName = Annotated[str, Field(max_length=_LONGEST_SENT), AfterValidator(cleaned)]


class Role(StrEnum):
    """The use that a token allows."""

    VIEWER = "viewer"
    """Sees everything, commands nothing."""
    OPERATOR = "operator"


class Sender(Enum):
    """The clients that may send a command, in the words of the protocol's reference."""

    EVERYBODY = "every client, viewers included"
    """A sign of life, and the question for the whole map."""
    OPERATORS = "every operator"
    """The command concerns the sender's session, or only asks: nothing is flown or changed."""
    OPERATORS_UNLESS_HOMING = "every operator; while it returns or lands, only the client in control"
    CONTROL_OR_FREE = "the client in control; every operator while nobody has control, or the one who has it is lost"
    CONTROL = "the client in control"


class Tenure(Enum):
    """State of control."""

    FREE = "free"
    HELD = "held"
    LOST = "lost"
    """A session has control and sent no sign of life within ``operator_timeout_s``: control is free for the asking."""


VIEWERS_COMMAND_NOTHING: Final = say("You are a viewer: viewers command nothing. Log in as operator to do that.")

TAKE_CONTROL_FIRST: Final = say("Take control first.")
SOMEONE_ELSE: Final = say("Someone else has control.")
CONTROLLER_LOST: Final = say("The operator in control is lost: take control first.")
_REFUSALS: Final[Mapping[Tenure, str]] = {
    Tenure.FREE: TAKE_CONTROL_FIRST,
    Tenure.HELD: SOMEONE_ELSE,
    Tenure.LOST: CONTROLLER_LOST,
}


def role_refusal(sender: Sender, role: Role) -> str:
    """Return why a client of this role may never send a command with this ``sender``; empty when its role allows it."""
    return "" if role is Role.OPERATOR or sender is Sender.EVERYBODY else VIEWERS_COMMAND_NOTHING


def authority_refusal(sender: Sender, *, has_control: bool, control: Tenure, homing: bool) -> str:
    """Return why an operator may not send a command with this ``sender`` now; empty when it may.

    Args:
        sender: Who may send the command.
        has_control: True when this client's session has control.
        control: Whether any session has control.
        homing: True in Return To Launch and Land.
    """
    if (
        has_control
        or sender in (Sender.EVERYBODY, Sender.OPERATORS)
        or (sender is Sender.OPERATORS_UNLESS_HOMING and not homing)
        or (sender is Sender.CONTROL_OR_FREE and control is not Tenure.HELD)
    ):
        return ""
    return _REFUSALS[control]
