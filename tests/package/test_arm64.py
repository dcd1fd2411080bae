"""The package for ARM64 in an ARM64 root, by the emulator qemu-user: no such machine is needed."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.package.clean_root import CleanRoot
from tests.package.test_life import EVERY_MODULE

pytestmark = pytest.mark.timeout(3600)

EMULATOR = "/usr/bin/qemu-aarch64-static"
FRAME = """
import numpy
from hawk.algo.vision.network import StallNetwork
picture = numpy.random.default_rng(1).integers(0, 255, (128, 128, 3), numpy.uint8)
maps = StallNetwork.load().run(picture)
print(type(maps).__name__, maps.core.shape)
"""


@pytest.fixture(scope="module")
def version(package_arm64: Path) -> str:
    return package_arm64.name.split("_")[1]


@pytest.fixture(scope="module")
def interpreter(python: str) -> str:
    return f"/usr/bin/{python}"


@pytest.fixture(scope="module")
def root(arm64_root: CleanRoot, package_arm64: Path, version: str, interpreter: str) -> CleanRoot:
    """The package's files, linked as its script does it; compiled files are left out, since the emulator is slow."""
    shutil.copy(EMULATOR, arm64_root.path(EMULATOR))
    subprocess.run(["dpkg-deb", "--extract", str(package_arm64), str(arm64_root.folder)], check=True, timeout=900)
    venv = arm64_root.path(f"/opt/hawk/lib/venv-{version}")
    venv.parent.mkdir(parents=True)
    shutil.copytree(arm64_root.path("/usr/lib/hawk-drone/venv"), venv, copy_function=os.link)
    (venv / "bin" / "python").symlink_to(interpreter)
    arm64_root.path("/opt/hawk/current").symlink_to(f"/opt/hawk/lib/venv-{version}")
    return arm64_root


@pytest.fixture(scope="module")
def emulated(interpreter: str) -> tuple[str, ...]:
    """The emulated Python of the version in force."""
    return (EMULATOR, "-0", "/opt/hawk/current/bin/python", interpreter, "-B")


def test_debian_s_python_lists_the_version(root: CleanRoot, version: str, interpreter: str) -> None:
    command = (EMULATOR, interpreter, "-IB", "/usr/lib/hawk-drone/versions", "versions")
    assert root.run(*command).splitlines()[0] == f"{version}  in force, was never ready"


def test_every_module_is_imported(root: CleanRoot, emulated: tuple[str, ...]) -> None:
    assert int(root.run(*emulated, "-c", EVERY_MODULE, timeout=1800).splitlines()[-1]) > 200


def test_it_states_its_version(root: CleanRoot, emulated: tuple[str, ...], version: str) -> None:
    stated = root.run(*emulated, "/opt/hawk/current/bin/hawk-drone", "--version").split()[-1]
    assert stated == version.partition("+")[0]


def test_a_frame_goes_through_the_network_for_stalls(root: CleanRoot, emulated: tuple[str, ...]) -> None:
    said = root.run(*emulated, "-c", FRAME, timeout=1800).splitlines()
    assert said[-1] == "NetworkMaps (64, 64)"


def test_check_reads_the_settings(root: CleanRoot, emulated: tuple[str, ...]) -> None:
    """Its deadlines are those of a drone's computer, so an emulated one passes few; it answers each."""
    options = ("--config", "/etc/hawk/config.toml", "--store", "/opt/hawk/store", "--json")
    root.run(*emulated, "-c", "import os; os.makedirs('/opt/hawk/store', exist_ok=True)")
    printed = root.run(*emulated, "/opt/hawk/current/bin/hawk-drone", "check", *options, fails=True, timeout=1800)
    checks = {check["name"]: check for check in json.loads(printed[printed.index("{") :])["checks"]}
    assert checks["Configuration"]["outcome"] == "passed"
    assert {"Camera", "Autopilot", "Model"} <= set(checks)
