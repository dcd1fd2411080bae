"""A known lot surveyed again: what is counted, and one lot flown twice."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.again.__main__ import figures, line, sections
from benchmarks.again.visits import Again, Twice, survey_again
from benchmarks.lots.visits import DrawnLot

LOT = Again(
    name="seed 7", first_m=100.0, planned_m=70.0, flown_m=77.0, seconds=30.0, finished=True, placed="registered",
    stalls=100, looked_at=100, looked_at_well=95, changed=40, reported=39, unchanged=60, false=1,
)  # fmt: skip


def values(*lots: Again) -> dict[str, float | None]:
    return {figure.key: figure.value for figure in figures(lots)}


def test_distances_are_medians_and_looks_those_of_the_worst_lot() -> None:
    far = replace(LOT, flown_m=140.0)
    found = values(LOT, replace(LOT, flown_m=70.0, looked_at=98), far)
    assert found["way_over_told_median"] == pytest.approx(1.1)
    assert found["way_over_told_max"] == pytest.approx(2.0)
    assert found["way_over_first_median"] == pytest.approx(0.77)
    assert found["looked_at_min"] == 0.98


def test_states_are_counted_over_all_lots_and_one_that_is_not_registered_reports_none() -> None:
    found = values(LOT, replace(LOT, reported=0, false=0, placed="unregistered"))
    assert found["changed_found"] == 39 / 80
    assert found["changed_false"] == 1 / 120
    assert found["again_registered"] == 1.0


def test_the_limits_are_those_of_the_issue() -> None:
    limits = {figure.key: figure.limit for figure in figures([LOT]) if figure.limit is not None}
    names = ("way_over_told_median", "way_over_first_median", "looked_at_min", "changed_found", "changed_false")
    assert [limits[name].highest for name in names[:2]] == [1.10, 0.80]
    assert [limits[name].lowest for name in names[2:4]] == [0.99, 0.97]
    assert limits["changed_false"].highest == 0.01
    assert all(figure.passed in (None, True) for figure in figures([LOT]) if figure.key != "changed_false")


def test_a_lot_is_a_line_for_people() -> None:
    assert line(LOT) == (
        "seed 7: 77 m flown, 70 m planned, 100 m the first survey, 100 of 100 looked at, 95 in a good part, "
        "39 of 40 changed reported, 1 of 60 unchanged, registered"
    )


def test_the_limits_are_those_of_the_corrected_plan_and_the_finds_have_keys_of_their_own() -> None:
    corrected, found = sections([Twice(replace(LOT, reported=30), LOT, 4), Twice(LOT, LOT, 3)])
    assert {figure.key: figure.value for figure in corrected.figures}["corrections"] == 7.0
    by_finds = {figure.key: figure for figure in found.figures}
    assert by_finds["changed_found_by_finds"].value == 69 / 80
    assert all(figure.limit is None for figure in found.figures)
    assert not by_finds.keys() & {figure.key for figure in corrected.figures}


@pytest.mark.flight
@pytest.mark.nightly
def test_the_second_survey_of_a_lot_flies_less_and_looks_at_every_stall() -> None:
    both = survey_again(DrawnLot(10))
    assert both.corrections < 0.2 * both.found.stalls
    for found in (both.found, both.corrected):
        assert found.finished
        assert found.flown_m < found.first_m
        assert found.looked_at == found.stalls
        assert found.reported >= 0.9 * found.changed > 0
