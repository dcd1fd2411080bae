from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.perception import marks
from benchmarks.perception.eyes import Result
from benchmarks.perception.marks import KINDS, Count, lots, measure
from hawk.survey.accuracy import Finding
from training.scenes import Scene


class Finds:
    """Finds the taken stalls of the scenes in their order, and none of the free ones."""

    def __init__(self, scenes: list[Scene]) -> None:
        self.scenes = {scene.image.tobytes(): scene for scene in scenes}

    def look(self, image: NDArray[np.uint8], metres_per_pixel: float, *, scale: float = 1.0) -> Result:
        taken = [stall.quad for stall in self.scenes[image.tobytes()].stalls if stall.taken]
        quads = (np.array(taken).reshape(-1, 4, 2) + 0.5) * metres_per_pixel
        finding = Finding(quads, np.zeros(len(quads), np.int8))
        return Result(finding, np.ones(len(quads)), np.zeros((1, 1), np.bool_))


@pytest.mark.slow
def test_free_and_taken_stalls_are_counted_apart() -> None:
    scenes = list(lots("dots", 0.5, 3))
    counts = measure(Finds(scenes), iter(scenes))
    assert counts[True].stalls > 5
    assert counts[True].recall == 1
    assert counts[False].stalls > 5
    assert counts[False].found == 0


@pytest.mark.slow
def test_a_kind_has_its_marks_and_an_occupancy_its_cars() -> None:
    assert set(KINDS) == {"lines", "dots", "tees", "corners", "blocks", "nothing"}
    empty, full = (list(lots("nothing", share, 4)) for share in (0.0, 1.0))
    assert not any(stall.lines_visible for scene in empty for stall in scene.stalls)
    shares = [np.mean([stall.taken for scene in scenes for stall in scene.stalls]) for scenes in (empty, full)]
    assert shares[0] < 0.2 < 0.8 < shares[1]
    with pytest.raises(KeyError):
        next(lots("chalk", 0.5))


def test_without_stalls_there_is_no_recall() -> None:
    assert math.isnan(Count().recall)
    assert Count(4, 1).recall == 0.25


@pytest.mark.slow
def test_the_command_prints_a_row_for_each_kind_and_fill(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(marks, "KINDS", {"tees": KINDS["tees"]})
    assert marks.main(["--scenes", "1", "--json", str(tmp_path / "marks.json")]) == 0
    rows = [line for line in capsys.readouterr().out.splitlines() if line.startswith("| tees")]
    assert len(rows) == 2
    assert "marks_tees_nearly_empty_free" in (tmp_path / "marks.json").read_text()
