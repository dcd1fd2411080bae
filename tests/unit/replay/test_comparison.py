"""Stalls of two maps that are lost, found, moved, or of another state."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hawk.model.lot_map import Stall, StallState
from hawk.replay.comparison import MOVED_M, SAME_M, compare_maps
from hawk.replay.flight import ReplayError
from hawk.results.survey_map import recorded_geojson
from tests.unit.replay.recordings import DATUM, stall, stalls


def text(found: dict[int, Stall]) -> str:
    return recorded_geojson(DATUM, found)


def test_equal_maps_have_no_change() -> None:
    found = compare_maps(text(stalls(9)), text(stalls(9)))
    assert (found.recorded, found.now, found.changes) == (9, 9, ())


def test_stalls_are_the_same_ones_by_their_place_not_by_their_id() -> None:
    renamed = {number + 50: replace(each, id=number + 50) for number, each in stalls(9).items()}
    found = compare_maps(text(stalls(9)), text(renamed))
    assert {change.kind for change in found.changes} == {"values"}


def test_each_kind_of_change_is_found_once() -> None:
    now = stalls(6)
    del now[1]
    now[2] = stall(2, state=StallState.FREE)
    now[3] = stall(3, east=MOVED_M + 0.05, state=StallState.FREE)
    now[4] = stall(4, taken=0.8)
    now[20] = stall(20)
    found = compare_maps(text(stalls(6)), text(now))
    kinds = [(change.kind, change.stall["id"]) for change in found.changes]
    assert kinds == [("lost", 1), ("found", 20), ("moved", 3), ("state", 2), ("values", 4)]
    assert found.number("lost") == 1
    moved = found.changes[2]
    assert moved.metres == pytest.approx(MOVED_M + 0.05, abs=0.002)


def test_a_stall_that_is_far_off_is_another_one() -> None:
    found = compare_maps(text(stalls(1)), text({1: stall(1, east=SAME_M + 0.05)}))
    assert [change.kind for change in found.changes] == ["lost", "found"]


def test_two_stalls_are_never_the_same_as_one() -> None:
    two = {1: stall(1, north=0.0), 2: stall(2, north=0.9)}
    found = compare_maps(text(two), text({1: stall(1, north=0.5)}))
    assert sorted(change.kind for change in found.changes) == ["lost", "moved"]


def test_stalls_that_only_pictures_of_before_showed_are_not_lost() -> None:
    found = compare_maps(text(stalls(4)), text({1: stall(1)}), frozenset({1, 2, 3}))
    assert [(change.kind, change.stall["id"]) for change in found.changes] == [("lost", 4)]
    assert found.earlier == 2


def test_empty_maps_are_compared() -> None:
    assert compare_maps(text({}), text({})).changes == ()
    assert [change.kind for change in compare_maps(text({}), text(stalls(2))).changes] == ["found", "found"]


@pytest.mark.parametrize("wrong", ["", "{}", '{"features": [{"id": 1}]}', '{"features": 3}'])
def test_text_that_is_no_map_is_refused(wrong: str) -> None:
    with pytest.raises(ReplayError, match="a recorded map cannot be read"):
        compare_maps(wrong, text({}))
