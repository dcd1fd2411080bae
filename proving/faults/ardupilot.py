"""``python -m proving.faults.ardupilot``: flies a real ArduCopter with the whole daemon, and writes a table."""

from __future__ import annotations

import argparse
import asyncio
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from hawk.runtime.process import SIMULATOR_NICENESS, set_session_niceness
from hawk.sim.launch import SimulationOptions
from proving.faults.fault import Fault, Outcome
from proving.faults.record import DOCS, REAL, keep_outcome, name_of, read_outcomes, with_words
from proving.faults.report import names, reporter, rewrite, short_table, summary, table
from proving.faults.run import ALL, SEED, START, run_faults
from proving.faults.table_vehicle import VEHICLE
from proving.faults.vehicle import ArduCopter, can_be_given

EXIT_USAGE = 2
PAGE: Final = DOCS / "ardupilot.md"
BEGIN: Final = "<!-- `make ardupilot` writes from here ... -->"
DEFAULTS: Final = "copter.parm"
MISSING: Final = "set ARDUPILOT=/path/to/arducopter, ArduPilot's program for software-in-the-loop (docs/ardupilot.md)"


class UsageError(Exception):
    """An option that cannot be used; the text names it."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run by command line; return the exit status: 1 when a flight did not end as it must, 2 for wrong options."""
    options = make_parser().parse_args(arguments)
    flights = selected(options.only, fitting(ALL) if options.others else ())
    if options.list or options.table:
        print("\n".join(names(flights)) if options.list else table(read_outcomes(REAL, flights)))
        return 0
    try:
        copter, world = copter_of(options), world_of(options)
        if not flights:
            raise UsageError(f"no flight has these words: {', '.join(options.only)}; --list shows all")
    except UsageError as error:
        print(f"proving.faults.ardupilot: {error}", file=sys.stderr)
        return EXIT_USAGE
    set_session_niceness(SIMULATOR_NICENESS)  # the proxy is part of the link, and must not delay it
    folder = options.out or Path(tempfile.mkdtemp(prefix="hawk-ardupilot-"))
    report = reporter(keep if options.write else lambda _: None)
    outcomes = asyncio.run(run_faults(flights, folder, world, report, copter))
    passed = all(outcome.passed for outcome in outcomes)
    print(summary(outcomes) + ("" if passed else f"; logs: {folder}"))
    if passed and options.out is None:
        shutil.rmtree(folder, ignore_errors=True)
    return 0 if passed else 1


def keep(outcome: Outcome) -> None:
    """Keep an outcome and write the page's table again."""
    known = selected((), fitting(ALL))
    keep_outcome(REAL, outcome, known)
    rewrite(PAGE, short_table(read_outcomes(REAL, known)), BEGIN)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(prog="python -m proving.faults.ardupilot", description=__doc__)
    parser.add_argument("only", nargs="*", metavar="WORDS", help="fly only those with these words in their line")
    parser.add_argument("--program", metavar="FILE", default="", help="ArduPilot's arducopter for SITL")
    parser.add_argument(
        "--defaults", metavar="FILE", default="", help=f"its parameters (default: {DEFAULTS} beside the program)"
    )
    parser.add_argument("--instance", type=int, default=0, metavar="N", help="shifts its own ports by 10 N (default 0)")
    parser.add_argument(
        "--others", action="store_true", help="also the faults of docs/faults.md that a real vehicle can be given"
    )
    parser.add_argument("--list", action="store_true", help="print the flights, fly none")
    parser.add_argument(
        "--table", action="store_true", help="print what must be seen and what was measured last, fly none"
    )
    parser.add_argument("--out", type=Path, help="folder for the programs' logs and files")
    parser.add_argument("--write", action="store_true", help=f"keep the outcomes ({REAL.name}), write {PAGE.name}")
    parser.add_argument("--world", type=Path, metavar="FILE", help="fly over this picture, in place of a drawn lot")
    parser.add_argument("--metres-per-pixel", type=float, metavar="X", help="scale of that picture")
    parser.add_argument("--truth", type=Path, metavar="FILE", help="what the picture really holds (JSON)")
    parser.add_argument("--start", metavar="X,Y", help="where the drone stands, metres in the picture")
    return parser


def fitting(faults: Sequence[Fault]) -> tuple[Fault, ...]:
    """Return the faults of the simulated drone that a real one can be given, and that it has no flight for."""
    known = set(names(VEHICLE))
    return tuple(fault for fault in faults if name_of(fault) not in known and can_be_given(fault))


def selected(words: Sequence[str], others: Sequence[Fault] = ()) -> tuple[Fault, ...]:
    """Return the flights that have one of these words in their line; all without words. ``others`` come last."""
    return with_words((*VEHICLE, *others), words)


def copter_of(options: argparse.Namespace) -> ArduCopter:
    """Return the vehicle. Raises UsageError naming what to set."""
    if not options.program:
        raise UsageError(MISSING)
    program = Path(options.program)
    if not program.is_file():
        raise UsageError(f"{program} is not a file: {MISSING}")
    defaults = Path(options.defaults) if options.defaults else program.with_name(DEFAULTS)
    if not defaults.is_file():
        raise UsageError(
            f"{defaults} is not a file: set DEFAULTS=/path/to/{DEFAULTS}, ArduPilot's parameters of the copter"
        )
    return ArduCopter(program, defaults, options.instance)


def world_of(options: argparse.Namespace) -> SimulationOptions:
    """Return the world: drawn, or a picture with its scale. Raises UsageError."""
    if options.world is None:
        for name in ("metres_per_pixel", "truth", "start"):
            if getattr(options, name) is not None:
                raise UsageError(f"--{name.replace('_', '-')}: only together with --world")
        return SimulationOptions(seed=SEED, start=START)
    if options.metres_per_pixel is None:
        raise UsageError("--metres-per-pixel: is needed with --world")
    return SimulationOptions(
        world=options.world, metres_per_pixel=options.metres_per_pixel, truth=options.truth, start=options.start
    )


if __name__ == "__main__":
    sys.exit(main())
