"""The package for ARM64 in an ARM64 root, by the emulator qemu-user: no such machine is needed."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from hawk.versions.kept import INTERPRETER, PYTHONS
from tests.package.clean_root import CleanRoot
from tests.package.test_life import EVERY_MODULE

pytestmark = pytest.mark.timeout(3600)

EMULATOR = "/usr/bin/qemu-aarch64-static"
FRAME = """
import numpy
from hawk.algo.vision.network import StallNetwork
picture = numpy.random.default_rng(1).integers(0, 255, (128, 128, 3), numpy.uint8)
for engine in ("opencv", "onnxruntime"):
    maps = StallNetwork.load(None, engine).run(picture)
    print(engine, type(maps).__name__, maps.core.shape)
"""


@pytest.fixture(scope="module")
def version(package_arm64: Path) -> str:
    return package_arm64.name.split("_")[1]


@pytest.fixture(scope="module")
def root(arm64_root: CleanRoot, package_arm64: Path, version: str) -> CleanRoot:
    """The package's files, linked as its script does it; compiled files are left out, since the emulator is slow."""
    shutil.copy(EMULATOR, arm64_root.path(EMULATOR))
    subprocess.run(["dpkg-deb", "--extract", str(package_arm64), str(arm64_root.folder)], check=True, timeout=900)
    venv = arm64_root.path(f"/opt/hawk/lib/venv-{version}")
    venv.parent.mkdir(parents=True)
    shutil.copytree(arm64_root.path("/usr/lib/hawk-drone/venv"), venv, copy_function=os.link)
    for name in PYTHONS:
        (venv / "bin" / name).symlink_to(INTERPRETER)
    arm64_root.path("/opt/hawk/current").symlink_to(f"/opt/hawk/lib/venv-{version}")
    return arm64_root


@pytest.fixture(scope="module")
def python() -> tuple[str, ...]:
    """The emulated Python of the version in force."""
    return (EMULATOR, "-0", "/opt/hawk/current/bin/python", INTERPRETER.as_posix(), "-B")


def test_debian_s_python_lists_the_version(root: CleanRoot, version: str) -> None:
    emulated = (EMULATOR, INTERPRETER.as_posix(), "-IB", "/usr/lib/hawk-drone/versions", "versions")
    assert root.run(*emulated).splitlines()[0] == f"{version}  in force, was never ready"


def test_every_module_is_imported(root: CleanRoot, python: tuple[str, ...]) -> None:
    assert int(root.run(*python, "-c", EVERY_MODULE, timeout=1800).splitlines()[-1]) > 200


def test_it_states_its_version(root: CleanRoot, python: tuple[str, ...], version: str) -> None:
    assert root.run(*python, "/opt/hawk/current/bin/hawk-drone", "--version").split()[-1] == version


def test_a_frame_goes_through_the_network_for_stalls_in_both_engines(root: CleanRoot, python: tuple[str, ...]) -> None:
    said = root.run(*python, "-c", FRAME, timeout=1800).splitlines()
    assert said[-2:] == ["opencv NetworkMaps (64, 64)", "onnxruntime NetworkMaps (64, 64)"]


def test_check_reads_the_settings(root: CleanRoot, python: tuple[str, ...]) -> None:
    """Its deadlines are those of a drone's computer, so an emulated one passes few; it answers each."""
    options = ("--config", "/etc/hawk/config.toml", "--store", "/opt/hawk/store", "--json")
    root.run(*python, "-c", "import os; os.makedirs('/opt/hawk/store', exist_ok=True)")
    printed = root.run(*python, "/opt/hawk/current/bin/hawk-drone", "check", *options, fails=True, timeout=1800)
    checks = {check["name"]: check for check in json.loads(printed[printed.index("{") :])["checks"]}
    assert checks["Configuration"]["outcome"] == "passed"
    assert {"Camera", "Autopilot", "Model"} <= set(checks)
