from __future__ import annotations

import json
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from hawk.picture.work_folder import WORK
from hawk.sim.photos import PhotoOptions, write_photos
from hawk.sim.photos_tags import CAMERAS
from tests.drawn_worlds import drawn_world

OPTIONS = PhotoOptions(height=35.0, width=700, overlap=(0.6, 0.3), camera=CAMERAS["FC6310"], noise_seed=3)
KILLED = """
import os, signal, sys
from pathlib import Path
from hawk.picture.sources import MapRequest, survey_of_source

def progress(step, done, of):
    if step == sys.argv[3] and done >= 2:
        os.kill(os.getpid(), signal.SIGKILL)

survey_of_source(MapRequest(Path(sys.argv[1]), Path(sys.argv[2])), progress)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Five photographs of a flight over a drawn lot."""
    path = tmp_path_factory.mktemp("flight") / "yard"
    write_photos(drawn_world(3), OPTIONS, path)
    for more in sorted(path.glob("*.JPG"))[5:]:
        more.unlink()
    return path


def command(folder: Path, out: Path, *more: str) -> list[str]:
    return [sys.executable, "-m", "hawk.cli", "map", str(folder), "--out", str(out), "--json", *more]


def killed_while(step: str, folder: Path, out: Path) -> None:
    """Map a folder, and kill that with -9 within a step, its first photographs done."""
    run = subprocess.run([sys.executable, "-c", KILLED, str(folder), str(out), step], check=False)
    assert run.returncode == -signal.SIGKILL
    assert not (out / "report.json").exists()


def files(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}


@pytest.mark.slow
@pytest.mark.nightly
def test_a_map_that_was_killed_twice_goes_on_to_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    whole, out = tmp_path / "whole", tmp_path / "out"
    subprocess.run(command(folder, whole), check=True, stdout=subprocess.DEVNULL)
    for step in ("read", "match", "map"):
        killed_while(step, folder, out)
    kept = {path.name: path.stat().st_mtime_ns for path in (out / WORK).iterdir()}
    assert {name.partition("-")[0] for name in kept} == {"features", "middles", "ties", "poses", "found"}
    torn = next(path for path in sorted((out / WORK).iterdir()) if path.name.startswith("found"))
    torn.write_bytes(torn.read_bytes()[:100])
    subprocess.run(command(folder, out, "--resume"), check=True, stdout=subprocess.DEVNULL)
    assert files(out) == files(whole)
    now = {path.name: path.stat().st_mtime_ns for path in (out / WORK).iterdir()}
    assert {name for name in kept if now[name] != kept[name]} == {torn.name}
    assert set(now) == {path.name for path in (whole / WORK).iterdir()}


@pytest.mark.slow
@pytest.mark.nightly
def test_a_photograph_that_changed_is_looked_at_again(folder: Path, tmp_path: Path) -> None:
    changed, out, whole = tmp_path / "yard", tmp_path / "out", tmp_path / "whole"
    shutil.copytree(folder, changed)
    killed_while("map", changed, out)
    first = min(changed.glob("*.JPG"))
    first.write_bytes(first.read_bytes()[:-3000])
    names = {path.name for path in (out / WORK).iterdir() if path.name.startswith("features")}
    for target, more in ((out, ["--resume"]), (whole, [])):
        assert subprocess.run(command(changed, target, *more), check=False, stdout=subprocess.DEVNULL).returncode == 3
    assert files(out) == files(whole)
    assert json.loads((out / "report.json").read_bytes())["left_out"][0]["name"] == first.name
    assert names == {path.name for path in (out / WORK).iterdir() if path.name.startswith("features")}
