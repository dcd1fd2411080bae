"""The command ``hawk-drone``: runs the daemon, flies a survey, shows and checks recordings, calibrates the camera."""

from __future__ import annotations

import argparse
import asyncio
import json
import sys
from collections.abc import Sequence
from dataclasses import fields
from importlib.metadata import version
from pathlib import Path
from typing import NoReturn

from hawk.background.commands import COMMAND as MAKE_BACKGROUND
from hawk.background.commands import add_background_command
from hawk.calibrate.commands import COMMAND as CALIBRATE
from hawk.calibrate.commands import add_calibrate_command
from hawk.check.commands import CHECK_COMMANDS, add_check_commands
from hawk.config import options as values
from hawk.config.addresses import MOST_PORT
from hawk.config.loader import load_settings
from hawk.config.sections import Config, ConfigError, WebSettings
from hawk.daemon.lots.import_plan import COMMAND as IMPORT_PLAN
from hawk.daemon.lots.import_plan import add_import_command
from hawk.daemon.options import DaemonOptions
from hawk.erasure.commands import COMMAND as ERASE
from hawk.erasure.commands import add_erase_command
from hawk.exports.commands import COMMAND as EXPORT
from hawk.exports.commands import add_export_command
from hawk.formats.box import COMMAND_TOO_MUCH, enter_command
from hawk.lots.storage.commands import LOT_COMMANDS, add_lot_commands
from hawk.picture.commands import COMMAND as MAP
from hawk.picture.commands import add_map_command
from hawk.replay.commands import COMMAND as REPLAY
from hawk.replay.commands import add_replay_command
from hawk.report.commands import COMMAND as REPORT
from hawk.report.commands import add_report_command
from hawk.runtime.late import late_functions
from hawk.runtime.process import READER_GONE, end_within, lose_readers, readers_are_gone
from hawk.runtime.repeated_log import plain_lines
from hawk.sim import launch as simulator
from hawk.sim.launch import (
    SIMULATOR_MISSING,
    SPEED_HELP,
    SimulationError,
    SimulationOptions,
    SimulatorOptionError,
    simulator_installed,
)
from hawk.stats.commands import COMMAND as STATS
from hawk.stats.commands import add_stats_command
from hawk.survey.day import COMMAND as PLAN_DAY
from hawk.survey.day import add_plan_day_command
from hawk.versions.commands import VERSION_COMMANDS, add_version_commands
from hawk.web.access.commands import COMMANDS as ACCESS_COMMANDS
from hawk.web.access.commands import add_access_commands
from hawk.worlds.moment import HOURS, Condition

COMMANDS = (
    {
        "run",
        "survey",
        "desk",
        "film",
        REPLAY,
        MAKE_BACKGROUND,
        CALIBRATE,
        IMPORT_PLAN,
        EXPORT,
        STATS,
        REPORT,
        ERASE,
        MAP,
        PLAN_DAY,
    }
    | ACCESS_COMMANDS
    | CHECK_COMMANDS
    | VERSION_COMMANDS
    | LOT_COMMANDS
)
EXIT_USAGE = 2
"""Exit status for wrong options and wrong settings, as argparse has it."""
EXIT_FAILED = 1
"""Exit status when the simulation could not start."""
LONGEST_SURVEY_S = 86_400.0
"""Greatest --timeout: no battery lasts a day."""
EXIT_S = 5.0
"""Real seconds for the process to end after its work; then its threads are printed and it is ended."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return the exit status: `READER_GONE` where who read the output has ended, as ``head`` does."""
    try:
        try:
            status = _run_command(arguments)
        finally:  # argparse leaves by SystemExit
            sys.stdout.flush()
    except BrokenPipeError:  # of the output, or of a socket
        if not readers_are_gone():
            raise
        lose_readers()
        return READER_GONE
    return status


def _run_command(arguments: Sequence[str] | None) -> int:
    given = list(sys.argv[1:] if arguments is None else arguments)
    if not given or given[0] not in COMMANDS | {"-h", "--help", "--version"}:
        given.insert(0, "run")
    try:
        options = make_parser().parse_args(given)
        if arguments is None and "boxed" in options:  # a process of its own that reads strangers' files
            mib = getattr(options, "memory", None)
            enter_command(needs_network=options.boxed(options), memory_bytes=None if mib is None else int(mib * 2**20))
        return int(options.action(options))
    except MemoryError:
        print(f"hawk-drone {given[0]}: {COMMAND_TOO_MUCH}", file=sys.stderr)
        return EXIT_FAILED
    except (ConfigError, SimulationError) as error:
        words = plain_lines(str(error))
        if given[0] == MAP and "--json" in given:  # the parser may not have read it
            print(json.dumps({"event": "error", "text": words}), flush=True)
        print(f"hawk-drone: {words}", file=sys.stderr)
        return EXIT_USAGE if isinstance(error, ConfigError | SimulatorOptionError) else EXIT_FAILED


class _Parser(argparse.ArgumentParser):
    """Reports a wrong option as every wrong setting is reported: one line."""

    def error(self, message: str) -> NoReturn:
        """Raise ConfigError."""
        raise ConfigError(f"{message.removeprefix('argument ')} (see {self.prog} --help)")


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command line. It raises ConfigError for what cannot be used."""
    parser = _Parser(
        prog="hawk-drone", description=__doc__, epilog="Without a command: run. Every setting: config.toml."
    )
    parser.add_argument("--version", action="version", version=f"hawk-drone {version('hawk-drone')}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    run = commands.add_parser("run", help="run the daemon and serve the operator's page")
    run.set_defaults(action=_run)
    _add_connections(run)
    _add_daemon_options(run)
    run.add_argument("--ready-file", type=values.new(), metavar="FILE", help=argparse.SUPPRESS)
    run.add_argument("--attach-sim", metavar="URL", help=argparse.SUPPRESS)
    run.add_argument("--parent-pid", type=values.pid, metavar="PID", help=argparse.SUPPRESS)
    run.add_argument("--again", action="store_true", help="after a fault: go on with its survey, also in a simulation")
    survey = commands.add_parser("survey", help="fly a whole survey: take off, explore, come home, write the results")
    survey.set_defaults(action=_survey)
    _add_daemon_options(survey)
    _add_survey_options(survey)
    desk = commands.add_parser("desk", help="show lots and correct their plans on the page, without a drone")
    desk.set_defaults(action=_desk)
    desk.add_argument("--config", type=values.path, metavar="FILE", help="settings (TOML); without it every default")
    desk.add_argument("--host", type=values.some, help="address to serve the page on")
    desk.add_argument("--port", type=values.whole(0, MOST_PORT), help="port to serve the page on, 0 for a free one")
    desk.add_argument("--store", type=values.path, metavar="DIR", help="folder with the store of lots")
    desk.add_argument("--lot", type=values.some, metavar="LOT", help="name or id of the lot whose picture is shown")
    desk.add_argument(
        "--collect", action="store_true", help="take surveys that drones send, each by a token of its own"
    )
    add_plan_day_command(commands)
    film = commands.add_parser("film", help="write the pictures of a recording as a film (AVI)")
    film.set_defaults(action=_film)
    film.add_argument("recording", type=values.file, metavar="RECORDING", help="a file of STORE/recordings (.mcap)")
    film.add_argument("film", type=values.new(".avi"), metavar="FILM", help="the file to write (.avi)")
    add_replay_command(commands, _show_recording)
    add_map_command(commands)
    add_access_commands(commands)
    add_check_commands(commands)
    add_calibrate_command(commands)
    add_background_command(commands)
    add_lot_commands(commands)
    add_export_command(commands)
    add_import_command(commands)
    add_stats_command(commands)
    add_report_command(commands, late_functions("hawk.daemon.lots.schedule").moments_due)
    add_erase_command(commands)
    add_version_commands(commands)
    return parser


def simulation_options(options: argparse.Namespace) -> SimulationOptions | None:
    """Return the simulation's options, None without --sim. Raises ConfigError naming an option that does not fit."""
    if not options.sim:
        names = ["seed", "condition", "at", "repaint", "cars", "world", "metres_per_pixel", "start", "gnss_sigma"]
        names += ["gnss_bias", "wind", "noise_seed", "compass_error", "slope", "rangefinder"]
        names += ["truth"] if getattr(options, "url", None) is None else []
        _refuse(options, names, "only together with --sim")
        if options.speed != 1.0 and getattr(options, "attach_sim", None) is None:
            raise ConfigError("--speed: only together with --sim")
        return None
    if not simulator_installed():
        raise ConfigError(f"--sim: {SIMULATOR_MISSING}")
    if options.world is not None and options.metres_per_pixel is None:
        raise ConfigError("--metres-per-pixel: is needed with --world (metres on the ground that a pixel covers)")
    if options.world is None:
        _refuse(options, ("metres_per_pixel", "truth", "cars"), "only together with --world")
    elif options.seed is not None:
        raise ConfigError("--seed: draws a world; not together with --world (--noise-seed: errors of the sensors)")
    if options.cars is not None and options.truth is None:
        raise ConfigError("--cars: needs --truth, which says where stalls and cars are")
    _check_drawn(options)
    given = {each.name: getattr(options, each.name, None) for each in fields(SimulationOptions)}
    return SimulationOptions(**{name: value for name, value in given.items() if value is not None})


def _refuse(options: argparse.Namespace, names: Sequence[str], remedy: str) -> None:
    """Refuse options that would change nothing. Raises ConfigError naming the first that was given."""
    for name in names:
        if getattr(options, name) is not None:
            raise ConfigError(f"--{name.replace('_', '-')}: {remedy}")


def _check_drawn(options: argparse.Namespace) -> None:
    """Check the options of a drawn world. Raises ConfigError naming the one that does not fit."""
    if options.world is not None:
        _refuse(options, ("condition", "at", "repaint"), "only for drawn worlds; not together with --world")
    if options.condition is None:
        return
    if options.condition not in list(Condition):
        raise ConfigError(f"--condition: must be one of {', '.join(Condition)}, not {options.condition}")
    if options.at is not None and options.condition in HOURS:
        raise ConfigError(f"--condition: {options.condition} is a time of day, which --at says; leave one out")


def _add_daemon_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", type=values.path, metavar="FILE", help="settings (TOML); without it every default")
    parser.add_argument(
        "--fence", type=values.file, metavar="FILE", help="GeoJSON polygon that the drone must not leave"
    )
    parser.add_argument("--outline", type=values.file, metavar="FILE", help="GeoJSON polygons of the area to survey")
    _add_simulated_world(parser.add_argument_group("simulation", "fly a simulated drone instead of a real one"))


def _add_connections(parser: argparse.ArgumentParser) -> None:
    """Add what a daemon that somebody starts is connected with; a survey's own daemon has its own."""
    parser.add_argument("--host", type=values.some, help="address to serve the page on")
    parser.add_argument("--port", type=values.whole(0, MOST_PORT), help="port to serve the page on, 0 for a free one")
    parser.add_argument("--autopilot", metavar="URL", help="MAVSDK connection URL of the autopilot")
    parser.add_argument("--camera", metavar="URL", help="URL of the camera")
    parser.add_argument(
        "--store", type=values.path, metavar="DIR", help="folder for parameters, journal and recordings"
    )


def _add_simulated_world(simulated: argparse._ArgumentGroup) -> None:
    simulated.add_argument("--sim", action="store_true", help="start hawk-sim and fly it")
    simulated.add_argument("--seed", type=values.whole(), metavar="N", help="world to draw (default 1)")
    simulated.add_argument("--condition", metavar="NAME", help="day, night, snow ... over a drawn world")
    simulated.add_argument(
        "--at",
        type=simulator.moment,
        metavar="MOMENT",
        help="the drawn world at a moment, as 2026-05-04T10:30 on the lot's clock (UTC-5)",
    )
    simulated.add_argument(
        "--repaint", type=simulator.repaint, metavar="K", help="the drawn world after K changes of its layout"
    )
    simulated.add_argument("--world", type=values.file, metavar="FILE", help="fly over this picture instead")
    simulated.add_argument("--metres-per-pixel", type=simulator.scale, metavar="X", help="scale of that picture")
    simulated.add_argument("--truth", type=values.file, metavar="FILE", help="what the picture really holds (JSON)")
    simulated.add_argument(
        "--cars", type=values.whole(), metavar="SEED", help="move that picture's cars to other stalls of its truth"
    )
    simulated.add_argument(
        "--start",
        type=values.as_text(values.place),
        metavar="X,Y",
        help="where the drone stands, metres in the world's picture",
    )
    _add_simulated_sensors(simulated)


def _add_simulated_sensors(simulated: argparse._ArgumentGroup) -> None:
    simulated.add_argument("--speed", type=simulator.speed, default=1.0, metavar="N", help=SPEED_HELP)
    simulated.add_argument(
        "--gnss-sigma", type=simulator.gnss_sigma, metavar="M", help="slow error of the position, metres"
    )
    simulated.add_argument(
        "--gnss-bias",
        type=values.as_text(simulator.gnss_bias),
        metavar="N,E",
        help="constant error of GNSS, north and east, metres",
    )
    simulated.add_argument(
        "--compass-error",
        type=simulator.compass_error,
        metavar="DEG",
        help="constant error of all compasses, clockwise, -30 to 30",
    )
    simulated.add_argument(
        "--noise-seed", type=values.whole(), metavar="N", help="of the errors of position and sensors (default: --seed)"
    )
    simulated.add_argument("--wind", type=simulator.wind, metavar="M/S", help="mean wind, metres per second")
    simulated.add_argument(
        "--slope",
        type=values.as_text(simulator.slope),
        metavar="PERCENT,DEG",
        help="the ground rises towards this direction",
    )
    simulated.add_argument(
        "--rangefinder", type=simulator.rangefinder, metavar="M", help="reach of a rangefinder that looks down"
    )


def _add_survey_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", type=values.path, required=True, metavar="DIR", help="folder for the results")
    parser.add_argument("--url", type=values.some, metavar="URL", help="fly the drone of a daemon that runs already")
    parser.add_argument("--token", type=values.some, help="the operator's token of that daemon")
    parser.add_argument(
        "--certificate",
        type=values.file,
        metavar="FILE",
        help="trust this certificate of that daemon alone (self-signed)",
    )
    parser.add_argument(
        "--continue",
        dest="continues",
        action="store_true",
        help="go on with the survey that an earlier flight left, after a battery swap; fly no other",
    )
    parser.add_argument(
        "--again",
        action="append",
        type=values.some,
        metavar="LOT",
        help="survey this known lot (its name or id) again: the shortest flight that looks at every stall; given "
        "several times, the lots are one flight",
    )
    parser.add_argument("--due", action="store_true", help="the same for all lots inside the fence that are due")
    parser.add_argument("--set-failsafes", action="store_true", help="set the autopilot's failsafes that are missing")
    parser.add_argument(
        "--timeout",
        dest="timeout_s",
        type=values.number(1, LONGEST_SURVEY_S),
        default=1800.0,
        metavar="S",
        help="seconds of exploring until it comes home anyway",
    )
    parser.add_argument("--quiet", action="store_true", help="no progress bar")


def _run(options: argparse.Namespace) -> int:
    if options.sim:
        _refuse(options, ("autopilot", "camera"), "not together with --sim, which flies a simulated drone of its own")
    config = load_settings(options)
    simulation = simulation_options(options)
    from hawk.daemon.start import run_daemon  # all of the daemon: other commands do not wait for it

    given = DaemonOptions(
        simulation,
        attached_simulation=options.attach_sim,
        speed=options.speed,
        ready_file=options.ready_file,
        parent_pid=options.parent_pid,
        is_again=options.again,
    )
    status = asyncio.run(run_daemon(config, given))
    end_within(EXIT_S, sys.stderr)  # a thread that hangs in a library would keep the process
    return status


def _desk(options: argparse.Namespace) -> int:
    config = load_settings(options)
    from hawk.daemon.desk import run_desk  # SQLAlchemy and the web server

    return asyncio.run(run_desk(config, options.lot, collects=options.collect))


def _show_recording(recording: Path, port: int) -> int:
    from hawk.daemon.desk import run_replay

    return asyncio.run(run_replay(Config(web=WebSettings(port=port)), recording))


def _survey(options: argparse.Namespace) -> int:
    simulation = simulation_options(options)
    if simulation is None and options.url is None:
        raise ConfigError("--url: is needed without --sim (the page's address of the daemon that flies the drone)")
    if simulation is not None and options.url is not None:
        raise ConfigError("--url: not together with --sim, which starts a daemon of its own")
    if options.url is None:
        _refuse(options, ("token", "certificate"), "only together with --url")
    else:
        _refuse(options, ("config", "fence"), "a setting of the daemon at --url: give it to that daemon")
    if options.due:
        _refuse(options, ("again",), "not together with --due, which chooses the lots")
    if options.again or options.due:
        _refuse(options, ("outline",), "not together with --again and --due, which survey the ground of lots")
    config = load_settings(options)  # a wrong setting shows here, before anything is started
    if options.url is None:
        from hawk.daemon.start_checks import check_background, check_files  # as much to load

        check_files(config)
        check_background(config.web)
    from hawk.survey.run import SurveyOptions, run_survey  # the web client

    given = {each.name: getattr(options, each.name) for each in fields(SurveyOptions) if each.name != "simulation"}
    given["set_failsafes"] |= simulation is not None
    return asyncio.run(run_survey(SurveyOptions(simulation=simulation, **given)))


def _film(options: argparse.Namespace) -> int:
    from hawk.store.film import FilmError, write_film  # OpenCV
    from hawk.store.replay import RecordingError

    try:
        made = write_film(options.recording, options.film)
    except (FilmError, RecordingError) as error:
        print(f"hawk-drone film: {error}", file=sys.stderr)
        return EXIT_FAILED
    lost = f", {made.unreadable} could not be read" if made.unreadable else ""
    print(f"{options.film}: {made.pictures} pictures, {made.seconds:.1f} s{lost}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
