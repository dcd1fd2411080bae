"""Ten thousand ticks of whatever may happen: requests hang, fields age, estimates jump, the guard raises.

The events are those of `test_properties`; here they are drawn by a seed, and every single tick is looked at.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any
from unittest import mock

import pytest

from hawk.comm.protocol.commands import (
    Ack,
    AutonomousExplore,
    AutonomousMove,
    ClearKill,
    Command,
    CompulsiveMove,
    Kill,
    KillRequest,
    KillToken,
)
from hawk.ddc.battery.battery import BATTERY_UNKNOWN_S, RESERVE_CONFIRM_S
from hawk.ddc.readings.belief import AIR_HEIGHT_M
from hawk.ddc.readings.position import POSITION_CONFIRM_S
from hawk.ddc.readings.sight import FAULT_CONFIRM_S
from hawk.ddc.readings.topic_interface import POSE_TIMEOUT_S
from hawk.ddc.rules import guard
from hawk.ddc.rules.guard import FENCE_RETURN_S
from hawk.model.plans import Inbound
from hawk.model.vehicle import CopterMode, LandedState
from tests.unit.ddc.fakes import TICK_S
from tests.unit.ddc.test_operations_manager_properties import SIMPLE, Flight

TICKS = 3_000
"""Ticks of a walk, 50 ms each."""
SEEDS = (1, 2, 3, 4)
TASKS: list[Command] = [AutonomousExplore(), AutonomousMove(x=30, y=9), CompulsiveMove(x=-25, y=9)]


class Walk(Flight):
    """A flight whose events are drawn by a seed; each tick is compared with the one before."""

    def __init__(self, seed: int) -> None:
        super().__init__()
        self.draw = random.Random(seed)
        self.ticks = 0
        self.raised = 0
        self.tasks = 0
        self.kills = 0
        self.wrong: list[str] = []
        self._broken = ExitStack()
        self.begin(safe=True, airborne=True, starts=1)
        self._watch_what_is_sent()

    def go(self, ticks: int) -> None:
        """Let a good operator begin task after task, and let things happen meanwhile, for this number of ticks."""
        happenings: list[Callable[[], None]] = [
            *[self._senses_age] * 5,
            *[self._guard_breaks] * 3,
            self._commands,
            self._kills,
            self._fails,
            self._refuses,
            self._jumps,
            self._somebody_switches,
        ]
        while self.ticks < ticks:
            self._goes_on()
            for _ in range(self.draw.choice([1, 1, 2, 3])):
                self.draw.choice(happenings)()
                self._run(self.draw.choice([0.2, 1.0, 4.0]))
                self.no_automatic_reaction_moved_down_in_rank()

    def teardown(self) -> None:
        """End the flight."""
        self._broken.close()
        super().teardown()

    # -- what happens ---------------------------------------------------------------------------------------------

    def _goes_on(self) -> None:
        self._broken.close()
        self.rig.sight.flows = True
        self._flies_again()
        if self.rig.autopilot.mode != CopterMode.GUIDED:
            self.rig.autopilot.change_mode(CopterMode.GUIDED)
            self._run(1.0, foreign=True)
        self.a_good_operator_goes_on(self.draw.choice(TASKS))

    def _commands(self) -> None:
        self.an_operator_commands(self.draw.choice(SIMPLE), self.draw.choice(["ana", "ana", "eve"]))

    def _kills(self) -> None:
        answer = self._handle(KillRequest(), "ana")
        if not isinstance(answer, KillToken):
            return
        before = self.rig.autopilot.count("kill")
        taken = self._handle(Kill(token=answer.token), "ana")
        self._run(0.05, foreign=True)
        self.kills += 1
        self._must(isinstance(taken, Ack) and taken.accepted, "a Kill with its token was refused")
        self._must(self.rig.autopilot.count("kill") > before, "a Kill did not go out")

    def _fails(self) -> None:
        good = [self.draw.random() < 0.7 for _ in range(2)]
        self.links_and_motors_fail(good[0], good[1], self.draw.random() < 0.2)

    def _refuses(self) -> None:
        requests = ["arm", "disarm", "set_mode", "takeoff", "upload_fence", "get_parameter", "set_home"]
        refused = {name for name in requests if self.draw.random() < 0.2}
        self.the_autopilot_refuses(refused, {name for name in requests if self.draw.random() < 0.2})

    def _jumps(self) -> None:
        far = self.draw.uniform(-40, 40)
        if self.draw.random() < 0.5:
            self.the_position_jumps(far / 4)
        else:
            self.the_estimate_jumps(far, -far / 2)

    def _senses_age(self) -> None:
        """Let everything of a good operator's flight grow old, one field at a time or several."""
        drone, sight, desk = self.rig.autopilot, self.rig.sight, self.rig.desk
        for _ in range(self.draw.choice([1, 1, 1, 3])):
            fields: list[tuple[str, object, list[Any]]] = [
                ("pose_flows", drone, [False]),
                ("landed_flows", drone, [False]),
                ("battery", drone, [None, 30.0, 12.0]),
                ("estimator_fault", drone, ["GPS glitch"]),
                ("flows", sight, [False]),
                ("healthy", sight, [False]),
                ("inbound", sight, [None, *Inbound]),
                ("present", desk, [False]),
            ]
            name, owner, values = self.draw.choice(fields)
            setattr(owner, name, self.draw.choice(values))

    def _guard_breaks(self) -> None:
        self._broken.close()
        self._broken.enter_context(mock.patch.object(guard, "reaction", self._raise))

    def _raise(self, *_: object) -> Any:
        self.raised += 1
        raise RuntimeError("the guard is broken")

    def _flies_again(self) -> None:
        drone = self.rig.autopilot
        if drone.landed is LandedState.IN_AIR and drone.armed:
            return
        self.foreign = True
        self._handle(ClearKill(), "ana")
        drone.north = drone.east = 0.0
        drone.connected = drone.pose_flows = drone.landed_flows = True
        drone.put_in_air()
        self._run(1.0, foreign=True)

    def _somebody_switches(self) -> None:
        self.somebody_changes_the_mode(self.draw.choice(list(CopterMode)))

    # -- what must hold -------------------------------------------------------------------------------------------

    def _must(self, holds: bool, words: str) -> None:
        if not holds:
            self.wrong.append(f"tick {self.ticks}, {self.rig.state}: {words}")

    def _watch_what_is_sent(self) -> None:
        drone = self.rig.autopilot
        send, disarm = drone.send_target, drone.disarm

        def sent(north: float, east: float, height: float, yaw: float) -> None:
            try:
                send(north, east, height, yaw)
            except AssertionError as error:
                self.wrong.append(f"tick {self.ticks}, {self.rig.state}: unsafe target: {error}")

        async def disarmed() -> None:
            self._must(not drone.armed or drone.height <= AIR_HEIGHT_M, f"a disarm at {drone.height:.0f} m")
            await disarm()

        drone.send_target = sent  # type: ignore[method-assign]
        drone.disarm = disarmed  # type: ignore[method-assign]

    async def _ticks(self, count: int) -> None:
        for _ in range(count):
            progress, raised = self.rig.manager.ticks, self.raised
            await self.rig.tick()
            self.ticks += 1
            self._look(fed=self.rig.manager.ticks > progress, failed=self.raised > raised)

    def _look(self, fed: bool, failed: bool) -> None:
        situation = self.rig.manager.situation()
        facts, state = situation.facts, situation.state
        if failed and facts.is_airborne:
            self._must(not fed, "a failed tick in the air fed the watchdog")
        if not facts.link.is_up or situation.interlocks.kill_state == "sending":
            return
        if state.needs_operator and not failed:
            self._must(facts.operator.is_present, "it waits for an operator who is lost")
        if not state.is_task:
            return
        self.tasks += 1
        self._must(not failed, "a task goes on while the guard is broken")
        self._must(facts.operator.is_present, "a task goes on without an operator")
        self._must(facts.position.age <= POSE_TIMEOUT_S, "a task goes on with an old position")
        self._must(facts.position.distrusted_s < POSITION_CONFIRM_S, "a task goes on with a position in doubt")
        self._must((facts.battery.reached_s or 0.0) < RESERVE_CONFIRM_S, "a task goes on with the reserve")
        self._must(facts.battery.unknown_s < BATTERY_UNKNOWN_S, "a task goes on with an unknown battery")
        self._must((facts.limits.breached_s or 0.0) < FENCE_RETURN_S, "a task goes on outside the fence")
        self._must(facts.limits.breached_s is None, "a task goes on beyond the fence")
        if state.sees and facts.sight.fault:
            self._must(facts.sight.fault_s < FAULT_CONFIRM_S, "it flies by sight without seeing")


@pytest.mark.slow
@pytest.mark.parametrize("seed", [*SEEDS[:1], *(pytest.param(seed, marks=pytest.mark.nightly) for seed in SEEDS[1:])])
def test_whatever_happens_no_tick_breaks_a_rule_of_safety(seed: int) -> None:
    walk = Walk(seed)
    try:
        walk.go(TICKS)
        assert walk.wrong == []
        assert walk.ticks >= TICKS
        assert walk.raised > 50, "the guard was hardly broken"
        assert walk.tasks > 50, "hardly a task was flown"
        assert walk.kills > 0
        assert walk.rig.clock() >= 100.0 + TICKS * TICK_S
    finally:
        walk.teardown()
