"""The command ``hawk-drone map``: pictures that others took become a survey.

Other commands pay nothing for it: what reads and maps pictures is imported when it is run.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import re
import sys
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pydantic import TypeAdapter

from hawk.config import options as values
from hawk.config.addresses import MOST_PORT, check_place
from hawk.config.loader import load_settings
from hawk.config.sections import ConfigError
from hawk.picture.inbox.folder import SETTLE_S
from hawk.picture.work_folder import is_ours, kept_source, name_of, other_private, other_source
from hawk.runtime.late import late
from hawk.runtime.process import ParentGoneError, kill_with_parent

if TYPE_CHECKING:
    from hawk.daemon import desk, start_checks
    from hawk.formats import remote_raster
    from hawk.picture import files, ingest, lot_files, lot_report, progress, report, sources
    from hawk.picture import values as errors
    from hawk.picture.city import check_files, scheduler
    from hawk.picture.inbox import commands as inbox
else:
    desk = late("hawk.daemon.desk")
    start_checks = late("hawk.daemon.start_checks")
    remote_raster = late("hawk.formats.remote_raster")
    check_files = late("hawk.picture.city.check_files")
    files = late("hawk.picture.files")
    ingest = late("hawk.picture.ingest")
    lot_files = late("hawk.picture.lot_files")
    lot_report = late("hawk.picture.lot_report")
    progress = late("hawk.picture.progress")
    report = late("hawk.picture.report")
    sources = late("hawk.picture.sources")
    errors = late("hawk.picture.values")
    scheduler = late("hawk.picture.city.scheduler")
    inbox = late("hawk.picture.inbox.commands")

COMMAND: Final = "map"
PARTLY: Final = 3
"""Exit status when a part of the source could not be mapped."""
_FAILED: Final = 1
_STOPPED: Final = 130
"""Exit status after Ctrl-C, as shells have it."""
_MOST_WORKERS: Final = 256
_MOST_CHECKED: Final = 2_000
_LEAST_MIB: Final = 500.0
_PASSED_ON: Final = ("height", "lenses", "calibration", "place", "model", "hfov", "focal35", "memory")
_SCHEDULER: Final = re.compile(r"(tcp|tls)://(\[[0-9A-Fa-f:.]+\]|[^\s:/\[\]]+):([0-9]{1,5})/?")
_HIGHEST_M: Final = 500.0
_LONGEST_S: Final = 86_400.0


def add_map_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(COMMAND, help="find the stalls in photographs, a film or an orthophoto")
    parser.add_argument(
        "source", type=_source, metavar="SOURCE", nargs="?",
        help="an orthophoto (GeoTIFF, VRT, JPEG or PNG with a world file; https:// and s3:// "
        "with --allow-host), a folder of a drone's photographs, a film "
        "(.mp4, .mov) with its .srt or a flight log, a recording (.mcap), or the folder of a WebODM project",
    )  # fmt: skip
    parser.add_argument(
        "--out", type=values.path, metavar="DIR",
        help="folder for the table, GeoJSON, GeoPackage, KMZ, picture and report; new or empty, or with --resume",
    )  # fmt: skip
    parser.add_argument("--resume", action="store_true", help="go on with the work that --out holds")
    parser.add_argument("--json", action="store_true", help="print progress and the report as lines of JSON")
    parser.add_argument("--name", type=values.some, metavar="NAME", help="name of the lot (that of the folder or file)")
    parser.add_argument(
        "--taken", type=values.past, metavar="TIME",
        help="time of the last picture, 2026-05-04T10:30+02:00, where the files give none or a clock without a zone",
    )  # fmt: skip
    parser.add_argument("--model", type=values.file, metavar="FILE", help="a network (.onnx) in place of hawk's")
    parser.add_argument(
        "--private", type=values.file, metavar="FILE",
        help="areas that nobody may look at, as gardens (GeoJSON, GeoPackage, KML): no picture shows them, nothing is "
        "counted there",
    )  # fmt: skip
    _add_orthophoto(parser.add_argument_group("orthophotos"))
    _add_photographs(parser.add_argument_group("photographs and films"))
    _add_store(parser.add_argument_group("store and page"))
    _add_inbox(parser.add_argument_group("inbox"))
    parser.set_defaults(action=_run, boxed=_needs_network)


def _add_orthophoto(group: Any) -> None:
    group.add_argument(
        "--outline", type=values.file, metavar="FILE",
        help="map only these lots: GeoJSON, GeoPackage, KML or OpenStreetMap's XML with amenity=parking",
    )  # fmt: skip
    group.add_argument(
        "--check", type=values.whole(1, _MOST_CHECKED), metavar="N",
        help="draw N windows for checking by eye into --out/check, more where the network is less sure",
    )  # fmt: skip
    group.add_argument(
        "--allow-host", type=_host, action="append", metavar="HOST",
        help="host that may be asked for the picture (https://, s3://), or for what a VRT names; repeat it for more",
    )  # fmt: skip
    group.add_argument("--seed", type=values.whole(0), metavar="N", help="seed of that drawing (1)")
    group.add_argument(
        "--checked", type=values.file, metavar="FILE",
        help="check/windows.csv with the counts by eye filled in: the report has the totals by them",
    )  # fmt: skip
    group.add_argument(
        "--crs", type=values.some, metavar="SYSTEM", help="system of coordinates where the file says none, EPSG:25832"
    )
    group.add_argument(
        "--workers", type=values.whole(1, _MOST_WORKERS), metavar="N", help="processes on this computer (1)"
    )
    group.add_argument(
        "--scheduler", type=_scheduler, metavar="ADDRESS", help="a Dask scheduler whose workers do it, tls://HOST:8786"
    )
    for name, words in (
        ("--tls-ca-file", "authority of the scheduler's certificate (PEM)"),
        ("--tls-cert", "certificate that the scheduler asks for (PEM)"),
        ("--tls-key", "key of that certificate (PEM)"),
    ):
        group.add_argument(name, type=values.file, metavar="FILE", help=words)


def _add_photographs(group: Any) -> None:
    group.add_argument(
        "--height", type=values.number(3.0, _HIGHEST_M), metavar="METRES",
        help="height of the middle photograph above the ground, where the files give none or a wrong one",
    )  # fmt: skip
    group.add_argument("--lenses", type=values.file, metavar="FILE", help="a table of lenses (docs/photographs.md)")
    group.add_argument("--calibration", type=values.file, metavar="FILE", help="lens of all pictures (ROS camera_info)")
    group.add_argument(
        "--group", type=values.whole(1), metavar="NUMBER", help="the flight or camera of a mixed folder to map"
    )
    group.add_argument(
        "--place", choices=("exif", "xmp"), help="which tags have the right place, where EXIF and XMP differ"
    )
    group.add_argument(
        "--log", type=values.file, metavar="FILE",
        help="captions (.srt) or ArduPilot log (.tlog, .bin) of a film; its own name beside it is found",
    )  # fmt: skip
    group.add_argument(
        "--log-offset", type=values.number(-_LONGEST_S, _LONGEST_S), metavar="SECONDS",
        help="second of the log at which the film begins, where their motion does not show it",
    )  # fmt: skip
    group.add_argument(
        "--hfov", type=values.number(5.0, 160.0), metavar="DEGREES", help="field of view across a film's picture"
    )
    group.add_argument(
        "--focal35", type=values.number(8.0, 500.0), metavar="MM", help="focal length of a film on 35 mm film"
    )


def _add_store(group: Any) -> None:
    group.add_argument(
        "--store", type=values.path, metavar="DIR", help="store the survey among the lots of this folder"
    )
    group.add_argument("--page", action="store_true", help="show the survey on the page, without a drone, until Ctrl-C")
    group.add_argument("--port", type=values.whole(0, MOST_PORT), metavar="PORT", help="port of that page")


def _add_inbox(group: Any) -> None:
    group.add_argument(
        "--watch", type=values.folder, metavar="DIR",
        help="in place of SOURCE and --out: map each flight that arrives in this folder into --store, and move it to "
        "done/ or failed/ there, with a report",
    )  # fmt: skip
    group.add_argument(
        "--settle", type=values.number(1.0, _LONGEST_S), metavar="SECONDS",
        help=f"without a change of its files a flight has arrived ({SETTLE_S:.0f})",
    )  # fmt: skip
    group.add_argument(
        "--memory", type=values.number(_LEAST_MIB), metavar="MIB",
        help="memory that mapping may take (four fifths of what is free)",
    )  # fmt: skip
    group.add_argument("--flight", type=_flight, metavar="JSON", help=argparse.SUPPRESS)
    group.add_argument("--parent-pid", type=values.pid, metavar="PID", help=argparse.SUPPRESS)


def _source(text: str) -> Path | remote_raster.RemoteRaster:
    if "://" in text or text.startswith("/vsi"):
        said = remote_raster.without_secrets(text)
        try:
            named = remote_raster.RemoteRaster.of(text)
        except remote_raster.RemoteError as error:
            raise argparse.ArgumentTypeError(f"{said} {error}") from None
        if named is None:
            words = "is on another computer, which is not asked: copy the picture here, or name https:// or s3://"
            raise argparse.ArgumentTypeError(f"{said} {words}")
        return named
    found = values.path(text)
    if not found.exists():
        raise argparse.ArgumentTypeError(f"{text} is not there: name a picture, a film or a folder")
    return found


def _host(text: str) -> remote_raster.AllowedHost:
    if "://" in text:
        raise argparse.ArgumentTypeError("name the host alone, as tiles.example or tiles.example:8080")
    try:
        return remote_raster.AllowedHost(*check_place(text))
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _flight(text: str) -> errors.FlightId:
    try:
        return TypeAdapter(errors.FlightId).validate_json(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"is no identity of a flight: {error}") from None


def _scheduler(text: str) -> str:
    found = _SCHEDULER.fullmatch(text)
    if found is None or not 0 < int(found[3]) <= MOST_PORT:
        raise argparse.ArgumentTypeError(f"{text} is no address of a scheduler; give it as tls://HOST:PORT")
    return text.rstrip("/")


def _needs_network(options: argparse.Namespace) -> bool:
    return options.page or bool(options.allow_host) or options.scheduler is not None or (options.workers or 1) > 1


def _run(options: argparse.Namespace) -> int:
    if options.parent_pid is not None:
        try:
            kill_with_parent(options.parent_pid)
        except ParentGoneError as error:
            _say_error(options, str(error))
            return _FAILED
    if options.watch is not None:
        _check_watch(options)
        _check_store(options.store)
        return inbox.watch(options, _passed_on(options))
    try:
        stored = ingest.private_areas(options.store)
    except errors.PictureError as error:
        _say_error(options, str(error))
        return _FAILED
    _check(options)
    asked = sources.MapRequest(
        source=options.source, out=options.out, model=options.model, outline=options.outline,
        private=options.private, check=options.check, checked=options.checked, crs=options.crs,
        workers=options.workers, scheduler=_named_scheduler(options), height_m=options.height, lenses=options.lenses,
        calibration=options.calibration, group=options.group, place=options.place, log=options.log,
        log_offset_s=options.log_offset, hfov_deg=options.hfov, focal35_mm=options.focal35, name=options.name,
        taken=options.taken, flight=options.flight, allow_host=_hosts(options) or None,
        stored=stored,
    )  # fmt: skip
    try:
        with kept_source(options.out, options.source, options.private):
            with progress.shown_progress(sys.stdout if options.json else sys.stderr, as_json=options.json) as show:
                mapped = _checked(options, sources.survey_of_source(asked, show))
            kept = _write(options, mapped)
            _draw_check(options, mapped)
    except errors.PictureError as error:
        _say_error(options, str(error))
        return _FAILED
    except KeyboardInterrupt:
        _say_error(options, "stopped; go on by --resume")
        return _STOPPED
    if options.page:
        return _show(options, kept)
    return PARTLY if mapped.left_out else 0


def _checked(options: argparse.Namespace, mapped: errors.PictureSurvey) -> errors.PictureSurvey:
    """Return a survey with the totals by windows that were checked by eye. Raises PictureError."""
    if options.checked is None or mapped.sample is None:
        return mapped
    found = check_files.read_check(mapped.sample, options.checked)
    return replace(mapped, checked=found.values(), notes=(*mapped.notes, found.words))


def _draw_check(options: argparse.Namespace, mapped: errors.PictureSurvey) -> None:
    """Write the windows for checking by eye where they are asked for. Raises PictureError."""
    if options.check is None or mapped.sample is None:
        return
    folder = check_files.write_check(
        mapped.sample, options.out, options.check, 1 if options.seed is None else options.seed
    )
    words = f"{folder}: count by eye, fill in {check_files.TABLE}, and name it by --checked with --resume"
    print(json.dumps({"event": "check", "folder": str(folder)}) if options.json else words)


def _hosts(options: argparse.Namespace) -> remote_raster.Hosts:
    return tuple(options.allow_host or ())


def _check_host(options: argparse.Namespace) -> None:
    """Refuse a source of a host that is not allowed. Raises ConfigError."""
    if isinstance(options.source, Path):
        return
    if options.source.is_s3:
        is_closed, host = not options.allow_host, "s3.REGION.amazonaws.com"
    else:
        host, port = options.source.place()
        is_closed = not any(allowed.fits(host, port) for allowed in _hosts(options))
        host = host if port in (80, 443) else f"{host}:{port}"
    if is_closed:
        words = (
            f"is on another computer, which is not asked: copy the picture here, or allow its host: --allow-host {host}"
        )
        raise ConfigError(f"SOURCE: {options.source} {words}")


def _check_watch(options: argparse.Namespace) -> None:
    """Refuse options that an inbox has no use for. Raises ConfigError naming one and the remedy."""
    own = {"watch", "settle", "store", "json", "action", "boxed", *_PASSED_ON}
    for name, value in vars(options).items():
        if name not in own and value not in (None, False):
            raise ConfigError(f"{_written(name)}: not together with --watch, which maps every flight")
    if options.store is None:
        raise ConfigError("--store: is needed with --watch: name the folder of the store of lots")
    watched = options.watch.resolve()
    for name, path in (("the store", options.store), ("a home folder", Path.home())):
        if path.resolve().is_relative_to(watched):
            raise ConfigError(f"--watch: {options.watch} holds {name}, whose files would be moved; name a new folder")


def _written(name: str) -> str:
    """Return an option as it is written on the command line."""
    return "SOURCE" if name == "source" else f"--{name.replace('_', '-')}"


def _passed_on(options: argparse.Namespace) -> dict[str, str]:
    """Return the options that hold for the flights of an inbox, by name."""
    given = {name: getattr(options, name) for name in _PASSED_ON}
    return {name: str(value) for name, value in given.items() if value is not None}


def _check(options: argparse.Namespace) -> None:
    """Refuse options that do not fit together. Raises ConfigError naming one and the remedy."""
    for name in ("source", "out"):
        if getattr(options, name) is None:
            raise ConfigError(f"{_written(name)}: is needed without --watch (see map --help)")
    _check_host(options)
    if options.settle is not None:
        raise ConfigError("--settle: only together with --watch")
    is_file = options.out.exists() and not options.out.is_dir()
    if is_file or not options.resume:
        try:
            values.new_folder(str(options.out))
        except argparse.ArgumentTypeError as error:
            resumed = "" if is_file else ", or go on with its work by --resume"
            raise ConfigError(f"--out: {error}{resumed}") from None
    elif not is_ours(options.out):
        raise ConfigError(
            f"--out: {options.out} holds other files, and no work that --resume can go on with; name the folder of "
            "that work, or a new one without --resume"
        )
    elif (other := other_source(options.out, options.source)) is not None:
        is_alike = other == name_of(options.source)
        words = f"{other} with other pictures" if is_alike else other
        raise ConfigError(f"--out: {options.out} holds the work on {words}; name another folder")
    elif problem := other_private(options.out, options.private):
        raise ConfigError(f"--private: {problem}")
    if options.seed is not None and options.check is None:
        raise ConfigError("--seed: only together with --check")
    if options.store is not None:
        _check_store(options.store)
    if options.scheduler is not None and options.workers is not None:
        raise ConfigError("--workers: not together with --scheduler, which has its own")
    _check_scheduler(options)
    if options.port is not None and not options.page:
        raise ConfigError("--port: only together with --page")
    if options.page:
        _check_port(options)


def _named_scheduler(options: argparse.Namespace) -> scheduler.Scheduler | None:
    pems = (options.tls_ca_file, options.tls_cert, options.tls_key)
    return None if options.scheduler is None else scheduler.Scheduler(options.scheduler, *pems)


def _check_scheduler(options: argparse.Namespace) -> None:
    """Refuse a scheduler that others can use, and files without one. Raises ConfigError."""
    for name in ("tls_ca_file", "tls_cert", "tls_key"):
        if getattr(options, name) is not None and options.scheduler is None:
            raise ConfigError(f"--{name.replace('_', '-')}: only together with --scheduler")
    try:
        if (named := _named_scheduler(options)) is not None:
            named.check()
    except errors.PictureError as error:
        raise ConfigError(str(error)) from error


def _check_store(folder: Path) -> None:
    """Make the folder of the store before the work begins. Raises ConfigError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        words = f"{folder} cannot be made ({error.strerror or error}); name a folder that this user may write"
        raise ConfigError(f"--store: {words}") from None
    if not os.access(folder, os.W_OK):
        raise ConfigError(f"--store: {folder} cannot be written; name a folder that this user may write")


def _check_port(options: argparse.Namespace) -> None:
    """Find before the work whether the page can be served. Raises ConfigError."""
    try:
        start_checks.check_port(load_settings(_desk(options)).web)
    except ConfigError as error:
        raise ConfigError(str(error).replace("web.port", "--port", 1)) from None


def _write(options: argparse.Namespace, mapped: errors.PictureSurvey) -> ingest.StoredSurvey | None:
    """Write the files, store the survey where that is asked for, and report. Raises PictureError."""
    program = f"hawk-drone {version('hawk-drone')}"
    if mapped.lots is not None:
        _write_lots(options, mapped, mapped.lots, program)
        return None
    kept = None
    written = files.write_files(mapped, options.out, program)
    if options.store is not None or options.page:
        kept = ingest.store_survey(mapped.landed, _store_folder(options), options.name)
        doubted = kept.said_of(mapped)
        if doubted.survey.doubt != mapped.survey.doubt:  # files are there, whatever the store does
            mapped, written = doubted, files.write_files(doubted, options.out, program)
    if options.json:
        paths = [str(path) for path in written]
        said = {"event": "report", **report.report(mapped, program), "files": paths, "store": kept and kept.words}
        said |= {"stored_survey": kept and kept.survey}
        print(json.dumps(said))
        return kept
    print(report.text(mapped))
    print(f"{options.out}: {', '.join(path.name for path in written)}")
    if kept is not None:
        print(kept.words)
    return kept


def _write_lots(
    options: argparse.Namespace, mapped: errors.PictureSurvey, lots: errors.LotSurveys, program: str
) -> None:
    """Write, store and report the surveys of several lots. Raises PictureError, after the files where the store fails.

    Each lot's survey is made, drawn and stored before the next one: all of them need more memory than there is.
    """
    store = ingest.LotsStore(_store_folder(options) if options.store is not None or options.page else None)
    with store:
        counts = lot_files.count_lots(lots, options.out, store.keep)
    written = lot_files.write_lots(mapped, counts, options.out, program)
    if store.failure is not None:
        raise store.failure
    if options.json:
        paths = [str(path) for path in written]
        said = {"event": "report", **lot_report.lots_report(mapped, counts, program), "files": paths}
        print(json.dumps({**said, "store": store.words}))
        return
    print(lot_report.lots_text(mapped, counts))
    print(f"{options.out}: {', '.join(path.name for path in written)}, and pictures of lots in {files.LOTS}")
    if store.words:
        print(store.words)


def _store_folder(options: argparse.Namespace) -> Path:
    return options.store if options.store is not None else Path(options.out) / "store"


def _show(options: argparse.Namespace, stored: ingest.StoredSurvey | None) -> int:
    """Serve the page from the store until a signal."""
    lot, survey = (None, None) if stored is None else (stored.lot, stored.survey)
    return asyncio.run(desk.run_desk(load_settings(_desk(options)), lot, survey))


def _desk(options: argparse.Namespace) -> argparse.Namespace:
    """Return the options of the command that serves the page."""
    return argparse.Namespace(config=None, host=None, port=options.port, store=_store_folder(options))


def _say_error(options: argparse.Namespace, words: str) -> None:
    if options.json:
        print(json.dumps({"event": "error", "text": words}))
    print(f"hawk-drone {COMMAND}: {words}", file=sys.stderr)
