"""Thresholds of the autopilot's battery failsafe, judged against the battery's cells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hawk.ddc.battery.chemistry import LIPO, Chemistry
from hawk.model.sentences import say

THRESHOLD_NAMES = ("BATT_LOW_VOLT", "BATT_LOW_MAH", "BATT_LOW_TIMER", "BATT_CAPACITY")
"""Volts (0: off), milliampere-hours left (0: off), seconds below the voltage (0: never), milliampere-hours when full.

Source: ArduPilot, AP_BattMonitor_Params.cpp, Copter 4.5 to 4.7.
"""
LOW_SHARE = 0.6
"""The largest BATT_LOW_MAH as a share of the capacity; ArduPilot's documentation recommends 0.2."""
LOW_TIMER_S = (1.0, 30.0)
"""ArduPilot's default is 10 s."""


@dataclass(frozen=True, slots=True)
class Problem:
    """A threshold that is wrong: what was found, and what to do."""

    value: str
    remedy: str


def threshold_problem(
    values: Mapping[str, float], cells: tuple[int, ...], chemistry: Chemistry = LIPO
) -> Problem | None:
    """Return what is wrong; None when the voltage triggers in time, and neither voltage nor charge triggers at once.

    A charge alone is not enough: it is the counter's, which begins at 100 % with any battery.

    Args:
        values: Each of `THRESHOLD_NAMES` -> its value.
        cells: The cell counts that the battery may have; the thresholds must fit each of them.
        chemistry: The kind of its cells.
    """
    volts, charge, timer, capacity = (values[name] for name in THRESHOLD_NAMES)
    if volts <= 0:
        remedy = _voltage_remedy(cells, chemistry)
        if charge <= 0:
            return Problem(say("off: BATT_LOW_VOLT and BATT_LOW_MAH are 0"), remedy)
        return Problem(say("no voltage: BATT_LOW_VOLT is 0, and BATT_LOW_MAH believes the counter"), remedy)
    if charge > 0 and _charge_share(charge, capacity) > LOW_SHARE:
        value = say(
            "BATT_LOW_MAH is {charge:g} of BATT_CAPACITY {capacity:g}: it would return at once",
            charge=charge,
            capacity=capacity,
        )
        return Problem(value, say("Set BATT_LOW_MAH to {fifth:.0f}, a fifth of the battery.", fifth=0.2 * capacity))
    return _voltage_problem(volts, timer, cells, chemistry)


def threshold_words(values: Mapping[str, float], cells: tuple[int, ...]) -> str:
    """Return thresholds that are right, in words."""
    volts, charge, timer, _ = (values[name] for name in THRESHOLD_NAMES)
    by_voltage = say("below {volts:g} V for {timer:g} s", volts=volts, timer=timer)
    if len(cells) == 1:
        each = volts / cells[0]
        by_voltage = say("below {volts:g} V ({each:.2f} V a cell) for {timer:g} s", volts=volts, each=each, timer=timer)
    return say("{time} or below {charge:g} mAh", time=by_voltage, charge=charge) if charge > 0 else by_voltage


def _charge_share(charge: float, capacity: float) -> float:
    return charge / capacity if capacity > 0 else 0.0


def _voltage_problem(volts: float, timer: float, cells: tuple[int, ...], chemistry: Chemistry) -> Problem | None:
    low, high = chemistry.low
    if not LOW_TIMER_S[0] <= timer <= LOW_TIMER_S[1]:
        return Problem(
            say(
                "BATT_LOW_TIMER is {timer:g} s, must be {low:g} to {high:g} s",
                timer=timer,
                low=LOW_TIMER_S[0],
                high=LOW_TIMER_S[1],
            ),
            say("Set BATT_LOW_TIMER to 10 s in the autopilot."),
        )
    if not cells:
        return Problem(say("the battery's cells are not known"), say("Set flight.battery_cells in the settings."))
    for count in cells:
        if not low <= volts / count <= high:
            sure = len(cells) == 1
            each = volts / count
            value = say(
                "BATT_LOW_VOLT {volts:g} V is {each:.2f} V a cell of {count}", volts=volts, each=each, count=count
            )
            remedy = say("Set flight.battery_cells in the settings.")
            return Problem(value, _voltage_remedy(cells, chemistry) if sure else remedy)
    return None


def _voltage_remedy(cells: tuple[int, ...], chemistry: Chemistry) -> str:
    usual = chemistry.low_usual
    if len(cells) != 1:
        return say("Set BATT_LOW_VOLT in the autopilot to {usual:g} V for each cell of the battery.", usual=usual)
    return say(
        "Set BATT_LOW_VOLT in the autopilot to {whole:.1f} V, {usual:g} V for each of {cells} cells.",
        whole=usual * cells[0],
        usual=usual,
        cells=cells[0],
    )
