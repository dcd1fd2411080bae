"""Flights that teach, flights that judge, and weights that are taken."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.perception.places import missing_ground, read_lots
from hawk.survey.accuracy import Tally
from training.lessons import Judgement, LessonError, figures, halves, refusal, split

GOOD = Tally(matched=900, found=950, true=1000, whole=1000, whole_matched=900, judged=900, agreed=860)
BEFORE = Judgement(GOOD, GOOD)


def lesson(folder: Path, name: str, lot: str, ended: str) -> None:
    folder.mkdir(exist_ok=True)
    (folder / f"{name}.json").write_text(json.dumps({"lot": lot, "ended": ended, "stalls": []}))


def test_the_latest_flights_of_each_lot_judge(tmp_path: Path) -> None:
    for number, day in enumerate([3, 1, 2, 4, 5, 6], 1):
        lesson(tmp_path, f"a{number}", "A", f"2026-05-0{day}T10:00:00Z")
    lesson(tmp_path, "b1", "B", "2026-05-01T10:00:00Z")
    lesson(tmp_path, "b2", "B", "2026-05-02T10:00:00Z")
    lesson(tmp_path, "c1", "C", "2026-05-02T10:00:00Z")
    parts = split(tmp_path)
    assert parts.judged == ("a5", "a6", "b2")
    assert parts.learnt == ("a1", "a2", "a3", "a4", "b1", "c1")


def test_one_flight_of_each_lot_has_nothing_to_judge_by(tmp_path: Path) -> None:
    lesson(tmp_path, "a1", "A", "2026-05-01T10:00:00Z")
    with pytest.raises(LessonError, match="nothing later to judge by; fly a lot again"):
        split(tmp_path)


@pytest.mark.parametrize("text", ["{", "{}", "[]", '{"lot": "A"}'])
def test_a_file_that_is_no_lesson_is_named(tmp_path: Path, text: str) -> None:
    (tmp_path / "a1.json").write_text(text)
    with pytest.raises(LessonError, match=r"a1\.json.*export the lot again"):
        split(tmp_path)


def test_an_empty_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(LessonError, match="name the folder that hawk-drone export"):
        split(tmp_path)


def test_weights_are_taken_that_are_better_on_later_flights_and_no_worse_on_drawn_worlds() -> None:
    better = replace(GOOD, matched=910)
    assert refusal(BEFORE, Judgement(better, GOOD)) == ""
    slightly = replace(GOOD, matched=895)  # F1 .005 less; the standard error of .92 over 1,000 stalls is .008
    assert refusal(BEFORE, Judgement(better, slightly)) == ""


@pytest.mark.parametrize(
    ("after", "reason"),
    [
        (Judgement(GOOD, GOOD), "no better on the later flights"),
        (Judgement(replace(GOOD, matched=890), GOOD), "no better on the later flights"),
        (Judgement(replace(GOOD, matched=910, judged=910, agreed=850), GOOD), "states are worse"),
        (Judgement(replace(GOOD, matched=910), replace(GOOD, matched=890)), "worse on drawn worlds"),
    ],
)
def test_other_weights_are_refused_with_the_reason(after: Judgement, reason: str) -> None:
    assert reason in refusal(BEFORE, after)


def test_states_that_no_label_names_decide_nothing() -> None:
    silent = replace(GOOD, judged=0, agreed=0)
    before = Judgement(silent, GOOD)
    after = Judgement(replace(silent, matched=910), GOOD)
    assert refusal(before, after) == ""
    assert {f.key: f.value for f in figures(before, after)}["later_state_accuracy"] is None


def test_figures_compare_with_the_weights_before() -> None:
    found = {figure.key: figure for figure in figures(BEFORE, Judgement(replace(GOOD, matched=950), GOOD))}
    assert found["later_recall"].value == 0.95
    assert found["later_recall"].ratio == pytest.approx(0.95 / 0.9)
    assert found["drawn_f1"].ratio == 1.0


def test_halves_of_a_place_are_two_flights_without_the_other_half(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    places, out = tmp_path / "places", tmp_path / "out"
    places.mkdir()
    cv2.imwrite(str(places / "mall.jpg"), rng.integers(0, 255, (200, 400, 3)).astype(np.uint8))
    corners = [[[x, 5.0], [x + 2.5, 5.0], [x + 2.5, 10.0], [x, 10.0]] for x in np.arange(2.0, 36.0, 2.5).tolist()]
    stalls = [{"corners_m": quad, "state": "free"} for quad in corners]
    (places / "mall.json").write_text(json.dumps({"metres_per_pixel": 0.1, "stalls": stalls, "lots_m": []}))
    assert halves(places, out) == ("mall-west", "mall-east")
    west, east = sorted(read_lots(out), key=lambda place: place.name != "mall-west")
    assert len(west.truth.stalls) + len(east.truth.stalls) == len(corners)
    assert west.truth.stalls[:, :, 0].max() <= east.truth.stalls[:, :, 0].min() + 1e-9
    for place, is_missing in ((west, slice(230, None)), (east, slice(0, 170))):
        missing = missing_ground(place.image)
        assert missing is not None
        assert missing[:, is_missing].mean() > 0.95
        assert missing.mean() < 0.7
    assert split(out).judged == ("mall-east",)
