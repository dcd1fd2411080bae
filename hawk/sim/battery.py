"""The battery: charge by current, voltage by charge and load."""

from __future__ import annotations

CAPACITY_MAH = 5000.0
EMPTY_V, FULL_V = 9.9, 12.6
"""Three lithium-polymer cells at rest, as ArduPilot's own simulation."""
RESISTANCE_OHM = 0.012
IDLE_A = 0.6


class Battery:
    """Lasts ``minutes`` in hover from full. ``remaining`` (0..1) may be set."""

    def __init__(self, minutes: float) -> None:
        self.remaining = 1.0
        self.current = IDLE_A
        self._hover_a = CAPACITY_MAH / 1000.0 * 60.0 / minutes

    def step(self, lifting: bool, effort: float, dt: float) -> None:
        """Use charge for ``dt`` seconds. ``effort`` is thrust over weight."""
        self.current = IDLE_A + (self._hover_a * effort**1.5 if lifting else 0.0)
        self.remaining = max(0.0, self.remaining - self.current * dt / 3600.0 / (CAPACITY_MAH / 1000.0))

    @property
    def voltage(self) -> float:
        """Volts under the present load."""
        return EMPTY_V + (FULL_V - EMPTY_V) * self.remaining - RESISTANCE_OHM * self.current

    @property
    def used_mah(self) -> float:
        """Charge taken out, milliampere-hours."""
        return (1.0 - self.remaining) * CAPACITY_MAH

    @property
    def is_empty(self) -> bool:
        """Whether the motors have nothing left to turn on."""
        return self.remaining <= 0.0
