"""Thresholds of the autopilot's battery failsafe, judged against the battery's cells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

THRESHOLD_NAMES = ("BATT_LOW_VOLT", "BATT_LOW_MAH", "BATT_LOW_TIMER", "BATT_CAPACITY")
"""Volts (0: off), milliampere-hours left (0: off), seconds below the voltage (0: never), milliampere-hours when full.

Source: ArduPilot, AP_BattMonitor_Params.cpp, Copter 4.5 to 4.7.
"""
LOW_V_A_CELL = (3.3, 3.9)
"""The low voltage of a lithium-polymer cell under load. ArduPilot's default is 10.5 V for three cells, 3.5 V each.

Below 3.3 V the voltage collapses within a minute; above 3.9 V a charged battery is "low" in flight.
"""
LOW_SHARE = (0.1, 0.6)
"""BATT_LOW_MAH as a share of the capacity; ArduPilot's documentation recommends 0.2."""
LOW_TIMER_S = (1.0, 30.0)
"""ArduPilot's default is 10 s."""
PACKS = (2, 3, 4, 5, 6, 8, 10, 12, 14)
"""Cells in series of the batteries that drones use."""
CELL_V = (3.5, 4.25)
"""A lithium-polymer cell at rest, from nearly empty to just charged."""
FLYING_CELL_V = 3.3
"""The same cell nearly empty in flight: its voltage sags under load."""


@dataclass(frozen=True, slots=True)
class Problem:
    """A threshold that is wrong: what was found, and what to do."""

    value: str
    remedy: str


def possible_cells(voltage: float | None, configured: int | None, in_flight: bool = False) -> tuple[int, ...]:
    """Return the cell counts that a battery of this voltage (V) may have.

    A configured count is the only one. Without a fitting count the result is empty.
    """
    if configured is not None:
        return (configured,)
    if voltage is None:
        return ()
    low, high = FLYING_CELL_V if in_flight else CELL_V[0], CELL_V[1]
    return tuple(count for count in PACKS if low * count <= voltage <= high * count)


def threshold_problem(values: Mapping[str, float], cells: tuple[int, ...]) -> Problem | None:
    """Return what is wrong; None when voltage or charge triggers in time and neither triggers at once.

    Args:
        values: Each of `THRESHOLD_NAMES` -> its value.
        cells: The cell counts that the battery may have; the thresholds must fit each of them.
    """
    volts, charge, timer, capacity = (values[name] for name in THRESHOLD_NAMES)
    if volts <= 0 and charge <= 0:
        return Problem("off: BATT_LOW_VOLT and BATT_LOW_MAH are 0", _voltage_remedy(cells))
    share = _charge_share(charge, capacity)
    if charge > 0 and share > LOW_SHARE[1]:
        value = f"BATT_LOW_MAH is {charge:g} of BATT_CAPACITY {capacity:g}: it would return at once"
        return Problem(value, f"Set BATT_LOW_MAH to {0.2 * capacity:.0f}, a fifth of the battery.")
    by_voltage = _voltage_problem(volts, timer, cells) if volts > 0 else None
    too_high = by_voltage is not None and any(volts / count > LOW_V_A_CELL[1] for count in cells)
    if too_high or (share < LOW_SHARE[0] and by_voltage is not None):
        return by_voltage
    if volts <= 0 and share < LOW_SHARE[0]:
        value = f"BATT_LOW_MAH is {charge:g} of BATT_CAPACITY {capacity:g}: too late"
        return Problem(value, f"Set BATT_LOW_MAH to {0.2 * capacity:.0f}, a fifth of the battery.")
    return None


def threshold_words(values: Mapping[str, float], cells: tuple[int, ...]) -> str:
    """Return thresholds that are right, in words."""
    volts, charge, timer, _ = (values[name] for name in THRESHOLD_NAMES)
    parts = []
    if volts > 0 and timer > 0:
        each = f" ({volts / cells[0]:.2f} V a cell)" if len(cells) == 1 else ""
        parts.append(f"below {volts:g} V{each} for {timer:g} s")
    if charge > 0:
        parts.append(f"below {charge:g} mAh")
    return " or ".join(parts)


def _charge_share(charge: float, capacity: float) -> float:
    return charge / capacity if capacity > 0 else 0.0


def _voltage_problem(volts: float, timer: float, cells: tuple[int, ...]) -> Problem | None:
    low, high = LOW_V_A_CELL
    if not LOW_TIMER_S[0] <= timer <= LOW_TIMER_S[1]:
        return Problem(
            f"BATT_LOW_TIMER is {timer:g} s, must be {LOW_TIMER_S[0]:g} to {LOW_TIMER_S[1]:g} s",
            "Set BATT_LOW_TIMER to 10 s in the autopilot.",
        )
    if not cells:
        return Problem("the battery's cells are not known", "Set flight.battery_cells in the settings.")
    for count in cells:
        if not low <= volts / count <= high:
            sure = len(cells) == 1
            value = f"BATT_LOW_VOLT {volts:g} V is {volts / count:.2f} V a cell of {count}"
            return Problem(value, _voltage_remedy(cells) if sure else "Set flight.battery_cells in the settings.")
    return None


def _voltage_remedy(cells: tuple[int, ...]) -> str:
    if len(cells) != 1:
        return "Set BATT_LOW_VOLT in the autopilot to 3.5 V for each cell of the battery."
    return f"Set BATT_LOW_VOLT in the autopilot to {3.5 * cells[0]:.1f} V, 3.5 V for each of {cells[0]} cells."
