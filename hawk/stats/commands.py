"""The command ``hawk-drone stats``: figures of a lot's use, of its stalls and its sections."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

from pydantic import BaseModel

from hawk.config import options as values
from hawk.config.sections import ConfigError
from hawk.lots.storage.commands import run_on_store
from hawk.runtime.late import late
from hawk.stats.partition import PARTITIONS

if TYPE_CHECKING:  # they load numpy and SQLAlchemy: not for the other commands
    from sqlalchemy import Connection

    from hawk.lots import names
    from hawk.lots import store as lots
    from hawk.lots.storage import database
    from hawk.lots.survey import observations
    from hawk.stats import period, queries, serialize, use_query
    from hawk.stats.use_query import Asked
else:
    database = late("hawk.lots.storage.database")
    observations = late("hawk.lots.survey.observations")
    names = late("hawk.lots.names")
    lots = late("hawk.lots.store")
    queries = late("hawk.stats.queries")
    period = late("hawk.stats.period")
    use_query = late("hawk.stats.use_query")
    serialize = late("hawk.stats.serialize")

COMMAND: Final = "stats"
_PARTS: Final = ("row", "zone", "kind", "section")
A = TypeVar("A", bound=BaseModel)


def add_stats_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(
        COMMAND, help="print occupancy, peak, load and turnover of a lot, with their intervals"
    )
    parser.add_argument("lot", type=values.some, metavar="LOT", help="name or id of the lot")
    add_period(parser)
    parser.add_argument(
        "--by", choices=PARTITIONS, help="parts to print: hours of the day, rows, zones, kinds of stalls, or sections"
    )
    add_question(parser)
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--csv", action="store_true", help="print CSV")
    form.add_argument("--json", action="store_true", help="print every figure as JSON")
    values.add_settings(parser)
    parser.set_defaults(action=_run)


def add_period(parser: argparse.ArgumentParser) -> None:
    """Add the options of a period and its clock."""
    parser.add_argument("--from", type=values.some, dest="begin", metavar="DATE", help="first day, as 2026-05-04")
    parser.add_argument("--to", type=values.some, dest="end", metavar="DATE", help="last day, as 2026-05-10")
    parser.add_argument(
        "--time-zone", type=values.some, metavar="NAME",
        help="clock of hours and days, as Europe/Amsterdam; without it the lot's",
    )  # fmt: skip


def add_question(parser: argparse.ArgumentParser) -> None:
    """Add the options of a question about a lot's use."""
    asked = parser.add_argument_group(
        "how full parts of the lot are at some hours of the week, as a sentence and a table"
    )
    asked.add_argument("--weekday", type=values.some, metavar="DAYS", help="days, as mon-fri, sat or mon,wed (all)")
    asked.add_argument("--hour", type=values.some, metavar="HOURS", help="hours, as 7-11, 8 or 7-9,16-18 (all)")
    for name in _PARTS:
        asked.add_argument(
            f"--{name}", type=values.some, action="append", metavar="NAME",
            help=f"{name}, as stats --by {name} names it; again for another one (all)",
        )  # fmt: skip


_ASKED: Final = ("weekday", "hour", *_PARTS)


def _run(options: argparse.Namespace) -> int:
    options.is_asked = any(getattr(options, name) is not None for name in _ASKED)
    if options.is_asked and options.by is not None:
        names = ", ".join(f"--{name}" for name in _ASKED)
        raise ConfigError(f"--by: not together with {names}: leave it out, or these")
    return run_on_store(options, lambda store: _answer(store, options))


def asked_of(options: argparse.Namespace) -> Asked:
    """Return the question of the options, once the period was found good. Raises LotInputError."""
    period.period_of(options.begin, options.end, options.time_zone or "UTC")  # wrong whatever the store holds
    parts = (getattr(options, name) or () for name in _PARTS)
    return use_query.asked_of(options.weekday, options.hour, *parts)


@contextmanager
def reading(store: Path, options: argparse.Namespace) -> Iterator[tuple[Connection, str]]:
    """Open a store, and give one view of it and the id of the lot of the options, whose looks are in one piece.

    Raises LotStoreError, NotFoundError.
    """
    with reading_lots(store, (options.lot,)) as (connection, (lot,)):
        yield connection, lot


@contextmanager
def reading_lots(store: Path, given: Sequence[str] | None) -> Iterator[tuple[Connection, list[str]]]:
    """Open a store, and give one view of it and the ids of some lots, by name or id, as `reading`; None: of all lots.

    Raises LotStoreError, NotFoundError.
    """
    lots.check_there(store)
    with closing(database.Database(store)) as opened:
        lots.show_damage(opened.damage)
        with opened.reading() as connection:
            if given is None:
                found = names.lots_by_name(connection)
            else:
                found = [names.lot_named(connection, each) for each in given]
            missing = [seq for lot in found for seq in observations.missing_looks(connection, lot)]
        if missing and not opened.is_read_only:
            with opened.writing() as connection:
                observations.keep_looks(connection, missing)
        with opened.reading() as connection:
            yield connection, found


def _answer(store: Path, options: argparse.Namespace) -> str:
    asked = asked_of(options)
    with reading(store, options) as (connection, lot):
        during = period.period_of_lot(connection, lot, options.begin, options.end, options.time_zone)
        if options.is_asked:
            answer = queries.ask(connection, lot, during, asked)
            return _shown(options, answer, serialize.asked_csv, serialize.asked_text)
        found = queries.statistics(connection, lot, during, options.by)
        return _shown(options, found, serialize.figures_csv, serialize.figures_text)


def _shown(
    options: argparse.Namespace, answer: A, table: Callable[[A], str], text: Callable[[A], str]
) -> str:  # fmt: skip
    if options.json:
        return answer.model_dump_json(indent=1)
    return table(answer).rstrip("\n") if options.csv else text(answer)
