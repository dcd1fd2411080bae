from __future__ import annotations

import asyncio

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from benchmarks.figures import Figure
from benchmarks.kill_under_load import LEAST_KILLS, KillWire, Run, figures, void
from proving.faults.proxy import Direction, packed

PERFORMANCE = {"vision_fps": 12.0, "tick_p99_ms": 5.0, "loop_lag_p99_ms": 6.0}


def run(longest_ms: float = 40.0, kills: int = LEAST_KILLS, others: float = 0.1, vision_fps: float = 12.0) -> Run:
    loaded = [3.0] * (kills - 1) + [longest_ms]
    cores = {"daemon": 0.8, "others": others}
    return Run([2.0] * 5, loaded, PERFORMANCE | {"vision_fps": vision_fps}, 48.0, cores)


def by_key(found: list[Figure]) -> dict[str, Figure]:
    return {figure.key: figure for figure in found}


def test_a_kill_under_load_stands_beside_one_without_viewers_and_its_limit() -> None:
    found = by_key(figures(run()))
    assert found["kill_loaded_p50_ms"].ratio == pytest.approx(1.5)
    assert found["kill_loaded_p99_ms"].passed
    assert found["kill_loaded_client_fps"].value == pytest.approx(3.0)
    assert not by_key(figures(run(longest_ms=500.0)))["kill_loaded_p99_ms"].passed


def test_a_vision_that_has_little_to_do_is_no_load() -> None:
    assert not by_key(figures(run(vision_fps=1.0)))["kill_loaded_vision_fps"].passed


def test_few_kills_and_a_busy_machine_are_reported() -> None:
    assert void(run()) == ""
    assert "too few" in void(run(kills=3))
    assert "1.20 cores" in void(run(others=1.2))


async def test_the_relay_notes_a_kill_and_keeps_it_from_the_drone() -> None:
    wire = KillWire()
    wire.arrived = asyncio.get_running_loop().create_future()
    fields = {
        "target_system": 1, "target_component": 1, "confirmation": 0,
        "param1": 1.0, "param2": 0.0, "param3": 0.0, "param4": 0.0, "param5": 0.0, "param6": 0.0, "param7": 0.0,
    }  # fmt: skip
    mode = packed("COMMAND_LONG", fields | {"command": mavlink.MAV_CMD_DO_SET_MODE}, 245)
    kill = packed("COMMAND_LONG", fields | {"command": mavlink.MAV_CMD_DO_FLIGHTTERMINATION}, 245)
    assert wire.passes(Direction.UP, mode)
    assert not wire.arrived.done()
    assert not wire.passes(Direction.UP, kill)
    assert wire.arrived.done()
    assert not wire.passes(Direction.UP, kill)
    assert wire.passes(Direction.DOWN, kill)
