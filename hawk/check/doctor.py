"""A bundle for a bug report, without secrets: versions, machine, settings, checks, journal's tail, small files.

Only files that are named here are copied, after `hawk.check.secrets` went over them; of all others the bundle has the
names, sizes and times.
"""

from __future__ import annotations

import io
import json
import os
import platform
import shutil
import subprocess
import sys
import tarfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib.metadata import distributions, version
from pathlib import Path
from typing import Any, Final

from hawk.check.last_flight import COMMAND, last_flight, read_journal, tell
from hawk.check.report import as_object
from hawk.check.result import CheckResult
from hawk.check.secrets import SecretFilter
from hawk.config.reference import reference_text, settings
from hawk.config.sections import Config
from hawk.store.journal_state import MAP, SEGMENT, read_records

JOURNAL_LINES: Final = 3000
"""Lines of the daemon's journal; its stack dumps go there, too."""
LAST_FLIGHT: Final = "last-flight.txt"
"""Name of the part that has the last flight in words."""
_JOURNAL_S: Final = 10.0
_LARGEST: Final = 256_000
"""Bytes of the largest file that is copied; of a longer one its end is."""
_SEGMENT_BYTES: Final = 64_000_000
_MOST_FILES: Final = 5000
_STORE_FILES: Final = ("params.json", "fence.geojson")
"""Small files of the store that decide a flight."""

Run = Callable[[Sequence[str]], str]
"""Returns what a command prints; an empty text when it cannot be run."""


def run_command(command: Sequence[str]) -> str:
    """Return the command's output; empty when it is not there, fails or hangs."""
    if shutil.which(command[0]) is None:
        return ""
    try:
        ended = subprocess.run(command, capture_output=True, timeout=_JOURNAL_S, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return ended.stdout.decode("utf-8", "replace")


@dataclass(frozen=True, slots=True)
class Bundle:
    """A written bundle: its file, and the names of its parts with their bytes."""

    path: Path
    parts: Mapping[str, int]


def collect(
    config: Config | None, folder: Path, checks: Sequence[CheckResult], hidden: SecretFilter, run: Run = run_command
) -> dict[str, str]:
    """Return the parts of the bundle by name, without secrets.

    Args:
        config: The settings; None when they cannot be read.
        folder: The store.
        checks: Results of `hawk.check.run.check_all`.
        hidden: Removes the secrets.
        run: Runs ``journalctl``.
    """
    parts = {
        "version.json": _json(_versions()),
        "machine.json": _json(_machine()),
        "checks.json": _json(as_object(checks)),
        "store-files.txt": _list_of(folder),
    }
    if config is not None:
        parts["settings.json"] = _json([asdict(each) for each in settings(config, reference_text())])
    journal = run(["journalctl", "-u", "hawk-drone", "-n", str(JOURNAL_LINES), "--no-pager", "-o", "short-iso"])
    if journal.strip():
        parts["daemon-journal.txt"] = journal
        parts[LAST_FLIGHT] = tell(last_flight(read_journal(run(COMMAND))))
    parts |= _small_files(folder)
    kept = _flight_journal(folder / "journal")
    if kept:
        parts["flight-journal.json"] = _json(kept)
    return {name: hidden.clean(text) for name, text in parts.items()}


def write_bundle(path: Path, parts: Mapping[str, str], now: float) -> Bundle:
    """Write the bundle, readable by its owner alone. Raises OSError, also when the file exists already."""
    inside = path.name.removesuffix(".tar.gz")
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    sizes: dict[str, int] = {}
    with os.fdopen(descriptor, "wb") as file, tarfile.open(fileobj=file, mode="w:gz") as archive:
        for name, text in parts.items():
            data = text.encode("utf-8", "replace")
            entry = tarfile.TarInfo(f"{inside}/{name}")
            entry.size, entry.mtime, entry.mode = len(data), int(now), 0o600
            archive.addfile(entry, io.BytesIO(data))
            sizes[name] = len(data)
    return Bundle(path, sizes)


def _versions() -> dict[str, Any]:
    packages = {each.metadata["Name"]: each.version for each in distributions()}
    return {
        "hawk-drone": version("hawk-drone"),
        "python": sys.version,
        "packages": dict(sorted((name, found) for name, found in packages.items() if name)),
    }


def _machine() -> dict[str, Any]:
    """Return platform, processors, memory (bytes), load and time since the boot; no name of the computer."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return {
        "system": platform.system(),
        "kernel": platform.release(),
        "architecture": platform.machine(),
        "os": _os_name(),
        "model": _read(Path("/proc/device-tree/model")).strip("\0\n "),
        "processors": os.cpu_count(),
        "memory_bytes": memory,
        "load": os.getloadavg(),
        "since_boot_s": round(time.clock_gettime(time.CLOCK_BOOTTIME)),
        "time": datetime.now(UTC).isoformat(timespec="seconds"),
        "user_is_root": os.geteuid() == 0,
    }


def _os_name() -> str:
    try:
        return platform.freedesktop_os_release().get("PRETTY_NAME", "")
    except OSError:
        return ""


def _list_of(folder: Path) -> str:
    """Return time, bytes and name of every file of the store."""
    lines = []
    for path in sorted(folder.rglob("*")):
        try:
            facts = path.lstat()
        except OSError:
            continue
        if path.is_dir() and not path.is_symlink():
            continue
        when = datetime.fromtimestamp(facts.st_mtime, UTC).isoformat(timespec="seconds")
        lines.append(f"{when} {facts.st_size:12} {facts.st_mode & 0o777:04o} {path.relative_to(folder)}")
        if len(lines) >= _MOST_FILES:
            lines.append("... and more")
            break
    return "\n".join(lines) + "\n" if lines else "There is no file.\n"


def _small_files(folder: Path) -> dict[str, str]:
    """Return the named small files of the store; a link may lead anywhere and is left out."""
    wanted = (path for name in _STORE_FILES if (path := folder / name).is_file() and not path.is_symlink())
    return {f"store/{path.name}": _read(path) for path in wanted}


def _flight_journal(folder: Path) -> dict[str, Any]:
    """Return the small values of each survey's journal: datum, arm place, flight, starts. Parts of the map are counted.

    The journal is read, never opened for writing: a daemon may use it.
    """
    surveys: dict[str, Any] = {}
    for segment in sorted(folder.glob("*/*")):
        if not SEGMENT.fullmatch(segment.name) or segment.is_symlink() or segment.stat().st_size > _SEGMENT_BYTES:
            continue
        try:
            records, lost = read_records(segment.read_bytes())
        except OSError:
            continue
        kept = surveys.setdefault(segment.parent.name, {"values": {}, "map_parts": 0, "lost_bytes": 0})
        kept["lost_bytes"] += lost
        for key, value in records:
            if key.startswith(MAP):
                kept["map_parts"] += 1
            elif value:
                kept["values"][key] = value[:_LARGEST].decode("utf-8", "replace")
            else:
                kept["values"].pop(key, None)
    return surveys


def _read(path: Path) -> str:
    """Return a file's text, of a long one its end; empty when it cannot be read."""
    try:
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - _LARGEST))
            return file.read(_LARGEST).decode("utf-8", "replace")
    except OSError:
        return ""


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, indent=2, default=str) + "\n"
