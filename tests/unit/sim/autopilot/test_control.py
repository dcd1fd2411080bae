from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest

from hawk.sim.autopilot.control import Controller, Limits, Setpoint
from hawk.sim.autopilot.gps import Estimate
from hawk.sim.autopilot.parameters import copter_parameters
from hawk.sim.vehicle import Body, Demand, step_body

LIMITS = Limits.of(copter_parameters())
DT = 0.01


class Loop:
    """A controller and a body whose state it knows exactly."""

    def __init__(self, limits: Limits = LIMITS, wind: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        self.body = Body(position=(0.0, 0.0, -20.0), on_ground=False)
        self.limits = limits
        self.wind = wind
        self.controller = Controller()
        self.demand = Demand()
        self.fastest = 0.0
        self.farthest = 0.0

    def run(self, setpoint: Setpoint, seconds: float) -> Body:
        for _ in range(round(seconds / DT)):
            body = self.body
            estimate = Estimate(body.position, body.velocity, body.roll, body.pitch, body.yaw)
            self.demand = self.controller.update(estimate, setpoint, self.limits, DT)
            self.body = step_body(body, self.demand, self.wind, DT)
            self.fastest = max(self.fastest, math.hypot(*self.body.velocity[:2]))
            self.farthest = max(self.farthest, self.body.position[0])
        return self.body


def test_goes_to_a_place_within_its_speed_and_stays() -> None:
    loop = Loop()
    body = loop.run(Setpoint((40.0, 0.0), down=-20.0), 20.0)
    assert body.position == pytest.approx((40.0, 0.0, -20.0), abs=0.05)
    assert 4.8 < loop.fastest < 5.1
    assert loop.farthest < 41.0


def test_a_slower_speed_of_the_set_point_holds() -> None:
    loop = Loop()
    loop.run(Setpoint((40.0, 0.0), down=-20.0, speed=2.0), 15.0)
    assert 1.9 < loop.fastest < 2.1


def test_wind_is_held_against() -> None:
    loop = Loop(wind=(0.0, 10.0, 0.0))
    body = loop.run(Setpoint((0.0, 0.0), down=-20.0), 25.0)
    assert math.hypot(*body.position[:2]) < 0.2
    assert body.roll < -math.radians(7)


def test_climbs_and_sinks_within_its_speeds() -> None:
    loop = Loop()
    body = loop.run(Setpoint((0.0, 0.0), down=-40.0), 5.0)
    assert body.velocity[2] == pytest.approx(-2.5, abs=0.05)
    body = loop.run(Setpoint((0.0, 0.0), down=-40.0), 15.0)
    assert body.height == pytest.approx(40.0, abs=0.05)
    body = loop.run(Setpoint((0.0, 0.0), climb=-9.0), 5.0)
    assert body.velocity[2] == pytest.approx(1.5, abs=0.05)


def test_velocities_are_flown() -> None:
    body = Loop().run(Setpoint(velocity=(1.0, -2.0), climb=0.5), 8.0)
    assert body.velocity == pytest.approx((1.0, -2.0, -0.5), abs=0.05)


def test_level_drifts_with_the_wind() -> None:
    body = Loop(wind=(0.0, 5.0, 0.0)).run(Setpoint(down=-20.0), 5.0)
    assert body.velocity[1] > 2.0
    assert abs(body.roll) < 1e-6


@pytest.mark.parametrize("yaw", [2.0, -2.0, 3.1])
def test_yaw_turns_by_the_smaller_angle_within_its_rate(yaw: float) -> None:
    loop = Loop(replace(LIMITS, slew_yaw=0.5))
    body = loop.run(Setpoint((0.0, 0.0), down=-20.0, yaw=yaw), 2.0)
    assert abs(body.yaw) <= 1.01
    assert math.copysign(1.0, body.yaw) == math.copysign(1.0, yaw)
    assert loop.run(Setpoint((0.0, 0.0), down=-20.0, yaw=yaw), 10.0).yaw == pytest.approx(yaw, abs=0.02)


def test_without_a_yaw_the_heading_is_held() -> None:
    loop = Loop()
    loop.run(Setpoint((0.0, 0.0), down=-20.0, yaw=1.0), 6.0)
    assert loop.run(Setpoint((5.0, 0.0), down=-20.0), 6.0).yaw == pytest.approx(1.0, abs=0.02)


def test_idle_lets_go() -> None:
    loop = Loop()
    loop.run(Setpoint(idle=True), 0.1)
    assert loop.demand.idle
    assert loop.body.velocity[2] > 0.5


def test_the_wanted_velocity_never_jumps() -> None:
    loop = Loop()
    leans = []
    for _ in range(300):
        loop.run(Setpoint((40.0, 0.0), down=-20.0), DT)
        leans.append(loop.body.pitch)
    assert max(abs(b - a) for a, b in itertools.pairwise(leans)) < math.radians(2.0)
