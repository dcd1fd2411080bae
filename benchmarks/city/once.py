"""One run over a city, as a program of its own: ``python -m benchmarks.city.once SOURCE OUT [--workers N]``.

The last line that it prints is JSON: windows, found ones, seconds of looking, hectares, stalls, a hash of the survey,
and the largest memory (MiB) of this process and of one worker.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path

from hawk.picture.city.run import CityWork, map_city
from hawk.picture.values import PictureError, PictureSurvey


def main(arguments: Sequence[str] | None = None) -> int:
    """Map once and print; return 1 when it cannot be done."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.city.once", description=__doc__)
    parser.add_argument("source", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--core", type=float, default=128.0, help="metres")
    options = parser.parse_args(arguments)
    most = {"worker": 0.0}

    def sample(*_: int) -> None:
        for child in children():
            most["worker"] = max(most["worker"], peak_mib(child))

    try:
        work = CityWork(options.source, out=options.out, workers=options.workers, core_m=options.core)
        run = map_city(work, sample)
    except PictureError as error:
        print(error, file=sys.stderr)
        return 1
    found = {
        "windows": run.windows, "reused": run.reused, "seconds": run.seconds, "hectares": run.mapped.area_m2 / 1e4,
        "stalls": len(run.mapped.survey.stalls), "failed": len(run.mapped.left_out), "hash": hash_of(run.mapped),
        "mib_client": peak_mib(os.getpid()), "mib_worker": most["worker"],
    }  # fmt: skip
    print(json.dumps(found))
    return 0


def hash_of(mapped: PictureSurvey) -> str:
    """Return a hash of everything that a survey says of its stalls and its ground."""
    content = (mapped.survey.stalls, mapped.survey.outline, mapped.area_m2, mapped.left_out)
    return hashlib.sha256(repr(content).encode()).hexdigest()


def children() -> list[int]:
    """Return the processes that this one has started, by proc(5)."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            if int(path.read_text().rpartition(")")[2].split()[1]) == os.getpid():
                found.append(int(path.parent.name))
    return found


def peak_mib(process: int) -> float:
    """Return the largest memory of a process up to now, by proc(5); 0 for one that has ended."""
    try:
        found = re.search(r"^VmHWM:\s+(\d+) kB$", Path(f"/proc/{process}/status").read_text(), re.MULTILINE)
    except OSError:
        return 0.0
    return int(found[1]) / 1024 if found else 0.0


if __name__ == "__main__":
    sys.exit(main())
