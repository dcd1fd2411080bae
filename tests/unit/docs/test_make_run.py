"""`make run` brings the documentation that the page leads to."""

from __future__ import annotations

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


def test_make_run_builds_the_documentation_before_the_daemon_where_it_is_missing(tmp_path: Path) -> None:
    command = ["make", "--dry-run", f"DOCS_SITE={tmp_path / 'index.html'}", "run"]
    steps = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert 0 <= steps.find("packaging/docs_site.py") < steps.find("bin/hawk-drone --config")
