"""The table of commands is whole, and its columns agree with the messages, the page and each other."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

import pytest

from hawk.comm.protocol.authority import Sender
from hawk.comm.protocol.command_table import (
    COMMAND_TABLE,
    TAKEN,
    CommandRow,
    Confirm,
    Need,
    Urgency,
    sender_of,
)
from hawk.comm.protocol.commands import AnyCommand, Confirmable, parse_command
from hawk.model.operation import StateName
from hawk.model.sentences import Sentence

LABELS = Path(__file__).parents[4] / "hawk" / "web" / "page" / "src" / "messages" / "en.ftl"
MODELS = get_args(get_args(AnyCommand)[0])
ROWS = list(COMMAND_TABLE.values())
rows = pytest.mark.parametrize("row", ROWS, ids=lambda row: row.type)


def having(flag: str) -> set[str]:
    return {row.type for row in ROWS if getattr(row, flag)}


def test_every_command_has_a_row_and_every_row_a_command() -> None:
    assert {type(row.example) for row in ROWS} == set(MODELS)
    assert len(ROWS) == len(MODELS)
    assert all(kind == row.type for kind, row in COMMAND_TABLE.items())


@rows
def test_a_row_has_every_state_or_none(row: CommandRow) -> None:
    assert set(row.states) in (set(StateName), set())
    assert all(reason == TAKEN or isinstance(reason, Sentence) for reason in row.states.values())


@rows
def test_a_row_has_a_help_text_and_an_example_that_is_taken(row: CommandRow) -> None:
    assert row.help.endswith((".", ")"))
    assert "\n" not in row.help
    assert parse_command(row.example.model_dump_json(by_alias=True)) == row.example


def test_a_command_without_states_only_asks_or_is_the_web_servers() -> None:
    without = {row.type for row in ROWS if not row.states}
    assert without == {"Route Request", "Check Fence"} | having("answered_by_web_server")
    assert all(not row.needs for row in ROWS if not row.states)


def test_what_each_flag_says_and_of_which_commands() -> None:
    assert having("answered_by_web_server") == {"Name", "Control", "Heartbeat", "Map Resync"}
    assert having("sent_by_itself") == {"Name", "Heartbeat", "Map Resync"}
    assert having("begins_flight") == {"Arm", "Takeoff"}
    assert having("only_asks") == {"Route Request", "Check Fence", "Kill Request"}
    assert having("sent_unheard") == {"Return To Launch", "Land", "Kill"}
    assert having("taken_while_cutting") == {"Kill Request", "Kill", "Hold", "Return To Launch", "Land"}


def test_what_stops_or_saves_the_drone_passes_the_queue() -> None:
    urgent = {row.type: row.urgency for row in ROWS if row.urgency is not Urgency.WAITS}
    saving = dict.fromkeys(("Hold", "Return To Launch", "Land", "Kill"), Urgency.SAVING)
    assert urgent == {**saving, "Kill Request": Urgency.URGENT}


def test_nothing_that_must_work_without_the_autopilot_needs_its_link() -> None:
    free = {
        "Configure",
        "Kill Request",
        "Kill",
        "Clear Kill",
        "Set Outline",
        "Clear Outline",
        "Survey Again",
        "Fly Plan",
    }
    assert {row.type for row in ROWS if row.states and Need.LINK not in row.needs} == free


def test_a_command_that_would_overrule_a_pilot_carries_the_confirmation() -> None:
    assert {row.type for row in ROWS if row.confirm is Confirm.OVERRULING} == {"Resume", "Return To Launch", "Land"}
    assert all(isinstance(row.example, Confirmable) is (row.confirm is Confirm.OVERRULING) for row in ROWS)


def test_one_click_starts_no_motor_and_no_flight() -> None:
    slid = {row.type for row in ROWS if row.confirm is Confirm.SLIDE}
    moves = {"Autonomous Explore", "Autonomous Move", "Compulsive Move"}
    assert slid == {"Arm", "Takeoff", "New Survey"} | moves
    assert {row.type for row in ROWS if row.confirm is Confirm.TWO_STEPS} == {"Kill"}


def test_every_need_is_that_of_a_command() -> None:
    assert {need for row in ROWS for need in row.needs} == set(Need)


def test_a_button_is_a_label_of_the_page() -> None:
    labels = set(re.findall(r"^([a-z-]+) =", LABELS.read_text(encoding="utf-8"), re.MULTILINE))
    buttons = {row.button for row in ROWS} - {""}
    assert len(buttons) > 15
    assert buttons <= labels


def test_a_type_without_a_row_needs_control() -> None:
    assert sender_of("Fly") is Sender.CONTROL
    assert sender_of("Hold") is Sender.OPERATORS_UNLESS_HOMING
