from __future__ import annotations

import cv2
import numpy as np
import pytest

from benchmarks import mosaic
from benchmarks.mosaic import Flown, Sources, black_share, seams, sharpness, tile_seams
from hawk.algo.ground import Window
from hawk.algo.mapper.mosaic import Mosaic
from hawk.model.lot_map import CELL_M, TILE_CELLS
from hawk.worlds.world import World

SIDE = 300


def ground() -> np.ndarray:
    soft = cv2.GaussianBlur(np.random.default_rng(2).normal(0, 1, (SIDE, SIDE, 3)).astype(np.float32), (0, 0), 2)
    return np.clip(120 + 100 * soft, 20, 235).astype(np.uint8)


OWN = ground()


def halves() -> np.ndarray:
    sources = np.zeros((SIDE, SIDE), np.int32)
    sources[:, SIDE // 2 :] = 1
    return sources


def flown(picture: np.ndarray, sources: np.ndarray) -> Flown:
    window, all_of_it = Window(0, 0, SIDE, SIDE, CELL_M), np.full((SIDE, SIDE), 255, np.uint8)
    return Flown(window, picture, all_of_it.copy(), sources, all_of_it, [2.0, 4.0], 0.5)


def test_the_worlds_own_picture_has_no_seams_and_a_step_of_light_has_both_figures() -> None:
    assert seams(OWN, OWN, halves()) == 1.0
    lit = OWN.copy()
    lit[:, SIDE // 2 :] = np.clip(lit[:, SIDE // 2 :].astype(int) + 15, 0, 255)
    assert seams(lit, OWN, halves()) > 2
    assert seams(lit, OWN, halves(), 6) > 1.5


def test_pixels_of_no_source_count_as_neither() -> None:
    sources = halves()
    sources[:, SIDE // 2 :] = -1
    sources[:50, :50] = 3
    dark = OWN.copy()
    dark[:, SIDE // 2 :] = 0
    assert seams(dark, OWN, sources) == pytest.approx(1.0)


def test_borders_of_tiles_are_those_of_the_map() -> None:
    assert tile_seams(flown(OWN, halves()), OWN) == pytest.approx(1.0, abs=0.15)
    lit = OWN.copy()
    lit[:, TILE_CELLS:] = np.clip(lit[:, TILE_CELLS:].astype(int) + 20, 0, 255)
    assert tile_seams(flown(lit, halves()), OWN) > 1.5


def test_sharpness_and_black() -> None:
    blurred = cv2.GaussianBlur(OWN, (0, 0), 1.5)
    assert sharpness(flown(OWN, halves()), OWN) == pytest.approx(1.0)
    assert sharpness(flown(blurred, halves()), OWN) < 0.5
    dark = OWN.copy()
    dark[:30] = 0
    assert black_share(flown(dark, halves())) == pytest.approx(0.1)
    figures = {figure.key: figure for figure in mosaic.figures([(flown(dark, halves()), OWN)])}
    assert figures["black_percent"].passed is False
    assert figures["frame_ms"].value == 3.0
    assert figures["finish_s"].value == pytest.approx(0.5 * 30_000 / 900)


@pytest.mark.slow
@pytest.mark.nightly
def test_a_small_world_is_flown() -> None:
    lot = np.array([[20.0, 20.0], [40.0, 20.0], [40.0, 40.0], [20.0, 40.0]])
    wide = np.asarray(cv2.resize(OWN, (1200, 1200), interpolation=cv2.INTER_CUBIC), np.uint8)
    world = World("drawn", 0.05, wide, lots=(lot,))
    sources = Sources()
    found = mosaic.fly(world, Mosaic(sources.note), sources, 1)
    assert len(found.frame_ms) == len(list(mosaic.path(world)))
    assert black_share(found) < 0.01
    own = mosaic.own_picture(world, found.window)
    assert seams(found.picture, own, found.sources) < 1.2
    assert len(np.unique(found.sources)) > 3
