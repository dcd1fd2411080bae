"""The drone that flies: the daemon's carrot, the simulated autopilot's controllers, body and position error.

The same parts fly in ``hawk-sim``; here they take larger steps, and nothing lies between them and a plan.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from hawk.config.sections import FlightSettings
from hawk.ddc.fence.geometry import path_is_inside
from hawk.ddc.motion import Carrot, Goal
from hawk.model.plans import Fence, HeightParameters, PathPlan
from hawk.model.poses import MapPose
from hawk.sim.autopilot.control import Controller, Limits, Setpoint
from hawk.sim.autopilot.gps import Estimate, Estimator
from hawk.sim.autopilot.parameters import copter_parameters
from hawk.sim.autopilot.sensors import Receiver
from hawk.sim.vehicle import Body, Wind, step_body

STEP_S: Final = 0.05
"""The state machine's tick."""
GNSS_SIGMA_M: Final = 0.5
"""Slow position error, as hawk-sim has it by default."""


class Drone:
    """Hovers at its start, then follows goals; ``distance_m`` is truly flown, ``seconds`` since the start."""

    def __init__(
        self,
        start: MapPose,
        fence: Fence,
        rng: np.random.Generator,
        gnss_sigma: float = GNSS_SIGMA_M,
        wind: Wind | None = None,
    ) -> None:
        place = (start.north, start.east, -start.height)
        self._body = Body(position=place, yaw=start.yaw, on_ground=False)
        self._estimator = Estimator(gnss_sigma, 0.0, rng)
        self._estimator.exact = gnss_sigma == 0.0
        self._estimate: Estimate = self._estimator.step(self._body, STEP_S)
        self._wind = wind or Wind(0.0, 0.0, rng)
        self._controller = Controller()
        self._controller.reset(self._estimate)
        self._limits = Limits.of(copter_parameters())
        self._carrot = Carrot(FlightSettings().speed_m_s)
        self._fence = fence
        self._heights = HeightParameters()
        self.distance_m = 0.0
        self.seconds = 0.0

    @property
    def true(self) -> MapPose:
        """The true pose."""
        body = self._body
        north, east, down = body.position
        return MapPose(north, east, -down, body.roll, body.pitch, body.yaw)

    @property
    def believed(self) -> MapPose:
        """The estimated pose."""
        estimate = self._estimate
        north, east, down = estimate.position
        return MapPose(north, east, -down, estimate.roll, estimate.pitch, estimate.yaw)

    @property
    def receiver(self) -> Receiver:
        """The GNSS receiver, whose errors may be set."""
        return self._estimator.gnss

    @property
    def speed(self) -> float:
        """Over ground, m/s."""
        return math.hypot(*self._body.velocity[:2])

    def step(self, goal: Goal | None) -> None:
        """Let one tick pass; without a goal, or with one beyond the fence, the drone goes on to its last target."""
        pose = self.believed
        if goal is not None and path_is_inside(self._fence, pose.point, goal.point):
            self._carrot.step(goal, pose, self.seconds, self._heights.minimum, self._heights.maximum)
        target = self._carrot.place or Goal(pose.north, pose.east, pose.height, pose.yaw)
        setpoint = Setpoint((target.north, target.east), down=-target.height, yaw=target.yaw)
        demand = self._controller.update(self._estimate, setpoint, self._limits, STEP_S)
        before = self._body.position
        self._body = step_body(self._body, demand, self._wind.step(STEP_S), STEP_S)
        self._estimate = self._estimator.step(self._body, STEP_S)
        self.distance_m += math.dist(before[:2], self._body.position[:2])
        self.seconds += STEP_S


def goal_of(plan: PathPlan, pose: MapPose, last: Goal | None) -> Goal | None:
    """Return the goal as the state Autonomous Explore takes it from a plan: without a target the last one stays."""
    if plan.target is None:
        return last
    height = pose.height if plan.height is None else plan.height
    return Goal(plan.target.north, plan.target.east, height, pose.yaw if plan.yaw is None else plan.yaw)
