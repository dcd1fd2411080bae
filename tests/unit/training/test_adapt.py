"""Weights are written only where they are taken."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from hawk.survey.accuracy import Tally
from training import adapt
from training.lessons import Judgement, Split

WORSE, SAME, BETTER = (Tally(matched=n, found=100, true=100) for n in (80, 85, 90))
Run = Callable[..., int]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Return a run of the command whose networks are judged as given: before, the whole step, half of it."""

    def make(name: str) -> Callable[..., Path]:
        def write(_options: object, _parts: Split, _base: Path, folder: Path) -> Path:
            (folder / name).write_bytes(name.encode())
            return folder / name

        return write

    def call(*judgements: tuple[Tally, Tally]) -> int:
        given = iter([Judgement(later, drawn) for later, drawn in judgements])
        monkeypatch.setattr(adapt, "judge", lambda *_: next(given))
        monkeypatch.setattr(adapt, "split", lambda _: Split(("a1",), ("a2",)))
        monkeypatch.setattr(adapt, "read_lots", lambda _: [])
        monkeypatch.setattr("hawk.algo.vision.network.StallNetwork.load", lambda _: None)
        monkeypatch.setattr(adapt, "_train", make("whole"))
        monkeypatch.setattr(adapt, "_half", make("half"))
        return adapt.main([str(tmp_path), "--out", str(tmp_path / "new.onnx")])

    return call


def test_the_whole_step_is_written_where_it_is_taken(run: Run, tmp_path: Path) -> None:
    assert run((SAME, SAME), (BETTER, SAME)) == 0
    assert (tmp_path / "new.onnx").read_bytes() == b"whole"


def test_half_of_the_step_is_tried_where_the_whole_one_is_worse_on_drawn_worlds(run: Run, tmp_path: Path) -> None:
    assert run((SAME, SAME), (BETTER, WORSE), (BETTER, SAME)) == 0
    assert (tmp_path / "new.onnx").read_bytes() == b"half"


def test_nothing_is_written_over_a_file_where_both_are_refused(
    run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "new.onnx").write_bytes(b"mine")
    assert run((SAME, SAME), (BETTER, WORSE), (SAME, SAME)) == 1
    assert (tmp_path / "new.onnx").read_bytes() == b"mine"
    said = capsys.readouterr().out
    assert "whole step: refused, worse on drawn worlds" in said
    assert "half of it: refused, no better on the later flights" in said


def test_a_folder_that_teaches_nothing_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert adapt.main([str(tmp_path), "--out", str(tmp_path / "new.onnx")]) == 2
    assert "name the folder that hawk-drone export" in capsys.readouterr().err
