"""The architecture document names only what exists, and every access program of the specification has its row."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest

ROOT = Path(__file__).parents[3]
DOCUMENT = ROOT / "docs" / "architecture.md"

SPECIFICATION: dict[str, str] = {
    "6 Message Socket": (
        "new MessageSocket, init, sendMessageSync, sendMessageAsync, getMessage, isConnected, close, "
        "MessageSocket, ConnectionTimeout, FailedToSend, NoMessagesError"
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
    """One row of the specification's table."""

    section: str
    name: str
    here: str
    test: str


def table() -> Iterator[Row]:
    """Yield the rows below "The specification's table"."""
    _, _, part = DOCUMENT.read_text(encoding="utf-8").partition("## The specification's table\n")
    section = ""
    for line in part.splitlines():
        if line.startswith("### "):
            section = line[4:].strip()
        elif line.startswith("| `"):
            name, here, test = (cell.strip() for cell in line.strip("|").split("|"))
            yield Row(section, name.strip("`"), here, test)


def marked(text: str) -> list[str]:
    """Return what stands between backticks."""
    return re.findall(r"`([^`]+)`", text)


def exists(name: str) -> bool:
    """Whether a dotted name is a module, or an attribute of one; what `__init__` sets counts as an attribute."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found: Any = importlib.import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            if not hasattr(found, part):
                return inspect.isclass(found) and part == parts[-1] and part in instance_attributes(found)
            found = getattr(found, part)
        return True
    return False


def instance_attributes(owner: type) -> set[str]:
    """Return the names that the class's methods assign to ``self``."""
    return set(re.findall(r"\bself\.(\w+)(?::[^=\n]+)? = ", inspect.getsource(owner)))


@cache
def names_of_tests(path: Path) -> frozenset[str]:
    """Return the names of a file's tests."""
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef)
    return frozenset(node.name for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, kinds))


ROWS = tuple(table())


@pytest.mark.parametrize("section", SPECIFICATION)
def test_every_program_of_the_specification_has_one_row(section: str) -> None:
    rows = [row.name for row in ROWS if row.section == section]
    assert len(rows) == len(set(rows))
    assert not set(SPECIFICATION[section].split(", ")) - set(rows)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.section}: {row.name}")
def test_every_row_names_what_exists(row: Row) -> None:
    named = marked(row.here)
    assert named
    for name in named:
        assert (ROOT / name).is_file() if "/" in name else exists(name), name


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.section}: {row.name}")
def test_every_row_names_a_test_that_exists(row: Row) -> None:
    (named,) = marked(row.test)
    path, _, test = named.partition("::")
    assert (ROOT / path).is_file(), path
    assert not test or (test.startswith("test_") and test in names_of_tests(ROOT / path)), named


def test_every_name_of_the_document_exists() -> None:
    text = DOCUMENT.read_text(encoding="utf-8").partition("## The specification's table\n")[0]
    for name in marked(text):
        if name.startswith("hawk.") and re.fullmatch(r"[\w.]+", name):
            assert exists(name), name
        elif name.startswith(("hawk/", "tests/", "docs/", "packaging/", "training/", "benchmarks/")):
            assert (ROOT / name).exists(), name


def test_every_state_of_the_program_has_a_row() -> None:
    from hawk.model import StateName

    assert {state.value for state in StateName} <= {row.name for row in ROWS if row.section == "17 Operation States"}


def test_a_name_that_is_none_is_noticed() -> None:
    assert exists("hawk.ddc.topic_interface.DdcTopicInterface.des_pose_pub")
    assert not exists("hawk.ddc.topic_interface.DdcTopicInterface.des_pose_publisher")
    assert not exists("hawk.ddc.nothing_of_that_name")
