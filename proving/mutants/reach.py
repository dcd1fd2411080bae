"""Which tests reach which line, by one run of the tests under coverage."""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final

from proving.mutants.modules import COVERING, folders_of_tests, own_files
from proving.mutants.sampling import Mutant

ENOUGH_TESTS_S: Final = 15.0
"""Seconds that the tests may take for one mutant."""
UNMAPPED: Final = "tests/unit/ddc/test_decider_state_table.py"
"""It makes every transition as it is imported, minutes under coverage; its own tests reach the line of none."""
LEAST_S: Final = 0.02
"""Seconds of a test that took less than pytest reports."""


@dataclass(frozen=True)
class ReachMap:
    """Which tests reach which lines, and the seconds that each takes."""

    reached: Mapping[str, Mapping[int, frozenset[str]]]
    seconds: Mapping[str, float]

    def tests(self, mutant: Mutant, inside_function: bool) -> tuple[str, ...]:
        """Return the tests that reach a mutant: the module's own files first, then those of quick tests, for so long.

        A line outside functions runs at import, so all tests that reach the module are its tests.
        """
        lines = self.reached.get(mutant.module, {})
        found = lines.get(mutant.line, frozenset()) if inside_function else frozenset[str]()
        files: dict[str, list[str]] = defaultdict(list)
        for test in sorted(found or frozenset[str]().union(*lines.values())):
            files[test.split("::")[0]].append(test)
        chosen: list[str] = []
        left = ENOUGH_TESTS_S
        means = {file: sum(map(self.cost, tests)) / len(tests) for file, tests in files.items()}
        own = own_files(mutant.module)
        for file in sorted(files, key=lambda file: (file not in own, means[file])):
            for test in sorted(files[file], key=self.cost):
                if self.cost(test) <= left:
                    chosen.append(test)
                    left -= self.cost(test)
        return tuple(chosen)

    @cached_property
    def known(self) -> frozenset[str]:
        """All tests of the map: a test of a module's own files that is not among them is new, and runs too."""
        return frozenset[str]().union(*(tests for lines in self.reached.values() for tests in lines.values()))

    def cost(self, test: str) -> float:
        """Return the seconds that a test takes."""
        return self.seconds.get(test, LEAST_S)


def map_of_tests(
    folder: Path, modules: Sequence[str], processes: int, cache: Path, tests: Sequence[str] = ()
) -> ReachMap:
    """Return the tests by line, from the cache when no module has changed since, else by one run under coverage.

    ``tests``: folders of the tests that run; none: those of the modules' rooms.
    """
    folders = tests or folders_of_tests(modules)
    key = _digest(folder, modules, folders)
    with suppress(OSError, ValueError):
        stored = json.loads(cache.read_text(encoding="utf-8"))
        if stored["key"] == key:
            return _as_map(stored)
    print("The tests run once under coverage, to see which lines each reaches ...", flush=True)
    options = [
        "--cov=hawk",
        "--cov-context=test",
        "--cov-report=",
        "--cov-fail-under=0",
        "--durations=0",
        "--durations-min=0",
        "-vv",
    ]
    workers = ["--numprocesses", str(processes), "--dist", "loadscope"] if processes > 1 else []
    command = [
        sys.executable,
        "-m",
        "pytest",
        *options,
        *workers,
        "-m",
        COVERING,
        f"--ignore={UNMAPPED}",
        *folders,
    ]
    run = subprocess.run(command, cwd=folder, env=environment(folder), capture_output=True, text=True, check=False)
    if run.returncode:
        raise SystemExit(f"The tests fail without a mutant: mend them first.\n{run.stdout[-3000:]}{run.stderr[-1000:]}")
    stored = {"key": key, "reached": _reached(folder, modules), "seconds": _durations(run.stdout)}
    cache.parent.mkdir(parents=True, exist_ok=True)
    cache.write_text(json.dumps(stored), encoding="utf-8")
    return _as_map(stored)


def _as_map(stored: Mapping[str, Any]) -> ReachMap:
    tests = stored["reached"]["tests"]
    reached = {
        module: {int(line): frozenset(tests[number] for number in numbers) for line, numbers in lines.items()}
        for module, lines in stored["reached"]["lines"].items()
    }
    return ReachMap(reached, stored["seconds"])


def _reached(folder: Path, modules: Sequence[str]) -> dict[str, Any]:
    from coverage import CoverageData

    data = CoverageData(str(folder / ".coverage"))
    data.read()
    numbers: dict[str, int] = {}
    lines: dict[str, dict[int, list[int]]] = {}
    for module in modules:
        lines[module] = {}
        for line, contexts in data.contexts_by_lineno(str(folder / module)).items():
            tests = {context.split("|")[0] for context in contexts if context}
            lines[module][line] = [numbers.setdefault(test, len(numbers)) for test in sorted(tests)]
    return {"tests": list(numbers), "lines": lines}


def _durations(output: str) -> dict[str, float]:
    seconds: defaultdict[str, float] = defaultdict(float)
    for cost, test in re.findall(r"^([\d.]+)s (?:call|setup|teardown) +(\S.*)$", output, re.MULTILINE):
        seconds[test.split("@")[0].strip()] += float(cost)
    return dict(seconds)


def _digest(folder: Path, modules: Sequence[str], tests: Sequence[str]) -> str:
    digest = hashlib.sha256("\n".join(tests).encode())
    for module in modules:
        digest.update(module.encode() + (folder / module).read_bytes())
    return digest.hexdigest()


def environment(folder: Path) -> dict[str, str]:
    """Return the environment in which a copy's own code is found first, and no compiled file is written."""
    return os.environ | {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
