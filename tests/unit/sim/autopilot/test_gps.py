from __future__ import annotations

import math

import numpy as np
import pytest

from hawk.sim.autopilot.gps import ATTITUDE_SIGMA, Estimator
from hawk.sim.vehicle import Body

BODY = Body(position=(10.0, 20.0, -30.0), velocity=(1.0, 2.0, 3.0), roll=0.1, pitch=-0.1, yaw=3.14, on_ground=False)


def estimator(sigma: float = 1.0, wait: float = 0.0, seed: int = 1) -> Estimator:
    return Estimator(sigma, wait, np.random.default_rng(seed))


def errors(sigma: float, steps: int, dt: float, seed: int = 1) -> np.ndarray:
    unit = estimator(sigma, seed=seed)
    return np.array([np.subtract(unit.step(BODY, dt).position, BODY.position) for _ in range(steps)])


@pytest.mark.slow
def test_the_error_starts_at_zero_and_reaches_its_sigma() -> None:
    assert np.abs(errors(1.0, 5, 0.01)).max() < 0.05
    walks = np.concatenate([errors(1.0, 2000, 3.0, seed)[200:] for seed in range(4)])
    assert walks[:, :2].std() == pytest.approx(1.0, rel=0.2)
    assert walks[:, 2].std() == pytest.approx(0.4, rel=0.25)


@pytest.mark.nightly
def test_the_error_moves_slowly() -> None:
    walk = errors(1.0, 20_000, 0.01)
    assert np.abs(np.diff(walk, axis=0)).max() / 0.01 < 0.2


@pytest.mark.nightly
def test_the_velocity_agrees_with_the_drifting_position() -> None:
    unit = estimator(3.0)
    estimates = [unit.step(BODY, 0.01) for _ in range(20_000)]
    drift = (estimates[-1].position[0] - estimates[0].position[0]) / 200.0
    believed = float(np.mean([estimate.velocity[0] for estimate in estimates])) - BODY.velocity[0]
    assert believed == pytest.approx(drift, abs=2e-3)


def test_without_sigma_the_position_is_true() -> None:
    assert np.abs(errors(0.0, 500, 0.01)).max() < 1e-9


def test_attitude_errors_stay_small_and_yaw_stays_wrapped() -> None:
    unit = estimator()
    for _ in range(3000):
        estimate = unit.step(BODY, 1.0)
        assert abs(estimate.roll - BODY.roll) < 6 * ATTITUDE_SIGMA
        assert -math.pi < estimate.yaw <= math.pi


def test_becomes_healthy_after_the_wait() -> None:
    unit = estimator(wait=5.0)
    seen = []
    for _ in range(52):
        unit.step(BODY, 0.1)
        seen.append((unit.healthy, unit.fix_type, unit.satellites))
    assert seen[48] == (False, 1, 0)
    assert seen[50] == (True, 3, 14)


def test_loses_the_fix_first_then_health_and_recovers() -> None:
    unit = estimator()
    unit.step(BODY, 3.0)
    assert unit.healthy
    unit.receiving = False
    for seconds, fix, healthy in ((3.5, 3, True), (3.0, 0, True), (1.5, 0, False)):
        unit.step(BODY, seconds)
        assert (unit.fix_type, unit.healthy) == (fix, healthy)
    assert unit.horizontal_accuracy > 50
    unit.receiving = True
    for _ in range(3):
        unit.step(BODY, 1.1)
    assert unit.healthy


@pytest.mark.slow
def test_dead_reckoning_walks_away_and_comes_back() -> None:
    unit = estimator(0.0)
    unit.step(BODY, 3.0)
    unit.receiving = False
    for _ in range(6000):
        away = unit.step(BODY, 0.01)
    assert math.dist(away.position[:2], BODY.position[:2]) > 1.0
    unit.receiving = True
    for _ in range(3000):
        back = unit.step(BODY, 0.01)
    assert math.dist(back.position[:2], BODY.position[:2]) < 0.1


def test_a_glitch_stays() -> None:
    unit = estimator(0.0)
    unit.jump(5.0, -2.0, 1.0)
    assert unit.step(BODY, 0.01).position == pytest.approx((15.0, 18.0, -29.0))
