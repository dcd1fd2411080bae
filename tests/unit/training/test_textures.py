from __future__ import annotations

import functools
from dataclasses import replace

import cv2
import numpy as np
import pytest

from hawk.worlds.scene.cars import SPRITE_M
from training.ground import Ground, Region
from training.targets import LABELS, UNKNOWN, TrainingScene
from training.textures import Textures, cut_textures, woven

PAVING, GRASS, CAR, PAINT = (150, 148, 146), (50, 110, 60), (200, 60, 40), (255, 255, 255)


def generator(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def region(shadow: tuple[int, int] = (0, -8), dark: float = 0.4) -> Region:
    """Paving on the left, grass on the right, and six painted stalls with cars of 42 x 18 pixels and their shadows."""
    rng = generator(1)
    image = np.zeros((320, 320, 3), np.float32)
    image[:, :200] = PAVING
    image[:, 200:] = GRASS
    image += rng.normal(0, 5, (320, 320, 1))
    labels = np.full((320, 320, LABELS), UNKNOWN, np.uint8)
    labels[..., 0] = np.arange(320) < 200
    labels[..., 1] = 0
    quads = []
    for k in range(6):
        left, top = 20 + 25 * k, 130
        quads.append([(left, top), (left + 25, top), (left + 25, top + 50), (left, top + 50)])
        cv2.rectangle(image, (left, top), (left + 25, top + 50), PAINT, 2)
        x, y = left + 4, top + 4
        part = slice(y + shadow[1], y + 42 + shadow[1]), slice(x + shadow[0], x + 18 + shadow[0])
        image[part] *= dark
        image[y : y + 42, x : x + 18] = CAR
        labels[y : y + 42, x : x + 18, 1] = 1
    yes, no = np.ones(6, np.bool_), np.zeros(6, np.bool_)
    picture = np.clip(image, 0, 255).astype(np.uint8)
    return Region("painted", TrainingScene(picture, labels, np.array(quads, np.float32), yes, yes, no))


@functools.cache
def textures() -> Textures:
    return cut_textures(Ground([region()]), generator())


def test_cars_are_cut_along_their_length_without_the_ground_about_them() -> None:
    assert len(textures().cars) == 6
    for car in textures().cars:
        rows, columns = car.pixels.shape[:2]
        assert columns * SPRITE_M == pytest.approx(4.2, abs=0.3)
        assert rows * SPRITE_M == pytest.approx(1.8, abs=0.2)
        assert np.abs(car.pixels.astype(int) - CAR).max() < 30


@pytest.mark.nightly
@pytest.mark.parametrize("shadow", [(0, -8), (0, 8)])
def test_the_sun_stands_opposite_the_shadows_of_the_cars(shadow: tuple[int, int]) -> None:
    look = cut_textures(Ground([region(shadow)]), generator())
    for car in look.cars:
        assert car.light is not None
        along = car.light[0]  # the length of these cars points down or up in the picture
        assert abs(along) > 0.8
        assert np.linalg.norm(car.light) == pytest.approx(1)
    signs = {np.sign(car.light[0]) for car in look.cars if car.light is not None}
    other = {np.sign(car.light[0]) for car in textures().cars if car.light is not None}
    assert len(signs) == 1
    assert (signs == other) == (shadow == (0, -8))


@pytest.mark.nightly
def test_only_cars_of_taken_stalls_that_are_judged_and_clear_are_cut() -> None:
    whole = region()
    some = np.array([True, True, False, False, False, False])
    for changed in (
        replace(whole.scene, taken=some),
        replace(whole.scene, judged=some),
        replace(whole.scene, unclear=~some),
    ):
        assert len(cut_textures(Ground([Region("some", changed)]), generator()).cars) == 2


@pytest.mark.nightly
def test_what_is_not_shaped_as_a_car_or_stands_in_the_shade_is_not_cut() -> None:
    whole = region().scene
    labels = whole.labels.copy()
    labels[134:150, 24:42, 1] = 0  # a part of the first car is hidden: what is left is too short
    image = whole.image.copy()
    image[120:190, 140:200] //= 3  # shade over the last one
    cut = cut_textures(Ground([Region("some", replace(whole, labels=labels, image=image))]), generator())
    assert len(cut.cars) == 4


def test_sheets_show_paving_and_grass_and_neither_paint_nor_cars() -> None:
    look = textures()
    assert len(look.paving) == 3
    assert len(look.grass) == 2
    assert look.leaves == ()
    for sheets, colour in ((look.paving, PAVING), (look.grass, GRASS)):
        for sheet in sheets:
            np.testing.assert_allclose(sheet.colour, colour, atol=2)
            shown = sheet.variation.astype(np.float32)
            assert shown.mean() == pytest.approx(1, abs=0.01)
            assert np.abs(shown - 1).max() < 8 * 5 / min(colour)


@pytest.mark.nightly
def test_plants_are_sorted_by_their_contrast() -> None:
    whole, rng = region().scene, generator(4)
    for contrast, names in ((0.05, {"grass"}), (0.25, {"wild", "leaves"}), (0.7, set())):
        image = whole.image.astype(np.float32)
        rough = rng.normal(0, 1, (320, 120))
        image[:, 200:] = np.array(GRASS) * (1 + contrast * rough[..., None])
        scene = replace(whole, image=np.clip(image, 0, 255).astype(np.uint8))
        look = cut_textures(Ground([Region("plants", scene)]), rng)
        assert {name for name in ("grass", "wild", "leaves") if getattr(look, name)} == names


def test_a_region_without_plain_ground_gives_no_sheet() -> None:
    whole = region().scene
    labels = whole.labels.copy()
    labels[..., 0] = UNKNOWN
    far = replace(whole, labels=labels, quads=whole.quads[:0], taken=whole.taken[:0], judged=whole.judged[:0])
    look = cut_textures(Ground([Region("unknown", replace(far, unclear=None))]), generator())
    assert (look.paving, look.grass, look.wild, look.leaves, look.cars) == ((),) * 5


def test_a_woven_sheet_varies_as_its_patches_do_and_goes_on_at_its_border() -> None:
    rng = generator(3)
    patches = [(100 + cv2.GaussianBlur(rng.normal(0, 30, (32, 32, 3)), (0, 0), 1.0)).astype(np.float32) for _ in "0123"]
    sheet = woven(patches, rng).variation.astype(np.float32)
    given = np.mean([(patch / patch.mean((0, 1))).std() for patch in patches])
    assert sheet.std() == pytest.approx(given, rel=0.1)
    for axis in (0, 1):
        step = np.abs(np.diff(sheet, axis=axis)).mean()
        seam = np.abs(np.take(sheet, 0, axis) - np.take(sheet, -1, axis)).mean()
        assert seam < 1.3 * step
