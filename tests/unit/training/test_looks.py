from __future__ import annotations

import pickle
from dataclasses import replace

import cv2
import numpy as np
import pytest

from hawk.worlds.plan import Tree, Vehicle
from hawk.worlds.scene.cars import draw_vehicle
from hawk.worlds.scene.light import Sun
from hawk.worlds.scene.materials import Material, sample_material, texture
from hawk.worlds.scene.render import AS_DRAWN
from hawk.worlds.scene.trees import draw_tree, leaf_colours
from tests.unit.training.test_textures import GRASS, generator, textures
from training.looks import Dress, RealLooks
from training.scenes import Scene, draw_scene
from training.textures import CarPicture, Textures, woven

SUN = Sun((0.0, -1.0), (0.5, 0.5, 0.5), 0.1)


def scene(seed: int, looks_seed: int | None) -> Scene:
    looks = AS_DRAWN if looks_seed is None else RealLooks(textures(), generator(looks_seed))
    return draw_scene(generator(seed), 200, looks=looks)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(6))
def test_the_looks_of_a_scene_change_its_picture_and_none_of_its_labels(seed: int) -> None:
    plain, real = scene(seed, None), scene(seed, 5)
    assert not np.array_equal(plain.image, real.image)
    for name in ("lot", "car", "cover", "shade", "cast"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(real, name))
    assert len(plain.stalls) == len(real.stalls)
    for one, other in zip(plain.stalls, real.stalls, strict=True):
        np.testing.assert_array_equal(one.quad, other.quad)
        unlike = replace(one, quad=np.zeros(0))
        assert repr(unlike) == repr(replace(other, quad=np.zeros(0)))


@pytest.mark.nightly
def test_the_same_seed_gives_the_same_looks() -> None:
    np.testing.assert_array_equal(scene(1, 5).image, scene(1, 5).image)
    assert not np.array_equal(scene(1, 5).image, scene(1, 6).image)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["asphalt", "concrete", "pavers", "clinker", "grass grid", "gravel"])
def test_paving_keeps_its_colour(kind: str) -> None:
    material = sample_material(generator(2), kind)
    drawn = texture(generator(2), material, 300, 200, 0.1)
    shown = RealLooks(textures(), generator()).ground(material, drawn.copy(), 0.1)
    assert shown.shape == drawn.shape
    np.testing.assert_allclose(shown.mean((0, 1)), drawn.mean((0, 1)), rtol=0.02)
    fine = [
        (image - cv2.GaussianBlur(image, (0, 0), 2)).std() for image in (shown / shown.mean(), drawn / drawn.mean())
    ]
    assert fine[0] != pytest.approx(fine[1], rel=0.02)


def test_grass_keeps_its_brightness_and_takes_a_part_of_the_hue_of_real_grass() -> None:
    material = Material("grass", (40.0, 100.0, 110.0), 0.1, 0.05, 0.05)
    drawn = texture(generator(2), material, 300, 200, 0.1)
    shown = [RealLooks(textures(), generator(seed)).ground(material, drawn, 0.1) for seed in range(12)]
    hues = [image.mean((0, 1)) / image.mean() for image in shown]
    real, dry = np.array(GRASS) / np.mean(GRASS), drawn.mean((0, 1)) / drawn.mean()
    assert all(image.mean() == pytest.approx(drawn.mean(), rel=0.03) for image in shown)
    shares = [(hue[2] - dry[2]) / (real[2] - dry[2]) for hue in hues]
    assert all(-0.1 < share < 1.1 for share in shares)
    assert np.ptp(shares) > 0.5


def test_other_ground_stays_as_it_is_drawn() -> None:
    drawn = np.full((40, 40, 3), 90, np.float32)
    looks = RealLooks(textures(), generator())
    for kind in ("water", "roof", "court"):
        assert looks.ground(sample_material(generator(), kind), drawn, 0.1) is drawn
    asphalt = sample_material(generator(), "asphalt")
    assert RealLooks(Textures((), (), (), (), ()), generator()).ground(asphalt, drawn, 0.1) is drawn


@pytest.mark.slow
def test_bark_and_rock_look_like_gardens_and_dirt_like_grass_in_their_own_colours() -> None:
    rng = generator(3)
    grass, wild = (woven([(100 + rng.normal(0, level, (32, 32, 3))).astype(np.float32)], rng) for level in (4, 30))
    looks = RealLooks(replace(textures(), grass=(grass,), wild=(wild,)), rng)
    for kind, rough in (("dirt", False), ("bark", True), ("rock", True)):
        material = replace(sample_material(generator(2), kind), colour=(70.0, 90.0, 120.0))
        drawn = np.full((200, 200, 3), material.colour, np.float32)
        shown = looks.ground(material, drawn, 0.1)
        np.testing.assert_allclose(shown.mean((0, 1)), material.colour, rtol=0.03)
        assert (shown.std() / shown.mean() > 0.28) == rough


@pytest.mark.parametrize("metres_per_pixel", [0.05, 0.1, 0.25])
def test_ground_of_another_scale_has_stones_of_another_size(metres_per_pixel: float) -> None:
    rng = generator(3)
    patch = (100 + cv2.GaussianBlur(rng.normal(0, 60, (32, 32, 3)), (0, 0), 1.5)).astype(np.float32)
    look = replace(textures(), paving=(woven([patch, patch[::-1]], rng),))
    material = Material("asphalt", (100.0, 100.0, 100.0), 0.0, 0.0, 0.0)
    drawn = np.full((256, 256, 3), 100, np.float32)
    shown = RealLooks(look, rng).ground(material, drawn, metres_per_pixel)
    at_scale = RealLooks(look, rng).ground(material, drawn, 0.1)
    near = [np.corrcoef(image[:, 2:, 0].ravel(), image[:, :-2, 0].ravel())[0, 1] for image in (shown, at_scale)]
    assert np.sign(round(near[0] - near[1], 1)) == np.sign(0.1 - metres_per_pixel)


def test_leaves_keep_their_outline_and_their_light() -> None:
    rng = generator(3)
    patch = (100 + rng.normal(0, 25, (32, 32, 3))).astype(np.float32)
    look = replace(textures(), leaves=(woven([patch], rng),))
    layers, _ = draw_tree(generator(1), Tree(0.0, 0.0, 3.0, 6.0), leaf_colours(generator(1)), SUN, 0.1)
    shown = RealLooks(look, rng).crown(layers)
    for one, other in zip(layers, shown, strict=True):
        np.testing.assert_array_equal(one.pixels[..., 3], other.pixels[..., 3])
        assert not np.array_equal(one.pixels, other.pixels)
        inside = one.pixels[..., 3] > 0
        assert other.pixels[inside, :3].mean() == pytest.approx(one.pixels[inside, :3].mean(), rel=0.1)
    assert RealLooks(textures(), rng).crown(layers) is layers


@pytest.mark.parametrize("heading", [0.0, 0.6, 1.7, 3.5, 5.0])
@pytest.mark.parametrize("shadow", [(1.0, 0.4), (-0.3, 1.0)])
def test_a_real_car_has_the_outline_of_the_drawn_one_and_is_lit_from_the_sun(
    heading: float, shadow: tuple[float, float]
) -> None:
    pixels = np.full((36, 84, 3), 60, np.uint8)
    pixels[:18] = 220  # bright on the sun's side
    look = replace(textures(), cars=(CarPicture(pixels, np.array([0.6, -0.8])),))
    model, vehicle = draw_vehicle(generator(3), "sedan"), Vehicle(0.0, 0.0, heading, "sedan")
    shown = RealLooks(look, generator(0)).vehicle(vehicle, model, Sun(shadow, (0.5,) * 3, 0.1))
    assert shown is not model
    for one, other in zip(model.sprites, shown.sprites, strict=True):
        np.testing.assert_array_equal(one.pixels[..., 3], other.pixels[..., 3])
        assert (one.height, one.along) == (other.height, other.along)
    body = shown.sprites[0].pixels[..., :3].astype(float)
    aside = np.array([-np.sin(heading), np.cos(heading)])
    lit_below = -np.array(shadow) @ aside > 0
    assert (body[-3:].mean() > body[:3].mean()) == lit_below
    roof = shown.sprites[1].pixels[..., :3].astype(float)
    assert (roof[-3:].mean() > roof[:3].mean()) == lit_below
    assert body[body.shape[0] // 2, int(0.45 * body.shape[1])].mean() < 40, "dark where the roof hides it"


def test_vehicles_that_no_picture_shows_and_a_quarter_of_the_cars_stay_drawn() -> None:
    looks = RealLooks(textures(), generator())
    for kind in ("lorry", "van", "pickup", "motorcycle", "coach"):
        model = draw_vehicle(generator(), kind)
        assert looks.vehicle(Vehicle(0.0, 0.0, 0.0, kind), model, SUN) is model
    model, vehicle = draw_vehicle(generator(), "suv"), Vehicle(0.0, 0.0, 0.0, "suv")
    drawn = np.mean([looks.vehicle(vehicle, model, SUN) is model for _ in range(300)])
    assert 0.17 < drawn < 0.33
    assert RealLooks(replace(textures(), cars=()), generator()).vehicle(vehicle, model, SUN) is model


@pytest.mark.nightly
def test_painters_get_the_textures_and_dress_a_share_of_the_scenes() -> None:
    dress = pickle.loads(pickle.dumps(Dress(textures(), 0.3)))  # noqa: S301
    dressed = [isinstance(dress.looks(4, index), RealLooks) for index in range(400)]
    assert 0.23 < np.mean(dressed) < 0.37
    assert dressed == [isinstance(Dress(textures(), 0.3).looks(4, index), RealLooks) for index in range(400)]
    assert all(Dress(textures(), 0.0).looks(4, index) is AS_DRAWN for index in range(50))
    index = dressed.index(True)
    one, other = (draw_scene(generator(2), 96, looks=d.looks(4, index)).image for d in (dress, Dress(textures(), 0.3)))
    np.testing.assert_array_equal(one, other)
