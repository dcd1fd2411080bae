"""The command ``hawk-drone export``: a survey as a file that other programs open, a feed, or pictures with labels."""

from __future__ import annotations

import argparse
import sys
import time
from contextlib import closing
from pathlib import Path
from typing import Any, Final

from hawk.config import options as values
from hawk.config.loader import config_of
from hawk.exports.feed_table import FEEDS, VALID_S, Wanted

COMMAND: Final = "export"
_ENDS: Final = (".csv", ".geojson", ".gpkg", ".kmz", ".png", ".tif")
_ALL: Final = "all"
_FAILED: Final = 1


def add_export_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    export = commands.add_parser(COMMAND, help="write a survey of a lot as a file for other programs")
    export.add_argument("lot", type=values.some, metavar="LOT", help="name or id of the lot")
    what = export.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "--out", type=values.new(*_ENDS), metavar="FILE",
        help="the file to write: .csv, .geojson, .gpkg, .kmz, .png (the lot's picture), .tif (the mosaic as Cloud "
        "Optimised GeoTIFF, with NAME-occupancy.tif and the STAC item NAME.json)",
    )  # fmt: skip
    what.add_argument(
        "--training", type=values.new_folder, metavar="DIR",
        help="folder to write pictures of the lot with its confirmed stalls as labels into, NAME.jpg and NAME.json, as "
        "training/ reads them; new or empty",
    )  # fmt: skip
    what.add_argument(
        "--feed", choices=tuple(FEEDS), help="print the lot in the words of a receiver, as the API's feed of this name"
    )
    export.add_argument(
        "--survey", type=values.some, metavar="ID",
        help="id of the survey, or its beginning (the last one that is registered); all: every registered one, as one "
        ".gpkg; with --out, or with --feed for one survey",
    )  # fmt: skip
    feed = export.add_argument_group("with --feed")
    feed.add_argument(
        "--valid-s", type=values.number(1.0), metavar="SECONDS",
        help=f"age of a look from which its state is unknown ({VALID_S:g}); of a feed over a survey",
    )  # fmt: skip
    feed.add_argument("--from", type=values.some, dest="begin", metavar="DATE", help="first day, of one over a period")
    feed.add_argument("--to", type=values.some, dest="end", metavar="DATE", help="last day, of one over a period")
    feed.add_argument("--time-zone", type=values.some, metavar="NAME", help="clock of the days (this computer's)")
    values.add_settings(export)
    export.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    from hawk.lots.store import check_there, lots_file  # loads numpy: not for the other commands
    from hawk.lots.values import LotStoreError

    config = config_of(options)
    if options.training is not None and options.survey is not None:
        print("hawk-drone: --survey: only together with --out or --feed: --training takes all", file=sys.stderr)
        return 2
    given = next((f"--{name}" for name, value in _of_feeds(options).items() if value is not None), None)
    if options.feed is None and given is not None:
        print(f"hawk-drone: {given}: only together with --feed", file=sys.stderr)
        return 2
    work = _feed if options.feed is not None else _export if options.training is None else _teach
    try:
        store = lots_file(config.store.directory, config.store.lots)
        check_there(store)
        print(work(store, options))
    except LotStoreError as error:
        print(f"hawk-drone: {error}", file=sys.stderr)
        return _FAILED
    except OSError as error:
        named = error.filename or options.out or options.training
        print(f"hawk-drone: {named}: {error.strerror or error}", file=sys.stderr)
        return _FAILED
    return 0


def _of_feeds(options: argparse.Namespace) -> dict[str, Any]:
    values = (options.valid_s, options.begin, options.end, options.time_zone)
    return dict(zip(("valid-s", "from", "to", "time-zone"), values, strict=True))


def _feed(store: Path, options: argparse.Namespace) -> str:
    from hawk.exports.feeds import feed_text
    from hawk.lots.database import Database
    from hawk.lots.store import show_damage
    from hawk.lots.teaching import lot_named

    with closing(Database(store)) as database, database.reading() as connection:
        show_damage(database.damage)
        lot = lot_named(connection, options.lot)
        wanted = Wanted(lot, options.survey, *_of_feeds(options).values())
        return feed_text(connection, options.feed, wanted, time.time()).rstrip("\n")


def _export(store: Path, options: argparse.Namespace) -> str:
    from hawk.exports.files import export, export_all
    from hawk.exports.reading import NEWEST, survey_of, surveys_of
    from hawk.lots.database import Database
    from hawk.lots.pictures import pictures_of
    from hawk.lots.store import show_damage
    from hawk.lots.teaching import lot_named

    with closing(Database(store)) as database, database.reading() as connection:
        show_damage(database.damage)
        lot = lot_named(connection, options.lot)
        if options.survey == _ALL:
            surveys = surveys_of(connection, lot)
            written, shown = export_all(connection, surveys, options.out), f"surveys: {len(surveys)}"
        else:
            survey = survey_of(connection, lot, options.survey or NEWEST)
            written, shown = export(connection, survey, pictures_of(store), options.out), f"survey {survey}"
    sizes = (f"{path}: {path.stat().st_size / 1e6:.2f} MB" for path in written)
    return "\n".join([shown, *sizes])


def _teach(store: Path, options: argparse.Namespace) -> str:
    from hawk.exports.files import written_to
    from hawk.lots.database import Database
    from hawk.lots.pictures import pictures_of
    from hawk.lots.store import show_damage
    from hawk.lots.teaching import lot_named, read_lesson, write_lesson

    with closing(Database(store)) as database, database.reading() as connection:
        show_damage(database.damage)
        lesson = read_lesson(connection, lot_named(connection, options.lot))
    with written_to(options.training, "--training"):
        taught = write_lesson(lesson, pictures_of(store), options.training)
    return "\n".join(
        [
            f"{options.training}: pictures with labels: {len(taught.pictures)}",
            *([f"surveys without a picture: {taught.gone}"] if taught.gone else []),
            *([f"surveys from before new paint: {taught.painted}"] if taught.painted else []),
            f"Train on from them: python -m training.adapt {options.training} --out FILE",
        ]
    )
