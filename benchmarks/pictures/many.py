"""Growth of time and memory with the number of photographs of a flight."""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from benchmarks.pictures.photos import survey_folder
from hawk.picture.work_folder import WORK
from hawk.sim.photos import PhotoOptions, plan, write_photos
from hawk.sim.photos_tags import CAMERAS
from hawk.worlds.generate import generate_world
from hawk.worlds.world import World

OPTIONS: Final = PhotoOptions(height=20.0, width=600, camera=CAMERAS["FC6310"])
"""Small pictures of 30 by 22 m."""
_SEED: Final = 3
_MIB: Final = 2**20
STEPS: Final = ("read", "match", "match again", "settle", "map", "finish")


@dataclass(frozen=True, slots=True)
class Grown:
    """A mapped folder: photographs, seconds of each step of `STEPS`, the process's greatest memory, and bytes kept."""

    photographs: int
    seconds: dict[str, float]
    peak_mib: float
    kept_mib: float

    @property
    def took_s(self) -> float:
        """Seconds in all."""
        return sum(self.seconds.values())


def measure(counts: Iterable[int]) -> list[Grown]:
    """Draw and map a folder of about each number of photographs, each in a process of its own; print a line each."""
    found = []
    for count in counts:
        with tempfile.TemporaryDirectory(prefix="hawk-many-") as folder:
            arguments = [sys.executable, "-m", __spec__.name, folder]
            for part in (["--draw", str(count)], []):
                made = subprocess.run([*arguments, *part], check=True, stdout=subprocess.PIPE, text=True)
            found.append(Grown(**json.loads(made.stdout)))
        print(_line(found[-1]), file=sys.stderr, flush=True)
    return found


def table(grown: Sequence[Grown]) -> str:
    """Return the measures as a table, with what each further photograph takes."""
    lines = ["| photographs | s a photograph | " + " | ".join(STEPS) + " | peak MiB | kept MiB |"]
    lines.append("|---" * (len(STEPS) + 4) + "|")
    for one in grown:
        steps = " | ".join(f"{one.seconds.get(step, 0.0) / one.photographs:.2f}" for step in STEPS)
        each = one.took_s / one.photographs
        lines.append(f"| {one.photographs} | {each:.2f} | {steps} | {one.peak_mib:.0f} | {one.kept_mib:.0f} |")
    if len(grown) > 1:
        first, last = grown[0], grown[-1]
        more = last.photographs - first.photographs
        lines.append(
            f"Each further photograph: {(last.took_s - first.took_s) / more:.2f} s, "
            f"{(last.peak_mib - first.peak_mib) / more:.2f} MiB of memory, "
            f"{(last.kept_mib - first.kept_mib) / more:.2f} MiB kept."
        )
    return "\n".join(lines)


def _line(one: Grown) -> str:
    steps = ", ".join(f"{step} {seconds:.0f} s" for step, seconds in one.seconds.items())
    return f"{one.photographs} photographs: {one.took_s:.0f} s ({steps}), {one.peak_mib:.0f} MiB"


def world_for(count: int) -> World:
    """Return ground over which a flight by `OPTIONS` takes about ``count`` photographs: one lot beside the other."""
    drawn = generate_world(_SEED)
    focal = OPTIONS.camera.focal_px(OPTIONS.width)
    seen = np.array([OPTIONS.camera.height_px(OPTIONS.width), OPTIONS.width]) / focal * OPTIONS.height
    along, across = (seen * (1 - np.array(OPTIONS.overlap))).tolist()
    lanes = max(2, round((count * along / across) ** 0.5))  # as wide as long
    photos = max(2, round(count / lanes))
    rows, columns = (round((n - 1.5) * step / drawn.metres_per_pixel) for n, step in ((lanes, across), (photos, along)))
    rows, columns = max(rows, 64), max(columns, rows + 1)  # lanes run along the longer side
    times = [-(-side // had) for side, had in zip((rows, columns), drawn.ground.shape, strict=False)]
    return World(
        "many", drawn.metres_per_pixel, np.ascontiguousarray(np.tile(drawn.ground, (*times, 1))[:rows, :columns])
    )


def draw(folder: Path, count: int) -> int:
    """Write the photographs of a flight; return how many they are."""
    world = world_for(count)
    print(f"{len(plan(world, OPTIONS))} photographs are drawn", file=sys.stderr)
    return write_photos(world, OPTIONS, folder)


def mapped(folder: Path, work: Path) -> Grown:
    """Map a folder in this process and return what it took."""
    cv2.setNumThreads(1)
    began: dict[str, float] = {}

    def note(step: str, done: int, count: int) -> None:
        began.setdefault(step, time.perf_counter())
        if step == "match again" and done == count - 1:
            began.setdefault("settle", time.perf_counter())

    start = time.perf_counter()
    survey = survey_folder(folder, work=work, progress=note)
    ends = [*list(began.values())[1:], time.perf_counter()]
    seconds = {step: end - at for (step, at), end in zip(began.items(), ends, strict=True)}
    seconds["read"] += began["read"] - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    kept = sum(path.stat().st_size for path in work.iterdir()) / _MIB
    return Grown(len(survey.shots), seconds, peak, kept)


def _main() -> int:
    parser = argparse.ArgumentParser(description="draw or map one folder; benchmarks.pictures --many calls this")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--draw", type=int)
    options = parser.parse_args()
    folder: Path = options.folder / "photographs"
    if options.draw is not None:
        draw(folder, options.draw)
        return 0
    one = mapped(folder, options.folder / WORK)
    print(json.dumps({name: getattr(one, name) for name in Grown.__slots__}))
    return 0


if __name__ == "__main__":
    sys.exit(_main())
