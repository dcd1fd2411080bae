"""``python -m proving.faults``: runs every fault, or those that are named; keeps and shows what was measured."""

from __future__ import annotations

import argparse
import asyncio
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from hawk.sim.launch import SimulationOptions
from proving.faults import shown_by_tests
from proving.faults.fault import Fault, Outcome
from proving.faults.page import rows, section
from proving.faults.record import DOCS, SIMULATED, keep_outcome, read_outcomes, with_words
from proving.faults.report import names, reporter, rewrite, summary, table
from proving.faults.run import ALL, SEED, START, run_faults

PAGE: Final = DOCS / "faults.md"
TESTS: Final = DOCS.parent / "tests"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run by command line; return the exit status: 1 when a fault did not end as it must."""
    parser = make_parser()
    options = parser.parse_args(arguments)
    faults = with_words(ALL, options.only)
    if options.tests:
        print(shown_by_tests.table(shown_by_tests.shown_by_tests(TESTS)))
    elif options.page:
        write_page()
    elif not faults:
        parser.error(f"no fault has these words: {', '.join(options.only)}; --list without words shows all")
    elif options.list:
        print("\n".join(names(faults)))
    elif options.table:
        print(table(each for each in read_outcomes(SIMULATED, ALL) if each.fault in faults))
    else:
        return fly(faults, options)
    return 0


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(prog="python -m proving.faults", description=__doc__)
    parser.add_argument("only", nargs="*", metavar="WORDS", help="only faults with these words in their line")
    parser.add_argument("--list", action="store_true", help="print the faults, run none")
    parser.add_argument(
        "--table", action="store_true", help="print what must be seen and what was measured last, run none"
    )
    parser.add_argument("--tests", action="store_true", help="print the faults that tests show, run none")
    parser.add_argument("--page", action="store_true", help=f"write {PAGE.name} again from the last outcomes, run none")
    parser.add_argument("--write", action="store_true", help=f"keep the outcomes ({SIMULATED.name}), write {PAGE.name}")
    parser.add_argument("--speed", type=float, default=3.0, help="the drone's seconds per real second (default 3)")
    parser.add_argument("--out", type=Path, help="folder for the programs' logs and files")
    return parser


def fly(faults: Sequence[Fault], options: argparse.Namespace) -> int:
    """Run these faults; return the exit status."""

    def keep(outcome: Outcome) -> None:
        if options.write:
            keep_outcome(SIMULATED, outcome, ALL)

    world = SimulationOptions(seed=SEED, start=START, speed=options.speed)
    with tempfile.TemporaryDirectory(prefix="hawk-faults-") as folder:
        outcomes = asyncio.run(run_faults(faults, options.out or Path(folder), world, reporter(keep)))
    print(summary(outcomes))
    if options.write:
        write_page()
    return 0 if all(outcome.passed for outcome in outcomes) else 1


def write_page() -> None:
    """Write the page's rows again, from the last outcomes."""
    rewrite(PAGE, section(rows(ALL), read_outcomes(SIMULATED, ALL)))


if __name__ == "__main__":
    sys.exit(main())
