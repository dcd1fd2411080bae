"""A fault as a value: when it happens, what is done, what must be seen, and within how many seconds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Literal

from hawk.comm.protocol.commands import Command
from hawk.comm.protocol.heartbeat import Heartbeat, LogEntry
from hawk.model.operation import StateName
from proving.faults.proxy import Direction, Rule


class When(StrEnum):
    """Part of a flight in which a fault happens."""

    GROUND = "on the ground"
    ARMED = "armed"
    HOVERING = "hovering"
    EXPLORING = "exploring"
    RETURNING = "returning"


# -- what is done ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Link:
    """The link to the autopilot follows these rules; none: it is well."""

    rules: tuple[Rule, ...] = ()


@dataclass(frozen=True, slots=True)
class Drone:
    """A fault of the simulated drone (`hawk.sim.faults.Fault`)."""

    values: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Forge:
    """The daemon gets a message that the autopilot did not send, ``times`` times, ``every_s`` apart.

    ``foreign``: from another socket; ``system``: by another MAVLink system.
    """

    kind: str
    fields: Mapping[str, Any]
    system: int = 1
    foreign: bool = False
    times: int = 1
    every_s: float = 0.2


@dataclass(frozen=True, slots=True)
class Station:
    """A second ground station sends the autopilot a message."""

    kind: str
    fields: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Signal:
    """The daemon's process gets a signal; ``withheld``: nobody starts it again, until `StartAgain`."""

    number: int
    withheld: bool = False


@dataclass(frozen=True, slots=True)
class StartAgain:
    """The daemon is started again."""


@dataclass(frozen=True, slots=True)
class CountAgain:
    """Messages of the daemon are counted, and the true place is compared, from here on."""


@dataclass(frozen=True, slots=True)
class Survey:
    """The operator begins a whole survey (`hawk.survey.operator.SurveyOperator`), from the checks to motors off."""


@dataclass(frozen=True, slots=True)
class Order:
    """The operator in control gives a command; ``stranger``: somebody else does."""

    command: Command
    stranger: bool = False


@dataclass(frozen=True, slots=True)
class KillMotors:
    """The operator in control cuts the motors, in two steps."""


@dataclass(frozen=True, slots=True)
class Leave:
    """The operator in control is gone, without a word."""


@dataclass(frozen=True, slots=True)
class Return:
    """The operator is back and takes control."""


@dataclass(frozen=True, slots=True)
class Hide:
    """The page of the operator in control is hidden, as a phone in a pocket, or shown again."""

    hidden: bool = True


@dataclass(frozen=True, slots=True)
class KnowLot:
    """The plan of a lot about the drone is in the store, and the operator in control surveys it again."""


@dataclass(frozen=True, slots=True)
class ChangeLot:
    """Somebody without control changes that lot over HTTP: "plan", "pin" or "outline"."""

    what: Literal["plan", "pin", "outline"]


@dataclass(frozen=True, slots=True)
class TakePlan:
    """The operator in control flies the changed plan that is offered; ``stranger``: somebody else does."""

    stranger: bool = False


@dataclass(frozen=True, slots=True)
class Bring:
    """The operator brings the drone into this part of a flight."""

    when: When


@dataclass(frozen=True, slots=True)
class SecondDaemon:
    """Another daemon is started for the same autopilot; ``shared``: with the same store too."""

    shared: bool


@dataclass(frozen=True, slots=True)
class Disk:
    """The disk of the daemon's store is full, or has room again (`Fault.own_disk` gives it one)."""

    full: bool


@dataclass(frozen=True, slots=True)
class WallClock:
    """The computer's wall clock is off by this time from now on, seconds."""

    step_s: float


@dataclass(frozen=True, slots=True)
class HalfRequests:
    """``count`` connections to the web server, each with half a request."""

    count: int


@dataclass(frozen=True, slots=True)
class Flood:
    """A viewer sends a command as fast as it can."""

    command: Command
    count: int


Act = (
    Link
    | Drone
    | Forge
    | Station
    | Signal
    | StartAgain
    | CountAgain
    | Survey
    | Order
    | KillMotors
    | Leave
    | Return
    | Hide
    | KnowLot
    | ChangeLot
    | TakePlan
    | Bring
    | SecondDaemon
    | Disk
    | WallClock
    | HalfRequests
    | Flood
)


# -- what is seen ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Moment:
    """Everything that can be seen at a moment.

    ``beat`` is the last heartbeat, None while none came since the daemon's last start; ``truth`` is the simulator's
    account of the drone. Since the fault began: ``log`` the daemon's messages, ``exits`` its exit statuses, ``starts``
    its starts, ``sent`` counts of messages to the autopilot by kind, ``answers`` to orders (None: accepted, else the
    reason). ``before`` is the truth when the fault began, or at the last `CountAgain`. ``second``: exit
    status (None: it runs) and output of a second daemon. ``survey``: the measures of the survey that has ended
    (`hawk.survey.report.compare`, and ``status``).
    """

    beat: Heartbeat | None
    truth: Mapping[str, Any]
    log: tuple[LogEntry, ...]
    exits: tuple[int, ...]
    starts: int
    sent: Mapping[str, int]
    answers: tuple[str | None, ...]
    survey: Mapping[str, float] = field(default_factory=dict)
    before: Mapping[str, Any] = field(default_factory=dict)
    second: tuple[int | None, str] | None = None


@dataclass(frozen=True, slots=True)
class Sight:
    """Something to see, in words, and the test of it."""

    words: str
    test: Callable[[Moment], bool]


def state(*names: StateName) -> Sight:
    """The daemon shows one of these states."""
    words = " or ".join(names)
    return Sight(words, lambda m: m.beat is not None and m.beat.state in names)


def mode(*names: str) -> Sight:
    """The autopilot is in one of these modes."""
    return Sight(f"mode {' or '.join(names)}", lambda m: m.truth["mode"] in names)


def reported(text: str) -> Sight:
    """A message or the state's detail contains the text."""

    def test(moment: Moment) -> bool:
        beat = moment.beat
        lines = [f"{entry.text} {entry.details}" for entry in moment.log]
        return any(text in line for line in lines) or (beat is not None and text in beat.detail)

    return Sight(f"“{text}”", test)


def unhealthy(part: str, text: str = "") -> Sight:
    """A part is unhealthy; its reason contains the text."""

    def test(moment: Moment) -> bool:
        return moment.beat is not None and any(
            item.name == part and not item.healthy and text in item.reason for item in moment.beat.health
        )

    return Sight(f"{part} unhealthy" + (f", “{text}”" if text else ""), test)


def healthy(part: str) -> Sight:
    """A part is healthy."""

    def test(moment: Moment) -> bool:
        return moment.beat is not None and any(item.name == part and item.healthy for item in moment.beat.health)

    return Sight(f"{part} healthy", test)


def check_fails(name: str) -> Sight:
    """A preflight check has not passed."""

    def test(moment: Moment) -> bool:
        return moment.beat is not None and any(item.name == name and not item.passed for item in moment.beat.checks)

    return Sight(f"check {name} fails", test)


def refused(text: str = "") -> Sight:
    """The last order was refused."""
    return Sight(
        "refused" + (f", “{text}”" if text else ""),
        lambda m: bool(m.answers) and m.answers[-1] is not None and text in m.answers[-1],
    )


def sent(kind: str, count: int = 1) -> Sight:
    """The daemon sent messages of a kind to the autopilot since the fault began."""
    return Sight(f"{kind} sent", lambda m: m.sent.get(kind, 0) >= count)


def asked(command: int, words: str) -> Sight:
    """The daemon sent the autopilot a command of this number (MAV_CMD)."""
    return Sight(words, lambda m: m.sent.get(f"COMMAND {command}", 0) > 0)


def surveyed(recall: float, precision: float) -> Sight:
    """The survey ended well, with at least this recall and precision of its stalls."""

    def test(moment: Moment) -> bool:
        found = moment.survey
        done = bool(found) and found["status"] == 0
        return done and found["stall_recall"] >= recall and found["stall_precision"] >= precision

    return Sight(f"whole lot surveyed, recall ≥ {recall:g}, precision ≥ {precision:g}", test)


def stayed_within(metres: float) -> Sight:
    """The drone was never farther outside the daemon's fence than that, since the fault began."""
    return Sight(f"never over {metres:g} m outside", lambda m: m.truth["farthest_outside"] <= metres)


def lower_than(height: float) -> Sight:
    """The drone is lower than that, metres."""
    return Sight(f"below {height:g} m", lambda m: m.truth["position"]["height"] < height)


def near_home(metres: float) -> Sight:
    """The real vehicle is within that distance of home, seen from above."""
    return Sight(f"within {metres:g} m of home", lambda m: m.truth["from_home"] <= metres)


def restarted(times: int = 1) -> Sight:
    """The daemon was started again and shows itself."""
    return Sight("the daemon runs again", lambda m: m.starts >= times and m.beat is not None)


def exited(status: int) -> Sight:
    """The daemon ended with this status."""
    return Sight(f"exit status {status}", lambda m: bool(m.exits) and m.exits[0] == status)


def both(*sights: Sight) -> Sight:
    """All of these at once."""
    return Sight(", ".join(sight.words for sight in sights), lambda m: all(sight.test(m) for sight in sights))


def either(*sights: Sight) -> Sight:
    """At least one of these."""
    return Sight(" or ".join(sight.words for sight in sights), lambda m: any(sight.test(m) for sight in sights))


def absent(sight: Sight) -> Sight:
    """The contrary."""
    return Sight(f"not: {sight.words}", lambda m: not sight.test(m))


ACCEPTED = Sight("accepted", lambda m: bool(m.answers) and m.answers[-1] is None)
_STEERING: tuple[str, ...] = (
    "SET_MODE",
    "SET_POSITION_TARGET_LOCAL_NED",
    "SET_POSITION_TARGET_GLOBAL_INT",
    *(f"COMMAND {number}" for number in (20, 21, 22, 176, 192, 252, 400)),
)
"""Messages by which a ground station steers; of the commands: NAV_RETURN_TO_LAUNCH, NAV_LAND, NAV_TAKEOFF, DO_SET_MODE,
DO_REPOSITION, OVERRIDE_GOTO, COMPONENT_ARM_DISARM."""
SILENT = Sight("nothing commanded", lambda m: not any(m.sent.get(kind, 0) for kind in _STEERING))
COMMANDED = Sight("a command of ours", lambda m: any(m.sent.get(kind, 0) for kind in _STEERING))
INSIDE = Sight("inside the fence", lambda m: m.truth["outside"] <= 0.0)
FELL = Sight("on the ground, motors off", lambda m: bool(m.truth["disarmed"]) and m.truth["position"]["height"] < 1.0)
DOWN = Sight("landed, motors off", lambda m: bool(m.truth["landed"] and m.truth["disarmed"]))
MOTORS_OFF = Sight("motors off", lambda m: bool(m.truth["disarmed"]))
UP = Sight("in the air", lambda m: not m.truth["landed"] and not m.truth["disarmed"])


@dataclass(frozen=True, slots=True)
class See:
    """The sight must come within ``within_s`` seconds of the drone's clock; ``lasts``: it must last for that time.

    ``real``: the seconds are real, because another program's timer or start decides, which no speed hastens.
    """

    sight: Sight
    within_s: float
    lasts: bool = False
    real: bool = False

    @property
    def words(self) -> str:
        """The sight and its time."""
        return f"{self.sight.words} ({'for' if self.lasts else '≤'} {self.within_s:g} s)"

    def words_with(self, seconds: float | None) -> str:
        """Return the sight with the seconds until it was seen, and its limit; None: it was not seen."""
        if self.lasts or seconds is None:
            return self.words
        return f"{self.sight.words}: {seconds:g} of {self.within_s:g} s"


class Subject(StrEnum):
    """Parts of the drone, the titles of docs/faults.md in their order."""

    LINK = "Link to the autopilot"
    POSITION = "Position, height, heading"
    BATTERY = "Battery"
    CAMERA = "Camera"
    PILOT = "Pilot and operators"
    STATIONS = "Other ground stations"
    PEOPLE = "People"
    PROGRAM = "Program and computer"


@dataclass(frozen=True, slots=True)
class Answer:
    """A row of docs/faults.md, below the title ``subject``; faults with equal ones share it.

    ``drone`` is what the drone does; ``{WORDS}`` in it stands for the seconds until a sight with these words (a pattern
    as of file names), the least and the greatest. ``you``: what the operator sees and does.
    """

    subject: Subject
    fault: str
    drone: str
    you: str


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault. ``steps``: acts and what must be seen after them, in order; each time counts from the last act.

    ``answer``: its row of docs/faults.md; None: a fault of a real ArduCopter, which that page has not.

    ``ends_flight``: daemon and drone start again afterwards (otherwise the next fault goes on in the same flight).
    ``falls``: motors off in the air are its end. ``own_disk``: the store lies on a small disk of its own.
    """

    name: str
    when: When
    steps: Sequence[Act | See]
    ends_flight: bool = False
    falls: bool = False
    own_disk: bool = False
    answer: Answer | None = None


def dropped(direction: Direction, *kinds: str, share: float = 1.0) -> Rule:
    """Return the rule that loses such messages; no kind: every one."""
    return Rule(direction, frozenset(kinds), drop=True, share=share)


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of a fault: seconds until each sight, and the problems in words (none: it ended as it must)."""

    fault: Fault
    seconds: tuple[float, ...] = ()
    problems: tuple[str, ...] = ()
    kept: tuple[str, ...] = field(default=())
    """Possessions of the daemon that are as they were."""
    figures: tuple[str, ...] = field(default=())
    """Other measurements, in words."""

    @property
    def passed(self) -> bool:
        """True when the fault ended as it must."""
        return not self.problems
