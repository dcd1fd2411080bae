from __future__ import annotations

import argparse
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from hawk.sim.cli import main
from hawk.sim.photos_command import overlap


@pytest.fixture
def picture(tmp_path: Path) -> Path:
    path = tmp_path / "lot.png"
    cv2.imwrite(str(path), np.random.default_rng(1).integers(60, 200, (300, 400, 3), np.uint8))
    return path


def _photos(picture: Path, out: Path, *more: str) -> int:
    world = [f"--world={picture}", "--metres-per-pixel=0.1", "--width=320"]
    return main(["photos", *world, f"--out={out}", *more])


@pytest.mark.slow
def test_photographs_and_truth_are_written(picture: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert _photos(picture, tmp_path / "out", "--height=40", "--overlap=50/40", "--camera=FC330") == 0
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names[0] == "DJI_0001.JPG"
    assert names[-1] == "truth.json"
    assert f"{len(names) - 1} photographs in" in capsys.readouterr().out
    truth = json.loads((tmp_path / "out" / "truth.json").read_text())["photos"]
    assert (truth["camera"], truth["overlap"]) == ("FC330", [0.5, 0.4])
    assert {shot["height_m"] for shot in truth["shots"]} == {40.0}


@pytest.mark.slow
def test_the_noise_s_seed_is_the_world_s_unless_it_is_given(picture: Path, tmp_path: Path) -> None:
    for name, more in (("a", ["--seed=4"]), ("b", ["--noise-seed=4"]), ("c", ["--noise-seed=5"])):
        assert _photos(picture, tmp_path / name, *more) == 0
    errors = [json.loads((tmp_path / name / "truth.json").read_text())["photos"]["errors"] for name in "abc"]
    assert errors[0] == errors[1] != errors[2]


def test_it_must_be_the_first_word(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--seed", "2", "photos", f"--out={tmp_path / 'out'}"])
    assert ended.value.code == 2
    assert "photos: must be the first word" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("more", "named"),
    [
        (["--at=2026-05-04T10:30"], "--at"),
        (["--cars=1"], "--cars"),
        (["--height=5", "--overlap=95/95"], "--height"),
        (["--truth=none.json"], "--truth"),
    ],
)
def test_options_that_do_not_fit_are_named(
    more: list[str], named: str, picture: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        status = _photos(picture, tmp_path / "out", *more)
    except SystemExit as ended:
        status = int(ended.code or 0)
    assert status == 2
    assert named in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_folder_that_cannot_be_made_ends_with_one(
    picture: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    assert _photos(picture, tmp_path / "file" / "out") == 1
    assert "--out" in capsys.readouterr().err


@pytest.mark.parametrize(("text", "shares"), [("70/60", (0.7, 0.6)), ("0/95", (0.0, 0.95))])
def test_the_overlap_is_read_in_percent(text: str, shares: tuple[float, float]) -> None:
    assert overlap(text) == shares


@pytest.mark.parametrize("text", ["", "70", "70/60/1", "96/60", "nan/1", "-1/1"])
def test_a_wrong_overlap_is_refused(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="must be ALONG/BETWEEN"):
        overlap(text)
