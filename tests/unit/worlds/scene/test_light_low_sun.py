from __future__ import annotations

import math

import numpy as np
import pytest

from hawk.worlds.plan import Building, Tree, Vehicle
from hawk.worlds.scene.canvas import Canvas
from hawk.worlds.scene.cars import ShadowsAmong, draw_vehicle
from hawk.worlds.scene.light import LOW_SUN_SHARE, Shadows, Sun, sample_sun, shade_gain
from hawk.worlds.scene.render import draw_plan
from hawk.worlds.scene.trees import draw_bare_tree
from tests.unit.worlds.builders import generator, plain_plan

LOW = Sun((4.0, 0.0), (0.5, 0.4, 0.28), 0.0)
HIGH = Sun((1.0, 0.0), (0.5, 0.4, 0.28), 0.0)


def test_a_quarter_of_the_suns_stand_eight_to_twenty_degrees_high_and_none_of_the_calm() -> None:
    suns = [sample_sun(np.random.default_rng(seed)) for seed in range(400)]
    low = [math.degrees(math.atan(1 / sun.reach)) for sun in suns if sun.is_low]
    assert len(low) / len(suns) == pytest.approx(LOW_SUN_SHARE * 0.88, abs=0.07)  # some are overcast
    assert min(low) > 7.9
    assert max(low) < 20.1
    assert not any(sample_sun(np.random.default_rng(seed), calm=True).is_low for seed in range(100))


def test_shade_has_the_colour_that_was_measured_in_real_lots() -> None:
    gains = np.array([sample_sun(np.random.default_rng(seed), calm=True).gain for seed in range(300)])
    blue, red = gains[:, 0] / gains[:, 1], gains[:, 2] / gains[:, 1]
    assert np.median(blue) == pytest.approx(1.32, abs=0.04)
    assert np.median(red) == pytest.approx(0.72, abs=0.04)
    assert (blue > 1).all()
    assert (red < 1).all()


def test_without_a_cold_sky_shade_is_grey() -> None:
    assert shade_gain(0.5, 0.0) == (0.5, 0.5, 0.5)


def test_a_building_out_of_the_picture_darkens_it_under_a_low_sun() -> None:
    def darkest(sun: Sun) -> float:
        plan = plain_plan()
        plan.buildings.append(Building(plan.axes.moved(-34, 0), 6.0, 20.0, 9.0))
        canvas = Canvas(0.0, 0.0, 100, 100, 0.1)
        return float(draw_plan(plan, canvas, sun, generator()).shade.max())

    assert darkest(LOW) > 0.9
    assert darkest(HIGH) == 0.0


def test_under_a_low_sun_a_lorry_darkens_the_car_beside_it_and_not_itself() -> None:
    lorry, car = Vehicle(0.0, 0.0, math.pi / 2, "lorry"), Vehicle(3.0, 0.0, math.pi / 2, "sedan")
    drawn = [(one, draw_vehicle(generator(), one.kind)) for one in (lorry, car)]
    places = np.array([[3.0, 0.0]])
    among = ShadowsAmong(drawn, LOW)
    assert among.gain(car, places, 0.7)[0] == pytest.approx(LOW.gain)
    assert (among.gain(car, places, 3.5) == 1).all(), "above the lorry's roof it is bright"
    assert (among.gain(lorry, np.array([[0.0, 0.0]]), 0.7) == 1).all()
    assert (ShadowsAmong(drawn, HIGH).gain(car, places, 0.7) == 1).all()
    assert (among.gain(car, np.array([[-3.0, 0.0]]), 0.7) == 1).all(), "towards the sun it is bright"


def test_a_crown_s_shadow_is_in_one_piece_under_a_low_sun() -> None:
    canvas = Canvas(0.0, -20.0, 600, 400, 0.1)
    shadows = Shadows(canvas, LOW)
    shadows.add_crown(2.0, 0.0, 2.0, 9.0, np.full((40, 40), 255, np.uint8))
    along = shadows.tall[200, 180:340]  # from 0.45 to 0.9 of the height
    assert (along > 0.9).all()


def test_the_ray_to_a_low_sun_decides_about_shade_above_the_ground() -> None:
    canvas = Canvas(0.0, 0.0, 200, 200, 0.1)
    shadows = Shadows(canvas, LOW)
    shadows.tall[:, 100:] = 1.0
    place = np.array([[7.0, 10.0]])
    assert shadows.shade_at(place)[0] == pytest.approx(1.0)
    assert shadows.shade_at(place, 1.5)[0] == pytest.approx(LOW.gain)


def test_a_tree_without_leaves_hides_little_and_still_stands_there() -> None:
    layers, whole = draw_bare_tree(generator(), Tree(0.0, 0.0, 4.0, 8.0), 0.1)
    shares = [float((layer.pixels[..., 3] > 0).mean()) for layer in layers]
    assert 0.02 < shares[0] < 0.45
    assert whole.shape == (80, 80)
    assert {layer.label for layer in layers} == {"tree"}
