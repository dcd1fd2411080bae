from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.worlds.plan import Axes, Building, Post, Surface, Tree, Vehicle
from hawk.worlds.scene.canvas import Canvas
from hawk.worlds.scene.render import draw_plan
from tests.unit.worlds.builders import EAST, GREY, SUN, WHITE, generator, plain_plan, square

METRES = st.floats(-200, 200)
ANGLE = st.floats(-7, 7)


@given(METRES, METRES, ANGLE, METRES, METRES)
def test_axes_measure_distances_as_the_ground_does(x: float, y: float, angle: float, u: float, v: float) -> None:
    axes = Axes.turned((x, y), angle)
    placed = axes.at(u, v)
    assert math.dist(placed, (x, y)) == pytest.approx(math.hypot(u, v), abs=1e-9)
    assert axes.points([(u, v)])[0] == pytest.approx(placed)
    assert math.remainder(axes.angle - angle, math.tau) == pytest.approx(0, abs=1e-9)


@given(ANGLE, METRES, METRES, METRES, METRES)
def test_moved_axes_add_their_origins(angle: float, u: float, v: float, du: float, dv: float) -> None:
    axes = Axes.turned((3.0, -4.0), angle)
    assert axes.moved(du, dv).at(u, v) == pytest.approx(axes.at(u + du, v + dv), abs=1e-9)
    assert axes.moved(du, dv).u == axes.u


@given(ANGLE, st.sampled_from([((1, 0), (0, -1)), ((0, 1), (-1, 0)), ((0, 1), (1, 0)), ((-1, 0), (0, -1))]))
def test_facing_axes_are_made_of_the_axes_own_directions(
    angle: float, directions: tuple[tuple[int, int], tuple[int, int]]
) -> None:
    axes = Axes.turned((10.0, 20.0), angle)
    turned = axes.facing(*directions)
    assert turned.origin == axes.origin
    assert turned.at(1, 0) == pytest.approx(axes.at(*directions[0]))
    assert turned.at(0, 1) == pytest.approx(axes.at(*directions[1]))


def test_turning_goes_from_east_towards_south() -> None:
    quarter = Axes.turned((0.0, 0.0), math.pi / 2)
    assert quarter.u == pytest.approx((0, 1), abs=1e-12)
    assert quarter.v == pytest.approx((-1, 0), abs=1e-12)
    assert quarter.rect(0, 0, 2, 1) == pytest.approx(np.array([[0, 0], [0, 2], [-1, 2], [-1, 0]]), abs=1e-12)


def test_a_building_s_footprint_is_its_rectangle() -> None:
    building = Building(Axes.turned((5.0, 5.0), math.pi / 2), 4.0, 2.0, 3.0)
    assert building.polygon == pytest.approx(np.array([[5, 5], [5, 9], [3, 9], [3, 5]]), abs=1e-12)


@settings(max_examples=50)
@given(METRES, METRES, METRES, METRES, st.floats(0.05, 1.0))
def test_a_line_is_a_rectangle_of_its_width_along_its_ends(
    x0: float, y0: float, x1: float, y1: float, width: float
) -> None:
    plan = plain_plan()
    plan.line((x0, y0), (x1, y1), width, 0, 1.0)
    length = math.dist((x0, y0), (x1, y1))
    if length < 0.05:
        assert plan.strokes == []
        return
    (stroke,) = plan.strokes
    first, second, third, fourth = stroke.polygon
    assert math.dist(first, second) == pytest.approx(length)
    assert math.dist(second, third) == pytest.approx(width)
    assert (first + fourth) / 2 == pytest.approx((x0, y0), abs=1e-9)
    assert (second + third) / 2 == pytest.approx((x1, y1), abs=1e-9)


@given(st.floats(0.1, 10), st.floats(0.1, 5), st.floats(0.5, 3), st.floats(4, 12))
def test_a_planted_tree_is_as_slender_as_asked_within_its_limits(
    radius: float, slenderness: float, least: float, most: float
) -> None:
    plan = plain_plan()
    plan.plant((1.0, 2.0), radius, slenderness, (least, most))
    (tree,) = plan.trees
    assert (tree.x, tree.y, tree.radius) == (1.0, 2.0, radius)
    assert least <= tree.height <= most
    if least < radius * slenderness < most:
        assert tree.height == pytest.approx(radius * slenderness)


def test_strokes_and_gains_remember_how_many_surfaces_were_there() -> None:
    plan = plain_plan()
    plan.paint(square(0, 0, 1), 0, 1.0)
    plan.add_surface(Surface(square(0, 0, 10), GREY))
    plan.change(square(0, 0, 1), 0.5)
    plan.add_surface(Surface(square(0, 0, 10), GREY))
    plan.line((0, 0), (5, 0), 0.1, 0, 1.0)
    assert [stroke.order for stroke in plan.strokes] == [0, 2]
    assert [gain.order for gain in plan.gains] == [1]


def test_a_surface_removes_what_stood_on_its_ground_and_nothing_beside_it() -> None:
    plan = plain_plan()
    plan.trees += [Tree(1, 1, 1, 2), Tree(20, 1, 1, 2)]
    plan.posts += [Post(2, 2, 5, 0), Post(20, 2, 5, 0)]
    plan.vehicles += [Vehicle(3, 3, 0, "suv"), Vehicle(20, 3, 0, "suv")]
    plan.add_surface(Surface(square(0, 0, 10), GREY))
    assert [tree.x for tree in plan.trees] == [post.x for post in plan.posts] == [20]
    assert [vehicle.x for vehicle in plan.vehicles] == [20]


@pytest.mark.parametrize(("offset", "stays"), [(0.0, False), (-4.0, False), (-8.0, True), (-20.0, True)])
def test_a_building_goes_when_a_third_of_it_is_covered(offset: float, stays: bool) -> None:
    plan = plain_plan()
    plan.buildings.append(Building(EAST.moved(offset, 0), 10.0, 10.0, 4.0))
    plan.add_surface(Surface(square(0, 0, 10), GREY))
    assert bool(plan.buildings) is stays


def test_nothing_stands_inside_a_building_after_settling() -> None:
    plan = plain_plan()
    plan.buildings.append(Building(EAST, 10.0, 10.0, 4.0))
    plan.trees += [Tree(5, 5, 2, 4), Tree(12, 5, 2, 4)]
    plan.vehicles += [Vehicle(5, 8, 0, "van"), Vehicle(-3, 8, 0, "van")]
    plan.settle()
    assert [tree.x for tree in plan.trees] == [12]
    assert [vehicle.x for vehicle in plan.vehicles] == [-3]
    assert len(plan.buildings) == 1


def test_gains_act_on_the_surfaces_before_them_only() -> None:
    plan = plain_plan()
    plan.add_surface(Surface(square(0, 0, 10), WHITE))
    plan.change(square(0, 0, 10), 0.5)
    plan.add_surface(Surface(square(5, 0, 5), WHITE))
    ground = draw_plan(plan, Canvas(0, 0, 100, 100, 0.1), SUN, generator()).ground
    assert ground[50, 20].mean() == pytest.approx(100, abs=2), "darkened"
    assert ground[30, 75].mean() == pytest.approx(200, abs=2), "drawn after the change"


def test_strokes_of_several_colours_take_them_from_the_palette() -> None:
    palette = [(250.0, 250.0, 250.0), (0.0, 200.0, 200.0), (200.0, 80.0, 0.0), (250.0, 250.0, 250.0)]
    plan = plain_plan(palette=palette)
    for colour in range(3):
        plan.line((1, 2 + 3 * colour), (9, 2 + 3 * colour), 1.0, colour, 1.0)
    ground = draw_plan(plan, Canvas(0, 0, 100, 100, 0.1), SUN, generator()).ground
    for colour in range(3):
        assert ground[20 + 30 * colour, 50] == pytest.approx(palette[colour], abs=3)


@pytest.mark.parametrize("strength", [0.25, 0.5, 1.0])
def test_paint_covers_the_ground_by_its_strength(strength: float) -> None:
    plan = plain_plan()
    plan.line((0, 5), (10, 5), 4, 0, strength)
    ground = draw_plan(plan, Canvas(0, 0, 100, 100, 0.1), SUN, generator()).ground
    assert ground[50, 50].mean() == pytest.approx(100 + strength * 155, abs=3)


@pytest.mark.parametrize("width", [0.1, 0.16, 0.3])
def test_a_painted_line_is_as_wide_on_the_ground_as_planned(width: float) -> None:
    plan = plain_plan()
    plan.line((5.03, -5), (5.03, 15), width, 0, 1.0)
    ground = draw_plan(plan, Canvas(0, 0, 100, 100, 0.1), SUN, generator()).ground
    painted = (ground[40:60, :, 1] - 100) / 155
    assert painted.sum(axis=1).mean() * 0.1 == pytest.approx(width, abs=0.02)
