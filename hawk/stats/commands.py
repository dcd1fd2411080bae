"""The command ``hawk-drone stats``: figures of a lot's use, from the states of its stalls."""

from __future__ import annotations

import argparse
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hawk.config import options as values
from hawk.lots.storage.commands import run_on_store
from hawk.runtime.late import late
from hawk.stats.partition import PARTITIONS

if TYPE_CHECKING:  # they load numpy and SQLAlchemy: not for the other commands
    from hawk.lots import names
    from hawk.lots import store as lots
    from hawk.lots.storage import database
    from hawk.lots.survey import observations
    from hawk.stats import period, queries, serialize
else:
    database = late("hawk.lots.storage.database")
    observations = late("hawk.lots.survey.observations")
    names = late("hawk.lots.names")
    lots = late("hawk.lots.store")
    queries = late("hawk.stats.queries")
    period = late("hawk.stats.period")
    serialize = late("hawk.stats.serialize")

COMMAND: Final = "stats"


def add_stats_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(
        COMMAND, help="print occupancy, peak, load and turnover of a lot, with their intervals"
    )
    parser.add_argument("lot", type=values.some, metavar="LOT", help="name or id of the lot")
    parser.add_argument("--from", type=values.some, dest="begin", metavar="DATE", help="first day, as 2026-05-04")
    parser.add_argument("--to", type=values.some, dest="end", metavar="DATE", help="last day, as 2026-05-10")
    parser.add_argument(
        "--by", choices=PARTITIONS, help="parts to print: hours of the day, or rows, zones, kinds of stalls"
    )
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
    return run_on_store(options, lambda store: _answer(store, options))


def _answer(store: Path, options: argparse.Namespace) -> str:
    during = period.period_of(options.begin, options.end, options.time_zone)
    lots.check_there(store)
    with closing(database.Database(store)) as opened:
        lots.show_damage(opened.damage)
        with opened.reading() as connection:
            lot = names.lot_named(connection, options.lot)
            missing = observations.missing_looks(connection, lot)
        if missing and not opened.is_read_only:
            with opened.writing() as connection:
                observations.keep_looks(connection, missing)
        with opened.reading() as connection:
            found = queries.statistics(connection, lot, during, options.by)
    if options.json:
        return found.model_dump_json(indent=1)
    return serialize.figures_csv(found).rstrip("\n") if options.csv else serialize.figures_text(found)
