"""Set-up of tests of every kind."""

from __future__ import annotations

import gc
import os
from collections.abc import Generator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# No test is timed: a machine that others share may stop for half a second anywhere.
UNTIMED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("repeatable", UNTIMED, derandomize=True, max_examples=30)
settings.register_profile("search", UNTIMED)
settings.load_profile("repeatable")

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the units do; threads that wait for each other spin

LONG = ("flight", "slow")
"""Kinds of unit tests whose files begin first, the longest at first."""
LIMITS_S = {"flight": 600, "integration": 600, "contract": 600, "e2e": 900, "nightly": 600, "slow": 300}
"""Seconds for one test with its fixtures, by kind; the limit of all others stands in pyproject.toml."""

LOG_TAIL = 4_000
"""Characters."""

gc.disable()  # until all tests are collected: thousands of them stay, and would be looked at again and again


def pytest_collection_finish() -> None:
    """Collect garbage again, but leave alone what collecting the tests has made."""
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give long kinds their limits, and begin with long files: one that began last would keep one core waiting."""
    ranks: dict[Path, int] = {}
    for item in items:
        for kind, seconds in LIMITS_S.items():
            if item.get_closest_marker(kind):
                item.add_marker(pytest.mark.timeout(seconds))
        ranks[item.path] = min(_rank(item), ranks.get(item.path, len(LONG)))
    items.sort(key=lambda item: ranks[item.path])


def _rank(item: pytest.Item) -> int:
    return next((rank for rank, kind in enumerate(LONG) if item.get_closest_marker(kind)), len(LONG))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Show the ends of the programs' logs with a failed test."""
    report = yield
    folder = getattr(item, "funcargs", {}).get("tmp_path")
    if report.failed and folder is not None:
        for log in sorted(folder.rglob("hawk-*.log")):
            report.sections.append((log.name, log.read_text(errors="replace")[-LOG_TAIL:]))
    return report
