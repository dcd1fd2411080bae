from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.figures import BenchmarkError, Figure
from benchmarks.surveys import (
    SPEEDS,
    Survey,
    _result,
    _void,
    figures,
    in_time,
    least_distance_m,
    place_figures,
    place_worlds,
)
from hawk.sim.launch import SLOWEST
from hawk.survey.run import LATE_FRAMES_LIMIT
from hawk.survey.truth import GroundTruth

RIGHT_ANGLE = math.pi / 2  # a picture is twice as wide as the drone is high
GOOD = {
    "status": 0, "landed": True, "disarmed": True, "stall_f1": 0.9, "free_count_error": 0.02,
    "free_count_error_stalls": 1.0, "excursions": 0, "distance_flown_m": 300.0, "late_frames": 0.001,
}  # fmt: skip


def lot(width: float, height: float, x: float = 0.0) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array([[x, 0], [x + width, 0], [x + width, height], [x, height]], float)


def truth(*lots: np.ndarray[Any, np.dtype[np.float64]]) -> GroundTruth:
    return GroundTruth((), (), (), lots, None)


def by_key(found: list[Figure]) -> dict[str, Figure]:
    return {figure.key: figure for figure in found}


def test_the_least_distance_is_the_area_beyond_the_first_picture_by_the_width_of_a_picture() -> None:
    # 20 m wide, 11.25 m deep pictures over 100 m x 40 m
    assert least_distance_m(truth(lot(100, 40)), 10.0, RIGHT_ANGLE) == pytest.approx((4000 - 20 * 11.25) / 20)


def test_lots_that_overlap_are_counted_once() -> None:
    one = least_distance_m(truth(lot(100, 40)), 10.0, RIGHT_ANGLE)
    assert least_distance_m(truth(lot(100, 40), lot(50, 40, 25)), 10.0, RIGHT_ANGLE) == pytest.approx(one)


def test_a_lot_within_one_picture_takes_no_distance() -> None:
    assert least_distance_m(truth(lot(5, 5)), 10.0, RIGHT_ANGLE) == 0.0


@pytest.mark.parametrize(
    ("share", "stalls", "right"),
    [
        (0.02, 1.0, True),
        (0.30, 3.0, True),  # few free stalls: three may be missed
        (-0.09, -9.0, True),
        (0.11, 11.0, False),
        (-0.5, -4.0, False),
        (None, 2.0, True),  # no free stall at all, two seen
        (None, 4.0, False),
        (0.0, None, False),
    ],
)
def test_a_count_is_right_within_a_tenth_or_three_stalls(
    share: float | None, stalls: float | None, right: bool
) -> None:
    survey = Survey("seed-1", {"free_count_error": share, "free_count_error_stalls": stalls}, 100.0)
    assert survey.count_is_right is right


def test_a_survey_that_did_not_land_is_not_finished() -> None:
    assert Survey("seed-1", GOOD, 100.0).finished
    for change in ({"landed": False}, {"disarmed": False}, {"status": 4}):
        assert not Survey("seed-1", {**GOOD, **change}, 100.0).finished
    assert not Survey("seed-1", {}, 0.0).finished


def test_figures_of_several_surveys_have_mean_and_worst() -> None:
    worse = {**GOOD, "stall_f1": 0.8, "free_count_error": -0.2, "free_count_error_stalls": -9.0, "excursions": 2}
    found = by_key(figures([Survey("seed-1", GOOD, 100.0), Survey("seed-2", worse, 150.0)]))
    assert found["stall_f1"].value == pytest.approx(0.85)
    assert found["stall_f1_min"].value == 0.8
    assert found["stall_f1_min"].passed is False
    assert found["free_count_error"].value == pytest.approx(0.11)
    assert found["free_count_error_max"].value == pytest.approx(0.2)
    assert found["free_counts_right"].passed is False
    assert found["surveys_excursions"].value == 2
    assert found["surveys_excursions"].passed is False
    assert found["distance_over_bound"].value == pytest.approx((3.0 + 2.0) / 2)
    assert found["surveys_finished"].passed


def test_a_survey_without_a_result_shows_in_the_figures() -> None:
    found = by_key(figures([Survey("seed-1", GOOD, 100.0), Survey("seed-2", {}, 0.0)]))
    assert found["surveys_finished"].value == 1
    assert found["surveys_finished"].passed is False
    assert found["stall_f1"].value == pytest.approx(0.9)


def test_late_frames_void_the_section_by_seed() -> None:
    late = Survey("seed-3", {**GOOD, "late_frames": 0.02}, 100.0)
    assert _void([Survey("seed-1", GOOD, 100.0)]) == ""
    assert "seed-3" in _void([Survey("seed-1", GOOD, 100.0), late])


def test_a_result_is_read_from_what_the_survey_wrote(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert _result("seed-1", tmp_path).report == {}
    assert "survey.log" in capsys.readouterr().err
    (tmp_path / "run").mkdir()
    (tmp_path / "report.json").write_text(json.dumps(GOOD))
    values = {"stalls": [], "lots_m": [lot(200, 100).tolist()]}
    (tmp_path / "run" / "truth.json").write_text(json.dumps(values))
    found = _result("seed-1", tmp_path)
    assert found.report["stall_f1"] == 0.9
    assert 300 < found.bound_m < 400


def test_every_place_of_a_folder_is_flown_over(tmp_path: Path) -> None:
    (tmp_path / "richmond.json").write_text('{"metres_per_pixel": 0.0938, "stalls": [], "lots_m": []}')
    ((name, options),) = place_worlds(tmp_path)
    assert name == "richmond"
    assert options[:4] == ["--world", str(tmp_path / "richmond.jpg"), "--metres-per-pixel", "0.0938"]


def test_a_folder_without_places_and_one_that_misfits_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BenchmarkError, match="--places"):
        place_worlds(tmp_path)
    (tmp_path / "bad.json").write_text("{}")
    with pytest.raises(BenchmarkError, match="metres_per_pixel"):
        place_worlds(tmp_path)


def test_places_count_alike() -> None:
    one = Survey("a", {**GOOD, "recall_whole": 1.0, "precision_star": 0.9}, 100.0)
    two = Survey("b", {**GOOD, "recall_whole": 0.5, "precision_star": 0.7, "landed": False}, 100.0)
    found = by_key(place_figures([one, two]))
    assert found["places_recall_whole"].value == 0.75
    assert found["places_recall_whole"].passed is False
    assert found["places_recall_whole_min"].value == 0.5
    assert found["places_finished"].passed is False
    assert found["places_excursions"].passed is True


async def flown(late_at: dict[float, float]) -> tuple[list[float], Survey]:
    """Return the speeds flown at, and the flight that counts, when so much is late at each speed."""
    speeds: list[float] = []

    async def fly(speed: float) -> Survey:
        speeds.append(speed)
        return Survey(f"at {speed:g}", {"late_frames": late_at[speed]}, 0.0)

    return speeds, await in_time("world 3", fly)


@pytest.mark.parametrize("flights", [1, 2, 3])
async def test_a_late_flight_is_flown_again_slower_and_one_in_time_counts(
    flights: int, capsys: pytest.CaptureFixture[str]
) -> None:
    late = {speed: 0.3 if number < flights else LATE_FRAMES_LIMIT for number, speed in enumerate(SPEEDS, 1)}
    speeds, survey = await flown(late)
    assert (speeds, survey.name) == ([*SPEEDS[:flights]], f"at {SPEEDS[flights - 1]:g}")
    assert capsys.readouterr().err.count("30% of the pictures came late") == flights - 1


async def test_the_slowest_flight_counts_as_late_as_it_is() -> None:
    speeds, survey = await flown(dict.fromkeys(SPEEDS, 1.0))
    assert (speeds, survey.name) == ([*SPEEDS], f"at {SPEEDS[-1]:g}")


def test_no_flight_is_faster_than_figures_count_at_or_slower_than_can_be_flown() -> None:
    assert max(SPEEDS) == SPEEDS[0] == 2.0
    assert min(SPEEDS) == SPEEDS[-1] >= SLOWEST
    assert sorted(SPEEDS, reverse=True) == [*SPEEDS]
