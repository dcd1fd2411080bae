"""Every access program of the specification has a row in docs/specification.md that names existing code and a test."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import pytest

from tests.sweep import sweep
from tests.unit.docs.names import ROOT, exists, marked, names_of_tests

DOCUMENT = ROOT / "docs" / "specification.md"

SPECIFICATION: dict[str, str] = {
    "6 Message Socket": (
        "new MessageSocket, init, sendMessageSync, sendMessageAsync, getMessage, isConnected, close, "
        "MessageSocket, BaseSocket, ConnectionTimeout, FailedToSend, NoMessagesError"
    ),
    "7 Drone Camera": "init, getImage, NoImage",
    "8 Operator Camera": "init, getImage, NoImage",
    "9 Algorithm Topic Interface": (
        "init, getDroneState, getDesiredPose, getLocalPose, parkLotDetectedPub, desLocInboundPub, occupancyMapPub, "
        "localPosPub, visionAppHealthPub, mapperAppHealthPub, pathPlanAppHealthPub"
    ),
    "10 Vision App": "init, process, publish, getParkLotDetected, getHealth, NoImage, AlgoError",
    "11 Mapper App": "init, process, publish, getOccupancyMap, getHealth, AlgoError",
    "12 Path Plan App": "init, process, publish, getLocalPose, getDesPoseInbound, getHealth, AlgoError",
    "13 Algorithm Manager App": "init, process, AlgoError",
    "14 Main Algorithm": "main",
    "15 DDC Topic Interface": (
        "init, getState, getGlobalPose, getDiagnostics, getParkLotDetected, getDesLocInbound, getHealthStatus, "
        "getLocalPose, getBatteryInfo, getRelAlt, getOccupancyMap, getVisionHealth, getMapperHealth, "
        "getPathPlanHealth, desPosePub, currStatePub"
    ),
    "16 DDC Service Interface": "init, setArm, setRtlAlt, sendTakeoffCmd, setMode, ReqFailed",
    "17 Operation States": "State, new State, process, transitionNextState, getIdentity",
    "18 Operations Manager": "init, process",
    "19 Main DDC": "main",
    "20 User Interface": "UserInterface, StartDroneCameraDisplay, exec_",
    "21 Main Interface": "main",
}
"""Exported types, constants, access programs and exceptions of the interface specification, by section."""


class Row(NamedTuple):
    """One item of the specification."""

    section: str
    name: str
    here: str
    test: str


def items() -> Iterator[Row]:
    """Yield the items below "The specification, item by item"."""
    _, _, part = DOCUMENT.read_text(encoding="utf-8").partition("## The specification, item by item\n")
    section = ""
    for line in part.splitlines():
        if line.startswith("### "):
            section = line[4:].strip()
        elif line.startswith("- `"):
            name, _, rest = line.removeprefix("- `").partition("`: ")
            here, _, test = rest.rpartition("; ")
            yield Row(section, name, here, test)


ROWS = tuple(items())


def test_every_item_is_one_of_a_section() -> None:
    _, _, part = DOCUMENT.read_text(encoding="utf-8").partition("## The specification, item by item\n")
    assert len([line for line in part.splitlines() if line.startswith(("-", "|"))]) == len(ROWS)
    assert {row.section for row in ROWS} == {"4 Notation", *SPECIFICATION}


@sweep("section", SPECIFICATION)
def test_every_program_of_the_specification_has_one_row(section: str) -> None:
    rows = [row.name for row in ROWS if row.section == section]
    assert len(rows) == len(set(rows))
    assert not set(SPECIFICATION[section].split(", ")) - set(rows)


@pytest.mark.slow
@sweep("row", ROWS)
def test_every_row_names_what_exists(row: Row) -> None:
    named = marked(row.here)
    assert named
    for name in named:
        assert (ROOT / name).is_file() if "/" in name else exists(name), name


@pytest.mark.slow
@sweep("row", ROWS)
def test_every_row_names_a_test_that_exists(row: Row) -> None:
    (named,) = marked(row.test)
    path, _, test = named.partition("::")
    assert (ROOT / path).is_file(), path
    assert not test or (test.startswith("test_") and test in names_of_tests(ROOT / path)), named


def test_every_state_of_the_program_has_a_row() -> None:
    from hawk.model.operation import StateName

    assert {state.value for state in StateName} <= {row.name for row in ROWS if row.section == "17 Operation States"}
