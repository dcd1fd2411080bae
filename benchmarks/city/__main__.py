"""A city on workers: ``python -m benchmarks.city [--lots DIR] [--core 64] [--json FILE]``.

A mosaic of 400 windows (20 by 20 cores of ``--core`` metres, with 16 m around each) of drawn lots, or of the places of
``--lots``, is mapped by 1, 2 and 4 workers, each time as a program of its own from its start to its survey. A second
one, 400 m a side, has windows as a city has them (128 m): hectares are those. Some five minutes on two quiet cores; a
line says how many cores other programs used meanwhile.
"""

from __future__ import annotations

import contextlib
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from benchmarks.city.picture import pieces, write_mosaic
from benchmarks.city.runs import Run, once, processor_s
from benchmarks.figures import BenchmarkError, Figure, Limit, Reference, Section, print_and_write
from benchmarks.options import folder_option, make_parser
from benchmarks.processes import cpu_time

EXIT_FAILED: Final = 1
_SIDE: Final = 20
"""Windows along a side of a mosaic."""
_SMALL_M: Final = 20.0
_USUAL_M: Final = 128.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, write; return 1 when it could not be measured or a limit is missed."""
    parser = make_parser("benchmarks.city", __doc__)
    parser.add_argument(
        "--lots", type=folder_option, metavar="DIR", help="PLACE.jpg and PLACE.json in place of drawn lots"
    )
    parser.add_argument("--core", type=float, default=64.0, metavar="M", help="side of a window's core (64)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="keep pictures, results and logs here; a new folder")
    options = parser.parse_args(arguments)
    with contextlib.ExitStack() as stack:
        folder = options.out or Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="hawk-city-")))
        folder.mkdir(parents=True, exist_ok=True)
        began, machine, ours = time.monotonic(), cpu_time().machine, processor_s()
        try:
            sections = measure(folder, options.lots, options.core)
        except BenchmarkError as error:
            print(f"city: {error}", file=sys.stderr)
            return EXIT_FAILED
        others = (cpu_time().machine - machine - (processor_s() - ours)) / (time.monotonic() - began)
    print(f"others used {others:.2f} cores meanwhile")
    return print_and_write(sections, options.json, cores_of_others=round(others, 2))


def measure(folder: Path, lots: Path | None, core_m: float) -> list[Section]:
    """Return all figures. Raises BenchmarkError."""
    parts = pieces(lots)
    large = write_mosaic(folder / "large.tif", parts, _SIDE * core_m)
    small = write_mosaic(folder / "small.tif", parts, _SIDE * _SMALL_M)
    runs = {count: _said(f"{count} workers", once(large, folder / f"by-{count}", core_m, count)) for count in (1, 2, 4)}
    usual = _said("hectares", once(small, folder / "usual", _USUAL_M))
    wrong = sum(not _same(folder / "by-1", folder / other) for other in ("by-2", "by-4"))
    return [_pace(runs, usual), _kept(runs, wrong)]


def _said(name: str, run: Run) -> Run:
    words = (
        f"{run.wall_s:.1f} s, of them {run.found['seconds']:.1f} s of looking, {run.processor_s:.1f} s of processors"
    )
    print(f"{name}: {words}", file=sys.stderr, flush=True)
    return run


def _pace(runs: dict[int, Run], usual: Run) -> Section:
    alone, two, four = runs[1], runs[2], runs[4]
    looking = {count: float(run.found["seconds"]) for count, run in runs.items()}
    return Section(
        f"pace, {alone.found['windows']} windows",
        [
            Figure("wall_1_s", "one process, start to survey", alone.wall_s, "s"),
            Figure("wall_2_s", "2 workers", two.wall_s, "s", Reference("one process", alone.wall_s)),
            Figure("wall_4_s", "4 workers", four.wall_s, "s", Reference("one process", alone.wall_s)),
            Figure("scaling_2", "2 workers, times as fast", alone.wall_s / two.wall_s, limit=Limit(lowest=1.8)),
            Figure("scaling_2_looking", "the same without start and merge", looking[1] / looking[2]),
            Figure("scaling_4", "4 workers, times as fast", alone.wall_s / four.wall_s),
            Figure("overhead_processor", "2 workers, processor time beyond one process's",
                   two.processor_s / alone.processor_s - 1),
            Figure("s_per_ha", "seconds a hectare and core, windows of 128 m",
                   usual.found["seconds"] / usual.found["hectares"], "s", limit=Limit(highest=12.0)),
            Figure("mib_per_worker", "memory of a worker, most", max(two.found["mib_worker"], four.found["mib_worker"]),
                   "MiB", limit=Limit(highest=1024.0)),
            Figure("mib_client", "memory of the client, most", two.found["mib_client"], "MiB"),
            Figure("mib_alone", "memory of the one process, windows of 128 m", usual.found["mib_client"], "MiB"),
        ],
    )  # fmt: skip


def _kept(runs: dict[int, Run], wrong: int) -> Section:
    hashes = [run.found["hash"] for run in runs.values()]
    stalls = [run.found["stalls"] for run in runs.values()]
    lost = max(abs(count - stalls[0]) for count in stalls)
    differ = len(set(hashes)) - 1
    return Section(
        "results",
        [
            Figure("stalls", "stalls of the mosaic", stalls[0]),
            Figure("seams_wrong", "stalls lost or doubled against one process", lost, limit=Limit(highest=0)),
            Figure("surveys_differ", "surveys that differ from one process's", differ, limit=Limit(highest=0)),
            Figure("files_differ", "folders of results with another byte", wrong, limit=Limit(highest=0)),
        ],
    )  # fmt: skip


def _same(one: Path, other: Path) -> bool:
    """Return True for two runs with the same results to the byte."""
    first, second = (sorted((folder / "windows").iterdir()) for folder in (one, other))
    return [path.name for path in first] == [path.name for path in second] and all(
        a.read_bytes() == b.read_bytes() for a, b in zip(first, second, strict=True)
    )


if __name__ == "__main__":
    sys.exit(main())
