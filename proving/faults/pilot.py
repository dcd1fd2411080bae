"""The operator of a fault's flight: takes control, and brings the drone into a part of a flight."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from urllib.parse import urlsplit

from hawk.comm.protocol.commands import (
    Ack,
    Arm,
    AutonomousExplore,
    Command,
    CompulsiveMove,
    Control,
    Hold,
    Kill,
    KillRequest,
    KillToken,
    NewSurvey,
    ReturnToLaunch,
    SetFailsafes,
    Takeoff,
)
from hawk.comm.protocol.heartbeat import Heartbeat
from hawk.model.operation import GROUND_STATES, StateName
from hawk.survey.client import DroneClient
from hawk.survey.handset import Handset, SurveyError, refusal_of
from proving.faults.fault import When

SILENCE_S = 30.0
"""Real seconds without a heartbeat until a phase is given up."""
_SIGHT = ("camera", "vision", "mapper", "planner")
_AWAY_M = 25.0  # so that the return takes a while
_STAYS_BEATS = 15
"""Heartbeats until an exploration has not ended at once: 3 s."""


class Pilot:
    """One connection with control."""

    def __init__(self, drone: DroneClient) -> None:
        self.drone = drone
        self._hand = Handset(drone, SILENCE_S, lambda _, __: None)

    @classmethod
    async def connect(cls, url: str) -> Pilot:
        """Connect; control is not taken yet."""
        place = urlsplit(url)
        drone = DroneClient(place.hostname or "", place.port or 0)
        await drone.start()
        return cls(drone)

    async def close(self) -> None:
        """End the connection without a word."""
        await self.drone.close()

    async def order(self, command: Command) -> str | None:
        """Give a command; return the reason when it is refused."""
        answer = await self.drone.ask(command)
        return answer.reason if isinstance(answer, Ack) and not answer.accepted else None

    async def kill(self) -> str | None:
        """Cut the motors, in two steps; return the reason when that is refused."""
        answer = await self.drone.ask(KillRequest())
        if not isinstance(answer, KillToken):
            return answer.reason if isinstance(answer, Ack) else "no token"
        return await self.order(Kill(token=answer.token))

    async def take_control(self) -> None:
        """Ask for control until it is given."""
        async with asyncio.timeout(SILENCE_S):
            while await self.order(Control(action="Request")) is not None:
                await self._hand.next()

    async def reach(self, when: When) -> None:
        """Bring the drone into this part of a flight. Raises SurveyError, LinkLostError, TimeoutError."""
        await self._until(lambda b: b.connected, 60.0)
        await self.take_control()
        if when is When.GROUND:
            await self._land()
        elif when is When.ARMED:
            await self._land()
            await self._arm()
        elif when is When.EXPLORING:
            await self._explore()
        else:
            await self._hover()
            if when is When.RETURNING:
                await self._must(CompulsiveMove(x=_AWAY_M, y=0.0))
                await self._until_state(StateName.COMPULSIVE_MOVE)
                await self._until_state(StateName.HOVER)
                await self._must(ReturnToLaunch())
                await self._until_state(StateName.RETURN_TO_LAUNCH)

    async def _explore(self) -> None:
        """Explore a lot that is not seen whole yet: with a new survey where the flights before have seen it."""
        await self._hover()
        if not await self._is_exploring():
            await self._land()
            await self._must(NewSurvey())
            await self._hover()
            if not await self._is_exploring():
                raise SurveyError("Explore ended at once, in a new survey too")

    async def _is_exploring(self) -> bool:
        """Begin to explore; return False where that ended at once, since nothing is left."""
        await self._until(lambda b: all(i.healthy for i in b.health if i.name in _SIGHT), 30.0)
        await self._until(lambda b: not refusal_of(b, "Autonomous Explore"), 30.0)
        await self._must(AutonomousExplore())
        beats = [await self._hand.next() for _ in range(_STAYS_BEATS)]
        return beats[-1].state == StateName.AUTONOMOUS_EXPLORE

    async def _land(self) -> None:
        beat = await self._hand.next()
        if beat.armed or beat.state not in GROUND_STATES:
            await self.order(ReturnToLaunch(confirmed=True))
        await self._until(lambda b: b.state == StateName.IDLE and b.armed is False, 240.0)

    async def _arm(self) -> None:
        def ready(beat: Heartbeat) -> bool:
            failed = [check for check in beat.checks if not check.passed]
            return bool(beat.checks) and all(check.remedy_command == "Set Failsafes" for check in failed)

        await self._until(ready, 120.0)
        beat = await self._hand.beat()
        if not all(check.passed for check in beat.checks):
            await self._must(SetFailsafes())
        await self._until(lambda b: bool(b.checks) and all(check.passed for check in b.checks), 60.0)
        await self._must(Arm())
        await self._until(lambda b: b.state == StateName.ARM and b.armed is True, 30.0)

    async def _hover(self) -> None:
        beat = await self._hand.next()
        if beat.state in (StateName.RETURN_TO_LAUNCH, StateName.LAND):
            await self._land()
            beat = await self._hand.next()
        if beat.state in GROUND_STATES:
            await self._land()
            await self._arm()
            await self._until(lambda each: not refusal_of(each, "Takeoff"), 30.0)
            await self._must(Takeoff())
        elif beat.state != StateName.HOVER:
            await self._must(Hold())
        await self._until_state(StateName.HOVER)

    async def _must(self, command: Command) -> None:
        await self._hand.order(command)

    async def _until(self, reached: Callable[[Heartbeat], bool], timeout_s: float) -> Heartbeat:
        return await self._hand.until(
            reached, timeout_s, lambda b: f"still {b.state}, {b.ardupilot_state}: {b.detail}, {_failed(b)}"
        )

    async def _until_state(self, wanted: StateName) -> Heartbeat:
        return await self._until(lambda b: b.state == wanted, 120.0)


def _failed(beat: Heartbeat) -> str:
    checks = [f"{check.name} {check.value}" for check in beat.checks if not check.passed]
    return ", ".join(checks + [f"{item.name} {item.reason}" for item in beat.health if not item.healthy])
