from __future__ import annotations

import subprocess
import sys

import pytest

from hawk.runtime.process import READER_GONE, readers_are_gone

PRINTS = "import sys\nfrom hawk import cli\ncli._run_command = lambda _: print('lines') or 0\nsys.exit(cli.main())"
GIVEN = (["-c", PRINTS], ["-m", "hawk.cli", "map", "none", "--out", "x", "--json"])


@pytest.mark.slow
@pytest.mark.parametrize("command", GIVEN)
def test_a_command_ends_quietly_when_nobody_reads_its_output(command: list[str]) -> None:
    with subprocess.Popen(
        [sys.executable, *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        said = process.stderr.read()
    assert (process.returncode, said) == (READER_GONE, "")


def test_an_output_that_is_read_is_not_gone() -> None:
    assert not readers_are_gone()
