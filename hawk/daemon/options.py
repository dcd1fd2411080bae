"""Options of the daemon's command line that are not settings, and its first words in the log."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from hawk.config.sections import Config
from hawk.sim.launch import SimulationOptions


@dataclass(frozen=True, slots=True)
class DaemonOptions:
    """Options of the command line.

    ``simulation``: start hawk-sim and fly it. ``attached_simulation``: URL of one that runs already, at
    ``speed`` simulated seconds per second. ``ready_file`` is written (JSON: url, first_tick_s) when the page is up.
    ``parent_pid``: end when that process ends.
    """

    simulation: SimulationOptions | None = None
    attached_simulation: str | None = None
    speed: float = 1.0
    ready_file: Path | None = None
    parent_pid: int | None = None
    is_again: bool = False
    """An earlier run ended by a fault: its survey goes on, also over the same simulated world."""

    @property
    def is_simulation(self) -> bool:
        """True when the drone is simulated."""
        return self.simulation is not None or self.attached_simulation is not None


def start_words(options: DaemonOptions, config: Config, *, flew_lately: bool) -> str:
    """Return the version that starts, with its autopilot and its store; ``flew_lately``: an earlier run was flying."""
    kind = "a simulation, " if options.is_simulation else ""
    again = ", after a start in the air" if flew_lately else ""
    place = f"autopilot at {config.autopilot.url}, store {config.store.directory.resolve()}"
    return f"hawk-drone {version('hawk-drone')}, {kind}{place}{again}"
