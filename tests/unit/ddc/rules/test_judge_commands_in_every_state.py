"""Every pair of state and command: taken, or refused with its reason and without any effect.

Facts stand written down here, not read from the table of commands: a reason that changes there is noticed.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest

from hawk.comm.protocol.command_table import COMMAND_TABLE
from hawk.comm.protocol.commands import (
    Ack,
    Arm,
    AutonomousExplore,
    AutonomousMove,
    Command,
    CompulsiveMove,
    Configure,
    Disarm,
    Hold,
    Kill,
    KillRequest,
    KillToken,
    Land,
    Resume,
    ReturnToLaunch,
    SetFailsafes,
    SetFence,
    SetOutline,
)
from hawk.comm.protocol.heartbeat import FenceCorner
from hawk.model.operation import StateName
from hawk.model.vehicle import LandedState
from tests.sweep import sweep
from tests.unit.ddc.fakes import PLACE, Rig

FENCE = [
    FenceCorner(latitude=PLACE.latitude + north, longitude=PLACE.longitude + east)
    for north, east in ((-1e-3, -1e-3), (1e-3, -1e-3), (1e-3, 1e-3), (-1e-3, 1e-3))
]
HERE: dict[str, Command] = {
    "Configure": Configure(min=10, des=20, max=30),
    "Autonomous Move": AutonomousMove(x=5, y=5),
    "Compulsive Move": CompulsiveMove(x=5, y=5),
    "Return To Launch": ReturnToLaunch(confirmed=True),
    "Set Fence": SetFence(corners=FENCE, ceiling=80),
    "Set Outline": SetOutline(polygons=[FENCE]),
}
"""Commands whose content must suit the place, in place of the table's examples."""
COMMANDS = {kind: HERE.get(kind, row.example) for kind, row in COMMAND_TABLE.items() if row.states and kind != "Kill"}
"""Kill itself, which needs a token, has a test of its own."""

TASKS = {StateName.AUTONOMOUS_EXPLORE, StateName.AUTONOMOUS_MOVE, StateName.COMPULSIVE_MOVE}
HOMING = {StateName.RETURN_TO_LAUNCH, StateName.LAND}

COLUMNS = (
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
ANSWERS = """
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
Disarm             | off!   off!      yes    air     air   air     air    air    air    falls  air  pilot
Resume             | ours   ours      ours   ours    ours  ours    ours   ours   ours   ours   ours yes
Kill Request       | yes    yes       yes    yes     yes   yes     yes    yes    yes    yes    yes  yes
Clear Kill         | uncut  saving    disarm air     air   air     air    air    air    air    air  pilot
Set Failsafes      | yes    saving    before before  before before before before before before before pilot
Set Fence          | yes    saving    disarm land    land  land    land   land   land   land   land pilot
Clear Fence        | undrawn saving   disarm land    land  land    land   land   land   land   land pilot
Set Outline        | yes    saving    yes    yes     yes   explores yes   yes    yes    yes    lost pilot
Clear Outline      | unset  saving    unset  unset   unset explores unset unset  unset  unset  lost pilot
Survey Again       | no-lot saving    no-lot no-lot  no-lot explores no-lot no-lot no-lot no-lot lost pilot
Fly Plan           | newest newest    newest newest  newest newest newest newest newest newest lost pilot
New Survey         | empty  saving    disarm land    land  land    land   land   land   land   land pilot
"""
"""Answer to each command in each state of a drone on which all is well: "yes", or a word of `REASONS`."""

REASONS = {
    "saving": "Saving: wait a moment.",
    "disarm": "Armed: disarm first.",
    "land": "Flying: land first.",
    "flying": "Already flying.",
    "armed": "Already armed, or arming.",
    "arm": "Arm first.",
    "off": "Take off first.",
    "climbs": "Climbing: wait until it holds.",
    "running": "Already exploring.",
    "moving": "Moving: Hold first.",
    "homing": "Returning home: Hold first.",
    "landing": "Landing: Hold first.",
    "homing!": "Already returning home.",
    "landing!": "Already landing.",
    "lost": "The operator was lost: wait until it holds for you.",
    "holds": "Holding already, until the operator is back.",
    "pilot": "Someone else flies: Resume first.",
    "ground": "On the ground.",
    "home": "Is at home.",
    "air": "In the air: land first.",
    "falls": "In the air: wait until it is on the ground.",
    "off!": "The motors are off.",
    "ours": "Nobody else flies.",
    "explores": "Exploring: Hold first.",
    "before": "Only before flight, disarmed.",
    "uncut": "The motors were not cut.",
    "undrawn": "No fence is drawn: the standard one is used.",
    "unset": "No outline is set.",
    "no-lot": "Lots: no lot has this id: open the list of lots, then choose one.",
    "newest": "No such changed plan waits: look at the newest one.",
    "empty": "The map is empty: the next flight begins it.",
}


def read_answers() -> dict[str, dict[StateName, str]]:
    """Return type of the command -> state -> reason of the refusal, empty where it is accepted."""
    found = {}
    for line in ANSWERS.strip().splitlines()[1:]:
        name, _, words = line.partition("|")
        reasons = ["" if word == "yes" else REASONS[word] for word in words.split()]
        found[name.strip()] = dict(zip(COLUMNS, reasons, strict=True))
    return found


ANSWER = read_answers()
ACCEPTED = {name: {state for state, reason in row.items() if not reason} for name, row in ANSWER.items()}

LEADS_TO: dict[str, StateName] = {
    "Configure": StateName.CONFIGURE,
    "Arm": StateName.ARM,
    "Takeoff": StateName.TAKEOFF,
    "Autonomous Explore": StateName.AUTONOMOUS_EXPLORE,
    "Autonomous Move": StateName.AUTONOMOUS_MOVE,
    "Compulsive Move": StateName.COMPULSIVE_MOVE,
    "Hold": StateName.HOVER,
    "Return To Launch": StateName.RETURN_TO_LAUNCH,
    "Land": StateName.LAND,
    "Resume": StateName.HOVER,
    "Set Fence": StateName.CONFIGURE,
}


def test_every_command_is_tried_in_every_state() -> None:
    assert set(ANSWER) == set(COMMANDS)
    assert set(COLUMNS) == set(StateName)


@pytest.mark.slow
@sweep("state, name", [(state, name) for name, states in ACCEPTED.items() for state in states])
async def test_what_a_state_accepts_is_done(state: StateName, name: str, tmp_path: Path) -> None:
    rig = Rig(Path(tempfile.mkdtemp(dir=tmp_path)))  # what a case before this one has set is not kept
    await rig.enter(state)
    answer = rig.manager.handle("ana", COMMANDS[name])
    await rig.tick()  # the planner's word on an Autonomous Move
    accepted = rig.socket.replies[-1][1] if answer is None else answer
    assert isinstance(accepted, KillToken) or (isinstance(accepted, Ack) and accepted.accepted)
    rig.expect(LEADS_TO.get(name, state))
    await rig.close()


@sweep("state", StateName)
@pytest.mark.nightly
async def test_what_a_state_refuses_changes_nothing_and_says_why(state: StateName, tmp_path: Path) -> None:
    rig = Rig(Path(tempfile.mkdtemp(dir=tmp_path)))  # what a case before this one has set is not kept
    await rig.enter(state)
    calls = len(rig.autopilot.calls)
    possible = {option.command: option for option in rig.manager.options()}
    refused = {name: reasons[state] for name, reasons in ANSWER.items() if reasons[state]}
    answers = {name: rig.manager.handle("ana", COMMANDS[name]) for name in refused}
    assert all(isinstance(answer, Ack) and not answer.accepted for answer in answers.values()), answers
    assert {name: answer.reason for name, answer in answers.items() if isinstance(answer, Ack)} == refused
    # of which lot it is, the offer knows nothing
    offered = {name: reason for name, reason in refused.items() if reason != REASONS["no-lot"]}
    assert not any(possible[name].possible for name in offered)
    assert {name: possible[name].reason for name in offered} == offered
    rig.expect(state)
    assert len(rig.autopilot.calls) == calls
    await rig.close()


@pytest.mark.parametrize("state", StateName)
async def test_what_is_offered_is_what_is_taken(fresh: Rig, state: StateName) -> None:
    await fresh.enter(state)
    offered = {option.command for option in fresh.manager.options() if option.possible}
    assert offered - {"Kill", "Survey Again"} == {name for name, states in ACCEPTED.items() if state in states}


@pytest.mark.parametrize("state", StateName)
async def test_kill_is_taken_in_every_state(fresh: Rig, state: StateName) -> None:
    await fresh.enter(state)
    token = fresh.manager.handle_now("ana", KillRequest())
    assert isinstance(token, KillToken)
    answer = fresh.manager.handle_now("ana", Kill(token=token.token))
    assert isinstance(answer, Ack)
    assert answer.accepted
    await fresh.run(1.2)
    assert fresh.autopilot.count("kill") >= 1
    assert not fresh.autopilot.armed
    fresh.expect(StateName.IDLE)


async def test_disarm_is_taken_in_land_on_the_ground_only(fresh: Rig) -> None:
    await fresh.enter(StateName.LAND)
    fresh.autopilot.stuck = True
    assert not fresh.command(Disarm()).accepted
    fresh.autopilot.landed = LandedState.ON_GROUND
    await fresh.tick()
    assert not fresh.command(Disarm()).accepted, "its height is 30 m"
    fresh.autopilot.height = 0.0
    await fresh.tick(2)
    fresh.order(Disarm())
    await fresh.tick(2)
    fresh.expect(StateName.IDLE)


@pytest.mark.parametrize("command", [Resume(), ReturnToLaunch(), Land()], ids=lambda c: c.type)
async def test_manual_needs_a_confirmation(fresh: Rig, command: Command) -> None:
    await fresh.enter(StateName.MANUAL)
    answer = fresh.command(command)
    assert not answer.accepted
    assert answer.reason.startswith("Confirmed: ")
    fresh.expect(StateName.MANUAL)


async def test_resume_waits_for_the_pilots_hand_to_leave_the_switch(fresh: Rig) -> None:
    await fresh.enter(StateName.MANUAL)
    fresh.autopilot.change_mode(2)
    await fresh.run(2.9)
    assert "mode changed" in fresh.command(Resume(confirmed=True)).reason
    await fresh.run(0.2)
    fresh.order(Resume(confirmed=True))
    await fresh.tick(2)
    fresh.expect(StateName.HOVER)
    assert fresh.autopilot.mode == 4


# -- control ----------------------------------------------------------------------------------------------------------


@sweep("name", sorted(set(COMMANDS) - {"Hold"}))
async def test_commands_of_someone_without_control_are_refused(rig: Rig, name: str) -> None:
    answer = rig.command(COMMANDS[name], client="eve")
    assert not answer.accepted
    assert answer.reason == "Someone else has control."


@pytest.mark.parametrize("state", [StateName.TAKEOFF, StateName.HOVER, *sorted(TASKS)])
async def test_anyone_may_hold(fresh: Rig, state: StateName) -> None:
    await fresh.enter(state)
    fresh.order(Hold(), client="eve")
    fresh.expect(StateName.HOVER)


@pytest.mark.parametrize("state", sorted(HOMING))
async def test_only_the_operator_in_control_holds_a_return_or_landing(fresh: Rig, state: StateName) -> None:
    await fresh.enter(state)
    assert fresh.command(Hold(), client="eve").reason == "Someone else has control."
    fresh.order(Hold())
    fresh.expect(StateName.HOVER)


@pytest.mark.parametrize("command", [ReturnToLaunch(), Land()], ids=lambda c: c.type)
async def test_anyone_may_bring_it_down_when_nobody_has_control(flying: Rig, command: Command) -> None:
    assert not flying.command(command, client="eve").accepted
    flying.desk.client = None
    flying.order(command, client="eve")


@pytest.mark.fault(
    "the operator in control is lost, another client sends Land or Return To Launch",
    "done at once, without control",
)
@pytest.mark.parametrize("command", [ReturnToLaunch(), Land()], ids=lambda c: c.type)
async def test_anyone_may_bring_it_down_when_the_one_in_control_is_lost(flying: Rig, command: Command) -> None:
    assert not flying.command(command, client="eve").accepted
    flying.desk.present = False
    flying.order(command, client="eve")


async def test_nothing_else_is_taken_from_others_when_the_one_in_control_is_lost(flying: Rig) -> None:
    flying.desk.present = False
    refused = flying.command(AutonomousExplore(), client="eve")
    assert refused.reason == "The operator in control is lost: take control first."


async def test_nothing_else_is_taken_when_nobody_has_control(flying: Rig) -> None:
    flying.desk.client = None
    assert flying.command(AutonomousExplore(), client="eve").reason == "Take control first."


async def test_without_a_link_commands_to_the_autopilot_are_refused(fresh: Rig) -> None:
    fresh.autopilot.connected = False
    await fresh.run(0.3)
    assert "No link" in fresh.command(Arm()).reason
    assert "No link" in fresh.command(SetFailsafes()).reason
