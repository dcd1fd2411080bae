"""Damaged and hostile files at every reader of strangers' files.

``python -m proving.fuzz files [--count 2000] [--seed 1] [--first 0] [--reader NAME] [--json FILE]``

Each file is read or refused in words, within a minute and 1 GiB, and nobody is asked for anything. A finding names its
reader and number: ``--reader NAME --first NUMBER --count 1`` reads that file again. Status 1 when there is one.
"""

from __future__ import annotations

import multiprocessing
import os
import resource
import socket
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Final

from benchmarks.figures import Figure, Limit, Section, print_and_write
from benchmarks.options import make_parser
from proving.fuzz.bases import hostile
from proving.fuzz.damage import SOUND, Damage
from proving.fuzz.readers import READERS, FileReader

COUNT: Final = 2000
MOST_BYTES: Final = 1 << 30
LONGEST_S: Final = 60.0
FINDINGS: Final = 20
"""A reader with this number of findings is left."""
_FORK: Final = multiprocessing.get_context("fork")


@dataclass(slots=True)
class FileResult:
    """Counts of one reader. ``memory_mb``: the most that reading took; ``findings``: each with its number."""

    name: str
    read: int = 0
    refused: int = 0
    reasons: Counter[str] = field(default_factory=Counter)
    memory_mb: float = 0.0
    seconds: float = 0.0
    findings: list[str] = field(default_factory=list)


def fuzz_reader(reader: FileReader, count: int, seed: int = 1, first: int = 0) -> FileResult:
    """Return what a reader makes of ``count`` files, in processes of their own."""
    result, begun = FileResult(reader.name), time.monotonic()
    with (
        tempfile.TemporaryDirectory(prefix="hawk-fuzz-") as name,
        socket.create_server(("127.0.0.1", 0)) as server,
    ):
        folder = Path(name)
        (folder / "bases").mkdir()
        server.setblocking(False)
        sound = list(reader.bases(folder / "bases"))
        damage = Damage(seed, sound, list(hostile(server.getsockname()[1])))
        number, last = first, first + count
        while number < last and len(result.findings) < FINDINGS:
            number = _read_from(reader, damage, range(number, last), folder, result)
            _note_request(server, number, result)
    result.seconds = time.monotonic() - begun
    return result


def _read_from(reader: FileReader, damage: Damage, numbers: range, folder: Path, result: FileResult) -> int:
    """Read files in one process as long as it lives; return the number of the next one."""
    here, there = _FORK.Pipe(duplex=False)
    process = _FORK.Process(target=_serve, args=(reader, damage, numbers, folder, there), daemon=True)
    process.start()
    there.close()
    number = numbers.start
    try:
        while number < numbers.stop and len(result.findings) < FINDINGS:
            if not here.poll(LONGEST_S):
                result.findings.append(f"{reader.name} {number}: takes more than {LONGEST_S:.0f} s")
                return number + 1
            outcome, words, peak = here.recv()
            if number == SOUND and outcome != "read":
                outcome, words = "fault", f"a sound file is not read: {words}"
            _judge(result, f"{reader.name} {number}", outcome, words, peak)
            number += 1
            if peak > MOST_BYTES:
                return number
    except EOFError:
        process.join()
        result.findings.append(f"{reader.name} {number}: its process ended with {process.exitcode}")
        return number + 1
    finally:
        process.kill()
        process.join()
    return number


def _judge(result: FileResult, where: str, outcome: str, words: str, peak: int) -> None:
    result.memory_mb = max(result.memory_mb, peak / 1e6)
    if peak > MOST_BYTES:
        result.findings.append(f"{where}: took {peak / 1e6:.0f} MB")
    if outcome == "read":
        result.read += 1
    elif outcome == "refused" and len(words.split()) >= 3:
        result.refused += 1
        result.reasons[words[:60]] += 1
    else:
        result.findings.append(f"{where}: {words or 'refused without words'}")


def _note_request(server: socket.socket, number: int, result: FileResult) -> None:
    try:
        server.accept()[0].close()
    except BlockingIOError:
        return
    result.findings.append(f"{result.name} before {number}: a request went out")


def _serve(reader: FileReader, damage: Damage, numbers: range, folder: Path, out: Connection) -> None:
    """Read files in this process, and send what became of each; memory counts beside what the process began with."""
    began = _peak_bytes()
    resource.setrlimit(resource.RLIMIT_DATA, (began + MOST_BYTES + (MOST_BYTES >> 1),) * 2)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # libraries print of damaged files
    warnings.simplefilter("ignore")
    read, errors = reader.prepare()
    for number in numbers:
        base = damage.at(number)
        place = folder / f"{reader.name}-{number}"
        place.mkdir()
        path = place / f"given{base.suffix}"
        path.write_bytes(base.data)
        outcome, words = _read(read, errors, path)
        out.send((outcome, words, _peak_bytes() - began))
        _remove(place)


def _peak_bytes() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _read(read: Callable[[Path], object], errors: tuple[type[Exception], ...], path: Path) -> tuple[str, str]:
    try:
        read(path)
    except errors as error:
        return "refused", " ".join(str(error).replace(str(path), "FILE").split())
    except BaseException as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        return "fault", f"{type(error).__name__}: {str(error)[:120]} ({Path(place.filename).name}:{place.lineno})"
    return "read", ""


def _remove(folder: Path) -> None:
    import shutil

    shutil.rmtree(folder, ignore_errors=True)


def figures(result: FileResult) -> list[Figure]:
    """Return the figures of a reader."""
    name = f"fuzz_{result.name}"
    return [
        Figure(f"{name}_read", "files read", float(result.read)),
        Figure(f"{name}_refused", "files refused in words", float(result.refused)),
        Figure(f"{name}_reasons", "different beginnings of refusals", float(len(result.reasons))),
        Figure(f"{name}_memory_mb", "most memory", result.memory_mb, "MB", limit=Limit(highest=MOST_BYTES / 1e6)),
        Figure(f"{name}_findings", "findings", float(len(result.findings)), limit=Limit(highest=0.0)),
    ]


def main(arguments: Sequence[str]) -> int:
    """Read, print, write."""
    parser = make_parser("proving.fuzz files", __doc__)
    parser.add_argument("--count", type=int, default=COUNT, help=f"files a reader (default {COUNT})")
    parser.add_argument("--seed", type=int, default=1, help="of the files (default 1)")
    parser.add_argument("--first", type=int, default=0, help="number of the first file (default 0)")
    parser.add_argument("--reader", choices=[each.name for each in READERS], help="only this one")
    options = parser.parse_args(arguments)
    sections = []
    for reader in READERS:
        if options.reader not in (None, reader.name):
            continue
        result = fuzz_reader(reader, options.count, options.seed, options.first)
        line = f"{reader.name}: {result.read} read, {result.refused} refused, {result.seconds:.0f} s"
        print(line, *result.findings, sep="\n  ", file=sys.stderr, flush=True)
        sections.append(Section(f"fuzz: {reader.name}", figures(result), "; ".join(result.findings)))
    return print_and_write(sections, options.json)
