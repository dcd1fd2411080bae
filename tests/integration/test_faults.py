"""Faults with a required end and time, in one flight; `make faults` runs them all."""

from __future__ import annotations

from pathlib import Path

import pytest

from hawk.sim.launch import SimulationOptions
from proving.faults.fault import Outcome
from proving.faults.report import names
from proving.faults.run import ALL, SHORT, run_faults
from tests.integration.sim_support import small_picture
from tests.pace import speed_here

pytestmark = [pytest.mark.integration, pytest.mark.alone]


async def test_five_faults_of_one_flight_end_without_problems(tmp_path: Path) -> None:
    faults = dict(zip(names(ALL), ALL, strict=True))
    options = SimulationOptions(
        world=small_picture(tmp_path), metres_per_pixel=0.5, speed=speed_here(3.0), camera_rate=5.0
    )
    outcomes: list[Outcome] = []
    await run_faults([faults[name] for name in SHORT], tmp_path / "run", options, outcomes.append)
    assert [outcome.problems for outcome in outcomes] == [()] * len(SHORT)
