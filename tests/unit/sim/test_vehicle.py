from __future__ import annotations

import math
from dataclasses import replace

import pytest

from hawk.sim.vehicle import DRAG, GRAVITY, Body, Demand, step_body

CALM = (0.0, 0.0, 0.0)
DT = 0.01


def fly(body: Body, demand: Demand, seconds: float, wind: tuple[float, float, float] = CALM) -> Body:
    for _ in range(round(seconds / DT)):
        body = step_body(body, demand, wind, DT)
    return body


def hovering(height: float = 20.0, **changes: float) -> Body:
    return replace(Body(position=(0.0, 0.0, -height), on_ground=False), **changes)  # type: ignore[arg-type]


def test_stands_still_without_motors() -> None:
    assert fly(Body(), Demand(), 1.0, wind=(10.0, 0.0, 0.0)) == Body()


def test_idling_motors_do_not_lift() -> None:
    assert fly(Body(), Demand((0.0, 0.0, -5.0), motors=True, idle=True), 1.0).on_ground


def test_lifts_off_on_demand() -> None:
    body = fly(Body(), Demand((0.0, 0.0, -1.0), motors=True), 2.0)
    assert not body.on_ground
    assert 1.0 < body.height < 2.0


def test_dead_motors_fall_as_stones_do() -> None:
    body = fly(hovering(50.0), Demand(), 1.0)
    assert body.velocity[2] == pytest.approx(GRAVITY, rel=0.2)
    body = fly(body, Demand(), 3.0)
    assert body.crashed
    assert body.on_ground
    assert body.height == pytest.approx(0.0)


def test_a_crashed_vehicle_never_flies_again() -> None:
    body = fly(hovering(20.0), Demand(), 4.0)
    assert fly(body, Demand((0.0, 0.0, -5.0), motors=True), 2.0) == body


def test_a_soft_touch_down_is_survived() -> None:
    sinking = hovering(0.5, velocity=(0.0, 0.0, 2.4))  # type: ignore[arg-type]
    body = fly(sinking, Demand((0.0, 0.0, 0.0), motors=True), 2.0)
    assert body.on_ground
    assert not body.crashed


@pytest.mark.parametrize("yaw", [0.0, 1.0, math.pi / 2, -2.0])
def test_accelerates_where_it_is_asked_whatever_the_heading(yaw: float) -> None:
    body = fly(hovering(yaw=yaw), Demand((1.0, -2.0, 0.0), motors=True), 1.0)
    assert body.velocity[0] > 0.5
    assert body.velocity[1] / body.velocity[0] == pytest.approx(-2.0, rel=0.02)


def test_lean_follows_the_acceleration_after_a_lag() -> None:
    demand = Demand((2.5, 0.0, 0.0), motors=True)
    assert abs(fly(hovering(), demand, 0.03).pitch) < math.radians(5)
    body = fly(hovering(), demand, 1.0)
    assert body.pitch == pytest.approx(-math.atan(2.5 / GRAVITY), abs=1e-3)
    assert body.roll == pytest.approx(0.0, abs=1e-3)


def test_rolls_right_to_go_right() -> None:
    assert fly(hovering(), Demand((0.0, 2.0, 0.0), motors=True), 1.0).roll > 0.1


def test_lean_is_limited() -> None:
    body = fly(hovering(), Demand((50.0, 50.0, 0.0), lean_max=0.5, motors=True), 2.0)
    assert math.hypot(body.roll, body.pitch) == pytest.approx(0.5, abs=0.01)


def test_wind_pushes_a_level_vehicle_along() -> None:
    body = fly(hovering(), Demand(motors=True), 1.0, wind=(0.0, 6.0, 0.0))
    assert body.velocity[1] == pytest.approx(6.0 * (1 - math.exp(-DRAG)), rel=0.02)


def test_turns_at_the_rate_asked_for() -> None:
    before = fly(hovering(), Demand(yaw_rate=0.5, motors=True), 2.0)
    after = fly(before, Demand(yaw_rate=0.5, motors=True), 1.0)
    assert after.yaw - before.yaw == pytest.approx(0.5, abs=0.01)
