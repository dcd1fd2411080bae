"""The battery: true charge and voltage, and what the autopilot's sensors make of them, which may disagree."""

from __future__ import annotations

from typing import Final

CAPACITY_MAH: Final = 5000.0
CELLS: Final = 3
EMPTY_V, FULL_V = 9.9, 12.6
"""Three lithium-polymer cells at rest, as ArduPilot's own simulation."""
RESISTANCE_OHM: Final = 0.012
IDLE_A: Final = 0.6


class Battery:
    """Lasts ``minutes`` in hover from full.

    `charge` (0..1) is true and makes the voltage; `remaining` (0..1) is what the autopilot counts. Setting `remaining`
    sets both, as a battery does whose charge is known.
    """

    def __init__(self, minutes: float, cells: int = CELLS) -> None:
        self.charge = 1.0
        self.cells = cells
        self.current = IDLE_A
        """Amperes, as measured."""
        self.resistance = RESISTANCE_OHM
        """Ohms of the whole battery; a cold or an old one has several times as much."""
        self.rest_v: float | None = None
        """Volts at rest whatever the charge; None: by the charge."""
        self.error_v = 0.0
        """The voltage sensor reads too high by this, volts."""
        self.counts = True
        """False: the counter stands still."""
        self._counted = 1.0
        self._hover_a = CAPACITY_MAH / 1000.0 * 60.0 / minutes

    def step(self, lifting: bool, effort: float, dt: float) -> None:
        """Use charge for ``dt`` seconds. ``effort`` is thrust over weight."""
        self.current = IDLE_A + (self._hover_a * effort**1.5 if lifting else 0.0)
        used = self.current * dt / 3600.0 / (CAPACITY_MAH / 1000.0)
        self.charge = max(0.0, self.charge - used)
        if self.counts:
            self._counted = max(0.0, self._counted - used)

    def restart_counter(self) -> None:
        """Count from full, as ArduPilot does after every boot."""
        self._counted = 1.0

    @property
    def remaining(self) -> float:
        """Charge left by the autopilot's counter, 0..1."""
        return self._counted

    @remaining.setter
    def remaining(self, share: float) -> None:
        self.charge = self._counted = share

    @property
    def voltage(self) -> float:
        """Volts under the present load, as measured."""
        at_rest = self.rest_v
        if at_rest is None:
            at_rest = (EMPTY_V + (FULL_V - EMPTY_V) * self.charge) * (self.cells / CELLS)
        return max(0.0, at_rest - self.resistance * self.current + self.error_v)

    @property
    def used_mah(self) -> float:
        """Charge taken out by the autopilot's counter, milliampere-hours."""
        return (1.0 - self._counted) * CAPACITY_MAH

    @property
    def is_empty(self) -> bool:
        """True when nothing is left: the motors stop."""
        return self.charge <= 0.0
