"""A bundle for a bug report, without secrets: versions, machine, settings, checks, the last flight, small files.

Only files that are named here are copied, after `hawk.check.doctor` went over them; of all others the bundle has the
names, sizes and times.
"""

from __future__ import annotations

import io
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tarfile
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib.metadata import distributions, version
from pathlib import Path
from typing import Any, Final

from hawk.check.result import CheckResult, as_object
from hawk.config.reference import reference_text, settings
from hawk.config.secrets import HIDDEN
from hawk.config.sections import Config
from hawk.runtime.program_log import TRACE
from hawk.store.journal_state import MAP, SEGMENT, read_records

_LEAST: Final = 4
"""Characters of the shortest secret that is searched for by itself."""
_PARAMETER: Final = re.compile(
    r"(?i)\b((?:[\w-]*(?:token|passw(?:or)?d|passphrase|pwd|user-pw|secret|cookie|api[_-]?key|authorization))[\"']?\s*[=:]\s*"
    r"(?:bearer\s+|basic\s+)?[\"']?)([^\s\"'&;,}]+)"
)
"""``token=...`` and the like: the value goes."""
_AFTER_TOKEN: Final = re.compile(r"(?i)(token\b.{0,60}?)(?<![A-Za-z0-9_-])([A-Za-z0-9_-]{20,})")
"""A word of 20 or more characters of base64url after "token"."""
_USER_IN_ADDRESS: Final = re.compile(r"://[^/\s@]+@")
_USER_WITH_SLASH: Final = re.compile(r"(://)[^\s\"']*:[^\s\"']*@")
_QUERY: Final = re.compile(r"(\b[a-z]{2,10}://[^\s\"'?]+\?)[^\s\"']+")
_KEY: Final = re.compile(r"-----BEGIN [^-]*(?:KEY|CERTIFICATE)-----.*?(?:-----END [^-]*-----|\Z)", re.DOTALL)


class SecretFilter:
    """Hides what looks like a secret, and what the settings say is one."""

    def __init__(self, known: Iterable[str] = ()) -> None:
        """``known``: secrets, hidden wherever they stand."""
        self._known = sorted({each for each in known if len(each) >= _LEAST}, key=len, reverse=True)

    def clean(self, text: str) -> str:
        """Return the text without secrets."""
        for each in self._known:
            text = text.replace(each, HIDDEN)
        text = _KEY.sub(HIDDEN, text)
        text = _USER_IN_ADDRESS.sub(f"://{HIDDEN}@", text)
        text = _USER_WITH_SLASH.sub(rf"\1{HIDDEN}@", text)
        text = _QUERY.sub(rf"\1{HIDDEN}", text)
        text = _PARAMETER.sub(rf"\1{HIDDEN}", text)
        previous = ""
        while previous != text:  # every word after "token", not the first alone
            previous, text = text, _AFTER_TOKEN.sub(rf"\1{HIDDEN}", text)
        return text


LINES: Final = 20_000
"""Lines of the journal that are looked through: some hundred flights, or one with a fault that is logged often."""
COMMAND: Final = ("journalctl", "-u", "hawk-drone", "-n", str(LINES), "--no-pager", "-o", "json")
_WARNING: Final = 4
"""Priority of syslog; lower is worse."""
NO_FLIGHT: Final = "The journal holds no flight."


@dataclass(frozen=True, slots=True)
class Line:
    """A line of the journal: ``when`` seconds since 1970, ``priority`` as syslog's, ``run`` boot and process."""

    when: float
    priority: int
    run: tuple[str, str]
    text: str

    @property
    def event(self) -> str:
        """Name of the trace's event; empty for a line of another logger."""
        mark = f"{TRACE}: "
        return self.text.removeprefix(mark).partition(": ")[0] if self.text.startswith(mark) else ""

    @property
    def words(self) -> str:
        """The event's words."""
        return self.text.removeprefix(f"{TRACE}: ").partition(": ")[2]


def read_journal(text: str) -> list[Line]:
    """Return the lines that ``journalctl -o json`` printed; what cannot be read is left out."""
    found = (_line(each) for each in text.splitlines())
    return [line for line in found if line is not None]


def _line(text: str) -> Line | None:
    try:
        entry: dict[str, Any] = json.loads(text)
        message = entry["MESSAGE"]
        if isinstance(message, list):  # bytes, where it is not plain text
            message = bytes(message).decode("utf-8", "replace")
        run = (str(entry.get("_BOOT_ID", "")), str(entry.get("_PID", "")))
        when = int(entry["__REALTIME_TIMESTAMP"]) / 1e6
        return Line(when, int(entry.get("PRIORITY", 6)), run, str(message))
    except (ValueError, KeyError, TypeError, AttributeError):
        return None


def last_flight(lines: Sequence[Line]) -> list[Line]:
    """Return the lines from the last Arm to the end of its flight, with the start before it; none without a flight.

    A flight ends when the motors are off. A program that ends in the air and starts again goes on with it.
    """
    begun = [number for number, line in enumerate(lines) if line.event == "arm"]
    if not begun:
        return []
    first = begun[-1]
    after = (number for number in range(first + 1, len(lines)) if lines[number].event == "disarm")
    last = next(after, len(lines) - 1)
    start = max((number for number in range(first) if lines[number].event == "start"), default=first)
    kept = [lines[start]] if start < first else []
    flown = [line for line in lines[first : last + 1] if line.event or line.priority <= _WARNING]
    return kept + flown


def in_words(lines: Sequence[Line]) -> str:
    """Return the flight in words: when, how long, how it ended, then each line with its time."""
    armed = next((line for line in lines if line.event == "arm"), None)
    if armed is None:
        return f"{NO_FLIGHT}\n"
    last = lines[-1]
    ended = "The motors were off at its end" if last.event == "disarm" else "The journal does not hold its end"
    landing = next((line for line in reversed(lines) if line.event == "landing"), None)
    faults = _worst(line for line in lines if line.priority <= _WARNING and not line.text.startswith(" "))
    parts = [
        f"Last flight: {_time(armed.when)} to {_time(last.when)}, {last.when - armed.when:.0f} s.",
        f"Landed {landing.words}." if landing is not None else "No landing is noted.",
        f"{ended}.",
        f"{len(faults)} warnings and faults{': ' + '; '.join(faults[:5]) if faults else ''}.",
    ]
    runs = len({line.run for line in lines[lines.index(armed) :]})
    if runs > 1:
        parts.insert(1, f"The program was started {runs - 1} times in this flight.")
    return "\n".join([" ".join(parts), "", *(f"{_time(line.when)} {line.text}" for line in lines)]) + "\n"


def _worst(lines: Iterable[Line]) -> list[str]:
    return list(dict.fromkeys(line.text.removeprefix(f"{TRACE}: ").strip() for line in lines))


def _time(when: float) -> str:
    return datetime.fromtimestamp(when, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


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
        parts[LAST_FLIGHT] = in_words(last_flight(read_journal(run(COMMAND))))
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
