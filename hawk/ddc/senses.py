"""Senses: collects the facts of a moment from the readings. Nothing else reads to decide.

Each reading keeps its own memory and returns its own facts (`hawk.ddc.readings`, `hawk.ddc.battery`,
`hawk.ddc.witnesses`). Outcomes of acts come from the performer.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import datetime
from typing import TypeVar

from hawk.comm.protocol.authority import OperatorDesk
from hawk.ddc.battery.battery import BatteryReading, Grounds
from hawk.ddc.battery.survey import SurveyReading
from hawk.ddc.facts import Facts
from hawk.ddc.fence.keepers import FenceKeeper, OutlineKeeper
from hawk.ddc.parameters.failsafes import ALL_NAMES
from hawk.ddc.readings.belief import Belief, BeliefReading, Motion, ground_health
from hawk.ddc.readings.clearance import BelowReading
from hawk.ddc.readings.fall import FallReading
from hawk.ddc.readings.home import HomeReading, home_on_map
from hawk.ddc.readings.instant import Instant, Parts, Reading
from hawk.ddc.readings.limits import LimitsReading
from hawk.ddc.readings.link import LinkReading
from hawk.ddc.readings.operator import OperatorReading
from hawk.ddc.readings.position import PositionReading
from hawk.ddc.readings.remote_control import RemoteControlReading
from hawk.ddc.readings.remote_id import RemoteIdReading
from hawk.ddc.readings.sight import SightReading
from hawk.ddc.readings.topic_interface import DdcTopicInterface
from hawk.ddc.readings.wind import WindReading
from hawk.ddc.requests.flight_log import FlightLog
from hawk.ddc.requests.requests import Outcomes, Requests
from hawk.ddc.requests.service_interface import DdcServiceInterface
from hawk.ddc.settings import DdcSettings
from hawk.ddc.witnesses.witness import WitnessFacts, WitnessReading
from hawk.model.operation import Fall

R = TypeVar("R", bound=Reading)


@dataclass(frozen=True, slots=True)
class Sources:
    """Everything that the senses read."""

    clock: Callable[[], float]
    utc: Callable[[], datetime]
    topics: DdcTopicInterface
    service: DdcServiceInterface
    desk: OperatorDesk
    fences: FenceKeeper
    outlines: OutlineKeeper
    log: FlightLog
    requests: Requests
    outcomes: Outcomes
    settings: DdcSettings
    survey: SurveyReading
    fall: Fall | None = None
    """The fall that ended the last flight of an earlier run, as nobody cleared it."""


class Senses:
    """Gathers facts: `tick` once a tick, `look` for a command between two ticks.

    A look changes no memory but the belief in armed and landed, which follows each HEARTBEAT.
    """

    def __init__(self, sources: Sources) -> None:
        topics, settings, now = sources.topics, sources.settings, sources.clock()
        vehicle = topics.vehicle
        self._from = sources
        self._readings: list[Reading] = []
        """In the order of the parts whose health they know."""
        self._belief = BeliefReading()
        self._believe(now)
        self._link = self._add(LinkReading(topics, sources.service.asked_for))
        self._position = self._add(PositionReading(topics, now))
        self._home = self._add(HomeReading(vehicle.home))
        self._below = self._add(BelowReading(vehicle.terrain, settings.heights.least_clearance_m))
        self._witness = self._add(WitnessReading(topics))
        self._remote_control = self._add(RemoteControlReading(vehicle.remote_control, settings.remote_control))
        self._remote_id = self._add(RemoteIdReading(vehicle.remote_id, settings.remote_id))
        self._wind = self._add(WindReading(settings.flight.maximum_wind_m_s))
        self._limits = self._add(LimitsReading(sources.fences, sources.outlines, settings.fence.ceiling_margin_m))
        self._fall = self._add(FallReading(sources.fall))
        self._operator = self._add(OperatorReading(sources.desk))
        self._sight = self._add(SightReading(topics))
        grounds = Grounds(sources.fences, sources.outlines)
        self._battery = BatteryReading(topics, settings, sources.survey, grounds, now)

    def close(self) -> None:
        """Stop listening."""
        for reading in self._readings:
            reading.close()

    def tick(self) -> Facts:
        """Return the facts of this tick, with the events since the tick before."""
        now = self._from.clock()
        belief = self._believe(now)
        self._link.observe(belief, now)
        instant = self._instant(belief, now)
        for reading in self._readings:
            reading.update(instant)
        self._battery.update(instant, self._wind.estimate, self._home.ends(instant))
        facts = self._gather(instant)
        return replace(
            facts, link=self._link.take_events(facts.link), position=self._position.take_jumps(facts.position)
        )

    def look(self) -> Facts:
        """Return the facts of this moment, without events."""
        now = self._from.clock()
        return self._gather(self._instant(self._believe(now), now))

    def _add(self, reading: R) -> R:
        self._readings.append(reading)
        return reading

    def _believe(self, now: float) -> Belief:
        topics = self._from.topics
        place = topics.vehicle.arm_place.latest
        motion = Motion.of(topics.get_pose(), topics.get_pose_age())
        return self._belief.update(topics.get_state(), motion, -math.inf if place is None else place.time, now)

    def _instant(self, belief: Belief, now: float) -> Instant:
        topics, service = self._from.topics, self._from.service
        return Instant(
            now=now,
            utc=self._from.utc().timestamp(),
            belief=belief,
            is_linked=self._link.is_up,
            pose=topics.get_pose(),
            pose_age=topics.get_pose_age(),
            arm=topics.vehicle.arm_place.latest,
            datum=service.datum,
            fence=topics.fence_pub.value,
            held_fence=service.held_fence if self._link.is_unbroken else None,
            heights=topics.get_heights(),
            parameters=service.parameters,
            healths=dict(topics.get_part_healths()),
        )

    def _gather(self, instant: Instant) -> Facts:
        """Return what the readings know. What a tick's update found stands in their memories."""
        outcomes, home, witness = self._from.outcomes, self._home.facts(), self._witness.facts(instant)
        read = instant.parameters
        return Facts(
            now=instant.now,
            utc=instant.utc,
            vehicle=instant.vehicle,
            ground=instant.belief.ground,
            link=self._link.facts(instant, self._from.log.autopilot_reason()),
            position=self._position.facts(instant, home_on_map(instant), home, self._below.facts(instant)),
            diagnostics=self._from.topics.get_diagnostics(),
            battery=self._battery.facts(instant),
            wind=self._wind.facts(instant),
            witness=witness,
            limits=self._limits.facts(instant),
            operator=self._operator.facts(instant),
            sight=self._sight.facts(instant, outcomes.desired_count),
            remote_control=self._remote_control.facts(instant),
            remote_id=self._remote_id.facts(instant),
            parts=self._parts(instant, witness),
            answers=self._from.requests.answers(),
            target_refusal=outcomes.target_refusal,
            parameters=tuple((name, float(read[name])) for name in ALL_NAMES if name in read),
            fall=self._fall.facts(),
            starts_in_air=outcomes.starts_in_air,
            lots=self._from.topics.get_lots_ahead(),
        )

    def _parts(self, instant: Instant, witness: WitnessFacts) -> Parts:
        """Return the health of every part: that of armed and landed stands behind the position's."""
        parts = dict(instant.healths)
        link, position = parts.pop("link"), witness.position_health(parts.pop("position"))
        ground = ground_health(instant.belief.ground, is_linked=instant.is_linked)
        known = [part for reading in self._readings for part in reading.parts(instant)]
        return ("link", link), ("position", position), ("ground", ground), *parts.items(), *known
