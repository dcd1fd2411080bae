"""An inbox that is killed: flights dropped in any order and manner, each stored once, none lost.

``python -m benchmarks.inbox [--flights 50] [--kills 20] [--seed 1] [--dir DIR] [--json FILE]``

Each flight is four small photographs of a drawn lot, of a day of its own, with the pixels of one flight. They come as
a folder, as the folders of a card, as loose files, in two parts, slowly under a temporary name, or twice, by the seed.
The inbox is the program itself with its real mapping; it is ended by SIGKILL at drawn moments, and started again.
"""

from __future__ import annotations

import contextlib
import math
import random
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Final

from benchmarks.figures import BenchmarkError, Figure, Limit, Section, print_and_write
from benchmarks.options import make_parser
from hawk.sim.photos import PhotoOptions, write_photos
from hawk.sim.photos_tags import CAMERAS
from hawk.worlds.generate import generate_world

PHOTOGRAPHS: Final = 4
FIRST_DAY: Final = datetime(2024, 1, 1, tzinfo=UTC)
KINDS: Final = ("folder", "card", "loose", "parts", "slowly", "twice")
SETTLE_S: Final = 2.0
KILL_S: Final = (2.0, 22.0)
"""Least and most seconds from a start to the next kill."""
MOST_WAITING: Final = 5
"""Flights that are dropped and not mapped yet."""
LONGEST_S: Final = 7200.0
_DAY_S: Final = 86_400.0
_LOOK_S: Final = 0.1
_OPTIONS: Final = PhotoOptions(height=35.0, width=700, overlap=(0.6, 0.3), camera=CAMERAS["FC6310"], noise_seed=3)
Files = Mapping[str, bytes]
Action = Callable[[], object]


@dataclass(frozen=True, slots=True)
class Folders:
    """The inbox and the store below one folder."""

    root: Path

    @property
    def inbox(self) -> Path:
        """The folder that is filled."""
        return self.root / "inbox"

    @property
    def store(self) -> Path:
        """The folder of the store."""
        return self.root / "store"


@dataclass(slots=True)
class Run:
    """The program, which is killed and started again. ``kills``: so far."""

    folders: Folders
    random: random.Random
    log: Path
    kills: int = 0
    process: subprocess.Popen[bytes] | None = None
    until: float = field(default=0.0)

    def go_on(self, most: int) -> None:
        """Start the program where it has ended, or kill it when its moment has come and fewer than ``most`` were."""
        now = time.monotonic()
        if self.process is None or self.process.poll() is not None:
            self._start(now)
        elif self.kills < most and now >= self.until:
            self.process.kill()
            self.process.wait()
            self.kills += 1

    def end(self) -> None:
        """End the program."""
        if self.process is not None:
            self.process.terminate()
            self.process.wait()

    def _start(self, now: float) -> None:
        folders = self.folders
        where = ["--watch", str(folders.inbox), "--store", str(folders.store), "--settle", f"{SETTLE_S:g}"]
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "hawk.cli", "map", *where], stdout=log, stderr=subprocess.STDOUT
            )
        self.until = now + self.random.uniform(*KILL_S)


def draw_flights(folder: Path, count: int) -> list[Files]:
    """Return the files of each flight: the photographs of one, taken on days of their own."""
    write_photos(generate_world(3), _OPTIONS, folder)
    drawn = [path.read_bytes() for path in sorted(folder.glob("*.JPG"))[:PHOTOGRAPHS]]
    written = datetime(2026, 5, 4, tzinfo=UTC)
    flights: list[Files] = []
    for number in range(count):
        day = FIRST_DAY + timedelta(days=number)
        dates = [(f"{written:{form}}".encode(), f"{day:{form}}".encode()) for form in ("%Y:%m:%d", "%Y-%m-%d")]
        files = {}
        for shot, data in enumerate(drawn, 1):
            for before, after in dates:
                data = data.replace(before, after)
            files[f"DJI_{number:03d}{shot}.JPG"] = data
        flights.append(files)
    return flights


def actions(flights: Sequence[Files], inbox: Path, drawn: random.Random) -> list[list[Action]]:
    """Return what is done to drop each flight, step by step, in a drawn order; others may come between two steps."""
    found = []
    for number, files in enumerate(flights):
        found.append(list(_steps(drawn.choice(KINDS), number, files, inbox)))
    drawn.shuffle(found)
    return found


def _steps(kind: str, number: int, files: Files, inbox: Path) -> Iterator[Action]:
    name, names = f"flight-{number:03d}", sorted(files)
    half = len(names) // 2
    if kind == "card":
        yield partial(_put_card, inbox / name / "DCIM", files)
    elif kind == "loose":
        yield lambda: _put(inbox, files)
    elif kind == "parts":
        yield lambda: _put(inbox / name, {each: files[each] for each in names[:half]})
        yield lambda: _put(inbox / f"{name}-rest", {each: files[each] for each in names[half:]})
    elif kind == "slowly":
        for each in names:
            yield partial(_put, inbox / name, {f"{each}.part": files[each][:2000]})
            yield partial(_finish, inbox / name / f"{each}.part", files[each])
    else:
        yield lambda: _put(inbox / name, files)
        if kind == "twice":
            yield lambda: _put(inbox / f"{name}-copy", files)


def _put(folder: Path, files: Files) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in files.items():
        (folder / name).write_bytes(data)


def _put_card(folder: Path, files: Files) -> None:
    for number, name in enumerate(sorted(files)):
        _put(folder / f"10{number % 2}MEDIA", {name: files[name]})


def _finish(unfinished: Path, data: bytes) -> None:
    unfinished.parent.mkdir(parents=True, exist_ok=True)
    unfinished.write_bytes(data)
    unfinished.rename(unfinished.with_suffix(""))


def waiting(folders: Folders) -> int:
    """Return how many drops, and flights of the journal, are not mapped yet."""
    own = {"done", "failed", "mapping"}
    drops = sum(1 for entry in folders.inbox.iterdir() if entry.name not in own)
    return drops + _unfinished(folders.store / "inbox.db")


def _unfinished(journal: Path) -> int:
    try:
        with contextlib.closing(sqlite3.connect(f"file:{journal}?mode=ro", uri=True)) as opened:
            return int(opened.execute("SELECT count(*) FROM flight WHERE state = 'mapping'").fetchone()[0])
    except sqlite3.Error:  # it is not there yet, or is made whole after a kill
        return 1


def judge(folders: Folders, flights: Sequence[Files]) -> tuple[int, int]:
    """Return how many flights are lost, and how many surveys are too many.

    A flight is lost without a survey of its day by all of its photographs, or where one of these is not in ``done``.
    """
    kept = Counter(path.read_bytes() for path in (folders.inbox / "done").glob("*/pictures/*"))
    days = _days(folders.store / "lots.db", "SELECT ended FROM survey")
    mapped = _days(folders.store / "inbox.db", "SELECT time FROM picture WHERE is_mapped")
    lost = [
        number
        for number, files in enumerate(flights)
        if not days[number] or mapped[number] != len(files) or not all(kept[data] for data in files.values())
    ]
    return len(lost), sum(days.values()) - len(days)


def _days(base: Path, query: str) -> Counter[int]:
    """Return how often each day, numbered as the flights, is among the moments that a query finds."""
    with contextlib.closing(sqlite3.connect(base)) as opened:
        return Counter(int((at - FIRST_DAY.timestamp()) // _DAY_S) for (at,) in opened.execute(query))


def measure(folders: Folders, flights: Sequence[Files], kills: int, seed: int) -> Section:
    """Drop the flights, kill the inbox, and return the figures. Raises BenchmarkError."""
    folders.inbox.mkdir(parents=True)
    folders.store.mkdir()
    drawn = random.Random(seed)
    left = actions(flights, folders.inbox, drawn)
    run = Run(folders, drawn, folders.root / "inbox.log")
    began, quiet_since = time.monotonic(), math.inf
    try:
        while time.monotonic() - quiet_since < 4 * SETTLE_S or run.kills < kills:
            if time.monotonic() - began > LONGEST_S:
                raise BenchmarkError(f"not done after {LONGEST_S:.0f} s: look at {run.log}")
            run.go_on(kills)
            count = waiting(folders)
            if left and count < MOST_WAITING:
                steps = left[drawn.randrange(min(3, len(left)))]
                steps.pop(0)()
                left = [each for each in left if each]
            quiet_since = min(quiet_since, time.monotonic()) if not left and not count else math.inf
            time.sleep(_LOOK_S)
    finally:
        run.end()
    took = time.monotonic() - began
    lost, doubled = judge(folders, flights)
    figures = [
        Figure("inbox_lost", "flights that are lost", lost, limit=Limit(highest=0)),
        Figure("inbox_doubled", "surveys too many", doubled, limit=Limit(highest=0)),
        Figure("inbox_flights", "flights dropped", len(flights)),
        Figure("inbox_kills", "kills by SIGKILL", run.kills),
        Figure("inbox_flight_s", "seconds a flight, kills among them", round(took / len(flights), 2)),
    ]
    return Section("inbox", figures)


def main() -> int:
    """Run and print the figures; return the exit status: 1 where a flight is lost or doubled."""
    parser = make_parser("benchmarks.inbox", __doc__)
    parser.add_argument("--flights", type=int, default=50, metavar="N", help="flights that are dropped (50)")
    parser.add_argument("--kills", type=int, default=20, metavar="N", help="kills of the program (20)")
    parser.add_argument("--seed", type=int, default=1, help="of order, manner and moments (1)")
    parser.add_argument("--dir", type=Path, metavar="DIR", help="new folder that is kept; without it nothing is")
    options = parser.parse_args()
    root = Path(tempfile.mkdtemp(prefix="inbox-")) if options.dir is None else options.dir
    try:
        flights = draw_flights(root / "drawn", options.flights)
        section = measure(Folders(root), flights, options.kills, options.seed)
    finally:
        if options.dir is None:
            shutil.rmtree(root, ignore_errors=True)
    return print_and_write([section], options.json)


if __name__ == "__main__":
    sys.exit(main())
