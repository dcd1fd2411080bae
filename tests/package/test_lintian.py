"""Debian's own check of packages finds nothing; debian/hawk-drone.lintian-overrides has the exceptions' reasons."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.package.clean_root import CALM

pytestmark = pytest.mark.timeout(3600)


def test_no_file_takes_the_place_of_a_link_of_the_system(package: Path) -> None:
    """In Debian 13 base-files owns /lib, a link to usr/lib."""
    listed = subprocess.run(["dpkg-deb", "--contents", str(package)], capture_output=True, text=True, check=True)
    names = {line.split()[5] for line in listed.stdout.splitlines()}
    assert {f"./usr/lib/systemd/system/hawk-{each}.service" for each in ("drone", "desk", "inbox")} <= names
    assert not [name for name in names if name.startswith(("./lib/", "./bin/", "./sbin/"))]


def test_lintian_finds_nothing(package: Path) -> None:
    command = ["lintian", "--allow-root", "--fail-on=error,warning", "--tag-display-limit=0", str(package)]
    done = subprocess.run([*CALM, *command], capture_output=True, text=True, timeout=3000, check=False)
    assert (done.returncode, done.stdout + done.stderr) == (0, "")
