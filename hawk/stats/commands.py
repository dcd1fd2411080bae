"""The command ``hawk-drone stats``: figures of a lot's use, from the states of its stalls."""

from __future__ import annotations

import argparse
import json
import sys
from contextlib import closing
from pathlib import Path
from typing import Any, Final

from hawk.config import options as values
from hawk.config.loader import config_of
from hawk.config.sections import ConfigError

COMMAND: Final = "stats"
BY: Final = ("hour", "row", "zone", "kind")
_FAILED: Final = 1


def add_stats_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(
        COMMAND, help="print occupancy, peak, load and turnover of a lot, with their intervals"
    )
    parser.add_argument("lot", type=values.some, metavar="LOT", help="name or id of the lot")
    parser.add_argument("--from", type=values.some, dest="begin", metavar="DATE", help="first day, as 2026-05-04")
    parser.add_argument("--to", type=values.some, dest="end", metavar="DATE", help="last day, as 2026-05-10")
    parser.add_argument("--by", choices=BY, help="parts to print: hours of the day, or rows, zones, kinds of stalls")
    parser.add_argument(
        "--time-zone", type=values.some, metavar="NAME",
        help="the lot's time zone, as Europe/Amsterdam; without it this computer's",
    )  # fmt: skip
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--csv", action="store_true", help="print CSV")
    form.add_argument("--json", action="store_true", help="print every figure as JSON")
    values.add_settings(parser)
    parser.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    from hawk.lots.store import lots_file  # loads numpy: not for the other commands
    from hawk.lots.values import LotInputError, LotStoreError

    config = config_of(options)
    try:
        print(_answer(lots_file(config.store.directory, config.store.lots), options))
    except LotInputError as error:
        raise ConfigError(f"--{error.field.replace('_', '-')}: {error.reason}") from None
    except LotStoreError as error:
        print(f"hawk-drone: {error}", file=sys.stderr)
        return _FAILED
    return 0


def _answer(store: Path, options: argparse.Namespace) -> str:
    from hawk.lots.database import Database
    from hawk.lots.looks import keep_looks, missing_looks
    from hawk.lots.store import check_there, show_damage
    from hawk.lots.teaching import lot_named
    from hawk.stats.answering import statistics
    from hawk.stats.asked import period_of
    from hawk.stats.shown import figures_csv, figures_json, figures_text

    period = period_of(options.begin, options.end, options.time_zone)
    check_there(store)
    with closing(Database(store)) as database:
        show_damage(database.damage)
        with database.reading() as connection:
            lot = lot_named(connection, options.lot)
            missing = missing_looks(connection, lot)
        if missing and not database.is_read_only:
            with database.writing() as connection:
                keep_looks(connection, missing)
        with database.reading() as connection:
            found = statistics(connection, lot, period, options.by)
    if options.json:
        return json.dumps(figures_json(found), indent=1)
    return figures_csv(found).rstrip("\n") if options.csv else figures_text(found)
