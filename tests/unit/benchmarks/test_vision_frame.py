"""The network's time by engine: those that are not installed are named and left out."""

from __future__ import annotations

import sys

import pytest

from benchmarks.vision_frame import engine_figures, frames
from hawk.algo.frame import FrameInput
from hawk.worlds.generate import generate_world


@pytest.fixture(scope="module")
def inputs() -> list[FrameInput]:
    return frames(generate_world(1), 20.0, 1)


@pytest.mark.nightly
@pytest.mark.slow
def test_each_engine_is_timed_beside_opencv(inputs: list[FrameInput]) -> None:
    figures = {figure.key: figure for figure in engine_figures(inputs)}
    assert figures["engine_opencv_ms"].ratio == 1.0
    assert figures["engine_onnxruntime_ms"].reference == figures["engine_opencv_ms"].reference


@pytest.mark.slow
@pytest.mark.nightly
def test_an_engine_that_is_not_installed_is_left_out(
    inputs: list[FrameInput], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    assert [figure.key for figure in engine_figures(inputs)] == ["engine_opencv_ms"]
    assert "onnxruntime is not installed" in capsys.readouterr().err
