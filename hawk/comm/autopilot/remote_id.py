"""Remote ID (ASTM F3411, ASD-STAN EN 4709-002) over MAVLink: what a ground station sends, and what it hears.

ArduPilot (AP_OpenDroneID) keeps what it is sent and passes it to a transmitter, with the drone's position of its own.
The transmitter answers once a second with OPEN_DRONE_ID_ARM_STATUS. Texts, units and unknown values are those of
MAVLink common.xml.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from hawk.comm.topic import Topic
from hawk.config.sections import RemoteIdSettings
from hawk.model.poses import GlobalPose
from hawk.runtime.repeated_log import plain

Fields = Mapping[str, Any]
NamedMessage = tuple[str, Fields]
"""Name and fields of a message."""

TRANSMITTERS: Final = frozenset({236, 237, 238})
"""MAV_COMP_ID_ODID_TXRX_1 to 3."""
ARM_STATUS: Final = "OPEN_DRONE_ID_ARM_STATUS"

EPOCH: Final = 1_546_300_800.0
"""Zero of Remote ID's time stamps: 2019-01-01 00:00 UTC, Unix seconds."""
_UNKNOWN_HEIGHT: Final = -1000.0
_GOOD_TO_ARM: Final = 0  # MAV_ODID_ARM_STATUS_GOOD_TO_ARM
_OPERATOR_ID_OF_AN_AUTHORITY: Final = 0  # MAV_ODID_OPERATOR_ID_TYPE_CAA
_TEXT: Final = 0  # MAV_ODID_DESC_TYPE_TEXT
_SERIAL_NUMBER: Final = 1  # MAV_ODID_ID_TYPE_SERIAL_NUMBER
_MULTIROTOR: Final = 2  # MAV_ODID_UA_TYPE_HELICOPTER_OR_MULTIROTOR
_PLACE_TYPE: Final = {"takeoff": 0, "fixed": 2}  # MAV_ODID_OPERATOR_LOCATION_TYPE
_UNDECLARED: Final = 0  # of classification type, category and class
_OURS: Final = [0] * 20
"""``id_or_mac``: only used for what is heard of other drones."""


@dataclass(frozen=True, slots=True)
class RemoteIdReport:
    """The transmitter's last word: ``good`` to arm, else ``error`` in its own words.

    ``time``: when it came, seconds of the daemon's clock. ``geoid_m``: height of mean sea level above the WGS-84
    ellipsoid here, metres; None while the receiver does not say.
    """

    good: bool | None = None
    error: str = ""
    time: float = -math.inf
    geoid_m: float | None = None


class RemoteIdReports:
    """Publishes the newest OPEN_DRONE_ID_ARM_STATUS."""

    def __init__(self, topic: Topic[RemoteIdReport]) -> None:
        self._topic = topic
        self._now = RemoteIdReport()

    def take_arm_status(self, fields: Fields, arrival: float) -> None:
        """Take the transmitter's word. Raises KeyError, TypeError or ValueError when it cannot be read."""
        good = int(fields["status"]) == _GOOD_TO_ARM
        error = plain(str(fields.get("error") or "").rstrip("\0").strip())
        self._publish(replace(self._now, good=good, error=error, time=arrival))

    def take_gps(self, fields: Fields) -> None:
        """Take both heights of a GPS_RAW_INT, millimetres; zero is "not given" in its extension."""
        ellipsoid, sea_level = (int(fields.get(name) or 0) for name in ("alt_ellipsoid", "alt"))
        if ellipsoid and sea_level:
            geoid = (ellipsoid - sea_level) / 1000.0
            if geoid != self._now.geoid_m:
                self._publish(replace(self._now, geoid_m=geoid))

    def forget(self) -> None:
        """Drop the word of before a boot."""
        self._publish(RemoteIdReport())

    def _publish(self, now: RemoteIdReport) -> None:
        self._now = now
        self._topic.publish(now)


@dataclass(frozen=True, slots=True)
class OperatorPlace:
    """WGS-84 degrees, and metres above the ellipsoid; None: not known."""

    latitude: float
    longitude: float
    height: float | None

    @property
    def is_sendable(self) -> bool:
        """True for finite numbers in their bounds. 0, 0 is Remote ID's word for "not known"."""
        height = 0.0 if self.height is None else self.height
        if not all(map(math.isfinite, (self.latitude, self.longitude, height))):
            return False
        return abs(self.latitude) <= 90.0 and abs(self.longitude) <= 180.0 and (self.latitude, self.longitude) != (0, 0)


def takeoff_place(place: GlobalPose, geoid_m: float | None) -> OperatorPlace:
    """Return the operator's place for a place of the drone (metres above sea level)."""
    return OperatorPlace(place.latitude, place.longitude, None if geoid_m is None else place.altitude + geoid_m)


def fixed_place(settings: RemoteIdSettings) -> OperatorPlace | None:
    """Return the configured place; None when the take-off's is configured."""
    latitude, longitude = settings.operator_latitude_deg, settings.operator_longitude_deg
    if settings.operator_place != "fixed" or latitude is None or longitude is None:
        return None
    return OperatorPlace(latitude, longitude, settings.operator_height_m)


def who(settings: RemoteIdSettings) -> tuple[NamedMessage, ...]:
    """Return the messages that never change: operator, and description and serial number where they are configured."""
    operator = {"id_or_mac": _OURS, "operator_id_type": _OPERATOR_ID_OF_AN_AUTHORITY}
    found: list[NamedMessage] = [("OPEN_DRONE_ID_OPERATOR_ID", operator | {"operator_id": settings.operator_id or ""})]
    if settings.description is not None:
        text = {"id_or_mac": _OURS, "description_type": _TEXT, "description": settings.description}
        found.append(("OPEN_DRONE_ID_SELF_ID", text))
    if settings.serial_number is not None:
        number = list(settings.serial_number.encode("ascii").ljust(20, b"\0"))
        basic = {"id_or_mac": _OURS, "id_type": _SERIAL_NUMBER, "ua_type": _MULTIROTOR, "uas_id": number}
        found.append(("OPEN_DRONE_ID_BASIC_ID", basic))
    return tuple(found)


def where(settings: RemoteIdSettings, place: OperatorPlace, utc: float, *, whole: bool) -> NamedMessage:
    """Return the operator's place at ``utc`` (Unix seconds): OPEN_DRONE_ID_SYSTEM, or the short SYSTEM_UPDATE."""
    update = {
        "operator_latitude": round(place.latitude * 1e7),
        "operator_longitude": round(place.longitude * 1e7),
        "operator_altitude_geo": _UNKNOWN_HEIGHT if place.height is None else place.height,
        "timestamp": max(0, int(utc - EPOCH)),
    }
    if not whole:
        return "OPEN_DRONE_ID_SYSTEM_UPDATE", update
    return "OPEN_DRONE_ID_SYSTEM", {
        **update,
        "id_or_mac": _OURS,
        "operator_location_type": _PLACE_TYPE[settings.operator_place],
        "classification_type": _UNDECLARED,
        "area_count": 1,  # one drone, at its own place
        "area_radius": 0,
        "area_ceiling": _UNKNOWN_HEIGHT,
        "area_floor": _UNKNOWN_HEIGHT,
        "category_eu": _UNDECLARED,
        "class_eu": _UNDECLARED,
    }
