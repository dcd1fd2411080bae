"""Live pictures to many viewers, beside µStreamer from Debian.

``python -m benchmarks.video [--json FILE] [--seconds 15] [--rounds 3] [--viewers 1,4,16]``

A made-up camera gives the same JPEGs (1280 x 720 pixels, about 90 kB) at 30 pictures a second to both servers, each
stamped when it is handed over. Each server is a process of its own on one core, its viewers another one on the other
cores. From four viewers on, one has a link of 12 Mbit/s, and one reads nothing for 5 s. Rounds alternate between
hawk's ``/video``, µStreamer, and hawk's ``/stream.mjpg``. In one more round a page beside hawk's viewers measures round
trips of commands.

In JSON ``socket_16_...`` is ``/video`` with 16 viewers, ``stream_16_...`` ``/stream.mjpg``, ``ustreamer_16_...``
µStreamer. ``fast_p99_over_ustreamer``, ``slow_p50_over_ustreamer`` and ``cpu_per_frame_over_ustreamer`` are of the most
viewers, and of the worse of hawk's two addresses. Without µStreamer (``apt-get install ustreamer``) hawk is measured
alone.
"""

from __future__ import annotations

import argparse
import asyncio
import math
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks.figures import BenchmarkError, Figure, Limit, Section, print_and_write
from benchmarks.processes import cpu_time
from benchmarks.video import servers
from benchmarks.video.measure import FPS, Setting, figures, measure
from benchmarks.video.pictures import draw, write

QUIET_CORES = 0.2
"""Others that use more of the machine than this spoil the figures."""
LEAST_S = 15.0
LEAST_ROUNDS = 3


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, write; return 1 when it could not be measured."""
    options = _parser().parse_args(arguments)
    if options.json is not None:
        options.json.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="hawk-video-") as folder:
        try:
            found, problem = asyncio.run(_measure(options, Path(folder)))
        except BenchmarkError as error:
            found, problem = [], f"not measured: {error}"
    print_and_write([Section("video", found, problem)], options.json)
    return 0 if found else 1


async def _measure(options: argparse.Namespace, folder: Path) -> tuple[list[Figure], str]:
    pictures = folder / "pictures.bin"
    drawn = draw()
    write(pictures, drawn)
    feeder = servers.compiled(options.ustreamer_feeder, folder) if servers.is_there() else None
    if feeder is None:
        print(servers.INSTALL, file=sys.stderr, flush=True)
    before = cpu_time()
    runs = await measure(Setting(pictures, folder, options.seconds, feeder), options.viewers, options.rounds)
    others = cpu_time().cores_since(before)["others"]
    found = [
        Figure("picture_kb", "a picture", sum(map(len, drawn)) / len(drawn) / 1e3, "kB"),
        Figure("camera_fps", "pictures of the camera", FPS, "1/s"),
        *figures(runs),
        Figure("video_cores_others", "cores used: others", others, limit=Limit(highest=QUIET_CORES)),
    ]
    return found, _void(options, others)


def _void(options: argparse.Namespace, others: float) -> str:
    reasons = []
    if others > QUIET_CORES:
        reasons.append(f"other programs used {others:.2f} cores meanwhile")
    if options.seconds < LEAST_S or options.rounds < LEAST_ROUNDS:
        reasons.append(f"less than {LEAST_ROUNDS} rounds of {LEAST_S:g} s")
    return f"VOID: {'; '.join(reasons)}" if reasons else ""


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.video", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every figure as one flat object")
    parser.add_argument("--seconds", type=_seconds, default=LEAST_S, help="of each round (15)")
    parser.add_argument("--rounds", type=int, default=LEAST_ROUNDS, help="of each transport and number of viewers (3)")
    parser.add_argument(
        "--viewers", type=_counts, default=(1, 4, 16), metavar="A,B", help="numbers of viewers (1,4,16)"
    )
    parser.add_argument(
        "--ustreamer-feeder",
        type=Path,
        default=servers.FEEDER,
        metavar="PATH",
        help="preload library, or its C source, that gives µStreamer the pictures of the file in FRAMES",
    )
    return parser


def _seconds(text: str) -> float:
    value = float(text)
    if not (math.isfinite(value) and value >= 1.0):
        raise argparse.ArgumentTypeError(f"{text}: at least 1 s")
    return value


def _counts(text: str) -> tuple[int, ...]:
    counts = tuple(int(each) for each in text.split(","))
    if not counts or min(counts) < 1 or max(counts) > 20:
        raise argparse.ArgumentTypeError(f"{text}: numbers of viewers from 1 to 20, as in 1,4,16")
    return counts


if __name__ == "__main__":
    sys.exit(main())
