"""The command ``hawk-drone export``: a survey as a file that other programs open, a feed, or pictures with labels."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hawk.config import options as values
from hawk.config.sections import ConfigError
from hawk.exports.formats import FEEDS, VALID_S, WRITTEN, Wanted
from hawk.lots.storage.commands import reading_there, run_on_store
from hawk.runtime.late import late

if TYPE_CHECKING:  # they load numpy and SQLAlchemy: not for the other commands
    from hawk.exports import feeds, files, records
    from hawk.lots import names, training_set
    from hawk.lots.survey import pictures
else:
    feeds = late("hawk.exports.feeds")
    files = late("hawk.exports.files")
    records = late("hawk.exports.records")
    names = late("hawk.lots.names")
    pictures = late("hawk.lots.survey.pictures")
    training_set = late("hawk.lots.training_set")

COMMAND: Final = "export"
_ALL: Final = "all"


def add_export_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    export = commands.add_parser(COMMAND, help="write a survey of a lot as a file for other programs")
    export.add_argument("lot", type=values.some, metavar="LOT", help="name or id of the lot")
    what = export.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "--out", type=values.new(*WRITTEN), metavar="FILE",
        help="the file to write: .csv, .geojson, sections.csv, sections.geojson (what was counted in sections), .gpkg, "
        ".kmz, .png (the lot's picture), .tif (the mosaic as Cloud "
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
    feed.add_argument("--time-zone", type=values.some, metavar="NAME", help="clock of the days (the lot's)")
    values.add_settings(export)
    export.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    if options.training is not None and options.survey is not None:
        raise ConfigError("--survey: only together with --out or --feed: --training takes all")
    given = next((f"--{name}" for name, value in _of_feeds(options).items() if value is not None), None)
    if options.feed is None and given is not None:
        raise ConfigError(f"{given}: only together with --feed")
    work = _feed if options.feed is not None else _export if options.training is None else _teach
    return run_on_store(options, lambda store: work(store, options))


def _of_feeds(options: argparse.Namespace) -> dict[str, Any]:
    values = (options.valid_s, options.begin, options.end, options.time_zone)
    return dict(zip(("valid-s", "from", "to", "time-zone"), values, strict=True))


def _feed(store: Path, options: argparse.Namespace) -> str:
    with reading_there(store) as connection:
        lot = names.lot_named(connection, options.lot)
        wanted = Wanted(lot, options.survey, *_of_feeds(options).values())
        return feeds.feed_text(connection, options.feed, wanted, time.time()).rstrip("\n")


def _export(store: Path, options: argparse.Namespace) -> str:
    with reading_there(store) as connection:
        lot = names.lot_named(connection, options.lot)
        if options.survey == _ALL:
            surveys = records.surveys_of(connection, lot)
            written, shown = files.export_all(connection, surveys, options.out), f"surveys: {len(surveys)}"
        else:
            survey = records.survey_of(connection, lot, options.survey or records.NEWEST)
            written = files.export(connection, survey, pictures.pictures_of(store), options.out)
            shown = f"survey {survey}"
    sizes = (f"{path}: {path.stat().st_size / 1e6:.2f} MB" for path in written)
    return "\n".join([shown, *sizes])


def _teach(store: Path, options: argparse.Namespace) -> str:
    with reading_there(store) as connection:
        lesson = training_set.read_lesson(connection, names.lot_named(connection, options.lot))
    with files.written_to(options.training, "--training"):
        taught = training_set.write_lesson(lesson, pictures.pictures_of(store), options.training)
    return "\n".join(
        [
            f"{options.training}: pictures with labels: {len(taught.pictures)}",
            *([f"surveys without a picture: {taught.gone}"] if taught.gone else []),
            *([f"surveys from before new paint: {taught.painted}"] if taught.painted else []),
            f"Train on from them: python -m training.adapt {options.training} --out FILE",
        ]
    )
