from __future__ import annotations

import json
import os
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from hawk.picture.inbox.journal import Flight, State
from hawk.picture.inbox.map_process import MapProcess, MapResult
from tests.unit.picture.inbox.inboxes import map_report

FLIGHT = Flight("0123", "north", State.MAPPING, "", (46.8, -92.0), "", "", 1, 0)


@pytest.fixture
def lock(tmp_path: Path) -> Iterator[int]:
    descriptor = os.open(tmp_path / "lock", os.O_RDWR | os.O_CREAT)
    yield descriptor
    os.close(descriptor)


OPTIONS = {"height": "60.0", "memory": "900.0", "hfov": "70.0", "place": "exif", "lenses": "lenses.toml"}


def run(
    tmp_path: Path,
    lock: int,
    monkeypatch: pytest.MonkeyPatch,
    program: str,
    *,
    stop: bool = False,
    flight: Flight = FLIGHT,
) -> MapResult:
    """Run the mapping of a flight with a program in place of the command."""
    script = tmp_path / "program"
    script.write_text(f"#!{sys.executable}\n{program}")
    script.chmod(0o700)
    monkeypatch.setattr(sys, "executable", str(script))
    event = threading.Event()
    if stop:
        threading.Timer(0.3, event.set).start()
    return MapProcess(tmp_path / "store", OPTIONS, event, lock)(flight, tmp_path / "home")


def given_to(tmp_path: Path, lock: int, monkeypatch: pytest.MonkeyPatch, flight: Flight) -> list[str]:
    """Return the arguments of the command for a flight."""
    report = map_report("s1").model_dump_json()
    kept = tmp_path / "said"
    program = f"import json, sys\nopen({str(kept)!r}, 'w').write(json.dumps(sys.argv[1:]))\nprint({report!r})"
    assert run(tmp_path, lock, monkeypatch, program, flight=flight).report == map_report("s1")
    said: list[str] = json.loads(kept.read_text())
    return said


def test_the_command_gets_the_flight(tmp_path: Path, lock: int, monkeypatch: pytest.MonkeyPatch) -> None:
    given = given_to(tmp_path, lock, monkeypatch, FLIGHT)
    assert given[:7] == ["-m", "hawk.cli", "map", "--json", "--resume", "--store", str(tmp_path / "store")]
    assert json.loads(given[given.index("--flight") + 1]) == {"id": "0123", "name": "north", "datum": [46.8, -92.0]}
    assert given[-2:] == ["--", str(tmp_path / "home/pictures")]
    assert int(given[given.index("--parent-pid") + 1]) == os.getpid()


@pytest.mark.parametrize(
    ("source", "names"),
    [
        ("", {"memory", "height", "lenses", "place"}),
        ("DJI_1.MP4", {"memory", "height", "lenses", "hfov"}),
        ("flight.mcap", {"memory", "height"}),
        ("lot.tif", {"memory"}),
    ],
)
def test_each_source_gets_the_options_that_it_has_a_use_for(
    tmp_path: Path, lock: int, monkeypatch: pytest.MonkeyPatch, source: str, names: set[str]
) -> None:
    given = given_to(tmp_path, lock, monkeypatch, replace(FLIGHT, source=source))
    assert {name for name in OPTIONS if f"--{name}" in given} == names
    assert all(given[given.index(f"--{name}") + 1] == OPTIONS[name] for name in names)
    assert given[-1] == str(tmp_path / "home/pictures" / source)


@pytest.mark.parametrize(
    ("program", "words", "number"),
    [
        ('import sys; print(\'{"event": "error", "text": "say the height"}\'); sys.exit(1)', "say the height", 0),
        ("import sys; print('takes more memory', file=sys.stderr); sys.exit(1)", "takes more memory", 0),
        ("import sys; sys.exit(4)", "Mapping ended with status 4", 0),
        ("print('hello')", "The report of the mapping cannot be read: Invalid JSON", 0),
        ("import os; os.kill(os.getpid(), 9)", "Mapping was ended by SIGKILL", 9),
        ("import sys; print('[1, 2]'); sys.exit(1)", "Mapping ended with status 1", 0),
    ],
)
def test_a_mapping_without_a_survey_says_why(
    tmp_path: Path, lock: int, monkeypatch: pytest.MonkeyPatch, program: str, words: str, number: int
) -> None:
    found = run(tmp_path, lock, monkeypatch, program)
    assert found.report is None
    assert found.words.startswith(words)
    assert (found.signal, found.is_stopped) == (number, False)


def test_a_mapping_is_ended_with_its_inbox(tmp_path: Path, lock: int, monkeypatch: pytest.MonkeyPatch) -> None:
    began = time.monotonic()
    found = run(tmp_path, lock, monkeypatch, "import time; time.sleep(60)", stop=True)
    assert found.is_stopped
    assert time.monotonic() - began < 30
