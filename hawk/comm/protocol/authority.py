"""Authority over the drone: which command a client may send, given its role and who has control.

The web server authenticates sessions and asks `role_refusal` before anything else about a command: it is the one place
where a viewer's commands end. It answers `ANSWERED_BY_THE_WEB_SERVER` and passes every other command on with the
client's id. The operations manager asks `authority_refusal` before anything else about a command.
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


class Right(Enum):
    """The clients that may send a command."""

    ANYONE = "anyone"
    """The command only asks: nothing is flown or changed."""
    ANYONE_UNLESS_HOMING = "anyone; while it returns or lands, only the client in control"
    CONTROL_OR_FREE = "the client in control; anyone while nobody has control, or the one who has it is lost"
    CONTROL = "the client in control"


class Tenure(Enum):
    """State of control."""

    FREE = "free"
    HELD = "held"
    LOST = "lost"
    """A session has control and sent no sign of life within ``operator_timeout_s``: control is free for the asking."""


ANSWERED_BY_THE_WEB_SERVER: Final = frozenset({"Heartbeat", "Name", "Control", "Map Resync"})
"""Types of the commands that concern the session only: any connected client may send them."""

RIGHTS: Final[Mapping[str, Right]] = {
    "Configure": Right.CONTROL,
    "Arm": Right.CONTROL,
    "Takeoff": Right.CONTROL,
    "Autonomous Explore": Right.CONTROL,
    "Autonomous Move": Right.CONTROL,
    "Compulsive Move": Right.CONTROL,
    "Route Request": Right.ANYONE,
    "Hold": Right.ANYONE_UNLESS_HOMING,
    "Return To Launch": Right.CONTROL_OR_FREE,
    "Land": Right.CONTROL_OR_FREE,
    "Disarm": Right.CONTROL,
    "Resume": Right.CONTROL,
    "Kill Request": Right.CONTROL_OR_FREE,
    "Kill": Right.CONTROL_OR_FREE,
    "Clear Kill": Right.CONTROL,
    "Set Failsafes": Right.CONTROL,
    "Set Fence": Right.CONTROL,
    "Clear Fence": Right.CONTROL,
    "New Survey": Right.CONTROL,
    "Check Fence": Right.ANYONE,
    "Set Outline": Right.CONTROL,
    "Clear Outline": Right.CONTROL,
}

VIEWER_MAY: Final = frozenset({"Heartbeat", "Map Resync"})
"""Types of a viewer's messages that are taken: a sign of life, and the question for the whole map."""
VIEWERS_COMMAND_NOTHING: Final = say("You are a viewer: viewers command nothing. Log in as operator to do that.")

TAKE_CONTROL_FIRST: Final = say("Take control first.")
SOMEONE_ELSE: Final = say("Someone else has control.")
CONTROLLER_LOST: Final = say("The operator in control is lost: take control first.")
_REFUSALS: Final[Mapping[Tenure, str]] = {
    Tenure.FREE: TAKE_CONTROL_FIRST,
    Tenure.HELD: SOMEONE_ELSE,
    Tenure.LOST: CONTROLLER_LOST,
}


def role_refusal(kind: str, role: Role) -> str:
    """Return why a client of this role may never send this type of command; empty when its role allows it."""
    return "" if role is Role.OPERATOR or kind in VIEWER_MAY else VIEWERS_COMMAND_NOTHING


def authority_refusal(kind: str, *, has_control: bool, control: Tenure, homing: bool) -> str:
    """Return why a client may not send a command now; empty when it may.

    Args:
        kind: Type of the command. A type that `RIGHTS` does not list needs control.
        has_control: True when this client's session has control.
        control: Whether any session has control.
        homing: True in Return To Launch and Land.
    """
    right = RIGHTS.get(kind, Right.CONTROL)
    if (
        has_control
        or right is Right.ANYONE
        or (right is Right.ANYONE_UNLESS_HOMING and not homing)
        or (right is Right.CONTROL_OR_FREE and control is not Tenure.HELD)
    ):
        return ""
    return _REFUSALS[control]
