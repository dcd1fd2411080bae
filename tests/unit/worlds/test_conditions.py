from __future__ import annotations

import numpy as np
import pytest

from hawk.worlds.generate import WorldOptions, generate_world
from hawk.worlds.moment import Condition
from hawk.worlds.scene.light import LampLight
from hawk.worlds.world import World
from training.scenes import CONDITION_SHARES, draw_scene, sample_condition


def world(condition: Condition) -> World:
    return generate_world(3, WorldOptions(metres_per_pixel=0.2, condition=condition))


@pytest.fixture(scope="module")
def day() -> World:
    return world(Condition.DAY)


@pytest.mark.slow
@pytest.mark.parametrize("condition", [c for c in Condition if c is not Condition.DAY])
def test_the_same_seed_is_the_same_lot_in_every_condition(day: World, condition: Condition) -> None:
    other = world(condition)
    assert len(other.stalls) == len(day.stalls)
    for one, same in zip(other.stalls, day.stalls, strict=True):
        np.testing.assert_array_equal(one.corners, same.corners)
        assert one.taken is same.taken
    assert not np.array_equal(other.ground, day.ground)


@pytest.mark.nightly
@pytest.mark.slow
def test_dusk_is_darker_than_day_and_night_darker_than_dusk(day: World) -> None:
    dusk, night = world(Condition.DUSK), world(Condition.NIGHT)
    assert day.ground.mean() > 1.3 * dusk.ground.mean() > 1.3 * night.ground.mean()
    cars = [np.mean([x.pixels[..., :3].mean() for x in w.layers if x.label == "car"]) for w in (day, dusk, night)]
    assert cars[0] > 1.3 * cars[1] > 1.3 * cars[2], "what stands on the ground is lit as the ground is"


@pytest.mark.slow
def test_snow_lies_in_patches(day: World) -> None:
    snow = world(Condition.SNOW).ground.min(axis=2) > 170
    bare = day.ground.min(axis=2) > 170
    assert 0.01 < snow.mean() - bare.mean() < 0.5


def test_a_lamp_lights_most_what_lies_below_it_and_falls_off_by_the_cosine_law() -> None:
    lamp = LampLight((0.1, 0.1, 0.1), np.array([[10.0, 20.0, 8.0]]), (1.0, 1.0, 1.0), 0.5)
    below, aside = lamp.at(np.array([[10.0, 20.0], [18.0, 20.0]]))[:, 0]
    assert below == pytest.approx(0.6)
    assert aside == pytest.approx(0.1 + 0.5 * 2**-1.5)


def test_scenes_to_train_on_come_in_all_conditions() -> None:
    rng = np.random.default_rng(5)
    drawn = [sample_condition(rng) for _ in range(600)]
    assert set(drawn) == set(Condition)
    assert sum(CONDITION_SHARES.values()) == pytest.approx(1.0)


@pytest.mark.nightly
@pytest.mark.slow
def test_a_scene_follows_from_its_generator_in_any_condition() -> None:
    for seed in range(8):
        one, two = (draw_scene(np.random.default_rng((4, seed)), 128).image for _ in range(2))
        np.testing.assert_array_equal(one, two)
