"""The benchmark of a city: its mosaic, its runs, and what it calls different."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.city import once
from benchmarks.city.__main__ import _same
from benchmarks.city.picture import PIECE, write_mosaic
from hawk.picture.orthophoto.source import open_orthophoto
from hawk.picture.orthophoto.windows import windows_of

CORE_M = 20.0


def mosaic(folder: Path) -> Path:
    """Write a small mosaic of two grey pieces."""
    parts = [np.full((*PIECE, 3), grey, np.uint8) for grey in (90, 140)]
    return write_mosaic(folder / "mosaic.tif", parts, 56.0)


def test_a_mosaic_has_the_windows_that_its_side_says(tmp_path: Path) -> None:
    picture = open_orthophoto(mosaic(tmp_path))
    assert (picture.grid.columns, picture.grid.rows) == (560, 560)
    assert len(windows_of(picture, core_m=CORE_M)) == 4


@pytest.mark.slow
@pytest.mark.nightly
def test_a_run_says_what_it_found_and_goes_on_where_one_has_stopped(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = mosaic(tmp_path)
    for name, reused in (("one", 0), ("other", 0), ("one", 4)):
        assert once.main([str(picture), str(tmp_path / name), "--core", str(CORE_M)]) == 0
        found = json.loads(capsys.readouterr().out)
        assert (found["windows"], found["reused"], found["failed"]) == (4, reused, 0)
        assert found["mib_client"] > 50
    assert _same(tmp_path / "one", tmp_path / "other")
    next((tmp_path / "other" / "windows").iterdir()).unlink()
    assert not _same(tmp_path / "one", tmp_path / "other")
    assert once.main([str(tmp_path / "gone.tif"), str(tmp_path / "none")]) == 1
