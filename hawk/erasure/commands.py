"""The command ``hawk-drone erase``."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any, Final

from hawk.config import options as values
from hawk.config.loader import config_of
from hawk.config.sections import ConfigError, StoreSettings
from hawk.lots.storage.commands import run_on_store
from hawk.runtime.late import late

if TYPE_CHECKING:  # it loads SQLAlchemy: not for the other commands
    from hawk.erasure import erasure as erasure
else:
    erasure = late("hawk.erasure.erasure")

COMMAND: Final = "erase"
_FAILED: Final = 1
_STOPPED: Final = 130
"""Exit status after Ctrl-C, as shells have it."""


def add_erase_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    erase = commands.add_parser(
        COMMAND, help="erase a lot, a survey or everything, with pictures, recordings and journals, for good"
    )
    what = erase.add_mutually_exclusive_group()
    what.add_argument("--lot", type=values.some, metavar="LOT", help="this lot (its name or id) with all its surveys")
    what.add_argument(
        "--survey",
        type=values.some,
        metavar="ID",
        help="this survey (its id, or its beginning); the lot keeps its stalls",
    )
    what.add_argument("--everything", action="store_true", help="every lot, survey, recording and journal")
    erase.add_argument("--yes", action="store_true", help="do not ask")
    erase.set_defaults(action=_run)
    values.add_settings(erase)


def _run(options: argparse.Namespace) -> int:
    settings = config_of(options).store
    if not (options.lot or options.survey or options.everything):
        raise ConfigError("--lot, --survey or --everything is missing: it says what to erase")
    named = f"lot {options.lot}" if options.lot else f"survey {options.survey}" if options.survey else "everything"
    if not options.yes and not _is_sure(f"Erase {named} in {settings.directory} for good? Type yes: "):
        print("hawk-drone erase: nothing is erased", file=sys.stderr)
        return _FAILED
    try:
        return run_on_store(options, lambda _: _erased(settings, options, named))
    except KeyboardInterrupt:
        print("hawk-drone erase: stopped; a part may be erased: run it again for the rest", file=sys.stderr)
        return _STOPPED


def _erased(settings: StoreSettings, options: argparse.Namespace, named: str) -> str:
    found = erasure.erase(settings, lot=options.lot, survey=options.survey)
    return (
        f"erased {named}: surveys {found.surveys}, pictures {found.pictures}, recordings {found.recordings}, "
        f"journals {found.journals}, earlier copies of the store {found.copies}. Backups and exported files that you "
        "made are yours to erase"
    )


def _is_sure(question: str) -> bool:
    try:
        return input(question).strip().lower() == "yes"
    except (EOFError, KeyboardInterrupt):
        return False
