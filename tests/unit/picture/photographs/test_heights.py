from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.model.pictures import CameraModel
from hawk.picture.photographs.heights import GUESS_M, assign_heights, doubt_of, guess_heights
from hawk.picture.values import PictureError, Shot

CAMERA = CameraModel(80, 60, 60.0, 60.0, 39.5, 29.5)


def _shot(name: str, height: float | None, altitude: float | None) -> Shot:
    return Shot(Path(name), CAMERA, 46.0, -91.0, altitude, height, None, (2.0, 3.0), None)


def _heights(shots: list[Shot], given_m: float | None = None) -> list[float]:
    return [round(shot.height or 0.0, 3) for shot in assign_heights(shots, given_m)[0]]


def test_heights_of_the_files_stay() -> None:
    assert _heights([_shot("a", 60.0, 160.0), _shot("b", 61.0, 161.0)]) == [60.0, 61.0]


def test_a_file_without_a_height_gets_it_from_its_altitude() -> None:
    shots = [_shot("a", 60.0, 160.0), _shot("b", None, 163.0), _shot("c", 62.0, 162.0)]
    assert _heights(shots) == [60.0, 63.0, 62.0]


def test_a_file_with_neither_is_left_out_and_named() -> None:
    shots, left = assign_heights([_shot("a", 60.0, 160.0), _shot("b", None, None)], None)
    assert [shot.name for shot in shots] == ["a"]
    assert [(each.name, "--height" in each.reason) for each in left] == [("b", True)]


def test_without_any_height_the_shots_stay_and_the_look_begins_at_a_usual_one() -> None:
    shots = [_shot("a", None, 160.0), _shot("b", None, 161.0)]
    assert assign_heights(shots, None) == (shots, [])
    assert doubt_of(shots) == "a and 1 others give no height above the ground"
    assert [shot.height for shot in guess_heights(shots)] == [GUESS_M - 0.5, GUESS_M + 0.5]
    assert all((shot.height or 0.0) >= 3.0 for shot in guess_heights([*shots, _shot("c", None, 20.0)]))


@given(st.floats(50.0, 400.0), st.lists(st.floats(-20.0, 20.0), min_size=1, max_size=9))
def test_a_height_that_a_person_gives_is_the_middle_photograph_s(given_m: float, steps: list[float]) -> None:
    altitudes = [350.0 + step for step in steps]
    found = _heights([_shot(str(k), None, altitude) for k, altitude in enumerate(altitudes)], given_m)
    assert sorted(found)[len(found) // 2] >= given_m - 1e-3
    assert sorted(found)[(len(found) - 1) // 2] <= given_m + 1e-3
    assert [a - b for a, b in zip(found, altitudes, strict=True)] == pytest.approx(
        [found[0] - altitudes[0]] * len(found), abs=2e-3
    )


def test_a_height_that_a_person_gives_goes_for_all_where_the_files_say_nothing() -> None:
    assert _heights([_shot("a", None, None), _shot("b", None, None)], 60.0) == [60.0, 60.0]


def test_a_height_that_a_person_gives_moves_those_whose_level_is_known_and_the_others_are_named() -> None:
    levels = [("a", None, 200.0), ("b", None, 180.0), ("c", None, None), ("d", None, 190.0)]
    shots, left = assign_heights([_shot(*each) for each in levels], 60.0)
    assert [(shot.name, shot.height) for shot in shots] == [("a", 70.0), ("b", 50.0), ("d", 60.0)]
    assert [each.name for each in left] == ["c"]
    assert "gives no height, the others do" in left[0].reason


def test_a_height_that_a_person_gives_takes_a_lacking_height_from_the_altitude() -> None:
    levels = [("a", 40.0, 200.0), ("b", None, 195.0), ("c", 50.0, 210.0)]
    assert _heights([_shot(*each) for each in levels], 60.0) == [60.0, 55.0, 70.0]


def test_photographs_on_the_ground_are_left_out_by_a_person_s_height_too() -> None:
    levels = [("a", 60.0, 200.0), ("g", 0.0, 140.0), ("b", 61.0, 201.0), ("h", -40.0, 100.0), ("c", 59.0, 199.0)]
    shots, left = assign_heights([_shot(*each) for each in levels], 50.0)
    assert [(shot.name, shot.height) for shot in shots] == [("a", 51.0), ("b", 52.0), ("c", 50.0)]
    assert [each.name for each in left] == ["g", "h"]
    assert left[0].reason.startswith("was taken on the ground: -9.0 m above the ground by --height 50")


@pytest.mark.parametrize("given_m", [0.0, -3.0, 500.5, 1200.0])
def test_a_height_beyond_every_flight_is_refused(given_m: float) -> None:
    with pytest.raises(PictureError, match=r"--height .*at most 500 m above the ground, not above the sea"):
        assign_heights([_shot("a", None, 160.0)], given_m)


def test_the_altitude_given_as_the_height_is_refused() -> None:
    with pytest.raises(PictureError, match=r"--height 200: is the altitude above the sea; the files give 40 m"):
        assign_heights([_shot("a", 40.0, 199.0), _shot("b", 40.5, 200.0)], 200.0)


def test_a_relative_altitude_above_every_flight_is_doubted() -> None:
    shots = [_shot("a", 60.0, 160.0), _shot("b", 734.0, 734.0)]
    assert assign_heights(shots, None) == (shots, [])
    assert doubt_of(shots).startswith("b gives 734 m above the take-off place, more than 500: it is an altitude")


def test_heights_that_are_the_altitudes_are_doubted() -> None:
    shots = [_shot("a", 312.40, 312.404), _shot("b", 313.10, 313.10)]
    assert doubt_of(shots) == "b's height 313.10 m is its altitude above the sea, as in all others"
    assert doubt_of([replace(shots[0], altitude=300.0), shots[1]]) == ""


def test_photographs_on_the_ground_are_left_out() -> None:
    shots, left = assign_heights([_shot("a", 0.3, 100.3), _shot("b", 60.0, 160.0)], None)
    assert [shot.name for shot in shots] == ["b"]
    assert "on the ground" in left[0].reason
