"""Authority over the drone: which command a client may send, given its role and who has control.

The web server authenticates sessions and asks `role_refusal` before anything else about a command: it is the one place
where a viewer's commands end. It answers `ANSWERED_BY_THE_WEB_SERVER` and passes every other command on with the
client's id. The operations manager asks `authority_refusal` before anything else about a command.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum, StrEnum
from typing import Final

from hawk.model.sentences import say


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
