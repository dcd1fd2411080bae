from __future__ import annotations

import asyncio
import io
from collections.abc import AsyncGenerator
from pathlib import Path

import cv2
import pytest
from rich.console import Console

from hawk.calibrate.camera_command import CameraPlan, Session, _Display, run_camera
from hawk.calibrate.lens import LensError
from hawk.cli import main
from hawk.comm.cameras.calibration import load_calibration
from hawk.comm.cameras.sources.source import CameraError, CameraSource, SourceFrame
from hawk.comm.clock import Clock
from hawk.config.sections import CameraSettings, Config
from tests.unit.calibrate.boards import TRUE, Picture
from tests.unit.jpegs import oriented


@pytest.fixture(scope="module")
def folder(pictures: list[Picture], tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("pictures")
    for k, picture in enumerate(pictures):
        cv2.imwrite(str(found / f"{k:02}.png"), picture)
    return found


@pytest.mark.slow
def test_a_folder_of_pictures_gives_the_file_and_the_setting(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings, out = tmp_path / "config.toml", tmp_path / "lens.yaml"
    settings.write_text("[camera]\n# calibration = 'camera.yaml'\n")
    line = ["calibrate", "--pictures", str(folder), "--out", str(out), "--config", str(settings), "--apply"]
    assert main(line) == 0
    said = capsys.readouterr()
    assert "19 views, error 0.1" in said.out
    assert "00.png: kept" in said.out
    assert f'calibration = "{out}"' in settings.read_text()
    model = load_calibration(CameraSettings(calibration=out)).for_size(TRUE.width, TRUE.height)
    assert model.fx == pytest.approx(TRUE.fx, abs=1.5)


@pytest.mark.nightly
def test_too_few_pictures_are_not_accepted_and_the_next_one_is_named(
    pictures: list[Picture], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for k, picture in enumerate(pictures[:9]):
        cv2.imwrite(str(tmp_path / f"{k}.png"), picture)
    out = tmp_path / "lens.yaml"
    assert main(["calibrate", "--pictures", str(tmp_path), "--out", str(out)]) == 1
    assert "not accepted: views are missing: move the board away" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.slow
def test_pictures_are_taken_as_the_sensor_gave_them_and_damaged_ones_are_left_out(
    pictures: list[Picture], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The size of the flight's pictures, whose orientation is not applied either."""
    for k, picture in enumerate(pictures[:3]):
        data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes()
        (tmp_path / f"{k}.jpg").write_bytes(oriented(data, 6) if k else data)
        (tmp_path / f"torn{k}.jpg").write_bytes(data[: len(data) // 2])
    assert main(["calibrate", "--pictures", str(tmp_path), "--out", str(tmp_path / "camera.yaml")]) == 1
    said = capsys.readouterr()
    assert "torn0.jpg: cannot be read (the picture is torn: its end is missing), left out" in said.err
    assert "2.jpg: kept" in said.out
    assert "two sizes" not in said.err


def test_pictures_of_two_sizes_are_refused(pictures: list[Picture]) -> None:
    session = Session(must_be_still=False)
    session.take(pictures[0])
    with pytest.raises(LensError, match="a picture is 480 x 540, the first was 960 x 540"):
        session.take(pictures[0][:, :480])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--out", "{there}"], "--out: {there} exists already: name another file, or give --replace"),
        (["--out", f"{{tmp}}/{'n' * 300}"], "cannot be written: File name too long; name a folder"),
        (["--pictures", "{tmp}/none"], "--pictures: {tmp}/none cannot be read: No such file"),
        (["--pictures", "{tmp}"], "--pictures: {tmp} has no pictures"),
        (["--json"], "--json: only for another work"),
        (["--paper", "A3"], "--paper: only for another work"),
        (["board", "--apply"], "--apply: not for the board"),
        (["--pictures", "{tmp}", "--camera", "file:///a.mp4"], "--camera: not with --pictures"),
        (["--in-flight", "--out", "{tmp}/lens.yaml"], "--out: not with --in-flight"),
        (["--apply"], "--apply: name the settings file"),
    ],
)
def test_options_that_cannot_be_used_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], words: str
) -> None:
    there = tmp_path / "there.yaml"
    there.touch()
    names = {"there": there, "tmp": tmp_path}
    assert main(["calibrate", "--store", str(tmp_path), *(each.format(**names) for each in options)]) == 2
    assert words.format(**names) in capsys.readouterr().err


class _Shown(CameraSource):
    """A camera before which the views are shown one after the other, again and again."""

    def __init__(self, jpegs: list[bytes], clock: Clock) -> None:
        self._jpegs, self._clock = jpegs, clock

    async def frames(self) -> AsyncGenerator[SourceFrame, None]:
        while True:
            for jpeg in self._jpegs:
                for _ in range(4):
                    yield SourceFrame(jpeg, self._clock())
                    await asyncio.sleep(0.02)


class _Absent(CameraSource):
    async def frames(self) -> AsyncGenerator[SourceFrame, None]:
        if self.torn == 0:
            raise CameraError("nothing at this address: plug it in")
        yield SourceFrame(b"", 0.0)


@pytest.mark.slow
def test_views_that_are_shown_to_the_camera_give_the_file(
    pictures: list[Picture], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    jpegs = [cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes() for picture in pictures]
    plan = CameraPlan(tmp_path / "lens.yaml", preview=tmp_path / "seen.jpg", limit_s=100.0)
    assert run_camera(Config(), plan, lambda _, clock: _Shown(jpegs, clock)) == 0
    said = capsys.readouterr()
    assert "next: move the board to the" in said.out
    assert "calibration = " in said.err
    model = load_calibration(CameraSettings(calibration=plan.out)).for_size(TRUE.width, TRUE.height)
    assert model.fx == pytest.approx(TRUE.fx, abs=2.0)
    preview = cv2.imread(str(plan.preview))
    assert preview is not None
    assert preview.shape == (360, 640, 3)


def test_a_terminal_shows_the_parts_in_place(pictures: list[Picture]) -> None:
    session, screen = Session(must_be_still=False), io.StringIO()
    session.take(pictures[4])
    with _Display(Console(file=screen, force_terminal=True, width=100), None) as display:
        display.show(session, pictures[4])
    assert "next: move the board to the" in screen.getvalue()
    assert "##" in screen.getvalue()


@pytest.mark.slow
def test_a_camera_that_is_not_there_ends_with_what_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = CameraPlan(tmp_path / "lens.yaml", limit_s=1.2)
    assert run_camera(Config(), plan, lambda *_: _Absent()) == 1
    said = capsys.readouterr()
    assert "not accepted: Camera: nothing at this address: plug it in" in said.err
    assert "nothing at this address" in said.out
    assert not plan.out.exists()
