"""The command ``hawk-drone report``: a lot's use as a document or a workbook that is handed over."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hawk.config import options as values
from hawk.lots.storage.commands import run_on_store
from hawk.report.options import CONTENT_TYPES, LANGUAGES, PAPERS, Form, Wanted
from hawk.runtime.late import late
from hawk.stats import commands as stats

if TYPE_CHECKING:  # they load numpy and SQLAlchemy: not for the other commands
    from hawk.exports import files as exports
    from hawk.lots.survey import pictures
    from hawk.report import files
    from hawk.runtime import files as disk
else:
    exports = late("hawk.exports.files")
    pictures = late("hawk.lots.survey.pictures")
    files = late("hawk.report.files")
    disk = late("hawk.runtime.files")

COMMAND: Final = "report"


def add_report_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(
        COMMAND, help="write a lot's use as a document to hand over: pictures, figures with intervals, surveys, method"
    )
    parser.add_argument("lot", type=values.some, metavar="LOT", help="name or id of the lot")
    parser.add_argument(
        "--out", type=values.new(*(f".{kind}" for kind in CONTENT_TYPES)), metavar="FILE", required=True,
        help="the file to write: .pdf (with the extra report), .html, which a browser prints, or .xlsx (a workbook)",
    )  # fmt: skip
    stats.add_period(parser)
    stats.add_question(parser)
    parser.add_argument("--language", choices=LANGUAGES, default=LANGUAGES[0], help="language (en)")
    parser.add_argument("--paper", choices=PAPERS, default=PAPERS[0], help="paper of .pdf and .html (a4)")
    values.add_settings(parser)
    parser.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    return run_on_store(options, lambda store: _write(store, options))


def _write(store: Path, options: argparse.Namespace) -> str:
    asked, out = stats.asked_of(options), options.out
    kind, form = out.suffix.lower().removeprefix("."), Form(options.language, options.paper)
    with stats.reading(store, options) as (connection, lot):
        wanted = Wanted(lot, asked, options.begin, options.end, options.time_zone)
        file = files.prepared(connection, pictures.pictures_of(store), wanted, kind, form, time.time())
    data = files.finished(file)
    with exports.written_to(out):
        disk.replace_whole(out, data)
    return f"{out}: {len(data) / 1e6:.2f} MB"
