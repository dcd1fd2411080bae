"""The replay benchmark decides a real flight, and processes pictures in which stalls are found."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.archive import replay_figures
from benchmarks.replayed import PICTURES_S, Replayed, draw, measure
from hawk.algo.frame import FrameInput
from hawk.store.replay import read_frames


@pytest.mark.nightly
@pytest.mark.slow
def test_a_flight_is_decided_and_processed(tmp_path: Path) -> None:
    found = measure(tmp_path, 3)
    assert found.differences == 0
    assert found.decided_x > 1
    assert found.processed_x > 0
    assert found.waited_x > 0
    assert found.stalls > 5
    assert found.processed_x == pytest.approx(1000 / PICTURES_S / found.picture_ms)


@pytest.mark.slow
@pytest.mark.nightly
def test_the_drawn_flight_moves_on(tmp_path: Path) -> None:
    frames = list(read_frames(draw(tmp_path / "a.mcap", 1), FrameInput))
    assert len(frames) == PICTURES_S
    assert len({frame.pose for frame in frames}) == PICTURES_S
    assert min(len(frame.jpeg) for frame in frames) > 20_000


def test_a_replay_that_is_slow_or_differs_fails() -> None:
    passed = [figure.passed for figure in replay_figures(Replayed(20.0, 0, 2.0, 100.0, 3.0, 30))]
    assert passed == [True, True, True, None, None, True]
    failed = [figure.passed for figure in replay_figures(Replayed(19.0, 1, 1.9, 100.0, 3.0, 0))]
    assert failed == [False, False, False, None, None, False]
