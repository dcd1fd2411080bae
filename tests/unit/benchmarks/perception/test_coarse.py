"""Cost of coarser pictures."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.perception.coarse import coarser, main
from benchmarks.perception.places import Place
from hawk.survey.accuracy import LabelledPlace


def place() -> Place:
    image = np.zeros((100, 200, 3), np.uint8)
    image[:, 100:] = 200
    missing = np.zeros((100, 200), np.bool_)
    missing[:50] = True
    nothing = LabelledPlace(np.zeros((0, 4, 2)), np.zeros(0, object))
    return Place("place", image, 0.1, nothing, missing=missing)


def test_a_place_is_averaged_and_keeps_its_ground() -> None:
    coarse = coarser(place(), 0.2)
    assert coarse.image.shape == (50, 100, 3)
    assert (coarse.metres_per_pixel, coarse.image[:, 49].max(), coarse.image[:, 50].min()) == (0.2, 0, 200)
    assert coarse.missing is not None
    assert coarse.missing.mean() == 0.5


def test_a_place_that_is_as_coarse_stays() -> None:
    assert coarser(place(), 0.1).image.shape == (100, 200, 3)


@pytest.mark.slow
def test_each_scale_has_a_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cv2.imwrite(str(tmp_path / "lot.jpg"), place().image)
    stall = {"corners_m": [[1, 1], [3.5, 1], [3.5, 6], [1, 6]], "state": "free"}
    labels = {"metres_per_pixel": 0.1, "stalls": [stall], "lots_m": []}
    (tmp_path / "lot.json").write_text(json.dumps(labels))
    main(["--lots", str(tmp_path), "--metres", "0.2"])
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["0.00", "0.20"]
    assert all("labels 1.000  recall 0.000" in line for line in lines)
