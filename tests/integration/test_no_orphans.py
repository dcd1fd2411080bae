"""A program that is killed leaves neither its simulator nor its daemon behind, however early it ends."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.integration.sim_support import small_picture
from tests.pace import PATIENCE_S

pytestmark = pytest.mark.integration


SURVEY = """
import asyncio, os, pathlib, sys

from hawk.sim.launch import SimulationOptions
from hawk.survey.stack import SimulatedStack


class Killed(SimulatedStack):
    def _began(self, session):
        print(self._simulation._process.pid, session, flush=True)
        if sys.argv[3] == "starts":
            os.kill(os.getpid(), 9)


picture, folder = map(pathlib.Path, sys.argv[1:3])
asyncio.run(Killed(SimulationOptions(world=picture, metres_per_pixel=0.5), folder, None, None).start())
os.kill(os.getpid(), 9)
"""
"""A survey that is killed as soon as its daemon was started, or serves its page."""
SIMULATION = """
import asyncio, os, pathlib, sys

from hawk.sim.launch import Simulation, SimulationOptions


class Killed(Simulation):
    async def _ready_line(self):
        print(self._process.pid, flush=True)
        os.kill(os.getpid(), 9)


asyncio.run(Killed(SimulationOptions(world=pathlib.Path(sys.argv[1]), metres_per_pixel=0.5)).start())
"""
"""A program that is killed as soon as its simulator was started."""


def ends(pid: int) -> bool:
    """Return True where that process ends in time; kill it otherwise."""
    try:
        descriptor = os.pidfd_open(pid)
    except ProcessLookupError:
        return True
    try:
        ended, _, _ = select.select([descriptor], [], [], PATIENCE_S)
        if not ended:
            signal.pidfd_send_signal(descriptor, signal.SIGKILL)
        return bool(ended)
    finally:
        os.close(descriptor)


def pids_left_by(script: str, *arguments: str) -> list[int]:
    """Run a program that prints the pids of its children and kills itself; return them."""
    command = [sys.executable, "-c", script, *arguments]
    program = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert program.returncode == -signal.SIGKILL, program.stderr
    return [int(word) for word in program.stdout.split()]


def test_a_simulator_ends_whose_program_was_killed_before_it_looked(tmp_path: Path) -> None:
    (simulator,) = pids_left_by(SIMULATION, str(small_picture(tmp_path)))
    assert ends(simulator)


@pytest.mark.parametrize(
    ("moment", "logged"),
    [("starts", "hawk-drone: --parent-pid: no process "), ("serves", "the program that started this one has ended")],
)
def test_simulator_and_daemon_end_when_their_survey_is_killed(tmp_path: Path, moment: str, logged: str) -> None:
    folder = tmp_path / "run"
    pids = pids_left_by(SURVEY, str(small_picture(tmp_path)), str(folder), moment)
    assert len(pids) == 2
    assert [pid for pid in pids if not ends(pid)] == []
    assert logged in (folder / "hawk-drone.log").read_text()
