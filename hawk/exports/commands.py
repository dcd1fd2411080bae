"""The command ``hawk-drone export``: a survey as a file that other programs open, or pictures with labels."""

from __future__ import annotations

import argparse
import sys
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hawk.config import options as values
from hawk.config.loader import config_of
from hawk.exports.formats import WRITTEN
from hawk.runtime.late import late

if TYPE_CHECKING:  # they load numpy and SQLAlchemy: not for the other commands
    from hawk.exports import files, records
    from hawk.lots import names, training_set
    from hawk.lots import store as lots
    from hawk.lots import values as errors
    from hawk.lots.storage import database
    from hawk.lots.survey import pictures
else:
    files = late("hawk.exports.files")
    records = late("hawk.exports.records")
    database = late("hawk.lots.storage.database")
    names = late("hawk.lots.names")
    pictures = late("hawk.lots.survey.pictures")
    training_set = late("hawk.lots.training_set")
    lots = late("hawk.lots.store")
    errors = late("hawk.lots.values")

COMMAND: Final = "export"
_NEWEST: Final = "newest"
_ALL: Final = "all"
_FAILED: Final = 1


def add_export_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    export = commands.add_parser(COMMAND, help="write a survey of a lot as a file for other programs")
    export.add_argument("lot", type=values.some, metavar="LOT", help="name or id of the lot")
    what = export.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "--out", type=values.new(*WRITTEN), metavar="FILE",
        help="the file to write: .csv, .geojson, .gpkg, .kmz, .png (the lot's picture), .tif (the mosaic as Cloud "
        "Optimised GeoTIFF, with NAME-occupancy.tif and the STAC item NAME.json)",
    )  # fmt: skip
    what.add_argument(
        "--training", type=values.new_folder, metavar="DIR",
        help="folder to write pictures of the lot with its confirmed stalls as labels into, NAME.jpg and NAME.json, as "
        "training/ reads them; new or empty",
    )  # fmt: skip
    export.add_argument(
        "--survey", type=values.some, metavar="ID", default=_NEWEST,
        help="id of the survey, or its beginning (the last one that is registered); all: every registered one, as one "
        ".gpkg; with --out",
    )  # fmt: skip
    values.add_settings(export)
    export.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    config = config_of(options)
    if options.training is not None and options.survey != _NEWEST:
        print("hawk-drone: --survey: only together with --out: --training takes every survey", file=sys.stderr)
        return 2
    try:
        store = lots.lots_file(config.store.directory, config.store.lots)
        lots.check_there(store)
        print(_teach(store, options) if options.training is not None else _export(store, options))
    except errors.LotStoreError as error:
        print(f"hawk-drone: {error}", file=sys.stderr)
        return _FAILED
    except OSError as error:
        named = error.filename or options.out or options.training
        print(f"hawk-drone: {named}: {error.strerror or error}", file=sys.stderr)
        return _FAILED
    return 0


def _export(store: Path, options: argparse.Namespace) -> str:
    with closing(database.Database(store)) as opened, opened.reading() as connection:
        lots.show_damage(opened.damage)
        lot = names.lot_named(connection, options.lot)
        if options.survey == _ALL:
            surveys = records.surveys_of(connection, lot)
            written, shown = files.export_all(connection, surveys, options.out), f"surveys: {len(surveys)}"
        else:
            survey = records.survey_of(connection, lot, options.survey)
            written, shown = (
                files.export(connection, survey, pictures.pictures_of(store), options.out),
                f"survey {survey}",
            )
    sizes = (f"{path}: {path.stat().st_size / 1e6:.2f} MB" for path in written)
    return "\n".join([shown, *sizes])


def _teach(store: Path, options: argparse.Namespace) -> str:
    with closing(database.Database(store)) as opened, opened.reading() as connection:
        lots.show_damage(opened.damage)
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
