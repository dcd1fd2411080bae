"""Assemble a virtual environment from wheels, for a path and a processor that need not be this machine's.

``assemble_venv.py --wheels DIR --out DIR --final PATH --arch amd64|arm64 --python 3.11``. Nothing is downloaded and
nothing of the wheels is run, so the environment for ARM64, or for another Debian, is assembled on any machine. Its
commands start the Python of ``PATH``, where the package puts it (`hawk.versions.folder`); the links to Python are made
there. What a drone never loads is left out, by whole files: none is changed.
"""

from __future__ import annotations

import argparse
import re
import shutil
import sys
import zipfile
from pathlib import Path
from typing import Final

from installer import install
from installer.destinations import SchemeDictionaryDestination
from installer.exceptions import InstallerError
from installer.sources import WheelFile

MACHINES: Final = {"amd64": "x86_64", "arm64": "aarch64"}
"""Debian's names of processors, and those of wheels."""
COMMAND: Final = "hawk-drone"
"""The one command that is kept; those of other packages need what is not installed here."""
DIALECTS: Final = "pymavlink/dialects"
SPOKEN: Final = ("v20/ardupilotmega.py", "v20/__init__.py", "__init__.py")
"""The dialect of the simulator. The others, 46 MB of source, would be compiled for minutes on a small computer."""
SKIPPED: Final = frozenset({"lxml", "pygments"})
"""Wheels that another one names and that nothing here loads: pymavlink's generator of dialects reads XML by lxml, rich
colours source code by pygments. They take 21 MB, compiled."""
UNUSED: Final = {
    "numpy": ("distutils",),
    "scipy": (
        *("cluster", "datasets", "differentiate", "fftpack", "integrate", "interpolate", "io", "ndimage", "odr"),
        *("signal", "stats"),
    ),
    "zstandard": ("_cffi*", "backend_rust*"),
}
"""Parts of packages that are never imported, 45 MB compiled. ``zstandard`` has its decoder once for each kind of
Python. tests/unit/packaging/test_left_out.py imports every module of hawk without them."""
TESTED: Final = ("numpy", "pymap3d", "scipy", "shapely")
"""Packages whose own tests are in their wheels. Nothing of them is imported; they take 30 MB, compiled twice that."""
TO_COMPILE: Final = frozenset({".a", ".c", ".h", ".hpp", ".pxd", ".pxi", ".pyi", ".pyx"})
"""Ends of files that others compile or type-check against: 6 MB."""
SETTINGS: Final = """\
home = /usr/bin
include-system-site-packages = false
version = {version}
executable = /usr/bin/python{version}
"""


class AssemblyError(Exception):
    """The wheels do not fit; the text names the one."""


def assemble(wheels: Path, out: Path, final: Path, arch: str, python: str) -> list[str]:
    """Install the wheels of a folder but those that are `SKIPPED`; return the file names.

    Args:
        wheels: Folder of wheels, all dependencies included.
        out: Folder to make.
        final: Path that the environment will have.
        arch: Debian's name of the processor.
        python: The release's Python, "3.11".

    Raises:
        AssemblyError: A wheel is for another processor or Python, or broken, or the program's own is missing.
    """
    found = sorted(path for path in wheels.glob("*.whl") if path.name.partition("-")[0].lower() not in SKIPPED)
    for wheel in found:
        check_tags(wheel.name, arch, python)
    name = f"python{python}"
    packages = out / "lib" / name / "site-packages"
    scheme = {"purelib": packages, "platlib": packages, "headers": out / "include", "scripts": out / "bin", "data": out}
    paths = {key: str(path) for key, path in scheme.items()}
    destination = SchemeDictionaryDestination(paths, interpreter=str(final / "bin" / name), script_kind="posix")
    for wheel in found:
        try:
            with WheelFile.open(wheel) as source:
                install(source, destination, {"INSTALLER": b"hawk-drone\n"})
        except (InstallerError, zipfile.BadZipFile, OSError, ValueError) as error:
            raise AssemblyError(f"{wheel.name}: {error}") from error
    if not (out / "bin" / COMMAND).is_file():
        raise AssemblyError(f"{wheels}: no wheel brings the command {COMMAND}; is the program's own wheel there?")
    for script in (out / "bin").iterdir():
        if script.name != COMMAND:
            script.unlink()
    leave_out_dialects(packages / DIALECTS)
    leave_out_unused(packages)
    (out / "pyvenv.cfg").write_text(SETTINGS.format(version=python), "ascii")
    return [wheel.name for wheel in found]


def leave_out_dialects(folder: Path) -> None:
    """Remove pymavlink's dialects but the one that is spoken.

    Raises AssemblyError where that one is not there.
    """
    if not folder.is_dir():
        return
    spoken = {folder / name for name in SPOKEN}
    if missing := sorted(str(path) for path in spoken if not path.is_file()):
        raise AssemblyError(f"pymavlink has no {missing[0]}")
    for path in folder.rglob("*"):
        if path.is_file() and path not in spoken:
            path.unlink()


def leave_out_unused(packages: Path) -> None:
    """Remove parts that are never loaded: those of `UNUSED`, tests of other packages, and sources of compiled files."""
    unused = [path for name, parts in UNUSED.items() for part in parts for path in (packages / name).glob(part)]
    tests = [folder for name in TESTED for folder in (packages / name).rglob("tests") if folder.is_dir()]
    sources = [path for path in packages.rglob("*") if path.suffix in TO_COMPILE]
    for path in (*unused, *tests, *sources):
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)


def check_tags(name: str, arch: str, python: str) -> None:
    """Raise AssemblyError for a wheel of another processor or Python, by its file name (PEP 427)."""
    pythons, abi, platforms = (part.split(".") for part in name.removesuffix(".whl").rsplit("-", 3)[1:])
    if not any(platform == "any" or platform.endswith(MACHINES[arch]) for platform in platforms):
        raise AssemblyError(f"{name}: is not for {arch}")
    ours = f"cp{python.replace('.', '')}"
    fits = (ours in pythons and ours in abi) or (abi == ["none"] and "py3" in pythons)
    if abi == ["abi3"]:  # a module for this Python and every later one
        fits = any(re.fullmatch(r"cp3\d+", tag) and int(tag[3:]) <= int(ours[3:]) for tag in pythons)
    if not fits:
        raise AssemblyError(f"{name}: is not for Python {python}")


def main(arguments: list[str] | None = None) -> int:
    """Assemble; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--wheels", type=Path, required=True, metavar="DIR")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--final", type=Path, required=True, metavar="PATH")
    parser.add_argument("--arch", choices=list(MACHINES), required=True)
    parser.add_argument("--python", required=True, metavar="3.N", help="of the release that it is for")
    options = parser.parse_args(arguments)
    try:
        installed = assemble(options.wheels, options.out, options.final, options.arch, options.python)
    except AssemblyError as error:
        print(f"assemble_venv: {error}", file=sys.stderr)
        return 1
    print(f"{options.out}: {len(installed)} wheels")
    return 0


if __name__ == "__main__":
    sys.exit(main())
