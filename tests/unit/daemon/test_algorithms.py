"""The algorithms as the daemon builds them."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

from hawk.algo.vision.app import VisionSettings
from hawk.daemon.algorithms import _vision


def test_a_network_that_cannot_be_used_in_the_air_is_replaced_by_the_packaged_one(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.ERROR):
        vision = _vision(VisionSettings(model=tmp_path / "gone.onnx"))
    assert vision.get_health().is_healthy
    (line,) = caplog.messages
    assert "vision.model" in line
    assert "packaged network is used" in line
