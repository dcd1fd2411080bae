from __future__ import annotations

import subprocess
import sys

import pytest

LOADED = "import sys, hawk.{module}; print(*sys.modules)"
STORE = {"sqlalchemy", "alembic", "hawk.lots.storage.database", "hawk.lots.ingest"}
LATER = {"scipy", "hawk.algo.manager", "hawk.algo.vision.app", "hawk.algo.mapper.app", "hawk.algo.path_plan.app"}


@pytest.mark.slow
@pytest.mark.parametrize(("module", "later"), [("daemon.start", set[str]()), ("daemon.algorithms", LATER)])
def test_a_daemon_that_starts_in_the_air_acts_before_vision_s_libraries_are_loaded(
    module: str, later: set[str]
) -> None:
    """They are as much to load as all the rest."""
    code = LOADED.format(module=module)
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert set(ended.stdout.split()) & (LATER | STORE) == later
