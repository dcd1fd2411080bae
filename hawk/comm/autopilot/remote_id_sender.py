"""Sends the operator's part of Remote ID once a second, while the autopilot is heard."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import Final

from hawk.comm.autopilot.remote_id import Fields, OperatorPlace, RemoteIdReport, fixed_place, takeoff_place, where, who
from hawk.comm.autopilot.vehicle import AutopilotError, VehicleTopics
from hawk.comm.clock import Clock
from hawk.config.sections import RemoteIdSettings
from hawk.model.poses import GlobalPose

_LOG = logging.getLogger(__name__)

PERIOD_S: Final = 1.0
"""Interval of all messages, seconds. ArduPilot and transmitters want the operator's place every 3 s."""
WHOLE_EVERY: Final = 5
"""Every fifth time the whole OPEN_DRONE_ID_SYSTEM is sent; an autopilot that has booted needs it."""
PLACE_AGE_S: Final = 3.0
"""On the ground an older position is not the place of the take-off, seconds."""


class RemoteIdSender:
    """Knows when and from where to send. A message that cannot be sent is left out; the next second has another."""

    def __init__(
        self,
        settings: RemoteIdSettings,
        topics: VehicleTopics,
        clock: Clock,
        send: Callable[[str, Fields], Awaitable[None]],
        utc: Callable[[], float],
    ) -> None:
        """``send`` sends one message without blocking the loop; ``utc``: Unix seconds."""
        self._settings = settings
        self._topics = topics
        self._clock = clock
        self._send = send
        self._utc = utc
        self._rounds = 0
        self._takeoff: OperatorPlace | None = None
        self._problem = ""

    async def run(self) -> None:
        """Send until cancelled."""
        while True:
            await self.send_once()
            await asyncio.sleep(PERIOD_S / self._clock.speed)

    async def send_once(self) -> None:
        """Send one second's messages, if the autopilot is heard."""
        state = self._topics.state.value
        if state is None or not state.connected:
            self._rounds = 0
            return
        messages = list(who(self._settings))
        place = self._place(is_armed=state.armed)
        if place is not None and place.is_sendable:
            messages.append(where(self._settings, place, self._utc(), whole=self._rounds % WHOLE_EVERY == 0))
            self._rounds += 1
        try:
            for name, fields in messages:
                await self._send(name, fields)
            self._problem = ""
        except AutopilotError as error:
            if str(error) != self._problem:
                _LOG.warning("Remote ID was not sent: %s", error)
            self._problem = str(error)

    def _place(self, *, is_armed: bool) -> OperatorPlace | None:
        fixed = fixed_place(self._settings)
        if fixed is not None or self._settings.operator_place == "fixed":
            return fixed
        pose = self._topics.pose.fresh(PLACE_AGE_S)
        stands_at = None if pose is None else pose.global_
        here = self._armed_at() if is_armed else stands_at
        if here is not None:
            report = self._topics.remote_id.value or RemoteIdReport()
            self._takeoff = takeoff_place(here, report.geoid_m)
        elif not is_armed:
            self._takeoff = None
        return self._takeoff

    def _armed_at(self) -> GlobalPose | None:
        """Return the arm place; home, where a daemon that starts in the air does not know it."""
        arm = self._topics.arm_place.value
        if arm is not None:
            return GlobalPose(arm.latitude, arm.longitude, arm.altitude)
        return self._topics.home.value
