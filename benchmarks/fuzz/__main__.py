"""Fuzzed input at the daemon's front door.

``python -m benchmarks.fuzz [--messages 1000000] [--seed 1] [--first 0] [--json FILE]``

Messages of operators with faults, random JSON, noise and binary go over a WebSocket to the real server, judge and
states of a drone that hovers; HTTP requests and WebSocket frames with faults go over connections beside. Nothing may
raise, every message is answered once, every refusal names the field or the reason, and a second client's commands are
all answered. A finding names its case: ``--first N --messages 32`` sends it again. Status 1 when there is one.
"""

from __future__ import annotations

import argparse
import asyncio
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks.figures import Figure, Limit, Section, tell
from benchmarks.fuzz.run import Result, Run

EXIT_FAILED = 1


def main(arguments: Sequence[str] | None = None) -> int:
    """Send, print, write."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.fuzz", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--messages", type=int, default=1_000_000, help="how many (default 1000000)")
    parser.add_argument("--seed", type=int, default=1, help="of the cases (default 1)")
    parser.add_argument("--first", type=int, default=0, help="number of the first case (default 0)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every figure as one flat object")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory(prefix="hawk-fuzz-") as folder:
        run = Run(Path(folder), options.seed, options.messages, options.first)
        result = asyncio.run(run.run(_progress))
    tell([Section("fuzz", figures(result), "; ".join(result.findings))], options.json)
    return EXIT_FAILED if result.findings else 0


def figures(result: Result) -> list[Figure]:
    """Return the figures of a run."""
    return [
        Figure("fuzz_messages", "messages", float(result.messages)),
        Figure("fuzz_connections", "connections with faults", float(result.connections)),
        Figure("fuzz_accepted", "accepted", float(result.accepted)),
        Figure("fuzz_refused", "refused", float(result.refused)),
        Figure("fuzz_reasons", "different beginnings of reasons", float(len(result.reasons))),
        Figure("fuzz_witnessed", "commands of the second client, answered", float(result.witnessed)),
        Figure("fuzz_per_s", "messages a second", result.messages / result.seconds if result.seconds else None, "1/s"),
        Figure("fuzz_memory_mb", "growth of memory after the first tenth", result.memory_mb, "MB"),
        Figure("fuzz_findings", "findings", float(len(result.findings)), limit=Limit(highest=0.0)),
    ]


def _progress(result: Result) -> None:
    line = f"{result.messages} messages, {result.seconds:.0f} s, {len(result.findings)} findings"
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
