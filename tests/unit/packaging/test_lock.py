"""Every locked package has a wheel for each Python and processor that is supported: nothing is compiled on a drone."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from packaging.markers import Marker, default_environment
from packaging.tags import Tag, compatible_tags, cpython_tags
from packaging.utils import parse_wheel_filename

from tests.unit.packaging.scripts import load

build_deb = load("deb/build_deb")
ROOT = Path(__file__).parents[3]
LOCK = tomllib.loads((ROOT / "uv.lock").read_text(encoding="utf-8"))["package"]
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
"""Debian 12 has 3.11, Ubuntu 24.04 3.12, Debian 13 3.13; 3.14 is the newest."""
Package = dict[str, Any]


def environment(python: str, arch: str) -> dict[str, str]:
    machine = {"amd64": "x86_64", "arm64": "aarch64"}[arch]
    return {
        **{key: str(value) for key, value in default_environment().items()},
        "python_version": python, "python_full_version": f"{python}.0", "platform_machine": machine,
        "sys_platform": "linux", "platform_system": "Linux", "os_name": "posix", "implementation_name": "cpython",
        "platform_python_implementation": "CPython", "extra": "",
    }  # fmt: skip


def holds(marker: str, about: dict[str, str]) -> bool:
    return not marker or Marker(marker).evaluate(about)


def locked(about: dict[str, str]) -> Iterator[Package]:
    """Yield what the Debian package installs in that environment."""

    def entry(name: str) -> Package:
        found = [each for each in LOCK if each["name"] == name]
        fit = [each for each in found if any(holds(m, about) for m in each.get("resolution-markers", [""]))]
        assert len(fit) == 1, f"{name}: {len(fit)} versions are locked"
        one: Package = fit[0]
        return one

    program = entry("hawk-drone")
    extras = [each for name in build_deb.EXTRAS for each in program["optional-dependencies"][name]]
    waiting = [*program["dependencies"], *extras]
    seen: set[str] = set()
    while waiting:
        wanted = waiting.pop()
        if wanted["name"] in seen or not holds(wanted.get("marker", ""), about):
            continue
        seen.add(wanted["name"])
        found = entry(wanted["name"])
        waiting += found.get("dependencies", [])
        yield found


def tags(python: str, arch: str) -> set[Tag]:
    version = tuple(int(part) for part in python.split("."))
    platforms = build_deb.PLATFORMS[arch]
    of_python = cpython_tags(version, platforms=platforms)
    return {*of_python, *compatible_tags(version, f"cp{version[0]}{version[1]}", platforms)}


@pytest.mark.parametrize("arch", ["amd64", "arm64"])
@pytest.mark.parametrize("python", PYTHONS)
def test_every_locked_package_has_a_wheel(python: str, arch: str) -> None:
    fit = tags(python, arch)
    packages = list(locked(environment(python, arch)))
    assert len(packages) > 30
    for package in packages:
        names = [each["url"].rpartition("/")[2] for each in package.get("wheels", [])]
        assert any(parse_wheel_filename(name)[3] & fit for name in names), f"{package['name']} {package['version']}"


def test_the_workflow_tries_each_of_them() -> None:
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    assert all(f'"{python}"' in workflow for python in PYTHONS)
