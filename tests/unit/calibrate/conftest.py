from __future__ import annotations

import pytest

from tests.unit.calibrate.boards import Picture, Studio, poses, sheet


@pytest.fixture(scope="session")
def studio() -> Studio:
    return Studio(sheet())


@pytest.fixture(scope="session")
def pictures(studio: Studio) -> list[Picture]:
    """Pictures that a calibration needs, by a known lens."""
    return [studio.view(pose, seed=k) for k, pose in enumerate(poses())]
