from __future__ import annotations

import math

import numpy as np
import pytest

from hawk.algo.mapper.grid import COARSE_M
from hawk.algo.mapper.window import Window
from hawk.algo.path_plan.field import InformationField
from hawk.algo.path_plan.lines import Line, best_plan, way_cost
from hawk.algo.path_plan.route import way_round
from hawk.algo.path_plan.sweep import Swath, ahead
from hawk.algo.path_plan.turned import Axes
from tests.unit.algo.synthetic import CAMERA

WINDOW = Window(-50, -50, 100, 100, COARSE_M)
SWATH = Swath(40.0, 24.0)
HEADINGS = tuple(i * math.pi / 16 for i in range(16))


def field_of(*boxes: tuple[float, float, float, float], allowed: np.ndarray | None = None) -> InformationField:
    """Everything in the boxes (north from, to, east from, to) is to be learned."""
    gain = np.zeros(WINDOW.shape, np.float32)
    rows, columns = np.indices(WINDOW.shape)
    north, east = -(rows + WINDOW.row + 0.5) * COARSE_M, (columns + WINDOW.column + 0.5) * COARSE_M
    for a, b, c, d in boxes:
        gain[(north >= a) & (north < b) & (east >= c) & (east < d)] = COARSE_M**2
    free = np.ones(WINDOW.shape, np.uint8) if allowed is None else allowed.astype(np.uint8)
    return InformationField(WINDOW, gain, free, free, gain, gain * 0)


def shown(lines: tuple[Line, ...], field: InformationField) -> float:
    """Share of the gain that flying the lines shows."""
    gain = field.gain.copy()
    rows, columns = np.indices(WINDOW.shape)
    north, east = -(rows + WINDOW.row + 0.5) * COARSE_M, (columns + WINDOW.column + 0.5) * COARSE_M
    for line in lines:
        d_n, d_e = line.end[0] - line.start[0], line.end[1] - line.start[1]
        length = math.hypot(d_n, d_e)
        c, s = (d_n / length, d_e / length) if length > 1e-6 else (1.0, 0.0)
        along = (north - line.start[0]) * c + (east - line.start[1]) * s
        aside = (east - line.start[1]) * c - (north - line.start[0]) * s
        half_w, half_d = SWATH.width / 2 + COARSE_M, SWATH.depth / 2 + COARSE_M
        gain[(np.abs(aside) <= half_w) & (along >= -half_d) & (along <= length + half_d)] = 0
    return 1 - float(gain.sum() / field.gain.sum())


def test_a_strip_is_flown_along_its_length_once() -> None:
    plan = best_plan(field_of((-15, 15, -60, 60)), (0.0, -60.0), math.pi / 2, SWATH, HEADINGS, 20.0)
    assert plan is not None
    assert len(plan.lines) == 1
    assert abs(plan.heading - math.pi / 2) < 0.21
    assert math.dist(plan.lines[0].start, plan.lines[0].end) == pytest.approx(120 - SWATH.depth, abs=6)
    assert plan.lines[0].start[1] < plan.lines[0].end[1]  # from the drone's end


@pytest.mark.parametrize(
    "boxes", [((-35, 35, -50, 50),), ((-60, 0, -60, 0), (0, 30, -60, 50)), ((-60, -40, -60, -40), (40, 60, 40, 60))]
)
def test_a_plan_shows_everything(boxes: tuple[tuple[float, float, float, float], ...]) -> None:
    field = field_of(*boxes)
    plan = best_plan(field, (0.0, 0.0), 0.0, SWATH, HEADINGS, 20.0)
    assert plan is not None
    assert shown(plan.lines, field) > 0.99
    assert plan.cost == pytest.approx(way_cost(plan.lines, (0.0, 0.0), 0.0))


def test_lines_end_where_the_drone_may_be() -> None:
    columns = np.indices(WINDOW.shape)[1]
    field = field_of((-15, 15, -60, 60), allowed=columns > 50)
    plan = best_plan(field, (0.0, 20.0), 0.0, SWATH, HEADINGS, 20.0)
    assert plan is not None
    for line in plan.lines:
        assert min(line.start[1], line.end[1]) > 0.0


def test_nothing_or_too_little_gives_no_plan() -> None:
    assert best_plan(field_of(), (0.0, 0.0), 0.0, SWATH, HEADINGS, 20.0) is None
    assert best_plan(field_of((0, 4, 0, 4)), (0.0, 0.0), 0.0, SWATH, HEADINGS, 20.0) is None


def test_ahead_ends_where_nothing_new_is_shown() -> None:
    length, gain = ahead(field_of((-10, 60, -15, 15)), (0.0, 0.0), 0.0, SWATH, 150.0, 2.0)
    assert length == pytest.approx(60 - SWATH.depth / 2, abs=2 * COARSE_M)
    assert gain == pytest.approx(60 * 30, rel=0.12)
    assert ahead(field_of((-60, -20, -15, 15)), (0.0, 0.0), 0.0, SWATH, 150.0, 2.0) == (0.0, 0.0)


def test_ahead_ends_before_ground_where_the_drone_may_not_be() -> None:
    rows = np.indices(WINDOW.shape)[0]
    field = field_of((-10, 70, -15, 15), allowed=-(rows + WINDOW.row + 0.5) * COARSE_M < 20)
    length, _ = ahead(field, (0.0, 0.0), 0.0, SWATH, 150.0, 2.0)
    assert 14 < length < 20


@pytest.mark.parametrize("heading", [0.0, 0.8, 2.5, 4.0])
def test_turned_axes_know_the_place_of_every_cell(heading: float) -> None:
    field = field_of((18, 22, 28, 32))
    axes = Axes((10.0, 20.0), heading, COARSE_M, 30.0, 30.0)
    turned = axes.turned(field, field.gain, (61, 61))
    rows, columns = np.indices(turned.shape)
    row, column = (float((turned * i).sum() / turned.sum()) for i in (rows, columns))
    assert axes.place_of(row, column) == pytest.approx((20.0, 30.0), abs=0.9)


def test_a_swath_is_the_good_middle_of_the_picture() -> None:
    swath = Swath.of(CAMERA, 35.0, 0.85)
    assert swath.width == pytest.approx(35 * 1280 / 914 * 0.85)
    assert swath.depth == pytest.approx(35 * 720 / 914 * 0.85)


def test_the_way_round_a_corner_goes_to_what_can_be_reached_straight_on() -> None:
    """Two wings of ground meet at a corner; the wing that is wanted cannot be seen from the other's end."""
    rows, columns = np.indices(WINDOW.shape)
    north, east = -(rows + WINDOW.row + 0.5) * COARSE_M, (columns + WINDOW.column + 0.5) * COARSE_M
    wings = ((np.abs(east) < 6) & (north > -6)) | ((np.abs(north) < 6) & (east > -6))
    field = field_of((0, 5, 0, 5), allowed=wings)
    place, end = (60.0, 0.0), (0.0, 60.0)
    corner = way_round(field, place, end)
    assert corner is not None
    for share in np.linspace(0, 1, 50):
        n, e = (a + (b - a) * share for a, b in zip(place, corner, strict=True))
        assert abs(e) < 8 or abs(n) < 8
    assert math.hypot(*corner) < 20
    assert way_round(field, corner, end) is not None


def test_there_is_no_way_to_an_island() -> None:
    columns = np.indices(WINDOW.shape)[1]
    field = field_of((0, 5, 0, 5), allowed=(columns < 30) | (columns > 70))
    assert way_round(field, (0.0, -60.0), (0.0, 60.0)) is None
    nowhere = field_of((0, 5, 0, 5), allowed=np.zeros(WINDOW.shape, np.uint8))
    assert way_round(nowhere, (0.0, -60.0), (0.0, 60.0)) is None
