"""Runs faults one after the other: in one flight as long as that goes well, with new programs otherwise."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

from faults.fault import Fault, Outcome
from faults.rig import Rig
from faults.table_drone import DRONE
from faults.table_link import LINK
from faults.table_programs import PROGRAMS
from hawk.simulation import SimulationOptions
from hawk.survey.stack import StackError

ALL: tuple[Fault, ...] = (*LINK, *DRONE, *PROGRAMS)
SEED, START = 3, "56,49"
"""A lot of 130 stalls, and a place amid them (x, y; metres), so that it is in sight after take-off."""
SHORT = (
    "on the ground: the link is cut in both directions",
    "hovering: the link is cut for a second",
    "hovering: one HEARTBEAT comes 1.2 s late",
    "hovering: the operator is gone and comes back",
    "hovering: the link is cut in both directions",
)
"""Faults of one flight of a minute, for `make test`; they need no lot."""


async def run_faults(
    faults: Sequence[Fault], folder: Path, options: SimulationOptions, say: Callable[[Outcome], None]
) -> list[Outcome]:
    """Run them in this order; return their outcomes.

    Args:
        faults: What is to be run.
        folder: For logs, journals and recordings; it is emptied where all ended as they must.
        options: The simulated drone and its world.
        say: Called with each outcome.
    """
    outcomes: list[Outcome] = []
    rig: Rig | None = None
    for number, fault in enumerate(faults):
        outcome, rig = await _run(fault, rig, folder / f"{number:02d}", options)
        outcomes.append(outcome)
        say(outcome)
        if rig is not None and (fault.ends_flight or not outcome.passed or number == len(faults) - 1):
            await rig.stop()
            rig = None
            if outcome.passed:
                shutil.rmtree(folder / f"{number:02d}", ignore_errors=True)
    return outcomes


async def _run(fault: Fault, rig: Rig | None, folder: Path, options: SimulationOptions) -> tuple[Outcome, Rig | None]:
    if rig is None:
        rig = Rig(folder, options)
        try:
            await rig.start()
        except StackError as error:
            await rig.stop()
            return Outcome(fault, problems=(str(error),)), None
    return await rig.run(fault), rig
