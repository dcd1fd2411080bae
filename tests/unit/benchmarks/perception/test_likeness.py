from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.perception import likeness
from benchmarks.perception.likeness import Spread, statistics, table, worlds
from hawk.model.lot_map import StallState
from tests.unit.benchmarks.test_perception_categories import SHADE, ground, place, row, shade


def test_the_statistics_are_those_of_the_picture(tmp_path: Path) -> None:
    picture = ground()
    shade(picture, 4, 12.5, 14, 18)
    found = statistics([place(picture, row(), [StallState.FREE] * 8)])
    assert found["shade_green"].median == pytest.approx(0.5, abs=0.03)
    assert found["shade_blue"].median == pytest.approx(SHADE[0] / SHADE[1], abs=0.05)
    assert found["shade_red"].median == pytest.approx(SHADE[2] / SHADE[1], abs=0.05)
    assert (found["lit_blue"].median, found["lit_red"].median) == pytest.approx((1.0, 1.0), abs=0.02)
    assert found["line_contrast"].median == pytest.approx(0.5, abs=0.1)
    assert 0.08 < found["line_width"].median < 0.25
    assert found["brightness"].median == pytest.approx(picture[..., 1].mean(), abs=1)
    assert found["stalls"].median == 8
    assert found["stalls_per_1000_m2"].median == pytest.approx(8 / 0.6)
    blurred = np.asarray(cv2.GaussianBlur(picture, (0, 0), 2.0), np.uint8)
    soft = statistics([place(blurred, row(), [StallState.FREE] * 8)])
    assert soft["sharpness"].median < 0.6 * found["sharpness"].median


def test_a_spread_leaves_out_what_was_not_measured() -> None:
    spread = Spread.of(np.array([np.nan, 1.0, 2.0, 3.0]))
    assert (spread.median, spread.count) == (2.0, 3)
    assert str(spread) == "2.00 (1.20 to 2.80)"
    assert str(Spread.of(np.array([np.nan]))) == "–"


def test_the_command_writes_a_column_for_each_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cv2.imwrite(str(tmp_path / "lot.jpg"), ground(), [cv2.IMWRITE_JPEG_QUALITY, 95])
    stalls = [{"corners_m": quad.tolist(), "state": "free"} for quad in row()]
    (tmp_path / "lot.json").write_text(json.dumps({"metres_per_pixel": 0.1, "stalls": stalls, "lots_m": []}))
    out = tmp_path / "out" / "likeness.json"
    out.parent.mkdir()
    assert likeness.main(["--lots", str(tmp_path), "--json", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "| | real lots |" in printed
    assert "| stalls a picture | 8.00 (8.00 to 8.00) |" in printed
    figures = json.loads(out.read_text())
    assert figures["real_lots_stalls_p50"] == 8
    assert figures["real_lots_shade_green_p50"] is None, "there is no shade"
    assert (
        table({"a": statistics([place(ground(), row(), [StallState.FREE] * 8)])}).count("\n") == len(likeness.ROWS) + 1
    )


def test_nothing_to_look_at_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        likeness.main([])
    assert likeness.main(["--lots", str(tmp_path)]) == 1
    assert "no picture to look at" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.nightly
def test_a_drawn_world_is_seen_with_its_stalls_where_they_are() -> None:
    (world,) = worlds([3])
    found = statistics([world])
    assert found["stalls"].median > 20
    assert found["line_contrast"].count > found["stalls"].median, "most sides of stalls show their line"
