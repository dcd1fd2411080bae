import numpy as np
import pytest

from training.scenes import BARE_SHARE, draw_scene


@pytest.mark.slow
def test_same_generator_state_gives_same_scene() -> None:
    first = draw_scene(np.random.default_rng(5), 128)
    second = draw_scene(np.random.default_rng(5), 128)
    other = draw_scene(np.random.default_rng(6), 128)
    assert np.array_equal(first.image, second.image)
    assert len(first.stalls) == len(second.stalls)
    assert not np.array_equal(first.image, other.image)


def test_shapes_and_masks() -> None:
    scene = draw_scene(np.random.default_rng(1), (96, 160))
    assert scene.image.shape == (96, 160, 3)
    assert scene.image.dtype == np.uint8
    for mask in (scene.lot, scene.car, scene.cover):
        assert mask.shape == (96, 160)
        assert set(np.unique(mask)) <= {0, 1}


@pytest.mark.nightly
@pytest.mark.slow
def test_what_is_covered_is_no_visible_car() -> None:
    scenes = [draw_scene(np.random.default_rng(k), 160) for k in range(8)]
    assert all(not (scene.car & scene.cover).any() for scene in scenes)
    assert any(scene.cover.any() for scene in scenes)
    assert any(scene.car.any() for scene in scenes)


@pytest.mark.nightly
@pytest.mark.slow
def test_stalls_have_the_size_of_stalls() -> None:
    stalls = [s for k in range(10) for s in draw_scene(np.random.default_rng(k), 160).stalls]
    assert len(stalls) > 20
    for stall in stalls:
        short = np.linalg.norm(stall.quad[1] - stall.quad[0])
        long = np.linalg.norm(stall.quad[2] - stall.quad[1])
        assert 20 < short < 50
        assert 44 < long < 90
        assert stall.hidden == (stall.covered >= 0.7)
    assert 0 < sum(s.taken for s in stalls) < len(stalls)


@pytest.mark.nightly
@pytest.mark.slow
def test_taken_stalls_show_cars_and_free_ones_do_not() -> None:
    taken: list[int] = []
    free: list[int] = []
    for k in range(24):
        scene = draw_scene(np.random.default_rng(k), 256)
        for stall in scene.stalls:
            column, row = np.round(stall.quad.mean(0)).astype(int)
            if stall.covered < 0.02 and 0 <= row < 256 and 0 <= column < 256:
                (taken if stall.taken else free).append(scene.car[row, column])
    assert np.mean(taken) > 0.9
    assert np.mean(free) < 0.15


@pytest.mark.nightly
@pytest.mark.slow
def test_some_scenes_have_no_lot() -> None:
    bare = [not draw_scene(np.random.default_rng(k), 64).lot.any() for k in range(40)]
    assert BARE_SHARE >= 0.14
    assert 2 <= sum(bare) <= 20


@pytest.mark.parametrize(("size", "scale"), [(8, 0.1), (64, 0.0), (64, -1.0)])
def test_bad_sizes_are_refused_by_name(size: int, scale: float) -> None:
    with pytest.raises(ValueError, match="size_px"):
        draw_scene(np.random.default_rng(0), size, metres_per_pixel=scale)
