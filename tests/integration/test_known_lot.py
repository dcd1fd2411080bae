"""A flight over a lot whose plan a person has confirmed: the real daemon on the simulated drone."""

from __future__ import annotations

import asyncio
import math
import uuid
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import urljoin

import numpy as np
import pytest
from sqlalchemy import insert

from benchmarks.perception.boxes import Boxes
from hawk.comm.protocol.commands import AutonomousExplore
from hawk.lots.storage.database import Database
from hawk.lots.storage.outlines import outline_json
from hawk.lots.storage.schema import LAYOUT, LOT, STALL
from hawk.model.lot_map import Stall, StallState
from hawk.model.operation import StateName
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import to_global
from hawk.sim.launch import SimulationOptions
from hawk.survey.stack import SimulatedStack
from hawk.worlds.generate import generate_world
from tests.integration.daemon_support import PatientStack, operator, write_settings
from tests.integration.sim_support import get_json
from tests.pace import speed_here

Stored = list[Mapping[str, Any]]
"""Items of the API."""
pytestmark = [pytest.mark.integration, pytest.mark.alone, pytest.mark.nightly]

SETTINGS = """
[heights]
minimum_m = 15.0
desired_m = 30.0
maximum_m = 40.0
"""
SPEED, CAMERA_HZ = speed_here(3.0), 5.0
BIAS = "1.2,-0.9"
"""Error of the receiver for the whole flight, metres north and east; it moves slowly beside, too."""
DATUM = GlobalPose(43.2609, -79.9192, 0.0)
"""Place of the upper left corner of hawk-sim's world."""


def store_plan(path: Path, truth: Mapping[str, Any], name: str = "Market") -> int:
    """Store the stalls of a truth as a lot that a person has confirmed; return their number."""
    lot, rows = str(uuid.uuid4()), list[dict[str, Any]]()
    boxes = Boxes.of(np.array([stall["corners_m"] for stall in truth["stalls"]]))
    values = np.column_stack([boxes.centre, boxes.along, boxes.width, boxes.length]).tolist()
    for number, (x, y, along_x, along_y, width, length) in enumerate(values, 1):
        ids = {"id": str(uuid.uuid4()), "lot": lot, "label": f"A {number}", "begins": 1, "ends": None, "kind": ""}
        shape = {"north": -y, "east": x, "angle": math.atan2(along_x, -along_y) % math.pi}
        sizes = {"width": width, "length": length, "is_confirmed": True, "first_survey": None, "first_id": None}
        rows.append({**ids, **shape, **sizes})
    rings = [to_global(DATUM, np.array([(-y, x) for x, y in ring])).tolist() for ring in truth["lots_m"]]
    outline = Outline(tuple(tuple((a, b) for a, b in ring) for ring in rings))
    place = {"outline": outline_json(outline), "latitude": DATUM.latitude, "longitude": DATUM.longitude}
    store = Database(path)
    with store.writing() as connection:
        connection.execute(insert(LOT).values(id=lot, name=name, datum_is_pinned=True, made=0.0, **place))
        connection.execute(insert(LAYOUT).values(lot=lot, version=1, valid_from=0.0, why="drawn", who="Ann"))
        connection.execute(insert(STALL), rows)
    store.close()
    return len(rows)


async def fly(stack: SimulatedStack, count: int) -> tuple[list[Stall], Stored, Stored]:
    """Explore the lot once; return the counted stalls of the map, and surveys and stalls as the store has them then."""
    url = (await stack.start()).url
    async with operator(url) as pilot:
        await pilot.take_off()
        await pilot.until_said("This is Market: its plan is known.")
        await pilot.order(AutonomousExplore())
        await pilot.until(lambda _: len(pilot.drone.map.stalls) >= count, 300.0)
        await pilot.until_state(StateName.HOVER, 300.0)
        await pilot.come_home()
        await pilot.until_said("The survey is stored as one of Market.")
        await pilot.drone.whole_map()
        shown = list(pilot.drone.map.stalls.values())
    answer = asyncio.get_running_loop().run_in_executor
    (lot,) = (await answer(None, get_json, urljoin(url, "/api/v1/lots")))["items"]
    path = f"/api/v1/lots/{lot['id']}"
    surveys = (await answer(None, get_json, urljoin(url, f"{path}/surveys")))["items"]
    stalls = (await answer(None, get_json, urljoin(url, f"{path}/stalls?limit=1000")))["items"]
    return [stall for stall in shown if stall.state is not StallState.SUGGESTED], surveys, stalls


async def test_a_flight_over_a_confirmed_plan_keeps_its_stalls_and_reads_their_states(tmp_path: Path) -> None:
    truth = generate_world(1).truth_json()
    (tmp_path / "store").mkdir()
    count = store_plan(tmp_path / "store" / "lots.db", truth)
    options = SimulationOptions(seed=1, speed=SPEED, camera_rate=CAMERA_HZ, gnss_bias=BIAS)
    stack = PatientStack(options, tmp_path, write_settings(tmp_path, SETTINGS), None)
    try:
        shown, surveys, stalls = await fly(stack, count)
    finally:
        await stack.stop()
    assert [stall for stall in shown if not stall.label] == []
    assert len(shown) == count
    (survey,) = surveys
    assert survey["placed"] == "registered"
    assert len(stalls) == count
    looked = [stall for stall in stalls if stall["state"] is not None]
    assert len(looked) >= 0.97 * count
    states = {f"A {number}": stall["state"] for number, stall in enumerate(truth["stalls"], 1)}
    right = sum(stall["state"] == states[stall["label"]] for stall in looked)
    assert right >= 0.95 * len(looked)
