"""The table of commands and states: which command a state accepts, and the reason where it does not."""

from __future__ import annotations

from collections.abc import Mapping

from hawk.model.operation import StateName
from hawk.model.sentences import say

_COLUMNS = (
    StateName.IDLE,
    StateName.CONFIGURE,
    StateName.ARM,
    StateName.TAKEOFF,
    StateName.HOVER,
    StateName.AUTONOMOUS_EXPLORE,
    StateName.AUTONOMOUS_MOVE,
    StateName.COMPULSIVE_MOVE,
    StateName.RETURN_TO_LAUNCH,
    StateName.LAND,
    StateName.COMMUNICATION_LOST,
    StateName.MANUAL,
)

_TABLE = """
Command            | Idle   Configure Arm    Takeoff Hover Explore A.Move C.Move RTL    Land   Lost Manual
Configure          | yes    saving    disarm land    land  land    land   land   land   land   land pilot
Arm                | yes    saving    armed  flying  flying flying flying flying flying flying flying pilot
Takeoff            | arm    saving    yes    flying  flying flying flying flying flying flying flying pilot
Autonomous Explore | off    off       off    climbs  yes   running moving moving homing landing lost pilot
Autonomous Move    | off    off       off    climbs  yes   yes     yes    yes    homing landing lost pilot
Compulsive Move    | off    off       off    climbs  yes   yes     yes    yes    homing landing lost pilot
Hold               | ground ground    ground yes     yes   yes     yes    yes    yes    yes    holds pilot
Return To Launch   | home   home      home   yes     yes   yes     yes    yes    homing! landing yes yes
Land               | ground ground    ground yes     yes   yes     yes    yes    yes    landing! yes yes
Disarm             | off!   off!      yes    air     air   air     air    air    air    yes    air  pilot
Resume             | ours   ours      ours   ours    ours  ours    ours   ours   ours   ours   ours yes
Kill Request       | yes    yes       yes    yes     yes   yes     yes    yes    yes    yes    yes  yes
Kill               | yes    yes       yes    yes     yes   yes     yes    yes    yes    yes    yes  yes
Clear Kill         | yes    saving    disarm air     air   air     air    air    air    air    air  pilot
Set Failsafes      | yes    saving    before before  before before before before before before before pilot
Set Fence          | yes    saving    disarm land    land  land    land   land   land   land   land pilot
Clear Fence        | yes    saving    disarm land    land  land    land   land   land   land   land pilot
Set Outline        | yes    saving    yes    yes     yes   explores yes   yes    yes    yes    lost pilot
Clear Outline      | yes    saving    yes    yes     yes   explores yes   yes    yes    yes    lost pilot
New Survey         | yes    saving    disarm land    land  land    land   land   land   land   land pilot
"""
"""A word is a reason of `_REASONS`; "yes": accepted if no condition refuses it."""

_REASONS: Mapping[str, str] = {
    "saving": say("Saving: wait a moment."),
    "disarm": say("Armed: disarm first."),
    "land": say("Flying: land first."),
    "flying": say("Already flying."),
    "armed": say("Already armed, or arming."),
    "arm": say("Arm first."),
    "off": say("Take off first."),
    "climbs": say("Climbing: wait until it holds."),
    "running": say("Already exploring."),
    "moving": say("Moving: Hold first."),
    "homing": say("Returning home: Hold first."),
    "landing": say("Landing: Hold first."),
    "homing!": say("Already returning home."),
    "landing!": say("Already landing."),
    "lost": say("The operator was lost: wait until it holds for you."),
    "holds": say("Holding already, until the operator is back."),
    "pilot": say("Someone else flies: Resume first."),
    "ground": say("On the ground."),
    "home": say("Is at home."),
    "air": say("In the air: land first."),
    "off!": say("The motors are off."),
    "ours": say("Nobody else flies."),
    "explores": say("Exploring: Hold first."),
    "before": say("Only before flight, disarmed."),
}


def _read_table() -> dict[str, dict[StateName, str]]:
    rows: dict[str, dict[StateName, str]] = {}
    for line in _TABLE.strip().splitlines()[1:]:
        name, _, cells = line.partition("|")
        rows[name.strip()] = dict(zip(_COLUMNS, cells.split(), strict=True))
    return rows


TABLE: Mapping[str, Mapping[StateName, str]] = _read_table()
"""Type of a command -> state -> "yes" or the word of a reason."""

NEEDS_LINK = frozenset(TABLE) - {"Configure", "Kill Request", "Kill", "Clear Kill", "Set Outline", "Clear Outline"}
"""Commands that need the autopilot to hear."""


def table_reason(command: str, state: StateName) -> str:
    """Return the reason why the table refuses a command (by its type) in a state; empty when it accepts it."""
    word = TABLE[command][state]
    return "" if word == "yes" else _REASONS[word]
