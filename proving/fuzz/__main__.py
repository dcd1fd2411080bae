"""Fuzzed input at the daemon's front door.

``python -m proving.fuzz [--messages 1000000] [--datagrams 1000000] [--seed 1] [--first 0] [--json FILE]``

Messages of operators with faults, random JSON, noise and binary go over a WebSocket to the real server, judge and
states of a drone that hovers; HTTP requests and WebSocket frames with faults go over connections beside. Nothing may
raise, every message is answered once, every refusal names the field or the reason, and a second client's commands are
all answered. Then datagrams go to the autopilot's port: MAVLink with random fields, damaged frames, noise, those of
other vehicles and of a stranger. Nothing may raise, an honest heartbeat is heard after each 64, no stranger is
believed, and the pose is honest again afterwards. A finding names its case: ``--first N --messages 32 --datagrams 64``
sends it again. Status 1 when there is one.

``python -m proving.fuzz files`` sends damaged files to their readers (`proving.fuzz.files`).
"""

from __future__ import annotations

import asyncio
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks.figures import Figure, Limit, Section, print_and_write
from benchmarks.options import make_parser
from proving.fuzz.link import LinkResult, LinkRun
from proving.fuzz.run import Result, Run


def main(arguments: Sequence[str] | None = None) -> int:
    """Send, print, write."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given[:1] == ["files"]:
        from proving.fuzz.files import main as fuzz_files

        return fuzz_files(given[1:])
    parser = make_parser("proving.fuzz", __doc__)
    parser.add_argument("--messages", type=int, default=1_000_000, help="of operators (default 1000000)")
    parser.add_argument("--datagrams", type=int, default=1_000_000, help="of the autopilot (default 1000000)")
    parser.add_argument("--seed", type=int, default=1, help="of the cases (default 1)")
    parser.add_argument("--first", type=int, default=0, help="number of the first case (default 0)")
    options = parser.parse_args(given)
    sections = []
    if options.messages:
        with tempfile.TemporaryDirectory(prefix="hawk-fuzz-") as folder:
            run = Run(Path(folder), options.seed, options.messages, options.first)
            result = asyncio.run(run.run(_progress))
        sections.append(Section("fuzz: operators", figures(result), "; ".join(result.findings)))
    if options.datagrams:
        link = asyncio.run(LinkRun(options.seed, options.datagrams, options.first).run(_link_progress))
        sections.append(Section("fuzz: the autopilot's port", link_figures(link), "; ".join(link.findings)))
    return print_and_write(sections, options.json)


def figures(result: Result) -> list[Figure]:
    """Return the figures of a run."""
    return [
        Figure("fuzz_messages", "messages", float(result.messages)),
        Figure("fuzz_connections", "connections with faults", float(result.connections)),
        Figure("fuzz_accepted", "accepted", float(result.accepted)),
        Figure("fuzz_refused", "refused", float(result.refused)),
        Figure("fuzz_reasons", "different beginnings of reasons", float(len(result.reasons))),
        Figure("fuzz_witnessed", "commands of the second client, answered", float(result.witnessed)),
        Figure("fuzz_per_s", "messages a second", _rate(result.messages, result.seconds), "1/s"),
        Figure("fuzz_memory_mb", "growth of memory after the first tenth", result.memory_mb, "MB"),
        Figure("fuzz_findings", "findings", float(len(result.findings)), limit=Limit(highest=0.0)),
    ]


def link_figures(result: LinkResult) -> list[Figure]:
    """Return the figures of a run at the link."""
    return [
        Figure("fuzz_datagrams", "datagrams", float(result.datagrams)),
        Figure("fuzz_strange", "of a stranger", float(result.strange)),
        Figure("fuzz_honest", "honest heartbeats between them", float(result.honest)),
        Figure("fuzz_states", "states published", float(result.states)),
        Figure("fuzz_datagrams_per_s", "datagrams a second", _rate(result.datagrams, result.seconds), "1/s"),
        Figure("fuzz_link_findings", "findings", float(len(result.findings)), limit=Limit(highest=0.0)),
    ]


def _rate(count: int, seconds: float) -> float | None:
    return count / seconds if seconds else None


def _link_progress(result: LinkResult) -> None:
    line = f"{result.datagrams} datagrams, {result.seconds:.0f} s, {len(result.findings)} findings"
    print(line, file=sys.stderr, flush=True)


def _progress(result: Result) -> None:
    line = f"{result.messages} messages, {result.seconds:.0f} s, {len(result.findings)} findings"
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
