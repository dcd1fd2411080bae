"""A lot of a section alone, with private ground: the real daemon counts it in flight, and stores its picture masked."""

from __future__ import annotations

import asyncio
import json
import uuid
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import urljoin

import numpy as np
import pytest
import shapely
from sqlalchemy import insert

from hawk.comm.protocol.commands import AutonomousExplore
from hawk.lots.plan.values import PRIVATE
from hawk.lots.registration.frames import frame_of
from hawk.lots.storage.database import Database
from hawk.lots.storage.outlines import outline_json
from hawk.lots.storage.schema import LAYOUT, LOT, SECTION, ZONE
from hawk.lots.survey.pictures import pictures_of
from hawk.model.lot_map import CELL_M, TILE_CELLS, TILE_M
from hawk.model.operation import StateName
from hawk.model.plans import Outline
from hawk.model.tile_picture import decode_picture
from hawk.results.survey_map import to_global
from hawk.sim.launch import SimulationOptions
from hawk.worlds.generate import generate_world
from tests.integration.daemon_support import PatientStack, operator, write_settings
from tests.integration.sim_support import get_json
from tests.integration.test_known_lot import CAMERA_HZ, DATUM, SETTINGS, SPEED

pytestmark = [pytest.mark.integration, pytest.mark.alone, pytest.mark.nightly]


def store_street(path: Path, truth: Mapping[str, Any]) -> tuple[shapely.Polygon, int]:
    """Store the world's lot without a stall: its west is a section, its east private. Return the latter's ground, and
    how many cars are parked in the section.
    """
    lot, ring = str(uuid.uuid4()), np.array(truth["lots_m"][0])
    (left, top), (right, bottom) = ring.min(axis=0), ring.max(axis=0)
    middle = (left + right) / 2
    west = shapely.box(-bottom, left, -top, middle - 8.0)  # (north, east), metres
    east = shapely.box(-bottom, middle + 8.0, -top, right)
    stalls = [(np.mean(stall["corners_m"], axis=0), stall["state"]) for stall in truth["stalls"]]
    parked = sum(state == "taken" and west.contains(shapely.Point(-y, x)) for (x, y), state in stalls)
    outline = Outline((tuple(map(tuple, to_global(DATUM, np.column_stack([-ring[:, 1], ring[:, 0]])).tolist())),))
    place = {"outline": outline_json(outline), "latitude": DATUM.latitude, "longitude": DATUM.longitude}
    corners = [json.dumps([*ground.exterior.coords][:-1]) for ground in (west, east)]
    store = Database(path)
    with store.writing() as connection:
        connection.execute(insert(LOT).values(id=lot, name="Market", datum_is_pinned=True, made=0.0, **place))
        connection.execute(insert(LAYOUT).values(lot=lot, version=1, valid_from=0.0, why="drawn", who="Ann"))
        common = {"lot": lot, "begins": 1, "ends": None}
        connection.execute(insert(SECTION).values(
            id=str(uuid.uuid4()), name="West", outline=corners[0], kind="", length_m=30.0, capacity=parked + 8,
            is_capacity_given=True, note="", **common,
        ))  # fmt: skip
        connection.execute(insert(ZONE).values(
            id=str(uuid.uuid4()), name="Garden", outline=corners[1], kind=PRIVATE, **common
        ))  # fmt: skip
    store.close()
    return east, parked


async def test_vehicles_of_a_section_are_counted_in_flight_and_private_ground_is_in_no_picture(tmp_path: Path) -> None:
    (tmp_path / "store").mkdir()
    file = tmp_path / "store" / "lots.db"
    private, parked = store_street(file, generate_world(1).truth_json())
    options = SimulationOptions(seed=1, speed=SPEED, camera_rate=CAMERA_HZ)
    stack = PatientStack(options, tmp_path, write_settings(tmp_path, SETTINGS), None)
    try:
        url = (await stack.start()).url
        async with operator(url) as pilot:
            await pilot.take_off()
            await pilot.order(AutonomousExplore())
            await pilot.until(
                lambda _: any((each.seen_share or 0.0) > 0.2 for each in pilot.drone.sections.values()), 300.0
            )
            await pilot.until_state(StateName.HOVER, 300.0)
            await pilot.come_home()
            await pilot.until_said("The survey is stored as one of Market.")
            (section,) = pilot.drone.sections.values()
            datum = pilot.beat.datum
        answer = asyncio.get_running_loop().run_in_executor
        (lot,) = (await answer(None, get_json, urljoin(url, "/api/v1/lots")))["items"]
        (stored,) = (await answer(None, get_json, urljoin(url, f"/api/v1/lots/{lot['id']}/sections")))["items"]
        (survey,) = (await answer(None, get_json, urljoin(url, f"/api/v1/lots/{lot['id']}/surveys")))["items"]
    finally:
        await stack.stop()
    assert section.capacity == parked + 8
    assert section.parked is not None
    look = stored["look"]
    assert (section.least, section.parked, section.most) == (look["least"], look["parked"], look["most"])
    assert parked - 2 <= section.parked <= parked + 6, "some stand in aisles, which the world's truth does not say"
    assert datum is not None
    seen = hidden = 0
    for (row, column), data in pictures_of(file).read(survey["id"]).items():
        mask = decode_picture(data)[1]
        cells = (np.arange(TILE_CELLS) + 0.5) * CELL_M
        places = np.stack(np.meshgrid(-row * TILE_M - cells, column * TILE_M + cells, indexing="ij"), -1)
        inside = shapely.contains_xy(_about(private, datum), places[..., 0], places[..., 1])
        seen += int(np.count_nonzero(mask))
        hidden += int(inside.sum())
        assert not mask[inside].any()
    assert seen > 100_000
    assert hidden > 20_000


def _about(ground: shapely.Polygon, datum: tuple[float, float]) -> shapely.geometry.base.BaseGeometry:
    """Return ground about hawk-sim's corner as metres about the map's datum."""
    return shapely.transform(ground, frame_of(datum, (DATUM.latitude, DATUM.longitude)).of)
