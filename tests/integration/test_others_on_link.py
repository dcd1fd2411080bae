"""Others on the autopilot's link before the drone's own signs of life, and a link of MAVLink 1: what a check says."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.integration.sim_support import free_tcp_port, free_udp_port, simulation, small_picture

pytestmark = [pytest.mark.integration]


def checks(folder: Path, *simulated: str) -> dict[str, dict[str, Any]]:
    """Return what `hawk-drone check` finds on the link of a simulated drone, by name."""
    port = free_udp_port()
    picture = small_picture(folder)
    world = ("--world", str(picture), "--metres-per-pixel", "0.5", "--mavlink", f"udpout:127.0.0.1:{port}")
    with simulation(*world, *simulated):
        command = [sys.executable, "-m", "hawk.cli", "check", "--json", "--store", str(folder / "store")]
        command += ["--autopilot", f"udpin://127.0.0.1:{port}", "--port", str(free_tcp_port())]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    return {each["name"]: each for each in json.loads(done.stdout)["checks"]}


def test_the_copter_is_found_behind_a_tracker_and_a_gimbal(tmp_path: Path) -> None:
    found = checks(tmp_path, "--others", "tracker,gimbal,station")
    assert found["Autopilot"]["outcome"] == "passed"
    assert "quadrotor" in found["Autopilot"]["value"]
    assert not {"MAVLink", "Second sender"} & set(found)


def test_of_two_copters_none_is_taken_before_one_is_named(tmp_path: Path) -> None:
    found = checks(tmp_path, "--others", "copter")
    assert found["Autopilot"]["outcome"] == "failed"
    assert "Several copters are heard: system 1 at 127.0.0.1" in found["Autopilot"]["value"]


def test_a_link_of_mavlink_1_is_named_with_its_remedy(tmp_path: Path) -> None:
    found = checks(tmp_path, "--mavlink-version", "1")
    assert found["MAVLink"]["outcome"] == "failed"
    assert "SERIALn_PROTOCOL" in found["MAVLink"]["remedy"]
