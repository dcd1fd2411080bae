"""The table of states and events, made by the program itself: each event is put to the decider in each state.

`python -m tests.unit.ddc.state_table` writes docs/states.md.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal, Self, cast

from hawk.comm.autopilot.terrain import Terrain
from hawk.comm.protocol.commands import Ack, Command, Kill, KillToken
from hawk.ddc.acts import Acts, Ask, CutMotors, Desire, ReadParameter
from hawk.ddc.battery.energy import Reserve
from hawk.ddc.decider import Decider, Decision
from hawk.ddc.facts import Answer, Facts
from hawk.ddc.orders import (
    ConfigureOrder,
    MoveOrder,
    ToArm,
    ToCommunicationLost,
    ToConfigure,
    ToExplore,
    ToHover,
    ToIdle,
    ToLand,
    ToManual,
    ToMove,
    ToReturn,
    ToTakeoff,
    Transition,
)
from hawk.ddc.readings.clearance import BelowFacts
from hawk.ddc.readings.home import HomeFacts
from hawk.ddc.readings.link import VehicleEvent
from hawk.ddc.readings.wind import Wind, WindFacts
from hawk.ddc.rules.kill import KillTokens
from hawk.model.operation import StateName
from hawk.model.plans import DesiredPose, ExploreStatus, HeightParameters, Inbound, PathPlan, Route, Verdict
from hawk.model.poses import MapPoint
from hawk.model.vehicle import CopterMode, LandedState
from tests.unit.ddc.fakes import SAFE_PARAMETERS
from tests.unit.ddc.rules.test_judge_commands_in_every_state import COMMANDS
from tests.unit.ddc.written_facts import SETTINGS, flying, follow, found, of_kind, on_ground, pose, without_link

DOCUMENT = Path(__file__).parents[3] / "docs" / "states.md"
BEGAN = 0.0
LATER = 1.0
"""Time of the event, seconds after the state began."""
SETTLED_S = 10.0
"""The program ran this long before the state began: it has read the parameters."""
TICK_S = 1.0
"""Of those ten seconds; a second holds time enough for every reading."""
_ROUTE = Route((MapPoint(0.0, 0.0), MapPoint(40.0, 0.0)), (0.0, 0.0))
_MOVE = MoveOrder(MapPoint(40.0, 0.0), 30.0, 0.0, False, 0)
_LOT_MOVE = replace(_MOVE, autonomous=True, number=3, route=_ROUTE)


def armed_on_ground(facts: Facts) -> Facts:
    """Return facts of a drone that stands with its motors on."""
    vehicle = replace(facts.vehicle, armed=True, landed=LandedState.ON_GROUND)
    return _at(0.0, 0.0)(replace(facts, vehicle=vehicle))


def _as_it_is(facts: Facts) -> Facts:
    return facts


def _without_operator(facts: Facts) -> Facts:
    return replace(facts, operator=replace(facts.operator, is_present=False))


def _hidden(facts: Facts) -> Facts:
    return replace(facts, operator=replace(facts.operator, is_present=True, hidden_s=60.0))


def _with_operator(facts: Facts) -> Facts:
    return replace(facts, operator=replace(facts.operator, is_present=True))


@dataclass(frozen=True)
class Column:
    """A state: its short name, the transition into it, and a drone as it is in that state."""

    name: str
    identity: StateName
    transition: Transition
    standing: Callable[[Facts], Facts] = _as_it_is
    mode: CopterMode = CopterMode.GUIDED

    def facts(self, now: float) -> Facts:
        """Return facts in which all is well in this state."""
        facts = flying(now, self.mode)
        home = HomeFacts(place=facts.position.datum, age=0.1, away=0.0)
        return self.standing(replace(facts, position=replace(facts.position, autopilot_home=home)))


class Program:
    """A decider in a state, and the requests that it made: none is answered unless an event says so."""

    def __init__(self, column: Column) -> None:
        self._column = column
        self._decider = Decider(SETTINGS, KillTokens(), BEGAN - SETTLED_S)
        self._asked: list[Ask] = []
        """Requests that the event answers."""
        self._read: list[Answer] = []
        """Answers to the reads of parameters, which come at any time."""
        self._desired: DesiredPose | None = None
        for tick in range(round(SETTLED_S / TICK_S)):
            self.tick(BEGAN - SETTLED_S + TICK_S * tick, Event("", "", found if tick == 0 else _as_it_is))
        self._keep(follow(self._decider, column.facts(BEGAN), column.transition).acts)

    @classmethod
    def begun(cls, column: Column) -> Self:
        """Return a copy of a program that settled and began this state: it does so once."""
        made: Self = _begun(cast("Hashable", cls), column)
        return deepcopy(made, {id(each): each for each in (SETTINGS, column, *made._asked, *made._read)})

    @property
    def state(self) -> StateName:
        """The active state."""
        return self._decider.state.identity

    def facts(self, now: float, event: Event) -> Facts:
        """Return the facts of an event."""
        facts = _judged(self._column.facts(now), self._desired)
        ended = (Answer(ask.name, ask.at, event.answers, "Not now.") for ask in self._asked)
        return event.change(replace(facts, answers=(*self._read, *ended)))

    def tick(self, now: float, event: Event) -> None:
        """Run one tick with the facts of an event."""
        self._keep(self._decider.tick(self.facts(now, event)).acts)

    def command(self, event: Event, command: Command) -> Decision:
        """Put a command."""
        decision = self._decider.command(self.facts(LATER, event), "ana", command)
        self._keep(decision.acts)
        return decision

    def _keep(self, acts: Acts) -> None:
        for act in acts:
            match act:
                case Ask(ReadParameter(name)):
                    self._read.append(_parameter(act, name))
                case Ask():
                    self._asked.append(act)
                case Desire():
                    self._desired = act.pose


@cache
def _begun(kind: Any, column: Column) -> Any:
    return kind(column)


def _judged(facts: Facts, desired: DesiredPose | None) -> Facts:
    """Return facts in which the planner found the desired place inside the lot, with a straight route there."""
    if desired is None or facts.place is None:
        return facts
    route = Route((facts.place.point, MapPoint(desired.north, desired.east)), (0.0, 0.0))
    verdict = Verdict(desired.number, Inbound.INSIDE, route)
    sight = replace(facts.sight, desired=desired, desired_count=desired.number, verdict=verdict)
    return replace(facts, sight=sight)


def _parameter(ask: Ask, name: str) -> Answer:
    """Return the answer to a read: all parameters that the autopilot has are safe."""
    if name in SAFE_PARAMETERS:
        return Answer(ask.name, ask.at, "done", value=SAFE_PARAMETERS[name])
    return Answer(ask.name, ask.at, "failed", f"{name}: no answer")


S = StateName
COLUMNS = (
    Column("Idle", S.IDLE, ToIdle(), on_ground),
    Column("Configure", S.CONFIGURE, ToConfigure(ConfigureOrder(HeightParameters())), on_ground),
    Column("Arming", S.ARM, ToArm(), on_ground),
    Column("Armed", S.ARM, ToArm(armed=True), armed_on_ground),
    Column("Takeoff", S.TAKEOFF, ToTakeoff()),
    Column("Hover", S.HOVER, ToHover()),
    Column("Explore", S.AUTONOMOUS_EXPLORE, ToExplore()),
    Column("A. Move", S.AUTONOMOUS_MOVE, ToMove(_LOT_MOVE)),
    Column("C. Move", S.COMPULSIVE_MOVE, ToMove(_MOVE)),
    Column("RTL", S.RETURN_TO_LAUNCH, ToReturn(), mode=CopterMode.RTL),
    Column("Land", S.LAND, ToLand(), mode=CopterMode.LAND),
    Column("Lost", S.COMMUNICATION_LOST, ToCommunicationLost(), _without_operator),
    Column("Manual", S.MANUAL, ToManual(), mode=CopterMode.LOITER),
)


@dataclass(frozen=True)
class Event:
    """Something that happens: facts of its moment, made of facts in which all is well; or a command."""

    group: str
    name: str
    change: Callable[[Facts], Facts] = _as_it_is
    command: Command | None = None
    steps: tuple[float, ...] = (LATER,)
    """Moments of the ticks, seconds."""
    answers: Literal["pending", "done", "failed"] = "pending"
    """Answer to the requests of the state."""


def _events(*events: VehicleEvent) -> Callable[[Facts], Facts]:
    return lambda facts: replace(facts, link=replace(facts.link, events=events))


def _mode(mode: CopterMode) -> Callable[[Facts], Facts]:
    """Return the change of an armed drone to a mode that nobody here asked for."""

    def change(facts: Facts) -> Facts:
        vehicle = replace(facts.vehicle, armed=True, custom_mode=int(mode))
        return _events(VehicleEvent.FOREIGN_MODE)(replace(facts, vehicle=vehicle))

    return change


def _armed(facts: Facts) -> Facts:
    return replace(facts, vehicle=replace(facts.vehicle, armed=True))


def _disarmed(facts: Facts) -> Facts:
    return replace(facts, vehicle=replace(facts.vehicle, armed=False))


def _landed(state: LandedState) -> Callable[[Facts], Facts]:
    return lambda facts: replace(facts, vehicle=replace(facts.vehicle, landed=state))


def _position(**values: float) -> Callable[[Facts], Facts]:
    return lambda facts: replace(facts, position=replace(facts.position, **values))  # type: ignore[arg-type]


def _reserve(facts: Facts) -> Facts:
    return replace(facts, battery=replace(facts.battery, reserve=Reserve(30.0, 31.0, 0.0), reached_s=3.0))


def _charge_unknown(facts: Facts) -> Facts:
    return replace(facts, battery=replace(facts.battery, info=None, unknown_s=30.0))


def _too_close(facts: Facts) -> Facts:
    below = BelowFacts(Terrain(facts.now, 3.0, 0.0, 50.0), 0.5, 3.0)
    return replace(facts, position=replace(facts.position, below=below))


def _strong_wind(facts: Facts) -> Facts:
    return replace(facts, wind=WindFacts(Wind(-11.0, 0.0), 10.0))


def _breach(seconds: float) -> Callable[[Facts], Facts]:
    return lambda facts: replace(facts, limits=replace(facts.limits, breached_s=seconds))


def _vision_failed(facts: Facts) -> Facts:
    return replace(facts, sight=replace(facts.sight, fault="Vision: no answer.", fault_s=1.0))


def _lot_lost(facts: Facts) -> Facts:
    return replace(facts, sight=replace(facts.sight, lot=None))


def _at(north: float, height: float) -> Callable[[Facts], Facts]:
    return lambda facts: replace(facts, position=replace(facts.position, pose=pose(facts.now, north, 0.0, height)))


def _explored(facts: Facts) -> Facts:
    plan = PathPlan(explore=ExploreStatus(done=True, seen=1.0))
    return replace(facts, sight=replace(facts.sight, plan=plan, plan_time=facts.now))


def _commands() -> Iterable[Event]:
    return (Event("Command", name, command=command) for name, command in COMMANDS.items())


EVENTS: tuple[Event, ...] = (
    *_commands(),
    Event("Command", "Kill with its token", command=Kill(token="x" * 16)),
    Event("Autopilot", "All is well", steps=(0.05, LATER)),
    Event("Autopilot", "Grants each request", steps=(LATER, LATER + 0.05), answers="done"),
    Event("Autopilot", "Refuses each request", steps=(LATER, LATER + 0.05), answers="failed"),
    Event("Autopilot", "Answers no request for 60 s", steps=tuple(0.5 * tick for tick in range(2, 122))),
    Event("Autopilot", "Disarmed", _disarmed),
    Event("Autopilot", "Armed by another station", _armed),
    Event("Autopilot", "Landed, motors on", armed_on_ground),
    Event("Autopilot", "In the air", lambda facts: _armed(_landed(LandedState.IN_AIR)(facts))),
    Event("Autopilot", "Landed state unknown", _landed(LandedState.UNDEFINED)),
    *(
        Event("Autopilot", f"Mode changed to {mode.name}", _mode(mode))
        for mode in (
            CopterMode.RTL,
            CopterMode.SMART_RTL,
            CopterMode.LAND,
            CopterMode.BRAKE,
            CopterMode.GUIDED,
            CopterMode.LOITER,
        )
    ),
    Event("Autopilot", "No word from the autopilot", lambda f: without_link(_events(VehicleEvent.LINK_LOST)(f))),
    Event("Autopilot", "No word for 30 s", without_link, steps=tuple(0.5 * tick for tick in range(2, 63))),
    Event("Autopilot", "Heard again", _events(VehicleEvent.LINK_BACK)),
    Event("Autopilot", "Found by a program that just began", _events(VehicleEvent.FOUND)),
    Event("Position", "Jumped by 5 m", _position(jump_m=5.0)),
    Event("Position", "Not trusted by the autopilot for 2 s", _position(distrusted_s=2.0)),
    Event("Position", "Pose older than 1 s", _position(age=1.1)),
    Event("Battery", "Needed for the return for 3 s", _reserve),
    Event("Battery", "Charge not known for 30 s", _charge_unknown),
    Event("Wind", "Above the limit for 10 s", _strong_wind),
    Event("Clearance", "Too close to what is below, for 0.5 s", _too_close),
    Event("Fence", "Drone outside", _breach(0.0)),
    Event("Fence", "Drone outside for 10 s", _breach(10.0)),
    Event("Operator", "Is back", _with_operator),
    Event("Operator", "Lost", _without_operator),
    Event("Operator", "Page hidden for 31 s", _hidden, steps=(31.0, 31.05)),
    Event("Operator", "Lost for 31 s", _without_operator, steps=tuple(0.5 * tick for tick in range(2, 65))),
    Event("Task", "Climbed to the desired height", _at(0.0, 35.0)),
    Event("Task", "At the place of the Move", _at(40.0, 30.0)),
    Event("Task", "Nothing left to explore", _explored),
    Event("Task", "No progress for 15 s", steps=tuple(0.5 * tick for tick in range(2, 32))),
    Event("Sight", "Vision fails for 1 s", _vision_failed),
    Event("Sight", "No lot in sight for 11 s", _lot_lost, steps=tuple(0.5 * tick for tick in range(2, 24))),
)


def outcome(column: Column, event: Event) -> str:
    """Return the result of an event in a state: a state, "stays", or the refusal of a command in its own words."""
    program = Program.begun(column)
    answer = _refusal(program, event)
    if answer:
        return f"refused: {answer}"
    for moment in event.steps:
        program.tick(moment, event)
    return "stays" if program.state is column.identity else program.state.value


def _refusal(program: Program, event: Event) -> str:
    """Put the event's command to the program; return the reason of a refusal, empty when it was accepted."""
    if event.command is None:
        return ""
    command = event.command
    if isinstance(command, Kill):
        token = program.command(event, COMMANDS["Kill Request"]).answer
        assert isinstance(token, KillToken)
        command = Kill(token=token.token)
    decision = program.command(event, command)
    if isinstance(command, Kill):
        assert CutMotors() in [act.request for act in of_kind(decision.acts, Ask) if isinstance(act, Ask)]
    answer = decision.answer
    return answer.reason if isinstance(answer, Ack) and not answer.accepted else ""


Outcomes = dict[tuple[str, str], dict[str, str]]
"""(group, event) -> state -> outcome."""


def table() -> Outcomes:
    """Return the outcomes of every pair."""
    return {(event.group, event.name): {c.name: outcome(c, event) for c in COLUMNS} for event in EVENTS}


def document(outcomes: Outcomes) -> str:
    """Return docs/states.md."""
    reasons: list[str] = []
    head = ["| | " + " | ".join(column.name for column in COLUMNS) + " |", "|---" * (len(COLUMNS) + 1) + "|"]
    commands: dict[tuple[str, ...], list[str]] = {}
    events: dict[tuple[str, ...], list[str]] = {}
    for (group, name), cells in outcomes.items():
        shown = tuple(_cell(cells[column.name], reasons) for column in COLUMNS)
        rows, words = (commands, name) if group == "Command" else (events, f"{group}: {name[0].lower()}{name[1:]}")
        rows.setdefault(shown, []).append(words)
    refusals = [f"{number}. {reason}" for number, reason in enumerate(reasons, start=1)]
    parts = [
        "## Commands",
        "",
        *head,
        *_lines(commands),
        "",
        *refusals,
        "",
        "## Events",
        "",
        *_items(events),
        "",
    ]
    return "\n".join([_HEAD, *parts])


def _items(rows: dict[tuple[str, ...], list[str]]) -> Iterator[str]:
    """Yield an item of a list for each row: the states by the one that follows; one that stays is not named."""
    for cells, names in rows.items():
        leading: dict[str, list[str]] = {}
        for column, cell in zip(COLUMNS, cells, strict=True):
            if cell:
                leading.setdefault(cell, []).append(column.name)
        every = [f"{', '.join(_grouped(states))} → {cell}" for cell, states in leading.items()]
        yield f"- {'; '.join(names)}: {'; '.join(every) or 'nothing'}"


def _grouped(states: list[str]) -> list[str]:
    """Return names of states, one name for a group of which all are there."""
    found = states
    for name, members in _GROUPS.items():
        if set(members) <= set(states):
            found = [name if state == members[0] else state for state in found if state not in members[1:]]
    return found


def _lines(rows: dict[tuple[str, ...], list[str]]) -> list[str]:
    """Return a line of a table for each row: what leads to the same in every state stands in one."""
    return [f"| {'; '.join(names)} | {' | '.join(cells)} |" for cells, names in rows.items()]


def _cell(text: str, reasons: list[str]) -> str:
    if text == "stays":
        return ""
    if not text.startswith("refused: "):
        return f"**{_SHORT.get(text, text)}**"
    reason = text.removeprefix("refused: ")
    if reason not in reasons:
        reasons.append(reason)
    return str(reasons.index(reason) + 1)


_SHORT = {column.identity.value: column.name for column in COLUMNS if column.identity is not S.ARM}
"""Names of states as the columns have them."""
_GROUPS = {
    "on the ground": ("Idle", "Configure", "Arming", "Armed"),
    "tasks": ("Explore", "A. Move", "C. Move"),
}
"""Names of several states at once, in the list of events."""
_HEAD = """# States and events

`.venv/bin/python -m tests.unit.ddc.state_table` puts each event to the decider in each state and writes this page; a
test compares the two. One event happens to a drone on which all is well. The cell, and the word behind an arrow, is the
state that follows; a state that stays is empty, or not named. A number: the command is refused, with that reason below
its table. The operator in control gives the commands. "Lost" is CommunicationLost, in which the operator is away; "RTL"
is Return To Launch. **On the ground** are Idle, Configure, Arming and Armed, **tasks** Explore and both Moves.
"""

if __name__ == "__main__":
    DOCUMENT.write_text(document(table()))
