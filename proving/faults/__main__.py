"""``python -m proving.faults``: runs every fault, or those that are named, and prints or writes their table."""

from __future__ import annotations

import argparse
import asyncio
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from hawk.sim.launch import SimulationOptions
from proving.faults.report import names, reporter, summary
from proving.faults.run import ALL, SEED, START, run_faults


def main(arguments: Sequence[str] | None = None) -> int:
    """Run by command line; return the exit status: 1 when a fault did not end as it must."""
    parser = argparse.ArgumentParser(prog="python -m proving.faults", description=__doc__)
    parser.add_argument("only", nargs="*", metavar="WORDS", help="run only faults with these words in their line")
    parser.add_argument("--list", action="store_true", help="print the faults, run none")
    parser.add_argument("--speed", type=float, default=3.0, help="the drone's seconds per real second (default 3)")
    parser.add_argument("--out", type=Path, help="folder for the programs' logs and files")
    parser.add_argument("--write", type=Path, metavar="PAGE", help="write the table into the marked section of a page")
    options = parser.parse_args(arguments)
    faults = [
        fault
        for fault, name in zip(ALL, names(ALL), strict=True)
        if not options.only or any(words in name for words in options.only)
    ]
    if not faults:
        parser.error(f"no fault has these words: {', '.join(options.only)}; --list without words shows all")
    if options.list:
        print("\n".join(names(faults)))
        return 0
    world = SimulationOptions(seed=SEED, start=START, speed=options.speed)
    with tempfile.TemporaryDirectory(prefix="hawk-faults-") as folder:
        outcomes = asyncio.run(run_faults(faults, options.out or Path(folder), world, reporter(options.write, ALL)))
    print(summary(outcomes))
    return 0 if all(outcome.passed for outcome in outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
