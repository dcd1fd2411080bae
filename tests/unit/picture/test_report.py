from __future__ import annotations

from dataclasses import replace

from hawk.picture.report import free_range, report, text
from hawk.picture.values import NO_STALLS, LeftOut
from tests.unit.picture.surveys import mapped


def test_the_interval_is_about_the_free_stalls() -> None:
    bounds = free_range(mapped())
    assert bounds is not None
    assert bounds[0] < 5 < bounds[1]
    assert bounds[1] - bounds[0] <= 8


def test_without_scores_no_interval_is_given() -> None:
    assert free_range(mapped(with_scores=False)) is None
    values = report(mapped(with_scores=False), "hawk-drone 1.0")
    assert values["free_range"] is None
    assert "nine of ten" not in text(mapped(with_scores=False))


def test_without_stalls_no_interval_is_given_and_there_is_no_lot() -> None:
    empty = replace(mapped(with_scores=False), survey=replace(mapped().survey, stalls=(), doubt=NO_STALLS, lot_id=""))
    values = report(empty, "hawk-drone 1.0")
    assert (values["free_range"], values["registered"], values["doubt"]) == (None, False, "it has no stalls")
    assert "nine of ten" not in text(empty)


def test_the_report_says_what_was_seen_and_left_out() -> None:
    values = report(mapped(crs="EPSG:28992", left_out=(LeftOut("a.jpg", "torn"),)), "hawk-drone 1.0")
    assert (values["stalls"], values["free"], values["taken"], values["unknown"]) == (8, 5, 2, 1)
    assert values["area_seen_m2"] == 1600.0
    assert values["crs"] == "EPSG:28992"
    assert values["left_out"] == [{"name": "a.jpg", "reason": "torn"}]
    assert values["notes"] == ["A note."]


def test_a_person_reads_the_same() -> None:
    words = text(mapped(left_out=(LeftOut("a.jpg", "torn"),)))
    assert "yard: 8 stalls on 0.16 ha" in words
    assert "free 5 (" in words
    assert "a.jpg: torn" in words


def test_no_more_stalls_are_free_than_there_are() -> None:
    survey = mapped()
    stalls = tuple(replace(stall, state="free", taken_probability=0.4) for stall in survey.survey.stalls)
    bounds = free_range(replace(survey, survey=replace(survey.survey, stalls=stalls)))
    assert bounds is not None
    assert bounds[0] < bounds[1] == len(stalls)
