from __future__ import annotations

import contextlib
import os
import re
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from hawk.cli import main
from hawk.sim.photos import PhotoOptions, write_photos
from hawk.sim.photos_tags import CAMERAS
from tests.drawn_worlds import drawn_world

OPTIONS = PhotoOptions(height=35.0, width=700, overlap=(0.6, 0.3), camera=CAMERAS["FC6310"], noise_seed=3)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ([], "--store: is needed with --watch"),
        (["--store", "s", "--out", "o"], "--out: not together with --watch"),
        (["--store", "s", "--name", "North"], "--name: not together with --watch"),
        (["--store", "s", "--page"], "--page: not together with --watch"),
        (["--store", "s", "--group", "1"], "--group: not together with --watch"),
        (["--store", "s", "--memory", "10"], "--memory: must be a number from 500"),
        (["--store", "s", "--calibration", "none.yaml"], "none.yaml"),
    ],
)
def test_options_that_an_inbox_has_no_use_for_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], given: list[str], words: str
) -> None:
    given = [str(tmp_path / each) if each in ("s", "o") else each for each in given]
    (tmp_path / "in").mkdir()
    assert main(["map", "--watch", str(tmp_path / "in"), *given]) == 2
    assert words in capsys.readouterr().err


def test_a_folder_whose_own_files_would_be_moved_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main(["map", "--watch", str(tmp_path), "--store", str(tmp_path / "store")]) == 2
    assert f"--watch: {tmp_path} holds the store" in capsys.readouterr().err
    monkeypatch.setenv("HOME", str(tmp_path / "home/anna"))
    assert main(["map", "--watch", str(tmp_path), "--store", str(tmp_path.parent / "store")]) == 2
    assert "holds a home folder, whose files would be moved" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_without_an_inbox_source_and_out_are_needed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["map", "--out", str(tmp_path / "out")]) == 2
    assert "SOURCE: is needed without --watch" in capsys.readouterr().err
    assert main(["map", str(tmp_path)]) == 2
    assert "--out: is needed without --watch" in capsys.readouterr().err
    assert main(["map", str(tmp_path), "--out", str(tmp_path / "out"), "--settle", "5"]) == 2
    assert "--settle: only together with --watch" in capsys.readouterr().err
    assert main(["map", str(tmp_path), "--out", str(tmp_path / "out"), "--flight", "{}"]) == 2
    assert "--flight: is no identity of a flight" in capsys.readouterr().err


@contextlib.contextmanager
def inbox(root: Path) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-m", "hawk.cli", "map", "--watch", str(root / "in"), "--store", str(root / "store")]
    with subprocess.Popen(
        [*command, "--settle", "1"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def read_until(process: subprocess.Popen[str], pattern: str) -> str:
    assert process.stdout is not None
    for line in process.stdout:
        if re.search(pattern, line):
            return line
    raise AssertionError(f"{pattern} was not said")


@pytest.mark.nightly  # of test_app.py a cheaper one cuts every step
def test_two_parts_become_one_survey_though_the_inbox_is_killed(tmp_path: Path) -> None:
    write_photos(drawn_world(3), OPTIONS, tmp_path / "yard")
    photographs = sorted((tmp_path / "yard").glob("*.JPG"))
    (tmp_path / "in/north").mkdir(parents=True)
    for path in photographs[:4]:
        path.rename(tmp_path / "in/north" / path.name)
    with inbox(tmp_path) as process:
        read_until(process, "north: begins: pictures: 4")
        process.send_signal(signal.SIGKILL)
    with inbox(tmp_path) as process:
        line = read_until(process, "north: done|--store: another inbox")
        if "another" in line:  # the mapping ends with its inbox, some milliseconds later
            process.wait()
    with inbox(tmp_path) as process:
        if "another" in line:
            read_until(process, "north: done")
        (tmp_path / "in/later").mkdir()
        for path in photographs[4:7]:
            path.rename(tmp_path / "in/later" / path.name)
        read_until(process, "north: done")
        other = main(["map", "--watch", str(tmp_path / "in"), "--store", str(tmp_path / "store")])
        assert other == 2
        process.send_signal(signal.SIGTERM)
        assert process.wait(30) == 0
    base = sqlite3.connect(tmp_path / "store/lots.db")
    surveys = base.execute("SELECT id, placed, free + taken + unknown FROM survey").fetchall()
    (present,) = base.execute("SELECT count(*) FROM stall WHERE ends IS NULL").fetchone()
    base.close()
    assert [row[1] for row in surveys] == ["first"]
    assert present == surveys[0][2] > 20
    said = (tmp_path / "in/done/north/report.txt").read_text()
    assert surveys[0][0] in said
    assert "Pictures: 7, which came in 2 parts." in said
    assert len(os.listdir(tmp_path / "in/done/north/pictures")) == 7
    assert not (tmp_path / "in/done/north/survey/work").exists()
