"""A round of two lots: the real daemon flies both in one flight, or in two with a battery swap between them."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import urljoin

import numpy as np
import pytest
import shapely

from hawk.comm.protocol.commands import AutonomousExplore, SurveyAgain
from hawk.model.operation import StateName
from hawk.sim.launch import SimulationOptions
from hawk.worlds.generate import generate_world
from tests.integration.daemon_support import Operator, PatientStack, operator, write_settings
from tests.integration.sim_support import get_json
from tests.integration.test_known_lot import BIAS, CAMERA_HZ, SETTINGS, SPEED, store_plan
from tests.pace import PATIENCE_S

pytestmark = [pytest.mark.integration, pytest.mark.alone, pytest.mark.nightly]
NAMES = ("North", "South")
LOW_PERCENT = 21.0
"""Charge at which the drone returns at once."""


def halves(truth: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the stalls of a world as two lots with a line between them."""
    middles = np.array([np.mean(stall["corners_m"], axis=0) for stall in truth["stalls"]])
    along = np.linalg.svd(middles - middles.mean(axis=0))[2][0]
    is_first = (middles - middles.mean(axis=0)) @ along > 0.0
    found = []
    for mine in (is_first, ~is_first):
        ring = shapely.MultiPoint(middles[mine]).convex_hull.buffer(1.0, join_style="mitre").exterior.coords[:-1]
        stalls = [stall for stall, yes in zip(truth["stalls"], mine, strict=True) if yes]
        found.append({"stalls": stalls, "lots_m": [[list(corner) for corner in ring]]})
    return found


async def choose(pilot: Operator, lots: Sequence[Mapping[str, Any]]) -> None:
    """Take control, and choose lots: they are read every two seconds, once the place is known."""
    await pilot.take_control()
    asked = SurveyAgain(lots=[lot["id"] for lot in lots])
    async with asyncio.timeout(PATIENCE_S):
        while await pilot.hand.offer(asked) is not None:
            await pilot.hand.next()


async def survey_of(url: str, lot: Mapping[str, Any]) -> dict[str, Any]:
    """Return the only survey of a lot."""
    path = urljoin(url, f"/api/v1/lots/{lot['id']}/surveys")
    (survey,) = (await asyncio.get_running_loop().run_in_executor(None, get_json, path))["items"]
    return dict(survey)


async def test_two_lots_are_flown_in_one_flight_and_each_is_its_own_survey(tmp_path: Path) -> None:
    (tmp_path / "store").mkdir()
    plans = halves(generate_world(1).truth_json())
    counts = {
        name: store_plan(tmp_path / "store" / "lots.db", plan, name) for name, plan in zip(NAMES, plans, strict=True)
    }
    options = SimulationOptions(seed=1, speed=SPEED, camera_rate=CAMERA_HZ, gnss_bias=BIAS)
    stack = PatientStack(options, tmp_path, write_settings(tmp_path, SETTINGS), None)
    answer = asyncio.get_running_loop().run_in_executor
    try:
        url = (await stack.start()).url
        lots = (await answer(None, get_json, urljoin(url, "/api/v1/lots")))["items"]
        async with operator(url) as pilot:
            await choose(pilot, lots)
            assert "no lot has this id" in await pilot.refusal(SurveyAgain(lots=[lots[0]["id"], "another"]))
            assert "no survey of a lot is due" in await pilot.refusal(SurveyAgain(due=True))
            planned = await pilot.until(lambda beat: beat.again_distance is not None)
            assert [lot.name for lot in planned.again_lots] == [lot["name"] for lot in lots]
            await pilot.take_off()
            await pilot.until(lambda beat: any(o.command == "Autonomous Explore" and o.possible for o in beat.options))
            await pilot.order(AutonomousExplore())
            beat = await pilot.until(lambda beat: any(lot.is_over for lot in beat.again_lots), 300.0)
            (first,) = [lot.name for lot in beat.again_lots if lot.is_over]
            await pilot.until_said(f"The survey is stored as one of {first}.")
            assert (await pilot.hand.beat()).armed
            beat = await pilot.until(lambda beat: beat.explore_done and beat.state == StateName.HOVER, 300.0)
            assert [lot.is_over for lot in beat.again_lots] == [True, True]
            assert min(lot.seen for lot in beat.again_lots) >= 0.95
            await pilot.come_home()
            (second,) = [name for name in NAMES if name != first]
            await pilot.until_said(f"The survey is stored as one of {second}.")
            async with asyncio.timeout(PATIENCE_S):  # one that was in doubt in flight is stored again by now
                while "unregistered" in [(await survey_of(url, lot))["placed"] for lot in lots]:
                    await pilot.hand.next()
        for lot in lots:
            assert (await survey_of(url, lot))["placed"] == "registered"
            path = f"/api/v1/lots/{lot['id']}/stalls?limit=1000"
            stalls = (await answer(None, get_json, urljoin(url, path)))["items"]
            assert len(stalls) == counts[lot["name"]]
            assert sum(stall["state"] is not None for stall in stalls) >= 0.95 * len(stalls)
    finally:
        await stack.stop()


async def test_after_a_battery_swap_within_a_round_the_lots_that_are_left_are_flown(tmp_path: Path) -> None:
    (tmp_path / "store").mkdir()
    for name, plan in zip(NAMES, halves(generate_world(1).truth_json()), strict=True):
        store_plan(tmp_path / "store" / "lots.db", plan, name)
    options = SimulationOptions(seed=1, speed=SPEED, camera_rate=CAMERA_HZ, gnss_bias=BIAS)
    stack = PatientStack(options, tmp_path, write_settings(tmp_path, SETTINGS), None)
    answer = asyncio.get_running_loop().run_in_executor
    try:
        url = (await stack.start()).url
        lots = (await answer(None, get_json, urljoin(url, "/api/v1/lots")))["items"]
        async with operator(url) as pilot:
            await choose(pilot, lots)
            await pilot.until(lambda beat: beat.again_distance is not None)
            await pilot.take_off()
            await pilot.order(AutonomousExplore())
            beat = await pilot.until(lambda beat: any(lot.is_over for lot in beat.again_lots), 300.0)
            (first,) = [lot.name for lot in beat.again_lots if lot.is_over]
            await pilot.until_said(f"The survey is stored as one of {first}.")
            await stack.inject({"battery": LOW_PERCENT})
            await pilot.until_down(300.0)
            (second,) = [name for name in NAMES if name != first]
            await pilot.until_said(f"Not finished: {second}.")
        url = (await stack.swap_battery(replace(options, noise_seed=99))).url
        async with operator(url) as pilot:
            await pilot.take_control()
            beat = await pilot.until(lambda beat: beat.again_distance is not None)
            assert {lot.name: lot.is_over for lot in beat.again_lots} == {first: True, second: False}
            await pilot.take_off()
            await pilot.order(AutonomousExplore())
            beat = await pilot.until(lambda beat: beat.explore_done and beat.state == StateName.HOVER, 300.0)
            assert [lot.is_over for lot in beat.again_lots] == [True, True]
            await pilot.come_home()
            await pilot.until_said(f"The survey is stored as one of {second}.")
        for lot in lots:
            assert (await survey_of(url, lot))["lot"] == lot["id"]
    finally:
        await stack.stop()
