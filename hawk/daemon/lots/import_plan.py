"""The command ``hawk-drone import-plan``: stalls and sections of an owner's plan from a file into a lot.

It works while the daemon runs, as `hawk-drone backup` does. Nothing is written by ``--dry-run``.
"""

from __future__ import annotations

import argparse
import asyncio
import time
from collections import Counter
from typing import TYPE_CHECKING, Any, Final

from hawk.config import options as values
from hawk.lots.storage.commands import run_on_store
from hawk.runtime.late import late

if TYPE_CHECKING:  # loaded by the command: numpy and the store are not for the others
    from sqlalchemy import Connection

    from hawk.daemon.lots import keeper
    from hawk.lots import names
    from hawk.lots import store as lots
    from hawk.lots.plan import edits
    from hawk.lots.plan_files import child, formats
    from hawk.lots.plan_import import choices, previews, transfer
    from hawk.lots.plan_import.choices import ImportAsked
    from hawk.lots.plan_import.previews import Preview
    from hawk.lots.store import LotStore
else:
    keeper = late("hawk.daemon.lots.keeper")
    names = late("hawk.lots.names")
    lots = late("hawk.lots.store")
    edits = late("hawk.lots.plan.edits")
    child = late("hawk.lots.plan_files.child")
    formats = late("hawk.lots.plan_files.formats")
    choices = late("hawk.lots.plan_import.choices")
    previews = late("hawk.lots.plan_import.previews")
    transfer = late("hawk.lots.plan_import.transfer")

COMMAND: Final = "import-plan"
_SHOWN: Final = 20
"""Features that are named in each list of the output."""
_TEXTS: Final = ("layer", "units", "label", "crs")


def add_import_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(
        COMMAND, help="import an owner's plan (GeoJSON, GeoPackage, KML, DXF, OpenStreetMap's XML) into a lot"
    )
    parser.add_argument("file", type=values.file, metavar="FILE", help="the file with the plan")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--lot", type=values.some, metavar="LOT", help="id or name of the lot")
    where.add_argument("--new", type=values.some, metavar="NAME", help="make a new lot of it, with this name")
    parser.add_argument("--layer", type=values.some, metavar="NAME", help="read this layer alone")
    parser.add_argument("--units", type=values.some, metavar="UNIT", help="of a drawing: m, cm, mm, dm, ft, in")
    parser.add_argument("--label", type=values.some, metavar="NAME", help="property that has the labels")
    parser.add_argument("--crs", type=values.some, metavar="NAME", help="system of the coordinates, as EPSG:25832")
    parser.add_argument(
        "--pin",
        action="append",
        default=[],
        metavar="X,Y,LAT,LON",
        help="a point of the drawing and its place on Earth; twice, for a plan without coordinates",
    )
    parser.add_argument("--replace", action="store_true", help="end stalls and sections on its ground that it has not")
    parser.add_argument("--rename", action="store_true", help="put a number behind labels and names that others keep")
    parser.add_argument("--uncertain", action="store_true", help="take it where its place is not certain, too")
    parser.add_argument("--who", type=values.some, default="hawk-drone", metavar="NAME", help="the one who imports")
    parser.add_argument("--dry-run", action="store_true", help="show what would change, write nothing")
    values.add_settings(parser)
    parser.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    return run_on_store(options, lambda store: asyncio.run(_import(lots.LotStore(store, keeper.find_stalls), options)))


async def _import(store: LotStore, options: argparse.Namespace) -> str:
    given = {name: getattr(options, name) for name in _TEXTS if getattr(options, name) is not None}
    given |= {name: "1" for name in ("replace", "rename") if getattr(options, name)}
    asked = choices.asked_of({"name": options.file.name, **given}, options.pin)
    formats.check_size(options.file.stat().st_size)
    try:
        log = options.file.with_name(f"{options.file.name}-wal")
        packed = await child.read_apart(options.file.read_bytes(), asked.file, log=log if log.is_file() else None)
        if not options.dry_run:
            return await store.write(lambda connection: _taken(connection, packed, asked, options, store))
        _shown(await store.read(lambda c: _tried(c, packed, asked, options, store), lots.FILE_S))
        return ""
    finally:
        await store.close()


def _previewed(
    connection: Connection, packed: bytes, asked: ImportAsked, options: argparse.Namespace, store: LotStore
) -> Preview:
    lot = None if options.lot is None else names.lot_named(connection, options.lot)
    return previews.preview(connection, lot, child.unpacked(packed), asked, store.register)


def _tried(
    connection: Connection, packed: bytes, asked: ImportAsked, options: argparse.Namespace, store: LotStore
) -> Preview:
    """Return the preview of an import that would be taken."""
    found = _previewed(connection, packed, asked, options, store)
    if found.lot is None:
        transfer.new_ground(connection, found)
    return found


def _taken(
    connection: Connection, packed: bytes, asked: ImportAsked, options: argparse.Namespace, store: LotStore
) -> str:
    """Import the plan in one transaction, and return words about it."""
    now = time.time()
    found = _previewed(connection, packed, asked, options, store)
    _shown(found)
    if found.lot is None:
        made = transfer.begin(connection, found, {"name": options.new}, options.who, now)
        return f"{options.new} is made, with {_parts(made.stalls, made.sections)}: lot {made.lot}, change {made.seq}"
    edit = edits.open_edit(connection, found.lot, {"who": options.who}, now).edit
    transfer.take(connection, found, {"edit": edit, "uncertain": options.uncertain}, now)
    why = f"imported from {asked.name}"[:80]
    closed = edits.close(connection, found.lot, {"edit": edit, "why": why}, now)
    if closed.layout is None:
        return "nothing is changed: the lot has this plan already"
    return f"the plan is version {closed.layout} of the layout, change {closed.seq}"


def _shown(found: Preview) -> None:
    """Print what an import would change."""
    shown = previews.shown_preview(found, "")
    place = shown.placed
    parts = _parts(len(found.plan.stalls), len(found.plan.sections))
    print(f"{shown.file}: {parts} ({shown.format}), placed by {place.by}")
    if place.doubt:
        print(f"  not certain where it lies on the lot: {place.doubt}; --uncertain takes it as it lies")
    elif place.on:
        words = f"moved {place.north} m north, {place.east} m east, turned {place.turn}°"
        print(f"  {words}: as the {'stalls of the lot' if place.on == 'stalls' else 'newest survey'}")
    if found.plan.stalls:
        print(_effects("stalls", len(shown.begin), len(shown.stay), shown.same, len(shown.end)))
    if found.plan.sections:
        effects = Counter(each.change for each in shown.sections)
        print(_effects("sections", effects["begin"], effects["stay"], shown.same_sections, effects["end"]))
    for title, named, count in (
        ("left out", shown.left_out, shown.left_out_count), ("refused", shown.clashes, shown.clash_count),
    ):  # fmt: skip
        for each in named[:_SHOWN]:
            print(f"  {title}: {each.name}: {each.reason}")
        if count > _SHOWN:
            print(f"  {title}: {count - min(_SHOWN, len(named))} more")
    for words in shown.notes:
        print(f"  assumed: {words}")
    for layer in shown.layers:
        print(f"  layer {layer.name}: {layer.outlines} outlines")


def _parts(stalls: int, sections: int) -> str:
    return f"{stalls} stalls and {sections} sections" if sections else f"{stalls} stalls"


def _effects(words: str, begin: int, change: int, same: int, end: int) -> str:
    return f"  {words}: {begin} begin, {change} stay and change, {same} are so already, {end} end"
