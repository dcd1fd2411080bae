"""Chemistry of a battery's cells: their limits under load, and the charge by the voltage at rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

ChemistryName = Literal["lipo", "lihv", "liion"]

PACKS = (2, 3, 4, 5, 6, 8, 10, 12, 14)
"""Cells in series of the batteries that drones use."""
REST_TOLERANCE_V = 0.1
"""Error of a voltage at rest, volts a cell: a power module is calibrated to some percent, and a battery
that was used a minute ago has not settled."""
SAG_V = 0.35
"""A sound cell sags by less than this in flight, volts. ArduPilot's default of 3.5 V for a cell under load is a cell of
3.75 V at rest, a quarter charged, with a sag of .25 V."""
LEAST_CELL_V = 2.0
"""A cell that shows less does not carry a drone: the reading is wrong, volts."""

SAGGING_V = 0.4
"""A cell in flight is looked for so far below the limit under which the drone lands, volts."""


@dataclass(frozen=True, slots=True)
class Chemistry:
    """The cells of one kind of battery; voltages in volts a cell.

    ``at_rest``: voltage and charge (percent) of a rested cell, rising, as pack makers print them; between them the
    charge is linear. Cells of one kind differ by some points, so that a verdict takes REST_TOLERANCE_V off.
    """

    name: str
    return_v: float
    """Under load: less ends the task, and the drone returns."""
    land_v: float
    """Under load: with less it lands."""
    resting: tuple[float, float]
    """A cell at rest, from nearly empty to just charged: cells are counted by it."""
    flying_v: float
    """The same cell nearly empty in flight."""
    low: tuple[float, float]
    """Bounds of the autopilot's low voltage."""
    low_usual: float
    """The low voltage to set where it is wrong."""
    at_rest: tuple[tuple[float, float], ...]

    def charge(self, volts: float) -> float:
        """Return the charge of a rested cell of this voltage, percent."""
        if volts <= self.at_rest[0][0]:
            return self.at_rest[0][1]
        for (low, below), (high, above) in pairwise(self.at_rest):
            if volts <= high:
                return below + (above - below) * (volts - low) / (high - low)
        return self.at_rest[-1][1]

    def possible_cells(self, voltage: float | None, configured: int | None, *, in_flight: bool) -> tuple[int, ...]:
        """Return the cell counts that a battery of this voltage (V) may have.

        A configured count is the only one. Without a fitting count the result is empty. In flight a battery that sags
        below its limits is counted, too, where only one count fits.
        """
        if configured is not None:
            return (configured,)
        if voltage is None:
            return ()
        fitting = self._fitting(voltage, self.flying_v if in_flight else self.resting[0])
        sagging = self._fitting(voltage, self.land_v - SAGGING_V) if in_flight and not fitting else ()
        return sagging if len(sagging) == 1 else fitting

    def _fitting(self, voltage: float, least: float) -> tuple[int, ...]:
        return tuple(count for count in PACKS if least * count <= voltage <= self.resting[1] * count)


LIPO = Chemistry(
    "lithium-polymer",
    return_v=3.3,
    land_v=3.2,
    resting=(3.5, 4.25),
    flying_v=3.3,
    low=(3.3, 3.9),
    low_usual=3.5,
    at_rest=(
        (3.27, 0.0),
        (3.61, 5.0),
        (3.69, 10.0),
        (3.71, 15.0),
        (3.73, 20.0),
        (3.75, 25.0),
        (3.77, 30.0),
        (3.79, 35.0),
        (3.80, 40.0),
        (3.82, 45.0),
        (3.84, 50.0),
        (3.85, 55.0),
        (3.87, 60.0),
        (3.91, 65.0),
        (3.95, 70.0),
        (3.98, 75.0),
        (4.02, 80.0),
        (4.08, 85.0),
        (4.11, 90.0),
        (4.15, 95.0),
        (4.20, 100.0),
    ),
)
"""Below 3.3 V under load the voltage collapses within a minute; above 3.9 V a charged battery is "low" in flight.
ArduPilot's default low voltage is 10.5 V for three cells, 3.5 V each."""
LIHV = Chemistry(
    "high-voltage lithium-polymer",
    return_v=3.4,
    land_v=3.3,
    resting=(3.55, 4.40),
    flying_v=3.4,
    low=(3.4, 4.0),
    low_usual=3.6,
    at_rest=(
        (3.30, 0.0),
        (3.65, 5.0),
        (3.72, 10.0),
        (3.77, 20.0),
        (3.81, 30.0),
        (3.85, 40.0),
        (3.89, 50.0),
        (3.94, 60.0),
        (4.02, 70.0),
        (4.11, 80.0),
        (4.21, 90.0),
        (4.35, 100.0),
    ),
)
"""Charged to 4.35 V."""
LIION = Chemistry(
    "lithium-ion",
    return_v=3.0,
    land_v=2.8,
    resting=(3.2, 4.25),
    flying_v=2.9,
    low=(2.9, 3.7),
    low_usual=3.2,
    at_rest=(
        (2.80, 0.0),
        (3.20, 5.0),
        (3.35, 10.0),
        (3.48, 20.0),
        (3.57, 30.0),
        (3.65, 40.0),
        (3.73, 50.0),
        (3.82, 60.0),
        (3.91, 70.0),
        (3.99, 80.0),
        (4.07, 90.0),
        (4.20, 100.0),
    ),
)
"""Cells of 18650 and 21700 with nickel, cobalt and manganese or aluminium; their makers allow 2.5 V."""

CHEMISTRIES: Mapping[ChemistryName, Chemistry] = {"lipo": LIPO, "lihv": LIHV, "liion": LIION}
