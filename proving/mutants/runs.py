"""Runs of the tests against mutants, in copies of the checkout, each in a process of its own."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from proving.mutants.modules import ALL_MODULES, COVERING, ROOT, own_files
from proving.mutants.reach import environment
from proving.mutants.sampling import Mutant, difference, mutated

IMPORTED_ONCE: Final = (
    "aiohttp.test_utils",
    "alembic.command",
    "cv2",
    "hypothesis",
    "mavsdk.asyncio",
    "numpy",
    "pydantic",
    "pymap3d",
    "scipy.optimize",
    "scipy.spatial",
    "shapely",
    "sqlalchemy.dialects.sqlite",
    "hawk.model.plans",
    "hawk.model.lot_map",
    "hawk.model.operation",
    "hawk.model.pictures",
    "hawk.model.plans",
    "hawk.model.poses",
    "hawk.model.vehicle",
    "hawk.config.sections",
)
"""Modules that every run needs and that import none of the modules under test."""

SURVIVED: Final = (0, 5)
"""Exit statuses of pytest when all tests pass and when there is none. A module that cannot be imported gives others."""

CONTROL_FAILED: Final = "control failed"
"""Outcome of the first tests of a process, run without a mutant, when they fail."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """Outcome for a mutant; ``shown``: the changed line before and after."""

    mutant: Mutant
    outcome: str
    shown: str
    seconds: float


class InOrder:
    """A pytest plugin: keep the chosen tests in their order, behind new ones that the map does not know."""

    def __init__(self, own: Sequence[str], tests: Sequence[str], known: frozenset[str]) -> None:
        self.own = own
        self._rank = {test: rank for rank, test in enumerate(tests)}
        self._known = known

    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        """Keep and order."""
        items[:] = sorted(filter(self._is_chosen, items), key=lambda item: self._rank.get(item.nodeid, -1))

    def _is_chosen(self, item: Any) -> bool:
        is_new = item.nodeid not in self._known and item.nodeid.split("::")[0] in self.own
        return is_new or item.nodeid in self._rank


def worker(folder: Path, known: frozenset[str], jobs: Any, verdicts: Any) -> None:
    """Take mutants with their tests from a queue until None comes; put verdicts."""
    os.chdir(folder)
    os.environ.update(environment(folder))
    sys.dont_write_bytecode = True
    sys.path[:] = [str(folder), *(path for path in sys.path if path not in ("", str(ROOT)))]
    for name in IMPORTED_ONCE:
        importlib.import_module(name)
    loaded = set(ALL_MODULES) & _loaded(folder)
    if loaded:
        raise RuntimeError(f"IMPORTED_ONCE imports modules under test: {sorted(loaded)}")
    is_first = True
    for mutant, tests, limit in iter(jobs.get, None):
        if is_first and _run(InOrder(own_files(mutant.module), tests, known), tests, limit) != "survived":
            verdicts.put(Verdict(mutant, CONTROL_FAILED, "", 0.0))
            return
        is_first = False
        verdicts.put(_try(folder, known, mutant, tests, limit))


def _loaded(folder: Path) -> set[str]:
    files = (getattr(module, "__file__", None) for module in list(sys.modules.values()))
    return {str(Path(file).relative_to(folder)) for file in files if file and file.startswith(f"{folder}/")}


def _try(folder: Path, known: frozenset[str], mutant: Mutant, tests: Sequence[str], limit: float) -> Verdict:
    path = folder / mutant.module
    source = path.read_text(encoding="utf-8")
    code = mutated(source, mutant)
    for compiled in (path.parent / "__pycache__").glob(f"{path.stem}.*.pyc"):
        compiled.unlink()  # it would count as the mutant's: its source has the same second and size
    began = time.monotonic()
    path.write_text(code, encoding="utf-8")
    try:
        outcome = _run(InOrder(own_files(mutant.module), tests, known), tests, limit)
    finally:
        path.write_text(source, encoding="utf-8")
    return Verdict(mutant, outcome, difference(source, code), time.monotonic() - began)


def _run(plugin: InOrder, tests: Sequence[str], limit: float) -> str:
    """Return what a process of its own finds: killed, survived, or timeout, which counts as killed."""
    child = os.fork()
    if not child:
        _test_and_exit(plugin, tests)
    ends = time.monotonic() + limit
    while time.monotonic() < ends:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return "survived" if os.waitstatus_to_exitcode(status) in SURVIVED else "killed"
        time.sleep(0.02)
    with suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return "timeout"


def _test_and_exit(plugin: InOrder, tests: Sequence[str]) -> None:
    status = 99
    try:
        os.setsid()
        nowhere = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(nowhere, stream)
        import pytest

        options = [
            "-x",
            "-q",
            "-p",
            "no:cacheprovider",
            "-p",
            "no:xdist",
            "-W",
            "ignore::pytest.PytestAssertRewriteWarning",
        ]
        files = dict.fromkeys((*plugin.own, *(test.split("::")[0] for test in tests)))
        status = int(pytest.main([*options, "-m", COVERING, *files], plugins=[plugin]))
    finally:
        os._exit(status)


def run_all(
    jobs: Sequence[tuple[Mutant, Sequence[str], float]], folders: Sequence[Path], known: frozenset[str]
) -> Iterator[Verdict]:
    """Yield the verdicts as they come."""
    context = multiprocessing.get_context("fork")
    queue, verdicts = context.Queue(), context.Queue()
    workers = [context.Process(target=worker, args=(folder, known, queue, verdicts), daemon=True) for folder in folders]
    for job in [*jobs, *[None] * len(workers)]:
        queue.put(job)
    for process in workers:
        process.start()
    for _ in jobs:
        verdict = verdicts.get()
        if verdict.outcome == CONTROL_FAILED:
            raise SystemExit(f"The tests of {verdict.mutant.module} fail without a mutant: mend them first.")
        yield verdict
    for process in workers:
        process.join()
