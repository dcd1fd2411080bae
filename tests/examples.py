"""Examples of costly properties, and cases of costly tests, that `make test` leaves to `make nightly`."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import settings


def examples(each_night: int) -> int:
    """Return ``each_night`` under the profile of `make nightly`, and a quarter of it, at least 3, in `make test`."""
    return each_night if settings.get_current_profile_name() == "search" else max(3, each_night // 4)


def nightly(*cases: Any) -> list[Any]:
    """Return the cases of a parametrized test that are tried once a night: a tuple has a value for each name."""
    return [pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.nightly) for case in cases]
