from __future__ import annotations

import math

import numpy as np

from hawk.sim.vehicle import GUST_SHARE, Wind


def test_without_wind_there_are_no_gusts() -> None:
    assert Wind(0.0, 1.0, np.random.default_rng(1)).step(0.01) == (0.0, 0.0, 0.0)


def test_mean_and_gusts_are_as_asked_for() -> None:
    wind = Wind(6.0, math.radians(30.0), np.random.default_rng(1))
    samples = np.array([wind.step(0.2) for _ in range(20_000)])
    assert np.allclose(samples.mean(0), [6 * math.cos(math.pi / 6), 3.0, 0.0], atol=0.2)
    assert np.allclose(samples[:, :2].std(0), 6 * GUST_SHARE, rtol=0.1)


def test_gusts_do_not_jump() -> None:
    wind = Wind(6.0, 0.0, np.random.default_rng(2))
    samples = np.array([wind.step(0.01) for _ in range(2000)])
    assert np.abs(np.diff(samples, axis=0)).max() < 0.7


def test_the_same_seed_blows_the_same_wind() -> None:
    first, second = (Wind(5.0, 0.0, np.random.default_rng(3)) for _ in range(2))
    assert [first.step(0.01) for _ in range(10)] == [second.step(0.01) for _ in range(10)]
