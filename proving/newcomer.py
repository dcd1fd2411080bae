"""From a bare Debian 12 to a finished survey by the README's commands: ``make newcomer``.

``python -m proving.newcomer [--package FILE] [--seed 1] [--mirror URL] [--json FILE]``

Two bare roots are made, one after the other. The first gets the sources of this commit: ``make run``, then a survey.
The second gets the Debian package, where there is one: ``apt-get install``, the daemon, a survey. To make the root and
to fetch the sources is not timed; what the commands download is. The network is this machine's. Needs root, mmdebstrap
and the machine to itself.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from http import HTTPStatus
from http.client import HTTPConnection
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

from benchmarks.figures import BenchmarkError, Figure, Limit, Section, print_and_write
from benchmarks.options import make_parser
from proving.bare_root import MIRROR, BareRoot, end, tail

TEN_MINUTES: Final = Limit(highest=600.0)
GOOD_SURVEY: Final = Limit(lowest=0.9)
EXIT_FAILED: Final = 1
_ROOT: Final = Path(__file__).resolve().parents[1]
_HOME: Final = "/root"
_SOURCES: Final = "/root/hawk"
_ANNOUNCED: Final = re.compile(r"hawk: open (http://\S+)")
_STEP_S: Final = 900.0
_ANSWER_S: Final = 10.0
_LOOK_S: Final = 0.1


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, write; return 1 when a step failed or a limit is missed."""
    options = _parser().parse_args(arguments)
    with tempfile.TemporaryDirectory(prefix="hawk-newcomer-") as name:
        try:
            sections = list(_measured(options, Path(name)))
        except BenchmarkError as error:
            print(f"newcomer: {error}", file=sys.stderr)
            return EXIT_FAILED
    return print_and_write(sections, options.json)


def _measured(options: argparse.Namespace, folder: Path) -> Iterator[Section]:
    root = BareRoot.make(folder / "sources", options.mirror)
    fetch_sources(root)
    yield Section("newcomer, from the sources", from_sources(root, folder / "sources.log", options.seed))
    shutil.rmtree(root.folder)
    package = options.package or newest_package()
    if package is None:
        print("newcomer: no package in dist/ (make deb): the sources alone are tried", file=sys.stderr)
        return
    root = BareRoot.make(folder / "package", options.mirror)
    shutil.copyfile(package, root.folder / "root" / package.name)
    found = from_package(root, package.name, folder / "package.log", options.seed)
    yield Section(f"newcomer, {package.name}", found)


def fetch_sources(root: BareRoot) -> None:
    """Clone this commit into the root. Raises BenchmarkError where this is not a clone itself."""
    target = root.folder / _SOURCES.lstrip("/")
    done = subprocess.run(
        ["git", "clone", "--quiet", str(_ROOT), str(target)], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise BenchmarkError(f"git clone: {done.stderr.strip()}")


def newest_package(folder: Path = _ROOT / "dist") -> Path | None:
    """Return the newest package of Debian 12 for this processor; None without one."""
    found = sorted(folder.glob("hawk-drone_*+deb12_amd64.deb"), key=lambda path: path.stat().st_mtime)
    return found[-1] if found else None


def from_sources(root: BareRoot, log: Path, seed: int) -> list[Figure]:
    """Time the README's "Try it" in the root. Raises BenchmarkError with the log's end where a command fails."""
    start = Start("sources", "needs", "python3 make", "make run", ".venv/bin/hawk-drone", _SOURCES)
    return _timed(root, start, "apt-get install python3 make", log, seed)


def from_package(root: BareRoot, name: str, log: Path, seed: int) -> list[Figure]:
    """Time the package's installation, the simulated drone and a survey. Raises BenchmarkError as `from_sources`."""
    start = Start("package", "install", f"./{name}", "hawk-drone --sim", "hawk-drone", _HOME)
    return _timed(root, start, "apt-get install ./hawk-drone_VERSION_ARCH.deb", log, seed)


@dataclass(frozen=True, slots=True)
class Start:
    """One kind of beginning: ``packages`` for apt-get, the line that runs the daemon, the program that surveys, and the
    folder in which both run. ``key`` and ``first`` name the figures.
    """

    key: str
    first: str
    packages: str
    daemon: str
    program: str
    within: str


def _timed(root: BareRoot, start: Start, first: str, log: Path, seed: int) -> list[Figure]:
    """Return the seconds of each step; ``first`` is the text of the first one."""
    install = f"apt-get update -qq && apt-get install -qq {start.packages}"
    fly = f"{start.program} survey --sim --seed {seed} --out survey-1"
    needs = _seconds(lambda: root.run(install, _HOME, log, _STEP_S))
    page = _seconds(lambda: see_page(root, start.daemon, start.within, log))
    survey = _seconds(lambda: root.run(fly, start.within, log, _STEP_S))
    folder = root.folder / start.within.lstrip("/") / "survey-1"
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    return [
        Figure(f"{start.key}_{start.first}_s", first, needs, "s"),
        Figure(f"{start.key}_page_s", f"{start.daemon}, until the page answers", page, "s"),
        Figure(f"{start.key}_survey_s", "hawk-drone survey --sim", survey, "s"),
        Figure(f"{start.key}_f1", "F1 of that survey's stalls", float(report["stall_f1"]), limit=GOOD_SURVEY),
        Figure(f"{start.key}_s", "all of it", needs + page + survey, "s", limit=TEN_MINUTES),
    ]


def see_page(root: BareRoot, line: str, within: str, log: Path) -> None:
    """Run the daemon until its page answers, then end it. Raises BenchmarkError where it ends before, or is late."""
    before = log.stat().st_size if log.exists() else 0
    daemon = root.start(line, within, log)
    try:
        until = time.monotonic() + _STEP_S
        while not (found := _ANNOUNCED.search(log.read_bytes()[before:].decode(errors="replace"))):
            if daemon.poll() is not None or time.monotonic() > until:
                raise BenchmarkError(f"{line}: no page\n{tail(log)}")
            time.sleep(_LOOK_S)
        _open(found[1], until)
    finally:
        end(daemon)


def _open(url: str, until: float) -> None:
    """Wait for the page. Raises BenchmarkError where it does not come."""
    address = urlsplit(url)
    while True:
        with (
            contextlib.suppress(OSError),
            contextlib.closing(HTTPConnection(address.netloc, timeout=_ANSWER_S)) as page,
        ):
            page.request("GET", address.path)
            if page.getresponse().status == HTTPStatus.OK:
                return
        if time.monotonic() > until:
            raise BenchmarkError(f"{url}: no page answers")
        time.sleep(_LOOK_S)


def _seconds(step: Callable[[], None]) -> float:
    """Return the seconds that a step takes."""
    start = time.monotonic()
    step()
    return time.monotonic() - start


def _parser() -> argparse.ArgumentParser:
    parser = make_parser("proving.newcomer", __doc__)
    parser.add_argument("--package", type=Path, metavar="FILE", help="Debian package (default: the newest in dist/)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the drawn lot (1)")
    parser.add_argument("--mirror", default=MIRROR, metavar="URL", help=f"Debian's mirror ({MIRROR})")
    return parser


if __name__ == "__main__":
    sys.exit(main())
