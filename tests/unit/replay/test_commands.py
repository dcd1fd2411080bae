"""The command ``hawk-drone replay``: its options, exit statuses, and files."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from hawk.cli import main
from hawk.replay import process as processing
from hawk.replay.flight import Maker
from tests.unit.replay.recordings import FakeAgain, flight, frame, recorded_frame, tick, write


@pytest.fixture
def fake_vision(monkeypatch: pytest.MonkeyPatch) -> None:
    class Fake(FakeAgain):
        def __init__(self, _config: object, version: str, model: Path | None = None) -> None:
            super().__init__()
            self.maker = Maker(version, "feed0001" if model is None else "feed0002")

    monkeypatch.setattr(processing, "Again", Fake)


@pytest.mark.usefixtures("fake_vision")
def test_a_map_that_is_equal_ends_with_zero_and_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path / "a.mcap", flight(4, 3))
    given = ["--process", "--json", str(tmp_path / "a.json"), "--out", str(tmp_path / "out")]
    assert main(["replay", str(path), *given]) == 0
    said = capsys.readouterr().out
    assert "4 of 4 recorded maps are equal byte for byte" in said
    assert "network feed0001" in said
    assert json.loads((tmp_path / "a.json").read_text())["maps_equal"] == 4
    assert (tmp_path / "out" / "stalls.csv").exists()


@pytest.mark.usefixtures("fake_vision")
def test_a_map_that_differs_ends_with_one_and_another_network_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path / "a.mcap", flight(4, 4))
    model = tmp_path / "other.onnx"
    model.write_bytes(b"a network")
    assert main(["replay", str(path), "--model", str(model)]) == 1
    said = capsys.readouterr().out
    assert "recorded by hawk-drone 0.2.9, network 0123abcd" in said
    assert "network feed0002" in said
    assert "the last map: 1 lost" in said


def test_pictures_are_handed_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    items = [*flight(2), recorded_frame(frame(3, jpeg=b"\xff\xd8torn"), 14.0)]
    path = write(tmp_path / "a.mcap", items, is_closed=False)
    assert main(["replay", str(path), "--to-odm", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "2 pictures, geo.txt, cameras.json; 0 left out" in said
    assert "pictures that could not be read: 1" in said
    assert "written up to the damage at 3.5 s: the file has no end" in said


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--json", "a.json"], "--json: only together with --check or --process"),
        (["--check", "--port", "0"], "--port: only without --check, --process and --to-odm"),
        (["--check", "--process"], "not allowed with argument --check"),
        (["--check", "--model", __file__], "--model: only together with --process"),
        (["--to-odm", "new", "--model", __file__], "--model: only together with --process"),
        (["--check", "--out", "new"], "--out: only together with --process"),
        (["--to-odm", "new", "--json", "a.json"], "--json: not together with --to-odm"),
    ],
)
def test_options_that_do_not_fit_together_are_refused(
    options: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["replay", __file__, *options]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "words"),
    [(["--process"], "holds no pictures"), (["--to-odm", "new"], "holds no pictures from 6 m above the ground")],
)
def test_a_recording_without_pictures_is_refused_in_a_line(
    options: list[str],
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    path = write(tmp_path / "a.mcap", [tick(10.5)])
    assert main(["replay", str(path), *options]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("hawk-drone replay: ")
    assert words in line
    assert [each.name for each in tmp_path.iterdir()] == ["a.mcap"]


@pytest.mark.usefixtures("fake_vision")
def test_a_report_that_cannot_be_written_is_an_error_with_a_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path / "a.mcap", flight(2))

    def full(*_: object, **__: object) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    assert main(["replay", str(path), "--process", "--json", str(tmp_path / "a.json")]) == 1
    assert "a.json cannot be written: No space left on device; name a file on a disk" in capsys.readouterr().err


@pytest.mark.usefixtures("fake_vision")
def test_progress_is_shown_on_a_terminal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path / "a.mcap", flight(10))
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    main(["replay", str(path), "--process"])
    assert "10 pictures" in capsys.readouterr().err
