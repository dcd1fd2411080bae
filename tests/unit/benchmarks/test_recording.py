"""The recording benchmark records what it says, and its file is one."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.archive import recording_figures
from benchmarks.recording import PART_S, PICTURES_S, TICKS_S, Recorded, measure
from hawk.algo.frame import FrameInput
from hawk.store.replay import read_frames, read_recording


@pytest.mark.slow
async def test_ticks_and_pictures_of_a_flight_are_recorded_and_cost_something(tmp_path: Path) -> None:
    found = await measure(tmp_path, PART_S)
    assert found.lost == 0
    assert 0 < found.cpu < 1
    (path,) = (tmp_path / "recordings").iterdir()
    assert found.bytes_s == path.stat().st_size / PART_S
    assert found.bytes_s > 500_000
    topics = [one.topic for one in read_recording(path)]
    assert (topics.count("tick"), topics.count("memory"), topics.count("stalls")) == (PART_S * TICKS_S, 1, 1)
    frames = list(read_frames(path, FrameInput))
    assert len(frames) == PART_S * PICTURES_S
    assert min(len(frame.jpeg) for frame in frames) > 50_000


def test_a_recording_that_costs_too_much_or_loses_messages_fails() -> None:
    assert [figure.passed for figure in recording_figures(Recorded(0.05, 1e6, 0))] == [True, None, True]
    assert [figure.passed for figure in recording_figures(Recorded(0.06, 1e6, 1))] == [False, None, False]
