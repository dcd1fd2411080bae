"""Build the container's image: ``python packaging/container/build_container.py``, or ``make container``.

1. ``packaging/deb/build_deb.py --wheels`` downloads the wheels that ``uv.lock`` locks, by their hashes, and builds the
   program's own: the same as in the Debian package.
2. They are linked into a folder of their own with the settings of the image (``build/container``): an engine is handed
   that folder, so that nothing else of a checkout, a token say, can get into an image.
3. podman, docker or buildah builds ``packaging/container/Containerfile`` there.

``--target blueos`` builds the extension for BlueOS. What stands behind ``--`` is handed to the engine.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
CONTAINERFILE: Final = Path("packaging/container/Containerfile")
ENGINES: Final = ("podman", "docker", "buildah")
DOCKER_FORMAT: Final = frozenset({"podman", "buildah"})
"""Engines whose own format (OCI) has no HEALTHCHECK."""
ARCHITECTURES: Final = {"x86_64": "amd64", "aarch64": "arm64"}
SETTINGS: Final = {
    "drone": (("web.host", "127.0.0.1", "0.0.0.0"),),  # noqa: S104 - the container's own network; a token is asked for
    "blueos": (
        ("web.host", "127.0.0.1", "0.0.0.0"),  # noqa: S104 - BlueOS looks for such ports only
        ("autopilot.url", "udpin://127.0.0.1:14550", "tcpout://127.0.0.1:5777"),
        ("web.allowed_hosts", "[]", '["blueos.local", "blueos-avahi.local", "blueos-hotspot.local"]'),
    ),
}
"""By target: setting, its value in ``config.toml``, and its value in the image. BlueOS's autopilot manager serves
MAVLink at 127.0.0.1:5777, and its beacon announces these names."""


class ContainerError(Exception):
    """The image cannot be built; the text names the step and the remedy."""


def build(root: Path, engine: str, target: str, arch: str, options: Sequence[str] = ()) -> str:
    """Build one image; return its name.

    Args:
        root: The project.
        engine: One of `ENGINES`.
        target: One of `SETTINGS`.
        arch: Debian's name of the processor.
        options: Further options of the engine.

    Raises:
        ContainerError: A step failed.
    """
    version = str(tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["project"]["version"])
    wheels = run([sys.executable, str(root / "packaging/deb/build_deb.py"), f"--arch={arch}", "--wheels"])
    folder = prepare(root, Path(wheels.splitlines()[-1]), root / "build" / "container" / f"{target}-{arch}", target)
    name = image_name(target, version)
    command = [engine, "build", "--file", str(root / CONTAINERFILE), "--target", target, "--tag", name]
    command += ["--build-arg", f"VERSION={version}"]
    if arch != own_arch():
        command += ["--platform", f"linux/{arch}"]
    if Path(engine).name in DOCKER_FORMAT:
        command += ["--format", "docker"]
    if subprocess.run([*command, *options, str(folder)], check=False).returncode:
        raise ContainerError(f"{engine} build failed: see its output")
    return name


def image_name(target: str, version: str) -> str:
    """Return the local name of an image."""
    return f"hawk-drone{'' if target == 'drone' else f'-{target}'}:{version}"


def own_arch() -> str:
    """Return Debian's name of this computer's processor. Raises ContainerError for one that has no wheels."""
    try:
        return ARCHITECTURES[platform.machine()]
    except KeyError:
        raise ContainerError(
            f"{platform.machine()}: there are images for amd64 and arm64; name one by --arch"
        ) from None


def find_engine(which: Callable[[str], str | None] = shutil.which) -> str:
    """Return the first engine that is installed and answers. Raises ContainerError."""
    installed = [name for name in ENGINES if which(name) is not None]
    for name in installed:
        if subprocess.run([name, "info"], capture_output=True, check=False).returncode == 0:
            return name
    silent = f" ({', '.join(installed)}: installed, and does not answer: is its service started?)" if installed else ""
    raise ContainerError(f"no container engine answers{silent}; install one: apt install podman")


def prepare(root: Path, wheels: Path, folder: Path, target: str) -> Path:
    """Make the folder that the image is built in: ``wheels`` and ``settings``. Raises ContainerError."""
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "settings").mkdir(parents=True)
    text = settings((root / "config.toml").read_text("utf-8"), target)
    (folder / "settings" / "config.toml").write_text(text, "utf-8")
    shutil.copytree(wheels, folder / "wheels", copy_function=os.link)
    return folder


def settings(text: str, target: str) -> str:
    """Return ``config.toml`` with the values of a target. Raises ContainerError where one is not there as expected."""
    for name, before, after in SETTINGS[target]:
        section, _, key = name.partition(".")
        pattern = rf"^\[{section}\]$(?:\n(?!\[).*)*?\n{key} = (?P<value>{re.escape(_toml(before))})$"
        found = list(re.finditer(pattern, text, flags=re.MULTILINE))
        if len(found) != 1:
            raise ContainerError(f"config.toml: {name} is not {_toml(before)}: see SETTINGS in {Path(__file__).name}")
        text = text[: found[0].start("value")] + _toml(after) + text[found[0].end("value") :]
    return text


def _toml(value: str) -> str:
    """Return a value as ``config.toml`` writes it: a list stands as it is."""
    return value if value.startswith("[") else f'"{value}"'


def run(command: Sequence[str]) -> str:
    """Run a step; return its output. Raises ContainerError with what it printed."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise ContainerError((done.stderr or done.stdout).strip())
    return done.stdout


def main(arguments: list[str] | None = None) -> int:
    """Build; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--target", choices=list(SETTINGS), default="drone")
    parser.add_argument(
        "--arch", choices=list(ARCHITECTURES.values()), help="another processor: the engine emulates it"
    )
    parser.add_argument("--engine", choices=ENGINES, help="the first that answers, when it is not named")
    parser.add_argument("options", nargs="*", metavar="OPTION", help="further options of the engine, behind --")
    chosen = parser.parse_args(arguments)
    try:
        engine = chosen.engine or find_engine()
        name = build(ROOT, engine, chosen.target, chosen.arch or own_arch(), chosen.options)
    except ContainerError as error:
        print(f"build_container: {error}", file=sys.stderr)
        return 1
    print(f"{name}: built by {engine}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
