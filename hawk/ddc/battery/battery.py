"""The battery: the charge that is believed, against the flight home and the rest of the survey."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from hawk.ddc.battery.charge import NO_CHARGE, ChargeFacts, ChargeReading
from hawk.ddc.battery.chemistry import CHEMISTRIES
from hawk.ddc.battery.energy import DrainReading, HomePath, Reserve, mean_speed
from hawk.ddc.battery.survey import Sighting, SurveyNeed, SurveyReading
from hawk.ddc.fence.geometry import area
from hawk.ddc.fence.keepers import FenceKeeper, OutlineKeeper
from hawk.ddc.fence.path import length
from hawk.ddc.readings.instant import Instant
from hawk.ddc.readings.topic_interface import BATTERY_TIMEOUT_S, DdcTopicInterface
from hawk.ddc.readings.wind import Wind
from hawk.ddc.settings import DdcSettings
from hawk.ddc.stopwatch import Stopwatch
from hawk.model.operation import StateName
from hawk.model.poses import MapPoint
from hawk.model.vehicle import BatteryInfo

BATTERY_UNKNOWN_S: Final = 30.0
"""Seconds without a valid charge after which the drone returns."""
RESERVE_CONFIRM_S: Final = 3.0
"""Seconds for which the reserve must be reached: a dip under load does not count."""


@dataclass(frozen=True, slots=True)
class BatteryFacts:
    """The battery and its reserve. ``info`` is None when the charge is unknown or older than the limit."""

    info: BatteryInfo | None = None
    age: float = math.inf
    unknown_s: float = 0.0
    """Seconds in flight without a valid charge."""
    reserve: Reserve | None = None
    """Charge against the cost of the flight home; None on the ground and while an input of it is unknown."""
    reached_s: float | None = None
    """Seconds since the reserve was reached; None while it is not."""
    cells: tuple[int, ...] = ()
    """Cell counts that the battery may have, by its voltage before take-off; empty while none fits."""
    survey: SurveyNeed | None = None
    """Charge against the rest of the survey, on the ground too; None while an input of it is unknown."""
    charge: ChargeFacts = NO_CHARGE
    """Counter, voltage and time flown, compared: what is believed of the charge."""
    short_s: float | None = None
    """Seconds while it explores for which the battery has been too low for the rest; None while it is not."""


@dataclass(frozen=True, slots=True)
class Grounds:
    """Fence and outline as an operator planned them: their areas say how large a survey may be."""

    fences: FenceKeeper
    outlines: OutlineKeeper

    def outline_area(self, instant: Instant) -> float | None:
        """Return the area of the outline inside the fence, square metres; None without one."""
        outline = self.outlines.facts(instant.datum, instant.fence)
        return None if outline is None else outline.area

    def fence_area(self, instant: Instant) -> float | None:
        """Return the area of the fence in force, on the ground that of the planned one, m²; None without one."""
        if instant.fence is not None and instant.is_airborne:
            return area(instant.fence)
        return None if instant.pose is None else self.fences.planned_area(instant.datum, instant.pose.global_)


class BatteryReading:
    """Compares the battery's readings, measures its drain, and times a reserve that is reached.

    It is updated after wind and home, on which the flight home depends.
    """

    def __init__(
        self,
        topics: DdcTopicInterface,
        settings: DdcSettings,
        survey: SurveyReading,
        grounds: Grounds,
        now: float,
    ) -> None:
        flight = settings.flight
        self._topics = topics
        self._flight = flight
        self._chemistry = CHEMISTRIES[flight.battery_chemistry]
        self._charge_reading = ChargeReading(self._chemistry, flight.battery_return_v, flight.battery_land_v)
        self._survey = survey
        self._grounds = grounds
        self._drain = DrainReading(flight.battery_reserve_percent)
        self._home_path = HomePath()
        self._cells: tuple[int, ...] = ()
        self._charge = NO_CHARGE
        self._known_at = now
        self._reserve: Reserve | None = None
        self._reached = Stopwatch()

    def update(self, instant: Instant, wind: Wind | None, ends: tuple[MapPoint, ...]) -> None:
        """Take the instant of a tick.

        Args:
            instant: The instant.
            wind: The wind; None: not known.
            ends: Places on the map at which the flight home may end; the farthest counts. None of them is known: ().
        """
        self._update_charge(instant)
        self._update_reserve(instant, wind, ends)
        try:
            self._survey.update(self._sighting(instant))
        except Exception:  # it informs only: the facts that decide are gathered all the same
            self._survey.fail()

    def facts(self, instant: Instant) -> BatteryFacts:
        """Return what is known."""
        now = instant.now
        return BatteryFacts(
            info=self._topics.get_battery_info(),
            age=self._topics.get_battery_age(),
            unknown_s=now - self._known_at,
            reserve=self._reserve,
            reached_s=self._reached.read(now),
            cells=self._cells,
            charge=self._charge,
            survey=self._survey.need,
            short_s=self._survey.short_s(now),
        )

    def _update_charge(self, instant: Instant) -> None:
        """Count the battery's cells at rest, and compare its readings. In flight the voltage sags, the count stays."""
        info, armed = self._topics.vehicle.battery.fresh(BATTERY_TIMEOUT_S), instant.vehicle.armed
        if info is not None and (not armed or not self._cells):
            configured = self._flight.battery_cells
            self._cells = self._chemistry.possible_cells(info.voltage, configured, in_flight=armed)
        self._charge = self._charge_reading.update(info, self._cells, instant.now, is_airborne=instant.is_airborne)
        if self._charge.believed is not None or not instant.is_airborne:
            self._known_at = instant.now

    def _update_reserve(self, instant: Instant, wind: Wind | None, ends: tuple[MapPoint, ...]) -> None:
        """Compare the charge with the cost of the flight home. What is not known leaves the reserve of before."""
        charge, pose, now = self._charge.believed, instant.fresh_pose, instant.now
        if not instant.vehicle.armed:
            self._drain.reset()  # the next flight may begin with another battery
        if not instant.is_airborne:
            self._reserve = None
            self._reached.update(False, now)
        elif charge is not None and ends and pose is not None and pose.map is not None:
            self._drain.update(charge, now)
            here = pose.map.point
            path = self._home_path.look(instant.fence, here, max(ends, key=here.distance), now)
            speed = mean_speed(path, self._flight.speed_m_s, wind)
            top = instant.heights.maximum
            self._reserve = self._drain.reserve(charge, length(path), pose.map.height, top, speed)
            self._reached.update(self._reserve.is_reached, now)

    def _sighting(self, instant: Instant) -> Sighting:
        topics = self._topics
        return Sighting(
            now=instant.now,
            utc=instant.utc,
            armed=instant.vehicle.armed,
            airborne=instant.is_airborne,
            exploring=topics.curr_state_pub.value is StateName.AUTONOMOUS_EXPLORE,
            charge=self._charge.believed,
            reserve=self._reserve,
            drain=self._drain.measured,
            plan=topics.get_path_plan(),
            lot_area=topics.get_occupancy_map().lot_area_m2,
            heights=instant.heights,
            tour_m=topics.get_lots_ahead().tour_m,
            outline_area=self._grounds.outline_area(instant),
            fence_area=lambda: self._grounds.fence_area(instant),
        )
