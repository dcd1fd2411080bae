"""docs/how-to/add-an-input.md names each value from outside that a flight reads, and who may write it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import AsyncIterator
from dataclasses import fields
from pathlib import Path

import pytest
from aiohttp import hdrs

from hawk.algo.frame import FrameInput
from hawk.algo.loop import Situation
from hawk.comm.protocol.authority import Sender
from hawk.comm.protocol.command_table import COMMAND_TABLE, IN_AIR, TASKS
from hawk.ddc.facts import Facts
from hawk.web.v1.table import OPERATIONS
from tests.unit.web.rig import Rig

TEXT = (Path(__file__).parents[3] / "docs" / "how-to" / "add-an-input.md").read_text(encoding="utf-8")
_PREFIX = re.compile(r"^/api(/v1)?(?=/)")
_PATTERN = re.compile(r"\{(\w+)(:[^{}]*(\{[^{}]*\})?[^{}]*)?\}")


@pytest.fixture
async def rig() -> AsyncIterator[Rig]:
    made = Rig()
    await made.start()
    yield made
    assert made.server is not None
    await made.server.close()


def named(heading: str, column: int = 0) -> list[str]:
    """Return what a section's table names in backticks in a column."""
    section = TEXT.split(f"## {heading}\n")[1].split("\n## ")[0]
    rows = [line.strip("|").split("|") for line in section.splitlines() if line.startswith("| ")][1:]
    return [name for row in rows for name in re.findall(r"`([^`]+)`", row[column])]


def test_each_field_of_the_frame_has_a_row() -> None:
    assert Counter(named("What the planner's frame holds")) == Counter(each.name for each in fields(FrameInput))
    assert {each.name for each in fields(Situation)} <= {each.name for each in fields(FrameInput)}


def test_each_field_of_the_facts_has_a_row() -> None:
    assert Counter(named("What the facts of a tick hold")) == Counter(each.name for each in fields(Facts))


def test_each_command_has_a_row() -> None:
    assert Counter(named("Commands")) == Counter(list(COMMAND_TABLE))


async def test_each_request_that_writes_has_a_row(rig: Rig) -> None:
    assert rig.app is not None
    reads = {hdrs.METH_GET, hdrs.METH_HEAD, hdrs.METH_OPTIONS, hdrs.METH_ANY}
    found = {
        _PATTERN.sub(r"{\1}", route.resource.canonical)
        for route in rig.app.router.routes()
        if route.method not in reads and route.resource is not None
    }
    found |= {operation.path for operation in OPERATIONS if operation.method not in reads}
    assert {_PREFIX.sub("", path) for path in found} == set(named("Requests that write"))


STEERS = [kind for kind, row in COMMAND_TABLE.items() if row.states and kind not in {"Kill Request"}]


@pytest.mark.parametrize("kind", STEERS)
def test_what_steers_needs_control_or_stops(kind: str) -> None:
    stops = {"Hold": Sender.OPERATORS_UNLESS_HOMING} | dict.fromkeys(
        ("Return To Launch", "Land", "Kill"), Sender.CONTROL_OR_FREE
    )
    assert COMMAND_TABLE[kind].sender is stops.get(kind, Sender.CONTROL)


@pytest.mark.parametrize("kind", ["Configure", "Set Fence", "Clear Fence", "Set Failsafes", "New Survey"])
def test_what_the_next_flight_begins_with_is_refused_in_the_air(kind: str) -> None:
    assert all(COMMAND_TABLE[kind].states[state] for state in IN_AIR)


@pytest.mark.parametrize("kind", ["Set Outline", "Clear Outline", "Survey Again"])
def test_the_outline_is_kept_while_it_explores(kind: str) -> None:
    assert COMMAND_TABLE[kind].states[TASKS[0]]
