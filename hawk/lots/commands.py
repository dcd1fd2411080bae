"""The commands ``hawk-drone backup`` and ``restore``: a copy of the lots' store, and its return."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any, Final

from hawk.config import options as values
from hawk.config.sections import config_of

LOT_COMMANDS: Final = frozenset({"backup", "restore"})
_FAILED: Final = 1


def add_lot_commands(commands: Any) -> None:
    """Add the commands to the subparsers of the command line."""
    backup = commands.add_parser("backup", help="write a copy of all lots and surveys, also while the daemon runs")
    backup.add_argument("file", type=values.new(), metavar="FILE", help="the file to write; it must be new")
    backup.set_defaults(action_of=_backup)
    restore = commands.add_parser("restore", help="put a backup of lots and surveys in place of those in the store")
    restore.add_argument("file", type=values.file, metavar="FILE", help="a file that hawk-drone backup wrote")
    restore.set_defaults(action_of=_restore)
    for parser in (backup, restore):
        parser.set_defaults(action=_run)
        values.add_settings(parser)


def _run(options: argparse.Namespace) -> int:
    from hawk.lots.store import lots_file  # loads numpy: not for the other commands
    from hawk.lots.values import LotStoreError

    config = config_of(options)
    try:
        print(options.action_of(lots_file(config.store.directory, config.store.lots), options))
    except LotStoreError as error:
        print(f"hawk-drone: {error}", file=sys.stderr)
        return _FAILED
    except OSError as error:
        print(f"hawk-drone: {error.filename or options.file}: {error.strerror or error}", file=sys.stderr)
        return _FAILED
    return 0


def _backup(store: Path, options: argparse.Namespace) -> str:
    from hawk.lots.backup import backup

    backup(store, options.file)
    return f"{options.file}: a copy of {store}, {options.file.stat().st_size / 1e6:.1f} MB"


def _restore(store: Path, options: argparse.Namespace) -> str:
    from hawk.lots.backup import restore

    kept = restore(store, options.file)
    return f"{store}: restored from {options.file}" + ("" if kept is None else f"; {kept} keeps the former content")
