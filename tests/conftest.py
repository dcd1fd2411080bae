"""Set-up of tests of every kind."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, settings

# No test is timed: a machine that others share may stop for half a second anywhere.
UNTIMED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("repeatable", UNTIMED, derandomize=True)
settings.register_profile("search", UNTIMED)
settings.load_profile("repeatable")

LIMITS_S = {"flight": 600, "integration": 600, "contract": 600, "e2e": 900}
"""Seconds for one test with its fixtures, by kind; the limit of all others stands in pyproject.toml."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give long kinds their limits, and begin with flights: one that began last would keep one core waiting."""
    for item in items:
        for kind, seconds in LIMITS_S.items():
            if item.get_closest_marker(kind):
                item.add_marker(pytest.mark.timeout(seconds))
    items.sort(key=lambda item: item.get_closest_marker("flight") is None)
