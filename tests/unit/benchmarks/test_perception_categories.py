"""Categories of errors, over pictures painted here: grey ground of 30 m x 20 m with a row of stalls."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.perception.categories import Category, categories
from benchmarks.perception.errors import ALL, NONE, Row, error_rows, error_section
from benchmarks.perception.eyes import Result
from benchmarks.perception.ground_light import GroundLight, ground_light
from benchmarks.perception.measures import Looked, look
from benchmarks.perception.paint import brightness, is_marked, side_lines
from benchmarks.perception.places import Place, state_array
from benchmarks.perception.stall_rows import Boxes, Rows, neighbours, spanning
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import Finding, LabelledPlace

Picture = NDArray[np.uint8]
Quads = NDArray[np.float64]
SCALE = 0.1
GREY, LIT = (150, 150, 150), 150
SHADE = tuple(round(0.5 * LIT * share) for share in (1.31, 1.0, 0.70))
FREE, TAKEN = StallState.FREE, StallState.TAKEN


def row(count: int = 8, x: float = 4.0, y: float = 6.0) -> Quads:
    """Stalls side by side, 2.5 m x 5 m."""
    return np.array(
        [
            [[x + 2.5 * k, y], [x + 2.5 * k + 2.5, y], [x + 2.5 * k + 2.5, y + 5], [x + 2.5 * k, y + 5]]
            for k in range(count)
        ]
    )


def ground(*, lines: bool = True) -> Picture:
    """Grey ground with a little noise; white lines of 12 cm between the stalls of `row`."""
    noise = np.random.default_rng(0).normal(0, 2, (200, 300, 1))
    picture = np.clip(np.array(GREY) + noise, 0, 255).astype(np.uint8)
    for k in range(9 if lines else 0):
        fill(picture, 3.95 + 2.5 * k, 6, 4.07 + 2.5 * k, 11, (225, 225, 225))
    return picture


def fill(picture: Picture, x0: float, y0: float, x1: float, y1: float, colour: tuple[int, ...]) -> None:
    """Paint a rectangle, metres."""
    rows, columns = slice(round(y0 / SCALE), round(y1 / SCALE)), slice(round(x0 / SCALE), round(x1 / SCALE))
    picture[rows, columns] = colour


def shade(picture: Picture, x0: float, y0: float, x1: float, y1: float) -> None:
    """Draw a shadow: lines in it stay brighter than the ground."""
    rows, columns = slice(round(y0 / SCALE), round(y1 / SCALE)), slice(round(x0 / SCALE), round(x1 / SCALE))
    part = picture[rows, columns]
    picture[rows, columns] = np.clip(part * (np.array(SHADE) / LIT), 0, 255).astype(np.uint8)


def crown(picture: Picture, x: float, y: float, radius: float) -> None:
    """Paint a tree's crown from above: green, lit and dark leaves."""
    height, width = picture.shape[:2]
    rows, columns = np.mgrid[:height, :width]
    inside = np.hypot(columns - x / SCALE, rows - y / SCALE) < radius / SCALE
    coarse = np.random.default_rng(1).uniform(0.5, 1.5, (height // 4, width // 4)).astype(np.float32)
    light = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_NEAREST)[..., None]
    picture[inside] = np.clip(np.array([45, 105, 80]) * light, 0, 255).astype(np.uint8)[inside]


def place(picture: Picture, stalls: Quads, states: list[StallState], *, outlined: bool = True) -> Place:
    outline = np.array([[0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [0.0, 20.0]])
    lots = (outline,) if outlined else ()
    return Place("painted", picture, SCALE, LabelledPlace(stalls, state_array(states), lots))


class Finder:
    """Finds the given stalls in the given states."""

    def __init__(self, stalls: Quads, states: list[StallState]) -> None:
        self._stalls, self._states = stalls, states

    def look(self, image: Picture, metres_per_pixel: float, *, scale: float = 1.0) -> Result:
        finding = Finding(self._stalls, state_array(self._states))
        return Result(finding, np.array([float(s is TAKEN) for s in self._states]), np.ones((50, 75), np.bool_))


def seen(picture: Picture, found: Quads, states: list[StallState] | None = None, labels: Quads | None = None) -> Looked:
    """Look at `row`, all of it free unless labels or states say otherwise."""
    labels = row() if labels is None else labels
    said = states or [FREE] * len(found)
    (one,) = look(Finder(found, said), [place(picture, labels, [FREE] * len(labels))])
    return one


def light_of(picture: Picture) -> GroundLight:
    return ground_light(place(picture, row(), [FREE] * 8), row())


def at(mask: NDArray[np.bool_], x: float, y: float) -> bool:
    return bool(mask[round(y / SCALE), round(x / SCALE)])


def test_shade_is_dark_and_blue_and_deep_where_it_is_wide() -> None:
    picture = ground()
    shade(picture, 4, 5, 10, 12)
    shade(picture, 15, 5, 16.5, 12)
    fill(picture, 20, 13, 26, 19, (70, 70, 70))
    light = light_of(picture)
    assert light.lit_colour == pytest.approx(GREY, abs=3)
    assert at(light.deep, 5.2, 8.5)
    assert at(light.shade, 15.7, 8.5)
    assert not at(light.deep, 15.7, 8.5), "as narrow as a car's shadow"
    assert not at(light.shade, 23, 16), "dark asphalt is not blue"
    assert not light.shade[:40].any()


def test_crowns_are_rough_and_lawns_are_not() -> None:
    picture = ground()
    crown(picture, 8, 8, 2)
    fill(picture, 14, 13, 24, 19, (60, 120, 90))
    light = light_of(picture)
    assert light.crown[60:100, 60:100].mean() > 0.6
    assert not light.crown[135:185, 145:235].any()


def test_a_picture_without_lit_ground_says_nothing_of_light() -> None:
    light = light_of(np.full((200, 300, 3), 20, np.uint8))
    assert np.isnan(light.lit_colour).all()
    assert not any(mask.any() for mask in (light.shade, light.deep, light.crown))


def test_a_line_shows_with_its_contrast_and_width() -> None:
    boxes = Boxes.of(row())
    lined, bare = brightness(ground()), brightness(ground(lines=False))
    for line in side_lines(lined, boxes, 3):
        assert line.shown > 0.9
        assert line.contrast == pytest.approx(0.5, abs=0.15)
        assert line.width == pytest.approx(0.12, abs=0.1)
    assert is_marked(lined, boxes, 3)
    assert not is_marked(bare, boxes, 3)
    with_car = ground(lines=False)
    fill(with_car, 11.8, 6.5, 13.6, 10.5, (235, 235, 235))
    assert not is_marked(brightness(with_car), boxes, 3), "a white car is no line"


def test_rows_have_neighbours_and_ends() -> None:
    stalls = np.concatenate([row(4), row(3, y=11.0), row(1, x=25.0, y=1.0)])
    sides = neighbours(Boxes.of(stalls), Boxes.of(stalls))
    assert (sides[0] != 0).sum() == 2
    assert {abs(int(sides[0, 1])), abs(int(sides[0, 4]))} == {1, 2}
    assert Rows.of(stalls).is_end.tolist() == [True, False, False, True, True, False, True, False]
    in_line = np.array([[[x, 0], [x + 5, 0], [x + 5, 2], [x, 2]] for x in (0.0, 6.0, 12.0)])
    rows = Rows.of(in_line)
    assert rows.axis.tolist() == [1, 1, 1]
    assert rows.is_end.tolist() == [True, False, True]
    beyond = Boxes.of(np.concatenate([in_line[2:] + np.array([6.0, 0.0]), in_line[2:] + np.array([6.0, 8.0])]))
    assert rows.at_end(beyond).tolist() == [True, False]
    assert rows.half_off(Boxes.of(in_line[:1] + np.array([2.4, 0.0]))).any()
    assert not rows.half_off(Boxes.of(in_line[:1])).any()


def test_a_quad_spans_others_only_where_it_covers_two() -> None:
    one, two = row(2), row(1) * np.array([1.0, 1.0])
    two[:, 1:3, 0] += 2.5
    assert spanning(two, one, 0.6).tolist() == [[True, True]]
    assert not spanning(one, one, 0.6).any()
    assert not spanning(two[:0], one, 0.6).any()


def test_every_category_of_a_missed_stall() -> None:
    picture = ground()
    crown(picture, 10.2, 12.0, 1.8)  # over the foot of the third
    shade(picture, 16.6, 4, 21.4, 13)  # over the sixth
    fill(picture, 4, 5.9, 4.5, 11.1, GREY)
    fill(picture, 6.2, 5.9, 6.7, 11.1, GREY)  # the lines of the first are gone
    one = seen(picture, row()[6:7])
    flags = categories(one).labels
    assert flags[Category.TREE][2]
    assert not flags[Category.TREE][[0, 5, 6, 7]].any()
    assert flags[Category.SHADE][5]
    assert not flags[Category.SHADE][[0, 1, 3]].any()
    assert np.flatnonzero(flags[Category.ROW_END]).tolist() == [0, 7]
    assert flags[Category.UNMARKED][0]
    assert not flags[Category.UNMARKED][[1, 3, 4, 7]].any()
    assert not flags[Category.PHASE].any()
    rows = error_rows([one])
    assert rows[ALL] == Row(labels=8, missed=7, judged=1, wrong=0, finds=1, false=0)
    assert rows[Category.TREE].missed >= 1
    assert (rows[Category.ROW_END].missed, rows[Category.UNMARKED].missed) == (2, 1)
    assert rows[NONE].labels >= 1


def test_half_a_stall_off_beyond_the_end_and_several_at_once() -> None:
    off = row(1) + np.array([3 * 2.5 + 1.25, 0.0])
    beyond = row(1) + np.array([8 * 2.5, 0.0])
    three = row(1)
    three[:, 1:3, 0] += 5.0
    finder = Finder(np.concatenate([off, beyond, three]), [FREE] * 3)
    (one,) = look(finder, [place(ground(), row(), [FREE] * 8, outlined=False)])
    found = categories(one)
    assert np.flatnonzero(found.finds[Category.PHASE]).tolist() == [0]
    assert np.flatnonzero(found.labels[Category.PHASE]).tolist() == [3, 4]
    assert np.flatnonzero(found.finds[Category.ROW_END]).tolist() == [1]
    assert np.flatnonzero(found.finds[Category.LONG]).tolist() == [2]
    assert np.flatnonzero(found.labels[Category.LONG]).tolist() == [0, 1, 2]
    rows = error_rows([one])
    assert rows[ALL].false == 3
    assert [rows[c].false for c in (Category.PHASE, Category.ROW_END, Category.LONG)] == [1, 1, 1]


def test_a_neighbour_s_shadow_in_a_free_stall_that_is_called_taken() -> None:
    """Cars in every second stall throw their shadows to the right; those of free stalls to their left fall nowhere."""
    picture, stalls = ground(), row(11, x=1.0)
    states = [TAKEN if k % 2 == 0 else FREE for k in range(11)]
    for k in range(0, 11, 2):
        x = 1.0 + 2.5 * k
        shade(picture, x + 2.1, 6.4, x + 3.7, 10.6)
        fill(picture, x + 0.4, 6.4, x + 2.1, 10.6, (40, 40, 190))
    said = [TAKEN] * 11
    (one,) = look(Finder(stalls, said), [place(picture, stalls, states)])
    flags = categories(one).labels
    assert flags[Category.NEIGHBOUR_SHADOW].tolist() == [k % 2 == 1 for k in range(11)]
    row_of = error_rows([one])[Category.NEIGHBOUR_SHADOW]
    assert (row_of.judged, row_of.wrong) == (5, 5)
    lit = look(Finder(stalls, said), [replace(place(ground(), stalls, states))])[0]
    assert not categories(lit).labels[Category.NEIGHBOUR_SHADOW].any()


def test_false_alarms_are_counted_as_the_starred_measures_count_them() -> None:
    """A find inside the lot, away from labels, may be a stall that nobody labelled; without an outline it is false."""
    away = row(1, x=12.0, y=14.0)
    labels = row()
    for outlined, false in ((True, 0), (False, 1)):
        (one,) = look(Finder(away, [FREE]), [place(ground(), labels, [FREE] * 8, outlined=outlined)])
        assert error_rows([one])[ALL].false == false


def test_the_section_has_every_category() -> None:
    values = {f.key: f.value for f in error_section("places", [seen(ground(), row()[1:])], "errors_lots_").figures}
    assert values["errors_lots_row_end_missed"] == 1
    assert values["errors_lots_all_labels"] == 8
    for name in (ALL, *Category, NONE):
        assert {f"errors_lots_{name}_{kind}" for kind in ("missed", "false", "wrong", "labels")} <= set(values)
