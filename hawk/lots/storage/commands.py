"""The commands ``hawk-drone backup``, ``restore`` and ``verify``: a copy of the lots' store, its return, its check."""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hawk.config import options as values
from hawk.config.loader import config_of
from hawk.runtime.late import late

if TYPE_CHECKING:  # they load numpy and SQLAlchemy: not for the other commands
    from sqlalchemy import Connection

    from hawk.lots import store as lots
    from hawk.lots import values as errors
    from hawk.lots.storage import backup, database
else:
    backup = late("hawk.lots.storage.backup")
    database = late("hawk.lots.storage.database")
    lots = late("hawk.lots.store")
    errors = late("hawk.lots.values")

LOT_COMMANDS: Final = frozenset({"backup", "restore", "verify"})
_FAILED: Final = 1
_WRONG: Final = 2


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
    return run_on_store(options, lambda store: str(options.action_of(store, options)))


def run_on_store(options: argparse.Namespace, work: Callable[[Path], str]) -> int:
    """Print the words that some work on the lots' store returns; return the exit status of its command.

    That is 2 for what the person asked wrongly: an option, a lot or survey that is not there, a file that cannot be
    used; 1 for what failed. ``work`` takes the store's file. Raises ConfigError.
    """
    config = config_of(options)
    try:
        words = work(lots.lots_file(config.store.directory, config.store.lots))
    except (errors.LotStoreError, OSError) as error:
        print(f"hawk-drone: {_reason(error, options)}", file=sys.stderr)
        return _WRONG if isinstance(error, errors.LotInputError | errors.NotFoundError) else _FAILED
    if words:
        print(words)
    return 0


@contextlib.contextmanager
def reading_there(store: Path) -> Iterator[Connection]:
    """Give a view of a store that is there; its damage is said. Raises LotStoreError."""
    lots.check_there(store)
    with contextlib.closing(database.Database(store)) as opened, opened.reading() as connection:
        lots.show_damage(opened.damage)
        yield connection


def _reason(error: Exception, options: argparse.Namespace) -> str:
    """Return the words of an error, with the option or the file that is meant."""
    given = {**vars(options), **dict.fromkeys(_DAYS)}
    file = next((given[name] for name in _FILES if given.get(name) is not None), None)
    if isinstance(error, OSError):
        return f"{error.filename or file or '--store'}: {error.strerror or error}"
    if not isinstance(error, errors.LotInputError):
        return str(error)
    if error.field in given and error.field not in _FILES:
        return f"--{error.field.replace('_', '-')}: {error.reason}"
    return str(error) if "file" not in given else f"{file}: {error}"


_FILES: Final = ("file", "out", "training")
"""Options that name a file or folder."""
_DAYS: Final = ("from", "to")
"""Options with a name that Python keeps for itself."""


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
