"""The packages that `make deb` built, and clean Debian roots to try them in."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from proving import bare_root
from tests.package.clean_root import CALM, CleanRoot
from tests.unit.packaging.scripts import load

ROOT = Path(__file__).resolve().parents[2]
WORK = ROOT / "build" / "deb"
BEFORE = "0.1.0"
"""Number of the package that is upgraded: the same tree."""
MIRROR = os.environ.get("DEB_MIRROR", bare_root.MIRROR)
RELEASES = load("deb/build_deb").RELEASES
NEEDS = ["base-files", "python3", "systemd", "systemd-sysv", "udev", "libstdc++6"]
"""Beside the release's Python. base-files has the links /bin and /lib of Debian 13."""


def built(pattern: str) -> Path:
    """Return the newest package that fits; skip without one."""
    found = sorted(ROOT.glob(pattern), key=lambda path: path.stat().st_mtime)
    if not found or os.geteuid() != 0:
        pytest.skip(f"{pattern} is not built, or this is not root: run make deb")
    return found[-1]


@pytest.fixture(scope="module", params=list(RELEASES))
def release(request: pytest.FixtureRequest) -> str:
    """The Debian of package and root."""
    return str(request.param)


@pytest.fixture(scope="module")
def python(release: str) -> str:
    """The command of that Debian's Python."""
    return f"python{RELEASES[release].python}"


@pytest.fixture(scope="module")
def package(release: str) -> Path:
    """The package of this tree for this processor."""
    return built(f"dist/hawk-drone_*+{RELEASES[release].suffix}_amd64.deb")


@pytest.fixture(scope="module")
def before(release: str) -> str:
    """The version of the package that is upgraded."""
    return f"{BEFORE}+{RELEASES[release].suffix}"


@pytest.fixture(scope="module")
def package_before(before: str) -> Path:
    """The package before it."""
    return built(f"build/deb/before/hawk-drone_{before}_amd64.deb")


@pytest.fixture(scope="module")
def version(package: Path) -> str:
    """The version of the package of this tree."""
    return package.name.split("_")[1]


@pytest.fixture(scope="module")
def package_arm64(release: str) -> Path:
    """The package of this tree for ARM64."""
    return built(f"dist/hawk-drone_*+{RELEASES[release].suffix}_arm64.deb")


def archive(release: str, name: str, *options: str, needs: Sequence[str] | None = None) -> Path:
    """Return the archive of a release's root with these packages; mmdebstrap makes it once."""
    path = WORK / "roots" / f"{release}-{name}.tar"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        partial = path.with_suffix(".partial.tar")
        wanted = [*NEEDS, f"python{RELEASES[release].python}"] if needs is None else needs
        include = [f"--include={','.join(wanted)}"] if wanted else []
        command = ["mmdebstrap", "--quiet", *options, *include, release, str(partial), MIRROR]
        subprocess.run([*CALM, *command], check=True, timeout=1800)
        partial.rename(path)
    return path


@pytest.fixture(scope="module")
def clean_root(release: str, tmp_path_factory: pytest.TempPathFactory) -> CleanRoot:
    """A root for one file of tests, of this processor."""
    if shutil.which("mmdebstrap") is None:
        pytest.skip("mmdebstrap is not installed: run make deb")
    path = archive(release, "amd64", "--variant=minbase")
    return CleanRoot.extract(path, tmp_path_factory.mktemp("root") / "debian")


@pytest.fixture(scope="module")
def arm64_root(release: str, tmp_path_factory: pytest.TempPathFactory) -> CleanRoot:
    """A root of ARM64, unpacked and not configured: that needs no registered emulator."""
    if shutil.which("mmdebstrap") is None or shutil.which("qemu-aarch64-static") is None:
        pytest.skip("mmdebstrap or qemu-aarch64-static is not installed: run make deb")
    path = archive(release, "arm64", "--variant=extract", "--architectures=arm64")
    return CleanRoot.extract(path, tmp_path_factory.mktemp("root") / "debian")
