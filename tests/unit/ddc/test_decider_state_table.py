"""Every pair of state and event: docs/states.md is what the program does, and it does nothing that is unsafe."""

from __future__ import annotations

import pytest

from hawk.model.operation import StateName
from tests.sweep import sweep
from tests.unit.ddc.state_table import COLUMNS, DOCUMENT, EVENTS, Outcomes, document, table

GROUND = {column.name for column in COLUMNS if column.facts(0.0).is_on_ground}
AIR = {column.name for column in COLUMNS} - GROUND
TASKS = {StateName.AUTONOMOUS_EXPLORE.value, StateName.AUTONOMOUS_MOVE.value, StateName.COMPULSIVE_MOVE.value}
BY_ITSELF = [(event.group, event.name) for event in EVENTS if event.group != "Command"]
REACTIONS = [(group, name) for group, name in BY_ITSELF if group not in ("Autopilot", "Operator")]


@pytest.fixture(scope="module")
def outcomes() -> Outcomes:
    """Every pair, put to the program once."""
    return table()


@pytest.mark.slow
def test_the_page_is_what_the_program_does(outcomes: Outcomes) -> None:
    assert DOCUMENT.read_text() == document(outcomes), "write it again: .venv/bin/python -m tests.unit.ddc.state_table"


@pytest.mark.slow
@sweep(
    ("command", "column", "following"),
    [
        ("Configure", "Idle", StateName.CONFIGURE),
        ("Arm", "Idle", StateName.ARM),
        ("Takeoff", "Armed", StateName.TAKEOFF),
        ("Autonomous Explore", "Hover", StateName.AUTONOMOUS_EXPLORE),
        ("Autonomous Move", "Hover", StateName.AUTONOMOUS_MOVE),
        ("Compulsive Move", "Hover", StateName.COMPULSIVE_MOVE),
        ("Return To Launch", "Hover", StateName.RETURN_TO_LAUNCH),
        ("Land", "Hover", StateName.LAND),
        ("Hold", "Explore", StateName.HOVER),
        ("Disarm", "Arming", StateName.IDLE),
        ("Resume", "Manual", StateName.HOVER),
    ],
)
def test_each_state_is_entered_by_its_command(
    outcomes: Outcomes, command: str, column: str, following: StateName
) -> None:
    assert outcomes["Command", command][column] == following.value


@sweep("event", BY_ITSELF)
def test_nothing_but_a_command_begins_a_task_or_a_take_off(outcomes: Outcomes, event: tuple[str, str]) -> None:
    begun = {*TASKS, StateName.TAKEOFF.value}
    assert begun.isdisjoint(outcomes[event].values())


@sweep("event", BY_ITSELF)
def test_nothing_but_a_command_takes_the_motors_off_a_drone_in_the_air(
    outcomes: Outcomes, event: tuple[str, str]
) -> None:
    if event[1] != "Disarmed":
        assert all(outcomes[event][column] != StateName.IDLE.value for column in AIR)


@sweep("event", REACTIONS)
@sweep("column", ["Manual", "RTL", "Land"])
def test_no_reaction_takes_the_drone_from_a_pilot_or_from_its_return(
    outcomes: Outcomes, column: str, event: tuple[str, str]
) -> None:
    assert outcomes[event][column] == "stays"


@sweep("column", [column.name for column in COLUMNS])
@sweep("command", ["Kill Request", "Kill with its token"])
def test_the_motors_can_be_cut_in_every_state(outcomes: Outcomes, command: str, column: str) -> None:
    assert outcomes["Command", command][column] == "stays"


@sweep("column", sorted(AIR))
def test_the_operator_can_bring_the_drone_down_from_every_state(outcomes: Outcomes, column: str) -> None:
    ends = {StateName.RETURN_TO_LAUNCH.value, StateName.LAND.value}
    paths = {outcomes["Command", command][column] for command in ("Return To Launch", "Land")}
    assert paths & ends or column == "Land", "landing already"


@sweep("column", sorted(GROUND))
def test_no_command_but_take_off_leads_from_the_ground_into_the_air(outcomes: Outcomes, column: str) -> None:
    air = {c.identity.value for c in COLUMNS if c.name in AIR} - {StateName.TAKEOFF.value}
    assert all(outcomes[event][column] not in air for event in outcomes if event[0] == "Command")


@sweep("column", sorted(AIR - {"Manual", "RTL", "Land"}))
@sweep("event", [event for event in BY_ITSELF if event[0] == "Battery"])
def test_the_battery_brings_the_drone_home_from_every_state(
    outcomes: Outcomes, event: tuple[str, str], column: str
) -> None:
    assert outcomes[event][column] == StateName.RETURN_TO_LAUNCH.value
