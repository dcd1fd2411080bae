"""The autopilot's own failsafes: what is left when this computer dies. Which parameters must say what."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

WATCHED_ID_NAMES = ("MAV_GCS_SYSID", "SYSID_MYGCS")
"""The parameter with the id that the ground-station failsafe watches: since ArduPilot 4.7, and before."""
SPARE_PILOT_BIT = 16
"""FS_OPTIONS bit 4: continue in pilot-controlled modes on ground-station failsafe."""
RETURN_ALTITUDE_NAMES = ("RTL_ALT_M", "RTL_ALT")
"""Metres since ArduPilot 4.7, centimetres before."""
_GCS_ACTIONS = frozenset({1, 3, 4, 5, 6, 7})  # FS_GCS_ENABLE: all but 0 (off) and 2 (goes on in Auto)

Values = Mapping[str, float | None]
"""Parameter -> value; None: the autopilot does not have it. A parameter that was not read yet is missing."""


@dataclass(frozen=True, slots=True)
class FailsafeCheck:
    """One failsafe: whether it is well, what was found, and what follows if it is not."""

    name: str
    passed: bool
    value: str
    consequence: str


def watched_names(values: Values) -> tuple[str, ...]:
    """Return the parameters that must be read, given what was read so far."""
    alternatives = [_present_name(names, values) for names in (WATCHED_ID_NAMES, RETURN_ALTITUDE_NAMES)]
    return ("FS_GCS_ENABLE", "FS_OPTIONS", "FENCE_ENABLE", "FENCE_ACTION", "BATT_FS_LOW_ACT", *alternatives)


def check_failsafes(values: Values, system_id: int) -> tuple[FailsafeCheck, ...]:
    """Return the check of every failsafe; what was not read yet has not passed."""
    return (_ground_station(values, system_id), _spares_pilot(values), _fence(values), _battery(values))


def wanted_values(values: Values, system_id: int) -> dict[str, float]:
    """Return what must be set so that all checks pass: parameter -> value, the present ones left out."""
    wanted: dict[str, float] = {}
    if values.get("FS_GCS_ENABLE") not in _GCS_ACTIONS:
        wanted["FS_GCS_ENABLE"] = 1.0
    watched = _present_name(WATCHED_ID_NAMES, values)
    if values.get(watched) != system_id:
        wanted[watched] = float(system_id)
    options = int(values.get("FS_OPTIONS") or 0)
    if not options & SPARE_PILOT_BIT:
        wanted["FS_OPTIONS"] = float(options | SPARE_PILOT_BIT)
    if not values.get("FENCE_ACTION"):
        wanted["FENCE_ACTION"] = 1.0
    if not values.get("FENCE_ENABLE"):
        wanted["FENCE_ENABLE"] = 1.0
    if not values.get("BATT_FS_LOW_ACT"):
        wanted["BATT_FS_LOW_ACT"] = 2.0
    return wanted


def return_altitude(values: Values) -> float | None:
    """Return the autopilot's return altitude in metres, None while it was not read."""
    in_metres, in_centimetres = RETURN_ALTITUDE_NAMES
    found = values.get(in_metres)
    if found is not None:
        return found
    centimetres = values.get(in_centimetres)
    return None if centimetres is None else centimetres / 100.0


def _present_name(names: tuple[str, str], values: Values) -> str:
    """Return the newer name unless the autopilot said that it does not have it."""
    newer, older = names
    return older if newer in values and values[newer] is None else newer


def _ground_station(values: Values, system_id: int) -> FailsafeCheck:
    consequence = "If this computer stops in flight, the drone stays in the air until the battery is empty."
    watched = _present_name(WATCHED_ID_NAMES, values)
    enabled, watches = values.get("FS_GCS_ENABLE"), values.get(watched)
    if enabled is None or watches is None:
        return FailsafeCheck("Ground-station failsafe", False, "not read yet", consequence)
    if enabled not in _GCS_ACTIONS:
        return FailsafeCheck("Ground-station failsafe", False, "off", consequence)
    if watches != system_id:
        found = f"watches station {watches:.0f}, this is {system_id}"
        return FailsafeCheck("Ground-station failsafe", False, found, consequence)
    return FailsafeCheck("Ground-station failsafe", True, f"on, watches this station ({system_id})", "")


def _spares_pilot(values: Values) -> FailsafeCheck:
    options = values.get("FS_OPTIONS")
    consequence = "If this computer stops while a pilot flies, the drone is taken from the pilot's hands."
    if options is None:
        return FailsafeCheck("Pilot keeps control", False, "not read yet", consequence)
    spared = bool(int(options) & SPARE_PILOT_BIT)
    return FailsafeCheck("Pilot keeps control", spared, "yes" if spared else "no", "" if spared else consequence)


def _fence(values: Values) -> FailsafeCheck:
    consequence = "If the drone leaves the fence, the autopilot does nothing about it."
    enabled, action = values.get("FENCE_ENABLE"), values.get("FENCE_ACTION")
    if enabled is None or action is None:
        return FailsafeCheck("Fence in the autopilot", False, "not read yet", consequence)
    if not enabled or not action:
        return FailsafeCheck("Fence in the autopilot", False, "off" if not enabled else "only reports", consequence)
    return FailsafeCheck("Fence in the autopilot", True, "on", "")


def _battery(values: Values) -> FailsafeCheck:
    action = values.get("BATT_FS_LOW_ACT")
    consequence = "With an empty battery the drone falls."
    if action is None:
        return FailsafeCheck("Battery failsafe", False, "not read yet", consequence)
    if not action:
        return FailsafeCheck("Battery failsafe", False, "off", consequence)
    return FailsafeCheck("Battery failsafe", True, "lands" if action == 1 else "returns home", "")
