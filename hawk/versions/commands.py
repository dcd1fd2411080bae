"""The commands ``hawk-drone rollback`` and ``hawk-drone versions``, and those of the Debian package's own scripts."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

from hawk.versions.folder import VersionError, Versions
from hawk.versions.switch import (
    IN_ORDER,
    Outside,
    Refusal,
    Refused,
    install,
    look,
    note_end,
    note_ready,
    require_ground,
    roll_back,
    use_idle_time_only,
)

VERSION_COMMANDS: Final = frozenset({"rollback", "versions"})
EXIT_FAILED: Final = 1
ROOT: Final = Path("/opt/hawk")


def add_version_commands(commands: Any) -> None:
    """Add both commands to the subparsers of the command line."""
    rollback = commands.add_parser("rollback", help="go back to the version that the Debian package replaced")
    rollback.set_defaults(action=partial(_guarded, _rollback))
    rollback.add_argument("version", nargs="?", metavar="VERSION", help="another version that is kept")
    versions = commands.add_parser("versions", help="list the versions that are kept, and which one is in force")
    versions.set_defaults(action=partial(_guarded, _list))
    for parser in (rollback, versions):
        _add_folders(parser)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command by Debian's Python; return the exit status."""
    parser = argparse.ArgumentParser(prog="hawk-drone", description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    add_version_commands(commands)
    for name, work, text in (
        ("ground", _ground, "fail unless a version may be switched now"),
        ("install", _install, "put the package's version in force"),
        ("ready", _ready, "note that the daemon is ready"),
        ("ended", _ended, "look at an end of the daemon (SERVICE_RESULT)"),
    ):
        command = commands.add_parser(name, help=text)
        command.set_defaults(action=partial(_guarded, work))
        _add_folders(command)
        if work is _install:
            command.add_argument("package", type=Path, help="the package's virtual environment")
            command.add_argument("version", help="the package's version")
    options = parser.parse_args(arguments)
    return int(options.action(options))


def _add_folders(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--root", type=Path, default=ROOT, help=argparse.SUPPRESS)
    parser.add_argument("--runtime", type=Path, default=None, help=argparse.SUPPRESS)


def _guarded(work: Callable[[argparse.Namespace], None], options: argparse.Namespace) -> int:
    try:
        work(options)
    except (Refused, VersionError) as error:
        return _fail(str(error))
    except PermissionError as error:
        return _fail(f"{error.filename}: {error.strerror}; run this as root (sudo)")
    except OSError as error:
        return _fail(f"{error.filename or options.root}: {error.strerror or error}")
    return 0


def _fail(text: str) -> int:
    print(f"hawk-drone: {text}", file=sys.stderr)
    return EXIT_FAILED


def _outside(options: argparse.Namespace) -> Outside:
    return Outside() if options.runtime is None else Outside(look=lambda: look(options.runtime))


def _versions(options: argparse.Namespace) -> Versions:
    versions = Versions(options.root)
    if versions.current is None and not versions.kept:
        raise VersionError(f"{options.root}: no version is kept there: the Debian package did not install this program")
    return versions


def _rollback(options: argparse.Namespace) -> None:
    versions = _versions(options)
    if os.geteuid() != 0 and not os.access(options.root, os.W_OK):
        raise VersionError("rollback: only root may switch the version; run: sudo hawk-drone rollback")
    before = versions.current
    now = roll_back(versions, options.version, _outside(options))
    print(f"Version {now} is in force. Version {before} is kept: hawk-drone rollback {before} goes forward again.")


def _list(options: argparse.Namespace) -> None:
    versions = _versions(options)
    for version in versions.kept:
        notes = [text for text, holds in _notes(versions, version) if holds]
        print(f"{version}{'  ' if notes else ''}{', '.join(notes)}")
    refusal = _outside(options).look()
    print("A version may be switched now." if refusal is None else f"No version may be switched now. {_text(refusal)}")


def _notes(versions: Versions, version: str) -> list[tuple[str, bool]]:
    return [
        ("in force", version == versions.current),
        ("previous", version == versions.previous),
        ("was never ready", not versions.was_ready(version)),
        ("left because it did not start", versions.has_failed(version)),
        ("its Python is not installed", not versions.has_python(version)),
    ]


def _text(refusal: Refusal) -> str:
    return f"{refusal.reason} {refusal.remedy}"


def _ground(options: argparse.Namespace) -> None:
    require_ground(_outside(options))


def _install(options: argparse.Namespace) -> None:
    use_idle_time_only()
    os.umask(0o022)  # the daemon's user reads it, whatever root's mask is
    outside = _outside(options)
    removed = install(Versions(options.root), options.package, options.version, outside)
    if removed:
        print(f"Removed: version {', '.join(removed)}")
    try:
        outside.restart()
    except VersionError as error:  # the version is installed; when it does not start, it is left by itself
        print(f"hawk-drone: warning: {error}", file=sys.stderr)


def _ready(options: argparse.Namespace) -> None:
    note_ready(Versions(options.root))


def _ended(options: argparse.Namespace) -> None:
    done = note_end(Versions(options.root), os.environ.get("SERVICE_RESULT", IN_ORDER))
    if done is not None:
        print(f"hawk-drone: {done}", file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
