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
SEED = 3
"""A lot whose stalls are in sight from above the start."""


async def run_faults(
    faults: Sequence[Fault], folder: Path, speed: float, say: Callable[[Outcome], None]
) -> list[Outcome]:
    """Run them in this order; return their outcomes.

    Args:
        faults: What is to be run.
        folder: For logs, journals and recordings; it is emptied where all ended as they must.
        speed: The drone's seconds per real second.
        say: Called with each outcome.
    """
    outcomes: list[Outcome] = []
    rig: Rig | None = None
    for number, fault in enumerate(faults):
        outcome, rig = await _run(fault, rig, folder / f"{number:02d}", speed)
        outcomes.append(outcome)
        say(outcome)
        if rig is not None and (fault.anew or not outcome.passed or number == len(faults) - 1):
            await rig.stop()
            rig = None
            if outcome.passed:
                shutil.rmtree(folder / f"{number:02d}", ignore_errors=True)
    return outcomes


async def _run(fault: Fault, rig: Rig | None, folder: Path, speed: float) -> tuple[Outcome, Rig | None]:
    if rig is None:
        rig = Rig(folder, SimulationOptions(seed=SEED, speed=speed))
        try:
            await rig.start()
        except StackError as error:
            await rig.stop()
            return Outcome(fault, problems=(str(error),)), None
    return await rig.run(fault), rig
