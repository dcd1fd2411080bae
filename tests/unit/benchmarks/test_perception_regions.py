from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.perception import __main__ as command
from benchmarks.perception import sections
from benchmarks.perception.eyes import Result
from benchmarks.perception.measures import look
from benchmarks.perception.regions import Regions, left_out_option, region_section
from hawk.algo.vision.network import StallNetwork
from tests.unit.benchmarks.test_perception_edges import STALLS, Finder, found


def write_region(folder: Path, name: str, **more: str) -> None:
    image = np.random.default_rng(0).integers(60, 200, (200, 400, 3)).astype(np.uint8)
    cv2.imwrite(str(folder / f"{name}.jpg"), image)
    stalls = [{"corners_m": quad.tolist(), "state": "unclear"} for quad in STALLS]
    (folder / f"{name}.json").write_text(json.dumps({"metres_per_pixel": 0.1, "stalls": stalls, "lots_m": [], **more}))


def test_regions_have_rows_of_lots_streets_and_grounds(tmp_path: Path) -> None:
    for name in ("estate_a", "estate_b"):
        write_region(tmp_path, name)
    for name, ground in (("campus", "brick"), ("office", "pavers")):
        write_region(tmp_path, name, ground=ground)
    regions = Regions(tmp_path, ("estate_*",))
    places = regions.read()
    some = {"office": STALLS[1:], "campus": STALLS[1:], "estate_a": STALLS[1:4], "estate_b": STALLS[1:7]}
    looked = [one for p in places for one in look(Finder(some[p.name]), [p])]
    values = {figure.key: figure.value for figure in region_section(regions, looked).figures}
    assert values["regions_lots_recall"] == 1.0
    assert values["regions_streets_recall"] == pytest.approx(0.5)
    assert values["regions_all_recall"] == pytest.approx(0.75)
    assert (values["regions_ground_pavers_labels"], values["regions_ground_brick_labels"]) == (9, 9)
    assert values["regions_streets_precision"] == 1.0
    assert "regions_all_lot_iou" not in values


class Suggester(Finder):
    """Finds all stalls but two, and suggests one of these and one beside them."""

    def look(self, image: NDArray[np.uint8], metres_per_pixel: float, *, scale: float = 1.0) -> Result:
        return replace(found(STALLS[3:]), suggested=np.stack([STALLS[1], STALLS[2] + (0.0, 40.0)]))


def test_suggested_stalls_count_apart(tmp_path: Path) -> None:
    write_region(tmp_path, "office")
    looked = look(Suggester(STALLS), Regions(tmp_path).read())
    values = {figure.key: figure.value for figure in region_section(Regions(tmp_path), looked).figures}
    assert (values["regions_all_suggested"], values["regions_all_suggested_labelled"]) == (2, 1)
    assert values["regions_all_recall"] == pytest.approx(7 / 9)
    assert values["regions_all_recall_with_suggested"] == pytest.approx(8 / 9)
    assert values["regions_all_precision"] == 1.0


def test_a_pattern_that_fits_no_region_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_region(tmp_path, "office")
    with pytest.raises(ValueError, match=r"'street\*' fits no region"):
        Regions(tmp_path, ("street*",)).read()
    assert command.main(["--regions", str(tmp_path), "--streets", "x*"]) == 2
    assert "fits no region" in capsys.readouterr().err


def test_regions_are_looked_at_by_the_network_that_was_not_trained_on_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("office", "estate_a"):
        write_region(tmp_path, name)
    fold = tmp_path / "fold.onnx"
    fold.write_bytes(b"weights")
    assert left_out_option(f"{fold}=estate_*") == (fold, "estate_*")
    regions = Regions(tmp_path, left_out=((fold, "estate_*"),))
    assert (regions.model("office"), regions.model("estate_a")) == (None, fold)
    monkeypatch.setattr(StallNetwork, "load", lambda path: path)
    monkeypatch.setattr(sections, "NetworkEye", lambda network: Finder(STALLS[1:3] if network == fold else STALLS[1:6]))
    looked = sections.look_left_out(Finder(STALLS[1:6]), regions)
    assert {one.place.name: one.tally.matched for one in looked} == {"office": 5, "estate_a": 2}
    with pytest.raises(ValueError, match="fits no region"):
        Regions(tmp_path, left_out=((fold, "x*"),)).read()
    with pytest.raises(SystemExit):
        command.main(["--left-out", "estate_*"])
    assert "write FILE=PATTERN" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["lots", "tiles", "negatives"])
def test_a_folder_that_is_not_there_is_refused(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        command.main([f"--{name}", "nowhere"])
    assert f"--{name}: nowhere is no folder" in capsys.readouterr().err
