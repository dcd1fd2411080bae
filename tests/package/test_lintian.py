"""Debian's own check of packages finds nothing; debian/hawk-drone.lintian-overrides has the exceptions' reasons."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.package.clean_root import CALM

pytestmark = pytest.mark.timeout(3600)


def test_lintian_finds_nothing(package: Path) -> None:
    command = ["lintian", "--allow-root", "--fail-on=error,warning", "--tag-display-limit=0", str(package)]
    done = subprocess.run([*CALM, *command], capture_output=True, text=True, timeout=3000, check=False)
    assert (done.returncode, done.stdout + done.stderr) == (0, "")
