"""`make run` starts the daemon again after a fault, as systemd does."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

KEEP_RUNNING = Path(__file__).resolve().parents[3] / "packaging" / "keep-running"
PROGRAM = """
import signal, sys, time
from pathlib import Path
log, *statuses = Path(sys.argv[1]), *sys.argv[2].split(",")
before = log.read_text().splitlines() if log.exists() else []
log.write_text("\\n".join([*before, " ".join(sys.argv[3:]) or "first"]))
status = statuses[min(len(before), len(statuses) - 1)]
if status == "wait":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(7))
    print("waiting", flush=True)
    time.sleep(60)
sys.exit(int(status))
"""


def command(folder: Path, statuses: str) -> list[str]:
    program = folder / "program.py"
    program.write_text(PROGRAM)
    return [str(KEEP_RUNNING), sys.executable, str(program), str(folder / "log"), statuses]


def runs(folder: Path) -> list[str]:
    return (folder / "log").read_text().splitlines()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("statuses", "started", "ends_with"),
    [
        ("0", ["first"], 0),
        ("2", ["first"], 2),
        ("1,0", ["first", "--again"], 0),
        ("1,1,2", ["first", "--again", "--again"], 2),
        ("1", ["first", "--again", "--again", "--again"], 1),
    ],
)
def test_after_a_fault_it_runs_again_and_after_an_orderly_end_it_does_not(
    tmp_path: Path, statuses: str, started: list[str], ends_with: int
) -> None:
    done = subprocess.run(command(tmp_path, statuses), capture_output=True, timeout=60, check=False)
    assert done.returncode == ends_with
    assert runs(tmp_path) == started


SLOW_WAIT = {"BASH_FUNC_wait%%": '() { builtin wait "$@"; local status=$?; sleep 0.3; return $status; }'}
"""A shell that comes back late from each wait: the program has ended by then."""


@pytest.mark.slow
@pytest.mark.parametrize("shell", [{}, SLOW_WAIT], ids=["at once", "late"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_program_in_order_and_starts_no_other(
    tmp_path: Path, number: signal.Signals, shell: dict[str, str]
) -> None:
    as_on_a_terminal = ["env", "--default-signal=INT"]  # a shell cannot trap what its parent ignored
    with subprocess.Popen(
        [*as_on_a_terminal, *command(tmp_path, "wait")], stdout=subprocess.PIPE, text=True, env={**os.environ, **shell}
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "waiting\n"
        process.send_signal(number)
        assert process.wait(30) == 7
    assert runs(tmp_path) == ["first"]
