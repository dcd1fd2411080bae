from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.worlds.conditions import draw_leaves, draw_puddles, draw_snow, set_condition
from hawk.worlds.moment import Condition
from hawk.worlds.plan import Block, Post, Tree, Vehicle
from hawk.worlds.scene.canvas import Canvas
from hawk.worlds.scene.facets import flat_layer
from hawk.worlds.scene.light import LampLight, Shadows, Sun, sample_sun
from hawk.worlds.scene.render import draw_plan
from tests.unit.worlds.builders import SUN, generator, plain_plan, square
from training.scenes import CONDITION_SHARES, sample_condition

DIRECTION = st.floats(0, 2 * math.pi)


def canvas() -> Canvas:
    ground = Canvas(0.0, 0.0, 200, 200, 0.1)
    ground.image[:] = 100
    return ground


def sun_towards(direction: float, reach: float = 1.0) -> Sun:
    return Sun((math.cos(direction) * reach, math.sin(direction) * reach), (0.5, 0.4, 0.3), 0.0)


@settings(max_examples=30)
@given(DIRECTION)
def test_a_shadow_falls_on_the_side_away_from_the_sun(direction: float) -> None:
    ground, sun = canvas(), sun_towards(direction, 2.0)
    shadows = Shadows(ground, sun)
    shadows.add_block(square(9.5, 9.5, 1), 2.0)
    shadows.apply(rng=generator())
    away = np.array([10.0, 10.0]) + np.array(sun.shadow)
    column, row = np.round(ground.to_px(away)).astype(int)
    assert ground.image[row, column].max() < 60
    column, row = np.round(ground.to_px(2 * np.array([10.0, 10.0]) - away)).astype(int)
    assert (ground.image[row, column] == 100).all(), "towards the sun it is bright"


@settings(max_examples=30)
@given(DIRECTION, st.floats(0.5, 6))
def test_a_shadow_is_as_long_as_height_and_sun_say(direction: float, height: float) -> None:
    sun = sun_towards(direction, 1.3)
    assert np.linalg.norm(sun.cast(height)) == pytest.approx(1.3 * height)
    assert sun.cast(height) == pytest.approx(height * np.array(sun.shadow))


def test_the_area_in_shade_grows_with_height() -> None:
    areas = []
    for height in (0.0, 1.0, 3.0):
        shadows = Shadows(canvas(), sun_towards(0.7))
        shadows.add_block(square(8, 8, 2), height)
        areas.append(float(shadows.low.sum()) * 0.01)
    assert areas[0] == pytest.approx(4, rel=0.05)
    assert areas[0] < areas[1] < areas[2]


def test_overlapping_shadows_are_no_darker_than_one() -> None:
    ground = canvas()
    shadows = Shadows(ground, SUN)
    for _ in range(3):
        shadows.add_block(square(5, 5, 2), 1.0)
        shadows.add_block(square(5, 5, 2), 1.0, tall=True)
    shadows.apply(rng=generator())
    assert ground.image.min() >= 100 * 0.3 - 0.5
    assert ground.image.max() == 100


def test_a_crown_casts_its_shadow_where_its_height_says() -> None:
    shadows = Shadows(canvas(), SUN)
    shadows.add_crown(4.0, 10.0, 1.5, 5.0, np.full((30, 30), 255, np.uint8))
    rows, columns = np.nonzero(shadows.tall > 0.5)
    assert columns.mean() * 0.1 == pytest.approx(4.0 + 2 * 5 * 0.65, abs=0.5)
    assert rows.mean() * 0.1 == pytest.approx(10.0, abs=0.2)
    assert shadows.low.max() > 0, "and its trunk"


def test_a_crown_s_shadow_outside_the_canvas_is_left_out() -> None:
    shadows = Shadows(canvas(), SUN)
    shadows.add_crown(80.0, 80.0, 1.5, 5.0, np.full((30, 30), 255, np.uint8))
    assert shadows.tall.max() == shadows.low.max() == 0


@settings(max_examples=60)
@given(st.integers(0, 5000), st.booleans())
def test_any_sun_leaves_some_light_and_more_blue_than_red(seed: int, calm: bool) -> None:
    sun = sample_sun(generator(seed), calm=calm)
    blue, green, red = sun.gain
    assert 0 < red <= green <= blue <= 1
    assert 0.04 <= math.hypot(*sun.shadow) <= (1.1 if calm else 7.2)
    assert 0.04 <= sun.soften <= 0.13
    assert not calm or green <= 0.62, "calm suns are seen"


def test_suns_come_from_all_sides() -> None:
    directions = [math.atan2(*sample_sun(generator(seed)).shadow[::-1]) for seed in range(80)]
    quarters = np.histogram(directions, 4, (-math.pi, math.pi))[0]
    assert quarters.min() > 8


@given(st.floats(0, 20), st.floats(0, 20), st.floats(3, 12))
def test_lamp_light_falls_with_distance_and_never_below_the_ambient(x: float, y: float, height: float) -> None:
    lamp = LampLight((0.2, 0.3, 0.4), np.array([[10.0, 10.0, height]]), (1.0, 0.9, 0.5), 0.8)
    near, far = lamp.at(np.array([[x, y], [10 + 2 * (x - 10), 10 + 2 * (y - 10)]]))
    assert (near >= far - 1e-6).all()
    assert (far >= np.array([0.2, 0.3, 0.4]) - 1e-6).all()
    assert near[2] - 0.4 == pytest.approx(0.5 * (near[0] - 0.2), abs=1e-5), "in the lamp's colour"


def test_two_lamps_light_twice() -> None:
    place = np.array([[5.0, 5.0, 6.0]])
    one = LampLight((0, 0, 0), place, (1.0, 1.0, 1.0), 0.5).at(place[:, :2])
    two = LampLight((0, 0, 0), np.repeat(place, 2, axis=0), (1.0, 1.0, 1.0), 0.5).at(place[:, :2])
    assert two == pytest.approx(2 * one)


def test_lamps_light_ground_and_layers_alike() -> None:
    lamp = LampLight((0.1, 0.1, 0.1), np.array([[5.0, 10.0, 6.0]]), (1.0, 1.0, 1.0), 0.8)
    ground = canvas()
    lamp.light(ground)
    assert ground.image[100, 50].mean() == pytest.approx(90, abs=3)
    assert ground.image[100, 190].mean() < 30
    layer = flat_layer(np.full((4, 4, 4), 100, np.uint8), (5.0, 10.0), 0.0, (1.0, 1.0), 2.0, "car")
    (lit,) = lamp.light_layers([layer])
    assert lit.pixels[0, 0, :3] == pytest.approx((90, 90, 90), abs=1)
    assert (lit.pixels[..., 3] == 100).all(), "as opaque as before"
    assert (layer.pixels == 100).all(), "the unlit layer is not changed"


@pytest.mark.parametrize("condition", list(Condition))
def test_each_condition_changes_what_it_names(condition: Condition) -> None:
    plan = plain_plan(posts=[Post(float(x), 5.0, 7.0, 0.0) for x in range(4)])
    sun = set_condition(plan, condition, SUN, generator(3))
    assert (plan.wet > 0) is (condition is Condition.WET)
    assert (plan.snow > 0) is (condition is Condition.SNOW)
    assert (plan.leaves > 0) is (condition is Condition.LEAVES)
    assert (plan.lamps is not None) is (condition in (Condition.DUSK, Condition.NIGHT))
    if condition in (Condition.DAY, Condition.WET, Condition.SNOW, Condition.LEAVES):
        assert sun == SUN
    elif condition is Condition.NIGHT:
        assert sun.shadow == (0.0, 0.0)
    else:
        assert min(sun.gain) >= 0.8, "weak shadows"


def test_dusk_has_long_shadows_and_night_is_darker() -> None:
    plans = {c: plain_plan(posts=[Post(1.0, 1.0, 7.0, 0.0)] * 3) for c in (Condition.DUSK, Condition.NIGHT)}
    suns = {condition: set_condition(plan, condition, SUN, generator(1)) for condition, plan in plans.items()}
    assert suns[Condition.DUSK].shadow == (4.0, 0.0)
    ambient = {c: plan.lamps.ambient for c, plan in plans.items() if plan.lamps is not None}
    assert max(ambient[Condition.NIGHT]) < min(ambient[Condition.DUSK])


def test_a_lot_without_posts_gets_lamps_of_its_own() -> None:
    plan = plain_plan(lots=[square(0, 0, 40)])
    set_condition(plan, Condition.NIGHT, SUN, generator(2))
    assert plan.lamps is not None
    assert len(plan.lamps.lamps) == 4
    assert ((plan.lamps.lamps[:, :2] >= 0) & (plan.lamps.lamps[:, :2] <= 40)).all()
    assert ((plan.lamps.lamps[:, 2] >= 6) & (plan.lamps.lamps[:, 2] <= 10)).all()


def test_conditions_come_by_their_shares() -> None:
    rng = generator(1)
    drawn = [sample_condition(rng) for _ in range(3000)]
    for condition, share in CONDITION_SHARES.items():
        assert drawn.count(condition) / 3000 == pytest.approx(share, abs=0.03)


@pytest.mark.parametrize("amount", [0.0, 0.3, 1.0])
def test_more_snow_covers_more_ground(amount: float) -> None:
    ground = canvas()
    draw_snow(ground, amount, generator(4))
    white = (ground.image.min(axis=2) > 180).mean()
    assert white == 0 if amount == 0 else white > 0.001
    assert ground.image.max() <= 239
    more = canvas()
    draw_snow(more, min(1.0, amount + 0.3), generator(4))
    assert (more.image.min(axis=2) > 180).mean() >= white


@pytest.mark.parametrize("wet", [0.2, 0.6, 1.0])
def test_wet_ground_is_darker_outside_its_puddles(wet: float) -> None:
    ground = canvas()
    draw_puddles(ground, wet, generator(2))
    assert np.median(ground.image) < 100
    assert np.median(ground.image) > 100 * (1 - 0.4 * wet) - 2


def test_leaves_fall_about_the_trees() -> None:
    ground, plan = canvas(), plain_plan(leaves=1.0, trees=[Tree(5.0, 5.0, 1.5, 4.0)])
    leaf = np.array([[20.0, 90.0, 160.0]], np.float32)
    draw_leaves(ground, plan, leaf, generator())
    fallen = (ground.image != 100).any(axis=2)
    assert fallen[30:70, 30:70].mean() > 0.05
    assert fallen[150:, 150:].mean() < 0.02
    assert ground.image[fallen] == pytest.approx(np.broadcast_to(leaf[0] * 0.9, (int(fallen.sum()), 3)))
    bare = canvas()
    draw_leaves(bare, replace(plan, leaves=0.0), leaf, generator())
    assert (bare.image == 100).all()


def test_it_is_dark_under_a_car_and_in_its_shadow() -> None:
    plan = plain_plan(vehicles=[Vehicle(8.0, 10.0, math.pi / 2, "van")])
    drawn = draw_plan(plan, Canvas(0, 0, 200, 200, 0.1), SUN, generator())
    assert drawn.ground[100, 80].mean() < 40, "under it"
    assert drawn.ground[100, 105].mean() < 60, "east of it"
    assert drawn.ground[100, 55].mean() > 95, "west of it"
    assert {layer.label for layer in drawn.layers} == {"car"}


def test_the_shade_of_a_building_falls_on_cars_and_blocks() -> None:
    colours = []
    for shades in ([], [square(0, 0, 20)]):
        plan = plain_plan(shades=shades, vehicles=[Vehicle(8.0, 10.0, 0.0, "sedan")])
        plan.blocks.append(Block(square(14, 14, 2), 0.3, (200.0, 200.0, 200.0)))
        drawn = draw_plan(plan, Canvas(0, 0, 200, 200, 0.1), SUN, generator(1))
        car = next(layer for layer in drawn.layers if layer.label == "car")
        colours.append((car.pixels[..., :3].mean(), drawn.ground[150, 150].mean()))
    assert colours[1][0] < 0.6 * colours[0][0]
    assert colours[1][1] == pytest.approx(200 * 0.4, abs=4)


def test_post_and_arm_cast_a_thin_shadow() -> None:
    drawn = draw_plan(plain_plan(posts=[Post(3.0, 10.0, 6.0, 0.0)]), Canvas(0, 0, 200, 200, 0.1), SUN, generator())
    assert drawn.ground[100, 80].mean() < 60
    assert drawn.ground[90, 80].mean() == pytest.approx(100, abs=1)
    (head,) = drawn.layers
    assert head.height == 6.0
    assert head.corners[:, 0].mean() == pytest.approx(3.8)
