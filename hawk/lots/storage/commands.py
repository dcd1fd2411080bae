"""The commands ``hawk-drone backup``, ``restore`` and ``verify``: a copy of the lots' store, its return, its check."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hawk.config import options as values
from hawk.config.loader import config_of
from hawk.runtime.late import late

if TYPE_CHECKING:  # they load numpy and SQLAlchemy: not for the other commands
    from hawk.lots import store as lots
    from hawk.lots import values as errors
    from hawk.lots.storage import backup
else:
    backup = late("hawk.lots.storage.backup")
    lots = late("hawk.lots.store")
    errors = late("hawk.lots.values")

LOT_COMMANDS: Final = frozenset({"backup", "restore", "verify"})
_FAILED: Final = 1


def add_lot_commands(commands: Any) -> None:
    """Add the commands to the subparsers of the command line."""
    copy = commands.add_parser("backup", help="write a copy of all lots and surveys, also while the daemon runs")
    copy.add_argument("file", type=values.new(), metavar="FILE", help="the file to write; it must be new")
    copy.set_defaults(action_of=_backup)
    restore = commands.add_parser("restore", help="put a backup of lots and surveys in place of those in the store")
    restore.add_argument("file", type=values.file, metavar="FILE", help="a file that hawk-drone backup wrote")
    restore.set_defaults(action_of=_restore)
    verify = commands.add_parser("verify", help="check every byte of all lots and surveys, or of a backup of them")
    verify.add_argument(
        "file", type=values.file, metavar="FILE", nargs="?", help="a backup; without one the store is checked"
    )
    verify.set_defaults(action_of=_verify)
    for parser in (copy, restore, verify):
        parser.set_defaults(action=_run, boxed=_needs_network)
        values.add_settings(parser)


def _needs_network(_: argparse.Namespace) -> bool:
    """Return False: a backup may come from a stranger."""
    return False


def _run(options: argparse.Namespace) -> int:
    config = config_of(options)
    try:
        print(options.action_of(lots.lots_file(config.store.directory, config.store.lots), options))
    except errors.LotStoreError as error:
        print(f"hawk-drone: {error}", file=sys.stderr)
        return _FAILED
    except OSError as error:
        print(f"hawk-drone: {error.filename or options.file or '--store'}: {error.strerror or error}", file=sys.stderr)
        return _FAILED
    return 0


def _backup(store: Path, options: argparse.Namespace) -> str:
    damage = backup.backup(store, options.file)
    written = f"{options.file}: a copy of {store}, {options.file.stat().st_size / 1e6:.1f} MB"
    if damage:
        raise errors.LotStoreError(f"{written}, with its damage. Keep the backups before it. {damage}")
    return written


def _restore(store: Path, options: argparse.Namespace) -> str:
    done = backup.restore(store, options.file)
    kept = "" if done.kept is None else f"; {done.kept} keeps the former content"
    return "\n".join([f"{store}: restored from {options.file}{kept}", *done.notes])


def _verify(store: Path, options: argparse.Namespace) -> str:
    if options.file is None:
        lots.check_there(store)
    return backup.verify(options.file or store)
