"""Options of a simulated autopilot and its link."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from hawk.sim.autopilot.battery import CELLS
from hawk.sim.geometry import Flat, Slope


class Other(StrEnum):
    """Kinds of other MAVLink systems and components on the vehicle's link."""

    TRACKER = "tracker"
    GIMBAL = "gimbal"
    COPTER = "copter"
    STATION = "station"


@dataclass(frozen=True, slots=True)
class AutopilotOptions:
    """Start (north, east; metres in the world), slow GNSS error (m), wind (m/s), minutes of hover.

    ``gnss_wait_s`` passes from boot to a good position. ``gcs_parameter`` "old" or "new" is the name of the parameter
    with the ground station's id. ``real_time_factor`` is simulated seconds per real second. ``slope`` is the ground.
    ``battery_cells`` changes no parameter: ArduPilot does not know it. ``gnss_bias`` is the receiver's constant error
    (north, east; metres). ``rangefinder_m`` is the reach of a rangefinder that looks down; 0: none, as on ArduCopter.
    """

    start: Flat = (0.0, 0.0)
    yaw: float = 0.0
    gnss_sigma: float = 0.5
    gnss_wait_s: float = 5.0
    gnss_bias: Flat = (0.0, 0.0)
    wind: float = 0.0
    wind_heading: float = 0.0
    battery_minutes: float = 20.0
    battery_cells: int = CELLS
    gcs_parameter: str = "old"
    real_time_factor: float = 1.0
    slope: Slope = field(default_factory=Slope)
    rangefinder_m: float = 0.0
