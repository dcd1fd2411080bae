"""The command ``hawk-drone report``: the use of lots as a document or a workbook that is handed over."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hawk.config import options as values
from hawk.config.loader import config_of
from hawk.config.sections import DUE_DAYS, ConfigError, ScheduledSurvey
from hawk.lots.storage.commands import run_on_store
from hawk.report.options import CONTENT_TYPES, LANGUAGES, MOST_LOTS, PAPERS, Form, Wanted
from hawk.runtime.late import late
from hawk.stats import commands as stats

if TYPE_CHECKING:  # they load numpy and SQLAlchemy: not for the other commands
    from hawk.exports import files as exports
    from hawk.lots.queries import NextDue
    from hawk.lots.survey import pictures
    from hawk.report import files
    from hawk.runtime import files as disk
else:
    exports = late("hawk.exports.files")
    pictures = late("hawk.lots.survey.pictures")
    files = late("hawk.report.files")
    disk = late("hawk.runtime.files")

COMMAND: Final = "report"


Due = Callable[[Sequence[ScheduledSurvey], str, str, float | None, float, int], list[datetime]]
"""Returns when surveys of a lot are due: `hawk.daemon.lots.schedule.moments_due`."""


def add_report_command(commands: Any, due: Due) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(
        COMMAND,
        help="write the use of lots as a document to hand over: pictures, figures with intervals, surveys, method",
    )
    parser.add_argument(
        "lot", type=values.some, metavar="LOT", nargs="*",
        help=f"name or id of a lot; of several, {MOST_LOTS} at most, the first page has a table and the total",
    )  # fmt: skip
    parser.add_argument("--all", action="store_true", help="all lots of the store, by name")
    parser.add_argument(
        "--out", type=values.new(*(f".{kind}" for kind in CONTENT_TYPES)), metavar="FILE", required=True,
        help="the file to write: .pdf (with the extra report), .html, which a browser prints, or .xlsx (a workbook)",
    )  # fmt: skip
    stats.add_period(parser)
    stats.add_question(parser)
    parser.add_argument("--language", choices=LANGUAGES, default=LANGUAGES[0], help="language (en)")
    parser.add_argument("--paper", choices=PAPERS, default=PAPERS[0], help="paper of .pdf and .html (a4)")
    values.add_settings(parser)
    parser.set_defaults(action=lambda options: _run(options, due))


def _run(options: argparse.Namespace, due: Due) -> int:
    if not options.all and not options.lot:
        raise ConfigError("LOT: name one or more lots, or write --all for all of them")
    if options.all and options.lot:
        raise ConfigError("--all: means all lots; leave it out, or the names")
    schedule, now = config_of(options).schedule, time.time()

    def next_due(lot: str, name: str, last: float | None) -> datetime | None:
        return next(iter(due(schedule, lot, name, last, now, DUE_DAYS)), None)

    return run_on_store(options, lambda store: _write(store, options, next_due, now))


def _write(store: Path, options: argparse.Namespace, due: NextDue, now: float) -> str:
    asked, out = stats.asked_of(options), options.out
    kind, form = out.suffix.lower().removeprefix("."), Form(options.language, options.paper)
    with stats.reading_lots(store, None if options.all else options.lot) as (connection, found):
        wanted, kept = Wanted("", asked, options.begin, options.end, options.time_zone), pictures.pictures_of(store)
        if len(found) > MOST_LOTS:
            named = "--all" if options.all else "LOT"
            raise ConfigError(f"{named}: {MOST_LOTS} lots at most, and these are {len(found)}; write several reports")
        if options.all or len(found) > 1:
            file = files.prepared_of_lots(connection, kept, found, wanted, kind, form, now, due)
        else:
            file = files.prepared(connection, kept, replace(wanted, lot=found[0]), kind, form, now)
    data = files.finished(file)
    with exports.written_to(out):
        disk.replace_whole(out, data)
    return f"{out}: {len(data) / 1e6:.2f} MB"
