"""A known lot surveyed again: the real daemon on the simulated drone flies the tour that it planned before take-off."""

from __future__ import annotations

import asyncio
from pathlib import Path
from urllib.parse import urljoin

import pytest

from hawk.comm.protocol.commands import AutonomousExplore, SurveyAgain
from hawk.model.operation import StateName
from hawk.sim.launch import SimulationOptions
from hawk.worlds.generate import generate_world
from tests.integration.daemon_support import PatientStack, operator, write_settings
from tests.integration.sim_support import get_json
from tests.integration.test_known_lot import BIAS, CAMERA_HZ, SETTINGS, SPEED, store_plan
from tests.pace import PATIENCE_S

pytestmark = [pytest.mark.integration, pytest.mark.alone]


@pytest.mark.nightly
async def test_a_known_lot_is_flown_by_the_tour_that_was_planned_before_take_off(tmp_path: Path) -> None:
    (tmp_path / "store").mkdir()
    store_plan(tmp_path / "store" / "lots.db", generate_world(1).truth_json())
    options = SimulationOptions(seed=1, speed=SPEED, camera_rate=CAMERA_HZ, gnss_bias=BIAS)
    stack = PatientStack(options, tmp_path, write_settings(tmp_path, SETTINGS), None)
    try:
        url = (await stack.start()).url
        answer = asyncio.get_running_loop().run_in_executor
        (lot,) = (await answer(None, get_json, urljoin(url, "/api/v1/lots")))["items"]
        async with operator(url) as pilot:
            await pilot.take_control()
            async with asyncio.timeout(PATIENCE_S):  # the lots are read every two seconds, once the place is known
                while await pilot.hand.offer(SurveyAgain(lots=[lot["id"]])) is not None:
                    await pilot.hand.next()
            assert "no lot has this id" in await pilot.refusal(SurveyAgain(lots=["another"]))
            planned = (await pilot.until(lambda beat: beat.again_distance is not None)).again_distance
            assert planned is not None
            await pilot.take_off()
            before = (await pilot.until(lambda beat: beat.distance_flown is not None)).distance_flown
            await pilot.until(lambda beat: any(o.command == "Autonomous Explore" and o.possible for o in beat.options))
            await pilot.order(AutonomousExplore())
            beat = await pilot.until(lambda beat: beat.explore_done and beat.state == StateName.HOVER, 300.0)
            assert beat.explored is not None
            assert beat.explored >= 0.98
            assert beat.distance_flown is not None
            assert before is not None
            assert beat.distance_flown - before < 1.5 * planned + 10.0
            await pilot.until_said("Surveyed again: every stall of the plan was looked at.")
            await pilot.come_home()
            await pilot.until_said("The survey is stored as one of Market.")
    finally:
        await stack.stop()
