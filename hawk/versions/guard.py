"""The rule that no version is switched while the drone may fly."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from hawk.versions.flight_state import FoundState, read_flight_state

UNIT: Final = "hawk-drone.service"
RUNTIME_FOLDER: Final = Path("/run/hawk")
"""RuntimeDirectory of the unit. It is kept over stops and emptied by a boot."""
SYSTEMD_FOLDER: Final = Path("/run/systemd/system")
"""Exists where systemd runs (sd_booted(3))."""
ASKED_S: Final = 3.0
"""Real seconds in which a daemon that runs must write its state again; it does so four times a second."""
PAUSE_S: Final = 0.1
_ENDED: Final = frozenset({"inactive", "failed", ""})


@dataclass(frozen=True, slots=True)
class Refusal:
    """``reason``: a sentence; ``remedy``: the next step of a person."""

    reason: str
    remedy: str


ARMED: Final = Refusal(
    "The drone is armed, or nobody knows that it is not.",
    "Land it, disarm it, and see that the daemon hears the autopilot.",
)
SILENT: Final = Refusal(
    "The daemon runs and does not say whether the drone is armed: it counts as armed.",
    "If the drone is on the ground with its motors off, stop the daemon: systemctl stop hawk-drone",
)
ENDED_ARMED: Final = Refusal(
    "The daemon does not run, and the drone was armed when it ended.",
    "Start the daemon, so that it asks the autopilot (systemctl start hawk-drone), or boot this computer again.",
)


def judge(found: FoundState, asked_s: float, *, unit_runs: bool) -> Refusal | None:
    """Return why no version may be switched now, None when one may.

    Args:
        found: The daemon's file.
        asked_s: CLOCK_MONOTONIC when the daemon was asked, seconds. "On the ground" counts when it was said since: a
            daemon that hangs does not see a pilot arm.
        unit_runs: True when systemd has the unit started, is starting it, or is ending it.
    """
    state = found.state
    if found.is_held:
        if state is not None and state.may_fly:
            return ARMED
        return None if state is not None and state.at_s >= asked_s else SILENT
    if state is not None and state.may_fly:
        return ENDED_ARMED
    return SILENT if unit_runs else None


def look(
    folder: Path = RUNTIME_FOLDER,
    *,
    unit_runs: Callable[[], bool] | None = None,
    monotonic: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> Refusal | None:
    """Ask the daemon, for `ASKED_S` at most while it does not say; return why no version may be switched now."""
    asked_s = monotonic()
    runs = unit_runs or service_runs
    while True:
        try:
            found = read_flight_state(folder)
        except OSError as error:
            return Refusal(f"{folder}: the daemon's flight state cannot be read: {error}.", "Run this as root.")
        refusal = judge(found, asked_s, unit_runs=runs())
        if refusal is not SILENT or monotonic() >= asked_s + ASKED_S:
            return refusal
        sleep(PAUSE_S)


def systemd_runs() -> bool:
    """Return True where systemd is the init system; in a bare root (chroot) it is not."""
    return SYSTEMD_FOLDER.is_dir()


def service_runs() -> bool:
    """Return True unless the unit has ended, or there is no systemd. A systemd that does not answer counts as True."""
    if not systemd_runs():
        return False
    command = ["systemctl", "show", "--property=ActiveState", "--value", UNIT]
    try:
        answer = subprocess.run(command, capture_output=True, text=True, timeout=10, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return True
    return answer.returncode != 0 or answer.stdout.strip() not in _ENDED
