from __future__ import annotations

from pathlib import Path

import pytest

from tests.unit.picture.film.films import Flight, stop_and_go, straight, write_film

STRAIGHT = Flight(straight, 8.0)
STOPPED = Flight(stop_and_go, 10.0)


@pytest.fixture(scope="session")
def straight_film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_film(tmp_path_factory.mktemp("film") / "DJI_0001.MP4", STRAIGHT)


@pytest.fixture(scope="session")
def stopped_film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_film(tmp_path_factory.mktemp("film") / "GOPR0002.MP4", STOPPED)
