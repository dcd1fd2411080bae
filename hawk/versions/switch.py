"""Puts versions in force on the ground: at an upgrade, by a rollback, and by itself after starts that failed."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from hawk.versions.flight_state import FoundState, read_flight_state
from hawk.versions.folder import VersionError, Versions

UNIT: Final = "hawk-drone.service"
DESK_UNIT: Final = "hawk-desk.service"
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


FAILED_STARTS: Final = 3
"""Starts that fail before a version was ever ready; then the version before is in force again."""
IN_ORDER: Final = "success"
"""SERVICE_RESULT of a service that was stopped (systemd.exec(5))."""
RESTART_S: Final = 120.0
"""Real seconds for systemd to end the old daemon and start the new one."""


class Refused(Exception):  # noqa: N818 - it is no error: the drone may fly
    """No version may be switched now; the text has the reason and the remedy."""

    def __init__(self, refusal: Refusal) -> None:
        super().__init__(f"{refusal.reason} {refusal.remedy}")


def use_idle_time_only() -> None:
    """Give this process the processor when nobody else wants it: the drone may fly."""
    os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))


def restart_services() -> None:
    """Start daemon and desk again where they run. Raises VersionError where systemd cannot do so."""
    if not systemd_runs():
        return
    for command in (
        ["systemctl", "daemon-reload"],
        ["systemctl", "try-restart", UNIT],
        ["systemctl", "try-restart", DESK_UNIT],
    ):
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=RESTART_S, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise VersionError(f"`{' '.join(command)}` failed: {error}") from error
        if done.returncode != 0:
            reason = done.stderr.strip() or f"status {done.returncode}"
            raise VersionError(f"`{' '.join(command)}` failed: {reason}; see journalctl")


@dataclass(frozen=True, slots=True)
class Outside:
    """Everything outside the folder of versions; replaced in tests."""

    look: Callable[[], Refusal | None] = look
    restart: Callable[[], None] = restart_services


def require_ground(outside: Outside) -> None:
    """Raise Refused while the drone may fly."""
    refusal = outside.look()
    if refusal is not None:
        raise Refused(refusal)


def install(versions: Versions, package: Path, version: str, outside: Outside) -> list[str]:
    """Put the version of the package's files in force; return the versions that were removed.

    The version that was in force stays as the previous one. A daemon that runs is not restarted. When the drone may
    fly, nothing is changed. Raises Refused, VersionError, OSError.
    """
    fresh = versions.prepare(package, version)
    before = versions.current
    previous = versions.previous if before in (None, version) else before
    require_ground(outside)
    versions.put(fresh, version)
    versions.switch(version, None if previous == version else previous)
    return versions.prune()


def roll_back(versions: Versions, wanted: str | None, outside: Outside) -> str:
    """Put the previous version in force, or the wanted one; return its name. Raises Refused, VersionError."""
    before = versions.current
    target = wanted or versions.previous
    if target is None:
        others = [version for version in versions.kept if version != before]
        remedy = f"go forward by: hawk-drone rollback {others[-1]}" if others else "install one by apt"
        raise VersionError(f"no version is kept that was in force before {before or 'this one'}; {remedy}")
    if target == before:
        raise VersionError(f"version {target} is in force already")
    if target not in versions.kept:
        raise VersionError(f"version {target} is not kept; kept: {', '.join(versions.kept) or 'none'}")
    if not versions.has_python(target):
        raise VersionError(f"version {target} was made for another Debian: its Python is not installed any more")
    require_ground(outside)
    versions.switch(target, before if wanted else None)
    outside.restart()
    return target


def note_ready(versions: Versions) -> None:
    """Note that the daemon of the version in force is ready."""
    version = versions.current
    if version is not None and not versions.was_ready(version):
        versions.note_ready(version)


def note_end(versions: Versions, result: str) -> str | None:
    """Look at an end of the daemon; return what was done about it, None for nothing.

    A version that was ever ready is not left: what ends in flight is no failed start. A version that was left is not
    gone back to, so two that do not start do not alternate; nor is one whose Python is not installed any more.

    Args:
        versions: The folder of versions.
        result: SERVICE_RESULT (systemd.exec(5)).
    """
    version = versions.current
    if version is None or result == IN_ORDER or versions.was_ready(version):
        return None
    failures = versions.note_failed_start(version)
    if failures < FAILED_STARTS:
        return f"version {version} failed to start ({result}), {failures} of {FAILED_STARTS}"
    previous = versions.previous
    if previous is None or versions.has_failed(previous) or not versions.has_python(previous):
        if failures == FAILED_STARTS:
            return f"version {version} failed to start {failures} times; no version before it is kept to go back to"
        return None
    versions.note_failed(version)
    versions.switch(previous, None)
    return f"version {version} failed to start {failures} times; version {previous} is in force again"
