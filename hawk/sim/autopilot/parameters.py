"""ArduPilot's parameters: typed, with ArduCopter's defaults; and the options of a simulated autopilot."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from enum import IntEnum, StrEnum
from typing import Final

from hawk.sim.geometry import Flat, Slope

CELLS: Final = 3


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
    (north, east; metres), ``compass_error`` that of all compasses (radians, clockwise). ``utc_s`` is the moment at the
    start by GNSS, Unix seconds; None: it gives none. ``rangefinder_m`` is the reach of a rangefinder that looks down;
    0: none, as on ArduCopter.
    """

    start: Flat = (0.0, 0.0)
    yaw: float = 0.0
    gnss_sigma: float = 0.5
    gnss_wait_s: float = 5.0
    gnss_bias: Flat = (0.0, 0.0)
    compass_error: float = 0.0
    wind: float = 0.0
    wind_heading: float = 0.0
    battery_minutes: float = 20.0
    battery_cells: int = CELLS
    gcs_parameter: str = "old"
    real_time_factor: float = 1.0
    slope: Slope = field(default_factory=Slope)
    rangefinder_m: float = 0.0
    utc_s: float | None = None


class ParameterType(IntEnum):
    """MAV_PARAM_TYPE of the types that ArduPilot has."""

    INT8 = 2
    INT16 = 4
    INT32 = 6
    REAL32 = 9


_RANGES = {
    ParameterType.INT8: (-128, 127),
    ParameterType.INT16: (-32768, 32767),
    ParameterType.INT32: (-(2**31), 2**31 - 1),
}


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter."""

    name: str
    type: ParameterType
    value: float


class Parameters:
    """The vehicle's parameters, in a fixed order. Values are kept in each parameter's own type."""

    def __init__(self, parameters: Iterable[Parameter]) -> None:
        self._parameters = {parameter.name: parameter for parameter in parameters}
        self._order = tuple(self._parameters)

    def __getitem__(self, name: str) -> float:
        """Return a value. Raises KeyError for an unknown name."""
        return self._parameters[name].value

    def __len__(self) -> int:
        """Return the number of parameters."""
        return len(self._order)

    def __contains__(self, name: object) -> bool:
        """Return True when there is a parameter of that name."""
        return name in self._parameters

    def flag(self, name: str) -> int:
        """Return a value as a whole number."""
        return int(self._parameters[name].value)

    def parameter(self, name: str) -> Parameter:
        """Return a parameter. Raises KeyError for an unknown name."""
        return self._parameters[name]

    def at(self, index: int) -> Parameter:
        """Return the parameter at a place in the list. Raises IndexError."""
        if index < 0:
            raise IndexError(index)
        return self._parameters[self._order[index]]

    def index(self, name: str) -> int:
        """Return the place of a parameter in the list. Raises ValueError for an unknown name."""
        return self._order.index(name)

    def values(self, beginnings: tuple[str, ...]) -> dict[str, float]:
        """Return the values of the parameters whose names begin so."""
        return {name: self._parameters[name].value for name in self._order if name.startswith(beginnings)}

    def set(self, name: str, value: float) -> Parameter:
        """Write a value, cut to the parameter's own type; return the parameter.

        Raises KeyError for an unknown name.
        """
        old = self._parameters[name]
        if old.type is not ParameterType.REAL32:
            low, high = _RANGES[old.type]
            value = float(min(max(round(value), low), high))
        self._parameters[name] = replace(old, value=value)
        return self._parameters[name]


def copter_parameters(gcs_name: str = "old") -> Parameters:
    """Return ArduCopter's parameters with their defaults.

    ``gcs_name`` "old" has SYSID_MYGCS (before 4.7), "new" has MAV_GCS_SYSID and MAV_GCS_SYSID_HI.
    """
    gcs = Parameter("SYSID_MYGCS" if gcs_name == "old" else "MAV_GCS_SYSID", ParameterType.INT16, 255)
    own = Parameter("SYSID_THISMAV" if gcs_name == "old" else "MAV_SYSID", ParameterType.INT16, 1)
    highest = [] if gcs_name == "old" else [Parameter("MAV_GCS_SYSID_HI", ParameterType.INT16, 0)]
    rest = [Parameter(name, kind, value) for kind, table in _DEFAULTS.items() for name, value in table.items()]
    return Parameters(sorted([gcs, own, *highest, *rest], key=lambda parameter: parameter.name))


_DEFAULTS: dict[ParameterType, dict[str, float]] = {
    ParameterType.INT8: {
        "AUTO_OPTIONS": 0,
        "BATT_FS_CRT_ACT": 0,
        "BATT_FS_LOW_ACT": 0,
        "BATT_FS_VOLTSRC": 0,
        "BATT_LOW_TIMER": 10,
        "BATT_MONITOR": 4,
        "COMPASS_USE": 1,
        "DISARM_DELAY": 10,
        "FENCE_ACTION": 1,
        "FENCE_ENABLE": 0,
        "FENCE_TOTAL": 0,
        "FENCE_TYPE": 7,
        "FLTMODE1": 0,
        "FLTMODE2": 0,
        "FLTMODE3": 0,
        "FLTMODE4": 0,
        "FLTMODE5": 0,
        "FLTMODE6": 0,
        "FLTMODE_CH": 5,
        "FRAME_CLASS": 1,
        "FRAME_TYPE": 1,
        "FS_CRASH_CHECK": 1,
        "FS_EKF_ACTION": 1,
        "FS_GCS_ENABLE": 0,
        "FS_THR_ENABLE": 1,
        "FS_VIBE_ENABLE": 1,
        "GPS_TYPE": 1,
        "LAND_REPOSITION": 1,
        "RALLY_INCL_HOME": 1,
        "RALLY_TOTAL": 0,
        "RTL_ALT_TYPE": 0,
        "RNGFND1_ORIENT": 25,
        "RNGFND1_TYPE": 0,
        "WP_YAW_BEHAVIOR": 2,
    },
    ParameterType.INT16: {
        "ANGLE_MAX": 3000,
        "FORMAT_VERSION": 120,
        "FS_THR_VALUE": 975,
        "LAND_ALT_LOW": 1000,
        "LAND_SPEED": 50,
        "LAND_SPEED_HIGH": 0,
        "PILOT_SPEED_DN": 0,
        "PILOT_SPEED_UP": 250,
        "RTL_ALT_FINAL": 0,
        "RTL_CLIMB_MIN": 0,
        "RTL_SPEED": 0,
    },
    ParameterType.INT32: {
        "ARMING_CHECK": 1,
        "BATT_CAPACITY": 5000,
        "FS_OPTIONS": 16,
        "LOG_BITMASK": 176126,
        "RTL_ALT": 1500,
        "RTL_LOIT_TIME": 5000,
        "STAT_BOOTCNT": 1,
    },
    ParameterType.REAL32: {
        "ATC_SLEW_YAW": 6000,
        "BATT_ARM_VOLT": 0,
        "BATT_CRT_MAH": 0,
        "BATT_CRT_VOLT": 0,
        "BATT_LOW_MAH": 0,
        "BATT_LOW_VOLT": 10.5,
        "COMPASS_OFS_X": 5,
        "COMPASS_OFS_Y": 13,
        "COMPASS_OFS_Z": -18,
        "FENCE_ALT_MAX": 100,
        "FENCE_ALT_MIN": -10,
        "FENCE_MARGIN": 2,
        "FENCE_RADIUS": 300,
        "FS_EKF_THRESH": 0.8,
        "FS_GCS_TIMEOUT": 5,
        "GUID_TIMEOUT": 3,
        "INS_ACCOFFS_X": 0.001,
        "INS_ACCOFFS_Y": 0.001,
        "INS_ACCOFFS_Z": 0.001,
        "INS_GYROFFS_X": 0.0001,
        "INS_GYROFFS_Y": 0.0001,
        "INS_GYROFFS_Z": 0.0001,
        "PSC_JERK_XY": 5,
        "PSC_POSXY_P": 1,
        "PSC_VELXY_P": 2,
        "RALLY_LIMIT_KM": 0.3,
        "RNGFND1_MAX": 7,
        "RNGFND1_MIN": 0.2,
        "RTL_CONE_SLOPE": 3,
        "WPNAV_ACCEL": 250,
        "WPNAV_ACCEL_Z": 100,
        "WPNAV_RADIUS": 200,
        "WPNAV_SPEED": 500,
        "WPNAV_SPEED_DN": 150,
        "WPNAV_SPEED_UP": 250,
    },
}
