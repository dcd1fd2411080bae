from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.perception import wrong_states as command
from benchmarks.perception.measures import look
from benchmarks.perception.wrong_states import COLUMNS, SIDE_PX, Wrong, sheet, wrong_states
from hawk.model.lot_map import StallState
from tests.unit.benchmarks.test_perception import ROW, Oracle, place, write_tiles


def test_only_stalls_that_were_found_in_the_wrong_state_are_yielded() -> None:
    """Of the place's six stalls, free and taken in turn, four are found, and two of them wrongly taken for taken."""
    found = list(wrong_states(look(Oracle(ROW[:4], np.ones(4)), [place()])))
    assert [one.labelled for one in found] == [StallState.FREE, StallState.FREE]
    assert np.array_equal([one.corners for one in found], ROW[[0, 2]])


def test_a_sheet_shows_each_with_its_outline_in_the_label_s_colour() -> None:
    wrong = [Wrong(place(), ROW[k % 6], StallState.FREE if k % 2 else StallState.TAKEN) for k in range(COLUMNS + 1)]
    drawn = sheet(wrong)
    assert drawn.shape == (2 * SIDE_PX, COLUMNS * SIDE_PX, 3)
    for k in range(COLUMNS + 1):
        top, left = k // COLUMNS * SIDE_PX, k % COLUMNS * SIDE_PX
        _, green, red = drawn[top : top + SIDE_PX, left : left + SIDE_PX].reshape(-1, 3).max(axis=0)
        assert bool(red > green) is (k % 2 == 0)
    assert sheet([]).shape == (SIDE_PX, COLUMNS * SIDE_PX, 3)


def test_the_command_writes_a_picture_and_says_how_many(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_tiles(tmp_path / "tiles", {"many": 5}, ["0 0.025 0.15 0.05 0.1"])
    monkeypatch.setattr("benchmarks.perception.wrong_states.StallNetwork.load", lambda _: None)
    monkeypatch.setattr(command, "NetworkEye", lambda _: Oracle(np.zeros((0, 4, 2)), np.zeros(0)))
    out = tmp_path / "pictures"
    assert command.main(["--tiles", str(tmp_path / "tiles"), "--out", str(out)]) == 0
    assert (out / "tiles.png").exists()
    assert "tiles: 0 wrong states" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        command.main(["--out", str(out)])
    assert "--lots" in capsys.readouterr().err
