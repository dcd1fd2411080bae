"""All measurements of a flight in one table.

``python -m benchmarks [--only latency,kill,...] [--places DIR] [--json FILE]`` (``make bench ARGS="--json FILE"``)

latency: the whole daemon at speed 1 with a page, beside an idle loop. flood: its tick while eight viewers send commands
without end, beside the tick before. kill: the operator's Kill through the whole daemon while vision works and 16 slow
clients watch. perception: the network on still frames of the drawn worlds of --seeds, and on the pictures of --places,
--tiles and --negatives (``python -m benchmarks.perception`` has more of it). exploration: the planner alone over lots
of known shape (``python -m benchmarks.exploration`` has more of it). chain: vision, mapper and planner flown over drawn
worlds with drifting GNSS, the fused map beside single frames (``python -m benchmarks.chain_flight``). seeds: whole
surveys of drawn worlds at speed 2 against their truth. places: the same over the pictures of --places (PLACE.jpg with
PLACE.json). Measure on a machine with nothing else to do: a section says VOID when others worked beside it.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import sys
import tempfile
from collections.abc import Awaitable, Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import cv2

from benchmarks import flood, kill_under_load, surveys, whole_daemon
from benchmarks.chain_flight import campaign as chain
from benchmarks.exploration import campaign
from benchmarks.figures import BenchmarkError, Figure, Section, print_and_write
from benchmarks.options import make_parser, names_option, seeds_option
from benchmarks.perception.sections import Material, network_sections
from hawk.algo.vision.network import StallNetwork
from hawk.config.options import as_text, whole
from hawk.sim import launch as simulator
from hawk.worlds.moment import Condition

Result = tuple[list[Figure], str]
SECTIONS: Final = ("latency", "flood", "kill", "perception", "exploration", "chain", "seeds", "places")
EXIT_FAILED: Final = 1


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, write; return 1 when a section could not be measured. The others are printed all the same."""
    parser = options_of()
    options = parser.parse_args(arguments)
    chosen = _chosen(parser, options)
    with _folder(options.keep) as folder:
        sections = [_run(name, _work(name, options, folder)) for name in chosen]
    print_and_write(sections, options.json)
    return EXIT_FAILED if any(not section.figures for section in sections) else 0


def _chosen(parser: argparse.ArgumentParser, options: argparse.Namespace) -> list[str]:
    """Return the sections that were asked for; without a word all that can be measured."""
    if options.only is None:
        return [name for name in SECTIONS if name != "places" or options.places is not None]
    if "places" in options.only and options.places is None:
        parser.error("argument --only: places are flown over pictures: say with --places DIR where they are")
    return [name for name in SECTIONS if name in options.only]


def options_of() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = make_parser("benchmarks", __doc__)
    parser.add_argument("--only", type=names_option(SECTIONS), metavar="A,B", help=f"of {', '.join(SECTIONS)}")
    parser.add_argument("--seconds", type=float, default=60.0, help="latency, flood: how long to measure (60)")
    parser.add_argument("--seed", type=int, default=1, help="latency, flood, kill: the world to fly over (1)")
    parser.add_argument("--kills", type=int, default=60, help="kill: how many, 5 s each (default 60)")
    parser.add_argument(
        "--lots", type=seeds_option, default="1-6", metavar="A-B", help="exploration: lots to fly over (1-6)"
    )
    parser.add_argument(
        "--chain",
        type=seeds_option,
        default="1-6",
        metavar="A-B",
        help="chain: worlds to fly the algorithms over (1-6)",
    )
    parser.add_argument(
        "--seeds", type=seeds_option, default="1-5", metavar="A-B", help="seeds: worlds to survey (1-5)"
    )
    parser.add_argument("--condition", type=Condition, choices=list(Condition), help="seeds: time of day and weather")
    parser.add_argument("--at", type=simulator.moment, metavar="MOMENT", help="seeds: the worlds at a moment")
    parser.add_argument("--repaint", type=simulator.repaint, metavar="K", help="seeds: after K changes of the layout")
    parser.add_argument("--cars", type=whole(), metavar="SEED", help="places: with their cars moved to other stalls")
    parser.add_argument(
        "--gnss-bias", type=as_text(simulator.gnss_bias), metavar="N,E", help="seeds: constant error of GNSS, metres"
    )
    parser.add_argument(
        "--compass-error", type=simulator.compass_error, metavar="DEG", help="seeds: constant error of the compasses"
    )
    parser.add_argument("--gnss-sigma", type=float, metavar="M", help="seeds: slow error of the position")
    parser.add_argument(
        "--places", type=Path, metavar="DIR", help="perception, places: pictures with truth to fly over (default none)"
    )
    parser.add_argument("--tiles", type=Path, metavar="DIR", help="perception: labelled tiles (default none)")
    parser.add_argument("--negatives", type=Path, metavar="DIR", help="perception: pictures without stalls")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep logs, maps and reports there")
    return parser


@contextlib.contextmanager
def _folder(keep: Path | None) -> Iterator[Path]:
    """Make a new folder: a daemon that finds a journal goes on with its survey."""
    if keep is None:
        with tempfile.TemporaryDirectory(prefix="hawk-bench-") as made:
            yield Path(made)
    else:
        keep.mkdir(parents=True, exist_ok=True)
        kept = Path(tempfile.mkdtemp(prefix="bench-", dir=keep))
        print(f"logs, maps and reports: {kept}", file=sys.stderr, flush=True)
        yield kept


def _work(name: str, options: argparse.Namespace, folder: Path) -> Callable[[], Awaitable[Result]]:
    async def perception() -> Result:
        return _perception(options), ""

    async def exploration() -> Result:
        return campaign.measure(options.lots), ""

    async def chain_flights() -> Result:
        return chain.measure(options.chain), ""

    return {
        "perception": perception,
        "chain": chain_flights,
        "exploration": exploration,
        "latency": lambda: whole_daemon.measure(options.seconds, options.seed, folder / "latency"),
        "flood": lambda: flood.measure(options.seconds, options.seed, folder / "flood"),
        "kill": lambda: kill_under_load.measure(options.kills, options.seed, folder / "kill"),
        "seeds": lambda: surveys.measure(options.seeds, folder / "seeds", _simulated(options)),
        "places": lambda: surveys.measure_places(options.places, folder / "places", options.cars),
    }[name]


def _perception(options: argparse.Namespace) -> list[Figure]:
    """Measure perception; in JSON its figures begin with ``perception_``, since surveys have figures of like names."""
    material = Material(lots=options.places, tiles=options.tiles, negatives=options.negatives, seeds=options.seeds)
    cv2.setNumThreads(1)  # milliseconds are those of one core
    sections = network_sections(StallNetwork.load(None), material)
    return [
        replace(figure, key=f"perception_{figure.key}", text=f"{section.name}: {figure.text}")
        for section in sections
        for figure in section.figures
    ]


def _simulated(options: argparse.Namespace) -> list[str]:
    names = ("condition", "at", "repaint", "gnss_sigma", "gnss_bias", "compass_error")
    given = ((f"--{name.replace('_', '-')}", getattr(options, name)) for name in names)
    return [f"{name}={value}" for name, value in given if value is not None]


def _run(name: str, work: Callable[[], Awaitable[Result]]) -> Section:
    """Measure one section on a loop of its own."""

    async def run() -> Result:
        return await work()

    print(f"measuring {name} ...", file=sys.stderr, flush=True)
    try:
        figures, problem = asyncio.run(run())
    except BenchmarkError as error:
        return Section(name, (), f"not measured: {error}")
    return Section(name, figures, problem)


if __name__ == "__main__":
    sys.exit(main())
