"""Runs faults one after the other: in one flight as long as that goes well, with new programs otherwise."""

from __future__ import annotations

import contextlib
import os
import shutil
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from hawk.runtime.process import AUTOGROUP, SIMULATOR_NICENESS, set_niceness
from hawk.sim.launch import SimulationOptions
from hawk.survey.stack import StackError
from proving.faults.disk import DiskError
from proving.faults.fault import Fault, Outcome
from proving.faults.rig import Rig
from proving.faults.table_drone import DRONE
from proving.faults.table_link import LINK
from proving.faults.table_others import OTHERS
from proving.faults.table_people import PEOPLE
from proving.faults.table_programs import PROGRAMS
from proving.faults.table_sensors import SENSORS
from proving.faults.vehicle import ArduCopter

ALL: tuple[Fault, ...] = (*LINK, *DRONE, *SENSORS, *OTHERS, *PEOPLE, *PROGRAMS)
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
    faults: Sequence[Fault],
    folder: Path,
    options: SimulationOptions,
    say: Callable[[Outcome], None],
    copter: ArduCopter | None = None,
) -> list[Outcome]:
    """Run them in this order; return their outcomes.

    Args:
        faults: What is to be run.
        folder: For logs, journals and recordings; a flight that ended as it must leaves none.
        options: The simulated drone and its world.
        say: Called with each outcome.
        copter: A real vehicle, in place of the simulated drone.
    """
    with in_time():
        return await _run(faults, folder, options, say, copter)


async def _run(
    faults: Sequence[Fault],
    folder: Path,
    options: SimulationOptions,
    say: Callable[[Outcome], None],
    copter: ArduCopter | None,
) -> list[Outcome]:
    outcomes: list[Outcome] = []
    rig: Rig | None = None
    try:
        for number, fault in enumerate(faults):
            problem = ""
            if rig is not None and fault.own_disk:
                ended, rig = rig, None
                await ended.stop()
                shutil.rmtree(ended.folder, ignore_errors=True)
            if rig is None:
                rig = Rig(folder / f"{number:02d}", options, copter, own_disk=fault.own_disk)
                problem = await _start(rig)
            outcome = Outcome(fault, problems=(problem,)) if problem else await rig.run(fault)
            outcomes.append(outcome)
            say(outcome)
            if fault.ends_flight or not outcome.passed or number == len(faults) - 1:
                ended, rig = rig, None
                await ended.stop()
                if outcome.passed:
                    shutil.rmtree(ended.folder, ignore_errors=True)
    finally:
        if rig is not None:
            await rig.stop()
    return outcomes


@contextlib.contextmanager
def in_time(autogroup: Path = AUTOGROUP) -> Iterator[None]:
    """Let this thread and its session go before others, where we may: they bear the link.

    The daemons would leave it no time on a busy computer, and a late link loses the autopilot: not the fault meant.
    """
    thread = threading.get_native_id()
    niceness = os.getpriority(os.PRIO_PROCESS, thread)
    session = ""
    with contextlib.suppress(OSError):  # a kernel without autogroups
        session = autogroup.read_text().rpartition(" ")[2].strip()
    set_niceness(SIMULATOR_NICENESS)
    if session:  # empty in the kernel's root group, which has none to set
        _set_session(autogroup, str(SIMULATOR_NICENESS))
    try:
        yield
    finally:
        set_niceness(niceness)
        if session:
            _set_session(autogroup, session)


def _set_session(autogroup: Path, niceness: str) -> None:
    with contextlib.suppress(OSError):  # no right to it
        autogroup.write_text(niceness)


async def _start(rig: Rig) -> str:
    """Start the programs; return the reason when they did not start."""
    try:
        await rig.start()
    except (StackError, DiskError) as error:
        return str(error)
    return ""
