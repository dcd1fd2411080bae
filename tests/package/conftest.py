"""The packages that `make deb` built, and clean Debian roots to try them in."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from benchmarks import bare_root
from tests.package.clean_root import CALM, CleanRoot

ROOT = Path(__file__).resolve().parents[2]
WORK = ROOT / "build" / "deb"
BEFORE = "0.1.0"
"""Number of the package that is upgraded: the same tree."""
MIRROR = os.environ.get("DEB_MIRROR", bare_root.MIRROR)
NEEDS = ["python3", "python3.11", "systemd", "systemd-sysv", "udev", "libstdc++6"]


def built(pattern: str) -> Path:
    """Return the newest package that fits; skip without one."""
    found = sorted(ROOT.glob(pattern), key=lambda path: path.stat().st_mtime)
    if not found or os.geteuid() != 0:
        pytest.skip(f"{pattern} is not built, or this is not root: run make deb")
    return found[-1]


@pytest.fixture(scope="session")
def package() -> Path:
    """The package of this tree for this processor."""
    return built("dist/hawk-drone_*_amd64.deb")


@pytest.fixture(scope="session")
def package_before() -> Path:
    """The one before it."""
    return built(f"build/deb/before/hawk-drone_{BEFORE}_amd64.deb")


@pytest.fixture(scope="session")
def package_arm64() -> Path:
    """The package of this tree for ARM64."""
    return built("dist/hawk-drone_*_arm64.deb")


def archive(name: str, *options: str, needs: Sequence[str] = NEEDS) -> Path:
    """Return the archive of a root with these packages; mmdebstrap makes it once."""
    path = WORK / "roots" / f"{name}.tar"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        partial = path.with_suffix(".partial.tar")
        include = [f"--include={','.join(needs)}"] if needs else []
        command = ["mmdebstrap", "--quiet", *options, *include, "bookworm", str(partial), MIRROR]
        subprocess.run([*CALM, *command], check=True, timeout=1800)
        partial.rename(path)
    return path


@pytest.fixture(scope="module")
def clean_root(tmp_path_factory: pytest.TempPathFactory) -> CleanRoot:
    """A root for one file of tests, of this processor."""
    if shutil.which("mmdebstrap") is None:
        pytest.skip("mmdebstrap is not installed: run make deb")
    return CleanRoot.extract(archive("amd64", "--variant=minbase"), tmp_path_factory.mktemp("root") / "debian")


@pytest.fixture(scope="module")
def arm64_root(tmp_path_factory: pytest.TempPathFactory) -> CleanRoot:
    """A root of ARM64, unpacked and not configured: that needs no registered emulator."""
    if shutil.which("mmdebstrap") is None or shutil.which("qemu-aarch64-static") is None:
        pytest.skip("mmdebstrap or qemu-aarch64-static is not installed: run make deb")
    path = archive("arm64", "--variant=extract", "--architectures=arm64")
    return CleanRoot.extract(path, tmp_path_factory.mktemp("root") / "debian")
