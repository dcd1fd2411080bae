from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from training import fit_classical
from training.fit_classical import _ground_image, _held_out, _joined, _score_lines, _taken_lines, fit, main
from training.scenes import Scene, SceneStall, draw_scene


def examples(seed: int, count: int, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Features with a constant first, and answers drawn by a logistic model."""
    rng = np.random.default_rng(seed)
    features = np.column_stack([np.ones(count), rng.normal(0, 1, (count, len(weights) - 1))])
    return features, (rng.random(count) < 1 / (1 + np.exp(-features @ weights))).astype(float)


@settings(max_examples=10)
@given(st.floats(-1, 1), st.floats(-2, 2), st.floats(-2, 2))
def test_a_fit_finds_the_weights_that_drew_its_examples(constant: float, first: float, second: float) -> None:
    true = np.array([constant, first, second])
    assert fit(*examples(1, 20_000, true), 0.0) == pytest.approx(true, abs=0.15)


def test_decay_keeps_all_weights_but_the_constant_small() -> None:
    features, right = examples(2, 4000, np.array([1.5, 2.0, -2.0]))
    free, held = fit(features, right, 0.0), fit(features, right, 1.0)
    assert np.abs(held[1:]).max() < 0.3 * np.abs(free[1:]).max()
    assert fit(features, np.ones(len(right)), 1.0)[0] > 3, "the constant is free"


def test_features_that_separate_the_answers_are_fitted_with_decay() -> None:
    features = np.column_stack([np.ones(40), np.r_[np.full(20, -1.0), np.full(20, 1.0)]])
    weights = fit(features, np.r_[np.zeros(20), np.ones(20)], 1e-3)
    assert np.isfinite(weights).all()
    assert weights[1] > 2
    assert weights[0] == pytest.approx(0, abs=1e-3)


def test_examples_of_scenes_are_joined_and_empty_ones_left_out() -> None:
    one, two = (np.ones((3, 2)), np.ones(3)), (np.zeros((0, 2)), np.zeros(0))
    features, right = _joined([one, two, one])
    assert features.shape == (6, 2)
    assert right.shape == (6,)


def test_the_share_of_right_answers_is_that_on_scenes_left_out() -> None:
    true = np.array([0.0, 8.0])
    lines = [examples(seed, 200, true) for seed in range(9)]
    good = _held_out(lines, 1e-4)
    assert good > 0.85
    for k in range(0, 9, 3):  # wrong answers in the held-out scenes alone
        lines[k] = (lines[k][0], 1 - lines[k][1])
    assert _held_out(lines, 1e-4) == pytest.approx(1 - good, abs=0.01)


def scene() -> Scene:
    drawn = (draw_scene(np.random.default_rng((5, seed)), (240, 320)) for seed in range(30))
    return next(one for one in drawn if sum(not s.hidden for s in one.stalls) > 12)


def test_the_ground_image_of_a_scene_is_north_up_at_its_scale() -> None:
    one = scene()
    view = _ground_image(one)
    assert view.metres_per_pixel == pytest.approx(0.1)
    assert view.valid.all()
    assert np.array_equal(view.values, one.image)
    assert view.to_map @ [10.0, 20.0, 1.0] == pytest.approx((-2.0, 1.0)), "rows go south, columns east"


def test_states_are_learnt_from_clear_stalls_inside_the_picture() -> None:
    one = scene()
    features, right = _taken_lines(one, _ground_image(one))
    corners = np.array([stall.quad for stall in one.stalls])
    inside = ((corners > 0) & (corners < (320, 240))).all(axis=(1, 2))
    clear = np.array([not s.hidden and s.covered < 0.3 for s in one.stalls])
    assert len(features) == len(right) == int((inside & clear).sum())
    assert (features[:, 0] == 1).all()
    assert right.tolist() == [float(s.taken) for s, kept in zip(one.stalls, inside & clear, strict=True) if kept]
    assert np.isfinite(features).all()


def test_found_bays_are_right_where_a_stall_is() -> None:
    one = scene()
    view = _ground_image(one)
    features, right = _score_lines(one, view)
    assert len(features) == len(right)
    assert set(right.tolist()) <= {0.0, 1.0}
    bare = replace(one, stalls=())
    without = _score_lines(bare, view)
    assert not without[1].any(), "without stalls no bay is right"
    np.testing.assert_array_equal(without[0], features)


def test_the_command_prints_both_fits(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    asked: list[tuple[int, ...]] = []

    def draw(rng: np.random.Generator, size: tuple[int, int]) -> Scene:
        asked.append(size)
        image = np.zeros((8, 8, 3), np.uint8)
        stall = SceneStall(np.zeros((4, 2)), False, False, False, True, 1.0, 0.0, "perpendicular")
        return Scene(image, image[..., 0], image[..., 0], image[..., 0], image[..., 0], (stall,), 0.1)

    monkeypatch.setattr(fit_classical, "draw_scene", draw)
    lines = iter(examples(seed, 60, np.array([0.3, 2.0, -1.0])) for seed in range(12))
    monkeypatch.setattr(fit_classical, "_taken_lines", lambda *_: next(lines))
    monkeypatch.setattr(fit_classical, "_score_lines", lambda *_: next(lines))
    main(["--scenes", "6", "--seed", "1"])
    printed = capsys.readouterr().out.splitlines()
    assert [line.split(" = ")[0] for line in printed] == ["_TAKEN", "_SCORE"]
    for line in printed:
        assert float(line.rsplit(": ", 1)[1]) > 0.6
    assert len(asked) == 6
