"""Looks at the parts without topics of their own, and publishes their health, rates and ages for the states."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from hawk.comm.autopilot.autopilot import MavsdkAutopilot
from hawk.comm.cameras.drone_camera import DroneCamera
from hawk.comm.mavlink.udp_gate import Hearing
from hawk.ddc.readings.topic_interface import DdcInputs
from hawk.model.operation import Health, Level
from hawk.model.sentences import say
from hawk.runtime.performance import LoopLag, Performance
from hawk.runtime.supervision import Supervisor, leave_at_once
from hawk.store.journal import FlightJournal
from hawk.store.recording import Recording

MONITOR_S: Final = 0.25
"""Real seconds between two looks."""
HANGING_CALLS: Final = 2
"""Number of calls that hang in MAVSDK after which a program in the air ends: failsafe and restart act then."""

AddMessage = Callable[[Level, str, str], object]
"""Adds a message for the operator: level, text, details."""


@dataclass(frozen=True, slots=True)
class MonitoredParts:
    """The parts that are looked at."""

    autopilot: MavsdkAutopilot
    camera: DroneCamera
    recording: Recording
    journal: FlightJournal
    supervisor: Supervisor
    lag: LoopLag
    performance: Performance


class Monitor:
    """Looks at the parts at an interval. ``write_flight_state`` is called before each look."""

    def __init__(
        self, parts: MonitoredParts, inputs: DdcInputs, add_message: AddMessage, write_flight_state: Callable[[], None]
    ) -> None:
        self._parts = parts
        self._inputs = inputs
        self._add_message = add_message
        self._write_flight_state = write_flight_state
        self._hearing = parts.autopilot.hearing
        self._problem = ""
        self._frames = 0

    async def run(self) -> None:
        """Look until cancelled."""
        while True:
            self._write_flight_state()
            await asyncio.sleep(MONITOR_S)
            self._look()

    def publish_calls_and_tasks(self) -> None:
        """Publish the health of calls into MAVSDK and of the program's own tasks; also called when one changes."""
        self._inputs.requests_health.publish(self._parts.autopilot.calls.health)
        self._inputs.tasks_health.publish(self._parts.supervisor.health)

    def report_end(self, name: str, words: str) -> None:
        """Report a task that ended and is started again."""
        self.publish_calls_and_tasks()
        self._add_message(
            "error",
            say("A part of the program ended and is started again."),
            say("{name}: {value}", name=name, value=words),
        )

    def report_hang(self, name: str, *, is_flying: bool) -> None:
        """Report a call that does not return; after the second in the air leave the drone to failsafe and restart."""
        if is_flying and self._parts.autopilot.calls.overdue >= HANGING_CALLS:
            leave_at_once(f"{HANGING_CALLS} calls hang in MAVSDK in the air, the last one in {name}: the program ends")
        self.publish_calls_and_tasks()
        self._add_message("error", say("A request hangs in MAVSDK."), name)

    def _look(self) -> None:
        parts, inputs = self._parts, self._inputs
        self._report_link()
        self._hearing = self._report_senders(self._hearing)
        inputs.camera_health.publish(parts.camera.health)
        inputs.recording_health.publish(self._storage_health())
        self.publish_calls_and_tasks()
        inputs.loop_lag.publish(parts.lag.latest_ms() / 1e3)
        if parts.performance.vision_fps is not None:
            inputs.vision_rate.publish(parts.performance.vision_fps)
        latest = parts.camera.latest
        if latest is not None:
            inputs.camera_time.publish(latest.captured)
            for _ in range(latest.sequence - self._frames):
                parts.performance.frame_received()
            self._frames = latest.sequence

    def _report_link(self) -> None:
        problem = self._parts.autopilot.problem
        if problem and problem != self._problem:
            self._add_message("warning", say("The link to the autopilot cannot be opened."), problem)
        self._problem = problem

    def _report_senders(self, before: Hearing) -> Hearing:
        """Publish and report who else sends to the autopilot's port, and a new address of the autopilot."""
        now = self._parts.autopilot.hearing
        self._inputs.second_sender.publish(now.second_sender)
        if now.second_sender and now.second_sender != before.second_sender:
            self._add_message("warning", say("A second sender on the autopilot's link."), now.second_sender)
        is_named = now.other_vehicles and now.other_vehicles not in now.second_sender
        if is_named and now.other_vehicles != before.other_vehicles:
            words = say(
                "{others}. Its messages are dropped; autopilot.vehicle_system_id names yours.",
                others=now.other_vehicles,
            )
            self._add_message("warning", say("Another copter is on the autopilot's link."), words)
        if before.sender and now.sender != before.sender:
            self._add_message(
                "warning",
                say("The autopilot has another address."),
                say("{former}, now {new}.", former=before.sender, new=now.sender),
            )
        return now

    def _storage_health(self) -> Health:
        journal = self._parts.journal.health
        return self._parts.recording.health if journal.is_healthy else journal
