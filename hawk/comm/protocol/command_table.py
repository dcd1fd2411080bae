"""The table of commands: everything that can be said of a command stands in its row.

Type, fields and help text are those of the row's model. The web server, the socket, `hawk.ddc.rules.judge` and
`hawk.ddc.rules.command_desk` read the row; `packaging/page_protocol.py` writes from it what the page knows of each
command, `packaging/protocol_page.py` the reference of the protocol.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Final

from hawk.comm.protocol import commands
from hawk.comm.protocol.authority import Sender
from hawk.comm.protocol.heartbeat import FenceCorner
from hawk.model.operation import GROUND_STATES
from hawk.model.operation import StateName as S
from hawk.model.sentences import say


class Need(Enum):
    """A condition of a command, in the words of the protocol's reference; `hawk.ddc.rules.needs` looks at each."""

    LINK = "a link to the autopilot"
    NO_FALL = "no fall that was not cleared"
    NOT_CUT = "no cut of the motors that was not cleared"
    CHECKS = "all preflight checks passed"
    ARMED = "the motors on"
    KEPT = "all that hawk set in the autopilot, as it was set"
    HOME = "the autopilot's home at the arm place"
    FAILSAFES = "the autopilot's failsafes"
    FENCE = "the fence in the autopilot"
    POSITION = "a position that is known, and a fence"
    NO_DOUBT = "a position that no witness doubts"
    INSIDE = "the drone inside the fence"
    PERCEPTION = "vision, mapper and planner without a fault"
    UNSEEN = "ground that is not seen yet"
    LOT = "a lot in sight, or an outline with ground inside the fence"
    AIR = "the drone in the air"
    GROUND = "the drone on the ground, or its motors off"
    NO_CAUSE = "no cause that still sends the drone home or down"
    NOT_AUTOPILOTS = "no return or landing that the autopilot began"
    SWITCH_RESTS = "3 s since the mode was changed"
    HOLDABLE = "a position that the drone can hold"
    OTHER_FAILSAFES = "the autopilot's failsafes, except those that hawk puts back"
    CUT = "motors that were cut"
    NOT_SETTING = "no failsafes being set"
    DRAWN_FENCE = "a drawn fence"
    OUTLINE = "an outline"
    OFFER = "a plan of the lot that was changed in flight"
    DISARMED = "the motors off"
    MAP = "a map that is not empty"


class Confirm(Enum):
    """Confirmation of a command, in the words of the protocol's reference."""

    NEVER = ""
    SLIDE = "by a slide on the page; a program need not"
    """It starts the motors, moves the drone or begins an empty map."""
    OVERRULING = "by `Confirmed` while someone else flies; the page asks then"
    TWO_STEPS = "by the token of a Kill Request; on the page by pressing for a second"


class Urgency(Enum):
    """Place of a command in the queue, in the words of the protocol's reference."""

    WAITS = ""
    URGENT = "passes the queue"
    SAVING = "passes the queue; accepted, it voids the commands that wait"
    """It stops or saves the drone."""


States = Mapping[S, str]
"""State -> reason why it does not take a command, `TAKEN` where it does."""
TAKEN: Final = ""


@dataclass(frozen=True, kw_only=True)
class CommandRow:
    """One command."""

    example: commands.Command
    """It stands in the protocol's reference. Its class has type, fields and help text."""
    sender: Sender = Sender.CONTROL
    states: States = field(default_factory=dict)
    """Every state; empty for a command on which no state bears: it only asks, or the web server answers it."""
    needs: tuple[Need, ...] = ()
    """In the order in which they are looked at; the first that does not hold is the reason of the refusal."""
    confirm: Confirm = Confirm.NEVER
    urgency: Urgency = Urgency.WAITS
    button: str = ""
    """Key of the label of the page's button; empty where the page sends it by itself, or not at all."""
    begins_flight: bool = False
    """Refused while the program's ticks fail, whatever else is well."""
    only_asks: bool = False
    """It changes nothing: it leaves no line in the program's log unless it is refused, and no stop voids it."""
    sent_unheard: bool = False
    """Sent to an armed drone that is not heard, whatever the state; nothing answers then."""
    taken_while_cutting: bool = False
    """Taken while the motors are being cut, from those who may cut them."""
    answered_by_web_server: bool = False
    """It concerns the session only and never reaches the drone."""
    sent_by_itself: bool = False
    """A page sends it by itself: it does not show that somebody sits before it."""

    @property
    def type(self) -> str:
        """The command's Type."""
        return self.example.type

    @property
    def help(self) -> str:
        """The meaning of the command, one line of plain English."""
        return " ".join((type(self.example).__doc__ or "").split())


def every(states: Iterable[S], reason: str) -> dict[S, str]:
    """Return the same reason for several states."""
    return dict.fromkeys(states, reason)


# -- states, and the reasons that several rows share ------------------------------------------------------------------

IN_AIR: Final = tuple(state for state in S if state not in GROUND_STATES and state is not S.MANUAL)
TASKS: Final = (S.AUTONOMOUS_EXPLORE, S.AUTONOMOUS_MOVE, S.COMPULSIVE_MOVE)

SAVES: Final = say("Saving: wait a moment.")
DISARM_FIRST: Final = say("Armed: disarm first.")
FLYING: Final = say("Already flying.")
MOVING: Final = say("Moving: Hold first.")
LANDING: Final = say("Landing: Hold first.")
EXPLORING: Final = say("Exploring: Hold first.")
LOST: Final = say("The operator was lost: wait until it holds for you.")
PILOT_FLIES: Final = say("Someone else flies: Resume first.")
ON_GROUND: Final = say("On the ground.")
IS_IN_AIR: Final = say("In the air: land first.")
MOTORS_OFF: Final = say("The motors are off.")
BEFORE_FLIGHT_ONLY: Final = say("Only before flight, disarmed.")

BEFORE_FLIGHT: Final[States] = {
    S.IDLE: TAKEN,
    S.CONFIGURE: SAVES,
    S.ARM: DISARM_FIRST,
    **every(IN_AIR, say("Flying: land first.")),
    S.MANUAL: PILOT_FLIES,
}
IN_FLIGHT: Final[States] = {
    **every(GROUND_STATES, say("Take off first.")),
    S.TAKEOFF: say("Climbing: wait until it holds."),
    S.HOVER: TAKEN,
    **every(TASKS, TAKEN),
    S.RETURN_TO_LAUNCH: say("Returning home: Hold first."),
    S.LAND: LANDING,
    S.COMMUNICATION_LOST: LOST,
    S.MANUAL: PILOT_FLIES,
}
UNLESS_IT_EXPLORES: Final[States] = {
    **every(S, TAKEN),
    S.CONFIGURE: SAVES,
    S.AUTONOMOUS_EXPLORE: EXPLORING,
    S.COMMUNICATION_LOST: LOST,
    S.MANUAL: PILOT_FLIES,
}
ALWAYS: Final[States] = every(S, TAKEN)

TO_BEGIN_A_TASK: Final = (Need.KEPT, Need.HOME, Need.FAILSAFES, Need.FENCE)
TO_MOVE: Final = (Need.LINK, Need.POSITION, Need.NO_DOUBT, Need.INSIDE, *TO_BEGIN_A_TASK)
TO_MOVE_IN_THE_LOT: Final = (*TO_MOVE, Need.PERCEPTION)

_AREA: Final = [
    FenceCorner(latitude=latitude, longitude=longitude)
    for latitude, longitude in ((60.1699, 24.9384), (60.1699, 24.9402), (60.1688, 24.9402), (60.1688, 24.9384))
]
_HOLE: Final = [
    FenceCorner(latitude=latitude, longitude=longitude)
    for latitude, longitude in ((60.1695, 24.939), (60.1695, 24.9392), (60.1694, 24.9391))
]

# -- the table --------------------------------------------------------------------------------------------------------

_ROWS: Final = (
    CommandRow(
        example=commands.Configure(min=15, des=35, max=60),
        states=BEFORE_FLIGHT,
        button="change-heights",
    ),
    CommandRow(
        example=commands.Arm(),
        states={**BEFORE_FLIGHT, S.ARM: say("Already armed, or arming."), **every(IN_AIR, FLYING)},
        needs=(Need.LINK, Need.NO_FALL, Need.NOT_CUT, Need.CHECKS),
        confirm=Confirm.SLIDE,
        button="arm",
        begins_flight=True,
    ),
    CommandRow(
        example=commands.Takeoff(),
        states={**BEFORE_FLIGHT, S.IDLE: say("Arm first."), S.ARM: TAKEN, **every(IN_AIR, FLYING)},
        needs=(Need.LINK, Need.ARMED, *TO_BEGIN_A_TASK),
        confirm=Confirm.SLIDE,
        button="takeoff",
        begins_flight=True,
    ),
    CommandRow(
        example=commands.AutonomousExplore(),
        states={**IN_FLIGHT, **every(TASKS, MOVING), S.AUTONOMOUS_EXPLORE: say("Already exploring.")},
        needs=(*TO_MOVE_IN_THE_LOT, Need.UNSEEN, Need.LOT),
        confirm=Confirm.SLIDE,
        button="explore",
    ),
    CommandRow(
        example=commands.AutonomousMove(x=42.5, y=-17, frame="Map"),
        states=IN_FLIGHT,
        needs=TO_MOVE_IN_THE_LOT,
        confirm=Confirm.SLIDE,
        button="move",
    ),
    CommandRow(
        example=commands.CompulsiveMove(x=10, y=-5, frame="Relative", height=30),
        states=IN_FLIGHT,
        needs=TO_MOVE,
        confirm=Confirm.SLIDE,
        button="move",
    ),
    CommandRow(
        example=commands.Hold(),
        sender=Sender.OPERATORS_UNLESS_HOMING,
        states={
            **every(GROUND_STATES, ON_GROUND),
            **every(IN_AIR, TAKEN),
            S.COMMUNICATION_LOST: say("Holding already, until the operator is back."),
            S.MANUAL: PILOT_FLIES,
        },
        needs=(Need.LINK, Need.NO_CAUSE, Need.AIR),
        urgency=Urgency.SAVING,
        button="hold",
        taken_while_cutting=True,
    ),
    CommandRow(
        example=commands.ReturnToLaunch(confirmed=False),
        sender=Sender.CONTROL_OR_FREE,
        states={
            **ALWAYS,
            **every(GROUND_STATES, say("Is at home.")),
            S.RETURN_TO_LAUNCH: say("Already returning home."),
            S.LAND: LANDING,
        },
        needs=(Need.LINK, Need.AIR),
        confirm=Confirm.OVERRULING,
        urgency=Urgency.SAVING,
        button="home",
        sent_unheard=True,
        taken_while_cutting=True,
    ),
    CommandRow(
        example=commands.Land(confirmed=True),
        sender=Sender.CONTROL_OR_FREE,
        states={**ALWAYS, **every(GROUND_STATES, ON_GROUND), S.LAND: say("Already landing.")},
        needs=(Need.LINK, Need.NOT_AUTOPILOTS, Need.AIR),
        confirm=Confirm.OVERRULING,
        urgency=Urgency.SAVING,
        button="land",
        sent_unheard=True,
        taken_while_cutting=True,
    ),
    CommandRow(
        example=commands.Disarm(),
        states={
            S.IDLE: MOTORS_OFF,
            S.CONFIGURE: MOTORS_OFF,
            S.ARM: TAKEN,
            **every(IN_AIR, IS_IN_AIR),
            S.LAND: TAKEN,
            S.MANUAL: PILOT_FLIES,
        },
        needs=(Need.LINK, Need.GROUND),
        button="disarm",
    ),
    CommandRow(
        example=commands.Resume(confirmed=True),
        states={**every(S, say("Nobody else flies.")), S.MANUAL: TAKEN},
        needs=(Need.LINK, Need.SWITCH_RESTS, Need.AIR, Need.HOLDABLE, Need.OTHER_FAILSAFES),
        confirm=Confirm.OVERRULING,
        button="resume",
    ),
    CommandRow(
        example=commands.KillRequest(),
        sender=Sender.CONTROL_OR_FREE,
        states=ALWAYS,
        urgency=Urgency.URGENT,
        button="cut-motors",
        only_asks=True,
        taken_while_cutting=True,
    ),
    CommandRow(
        example=commands.Kill(token="3f6c0b8f5a1e4d7c9b2a8e6d4c0f1a2b"),  # noqa: S106 - an example
        sender=Sender.CONTROL_OR_FREE,
        states=ALWAYS,
        confirm=Confirm.TWO_STEPS,
        urgency=Urgency.SAVING,
        button="cut-press",
        sent_unheard=True,
        taken_while_cutting=True,
    ),
    CommandRow(
        example=commands.ClearKill(),
        states={**BEFORE_FLIGHT, **every(IN_AIR, IS_IN_AIR)},
        needs=(Need.CUT,),
        button="remedy-kill",
    ),
    CommandRow(
        example=commands.SetFailsafes(),
        states={**BEFORE_FLIGHT, S.ARM: BEFORE_FLIGHT_ONLY, **every(IN_AIR, BEFORE_FLIGHT_ONLY)},
        needs=(Need.LINK, Need.NOT_SETTING),
        button="remedy-failsafes",
    ),
    CommandRow(
        example=commands.SetFence(corners=_AREA, ceiling=60, zones=[_HOLE]),
        states=BEFORE_FLIGHT,
        needs=(Need.LINK,),
        button="save-fence",
    ),
    CommandRow(
        example=commands.ClearFence(),
        states=BEFORE_FLIGHT,
        needs=(Need.LINK, Need.DRAWN_FENCE),
        button="set-aside-label",
    ),
    CommandRow(
        example=commands.SetOutline(polygons=[_AREA], holes=[_HOLE]),
        states=UNLESS_IT_EXPLORES,
        button="set-outline",
    ),
    CommandRow(
        example=commands.ClearOutline(),
        states=UNLESS_IT_EXPLORES,
        needs=(Need.OUTLINE,),
        button="remove-outline",
    ),
    CommandRow(
        example=commands.SurveyAgain(lots=["0b5f8a52-3c1e-4d7a-9c55-6f1f3f1f6a10"]),
        states=UNLESS_IT_EXPLORES,
        button="survey-again",
    ),
    CommandRow(
        example=commands.FlyPlan(plan="0b5f8a52-3c1e-4d7a-9c55-6f1f3f1f6a10-2-7"),
        states={**ALWAYS, S.COMMUNICATION_LOST: LOST, S.MANUAL: PILOT_FLIES},
        needs=(Need.OFFER,),
        button="fly-plan",
    ),
    CommandRow(
        example=commands.NewSurvey(),
        states=BEFORE_FLIGHT,
        needs=(Need.LINK, Need.DISARMED, Need.MAP),
        confirm=Confirm.SLIDE,
        button="new-survey",
    ),
    CommandRow(
        example=commands.RouteRequest(id="route-1", x=42.5, y=-17, frame="Map"),
        sender=Sender.OPERATORS,
        only_asks=True,
    ),
    CommandRow(
        example=commands.CheckFence(corners=_AREA, ceiling=60),
        sender=Sender.OPERATORS,
        only_asks=True,
    ),
    CommandRow(
        example=commands.OperatorName(name="Anna"),
        sender=Sender.OPERATORS,
        button="save",
        answered_by_web_server=True,
        sent_by_itself=True,
    ),
    CommandRow(
        example=commands.Control(action="Request"),
        sender=Sender.OPERATORS,
        button="take-control",
        answered_by_web_server=True,
    ),
    CommandRow(
        example=commands.OperatorHeartbeat(hidden=False),
        sender=Sender.EVERYBODY,
        answered_by_web_server=True,
        sent_by_itself=True,
    ),
    CommandRow(
        example=commands.MapResync(),
        sender=Sender.EVERYBODY,
        answered_by_web_server=True,
        sent_by_itself=True,
    ),
)
COMMAND_TABLE: Final[Mapping[str, CommandRow]] = {row.type: row for row in _ROWS}
"""Row of each command by its type, in the order in which the heartbeat lists what is possible."""


def sender_of(kind: str) -> Sender:
    """Return who may send a type of command; one without a row needs control."""
    row = COMMAND_TABLE.get(kind)
    return Sender.CONTROL if row is None else row.sender
