"""Assemble a virtual environment from wheels, for a path and a processor that need not be this machine's.

``assemble_venv.py --wheels DIR --out DIR --final PATH --arch amd64|arm64``. Nothing is downloaded and nothing of the
wheels is run, so the environment for ARM64 is assembled on any machine. Its commands start the Python of ``PATH``,
where the package puts it (`hawk.versions.kept`); the links to Python are made there.
"""

from __future__ import annotations

import argparse
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
PYTHON: Final = "python3.11"
DIALECTS: Final = "pymavlink/dialects"
SPOKEN: Final = ("v20/ardupilotmega.py", "v20/__init__.py", "__init__.py")
"""The dialect of the simulator. The others, 46 MB of source, would be compiled for minutes on a small computer."""
TESTED: Final = ("numpy", "scipy", "shapely")
"""Packages whose own tests are in their wheels. Nothing of them is imported; they take 30 MB, compiled twice that."""
SETTINGS: Final = f"""\
home = /usr/bin
include-system-site-packages = false
version = 3.11
executable = /usr/bin/{PYTHON}
"""


class AssemblyError(Exception):
    """The wheels do not fit; the text names the one."""


def assemble(wheels: Path, out: Path, final: Path, arch: str) -> list[str]:
    """Install every wheel of a folder; return the file names.

    Args:
        wheels: Folder of wheels, all dependencies included.
        out: Folder to make.
        final: Path that the environment will have.
        arch: Debian's name of the processor.

    Raises:
        AssemblyError: A wheel is for another processor, or broken, or the program's own is missing.
    """
    found = sorted(wheels.glob("*.whl"))
    for wheel in found:
        check_platform(wheel.name, arch)
    packages = out / "lib" / PYTHON / "site-packages"
    scheme = {"purelib": packages, "platlib": packages, "headers": out / "include", "scripts": out / "bin", "data": out}
    destination = SchemeDictionaryDestination(
        {name: str(path) for name, path in scheme.items()}, interpreter=str(final / "bin" / PYTHON), script_kind="posix"
    )
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
    leave_out_tests(packages)
    (out / "pyvenv.cfg").write_text(SETTINGS, "ascii")
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


def leave_out_tests(packages: Path) -> None:
    """Remove the tests of other packages that are in their wheels."""
    for name in TESTED:
        for folder in [*(packages / name).rglob("tests")]:
            if folder.is_dir():
                shutil.rmtree(folder)


def check_platform(name: str, arch: str) -> None:
    """Raise AssemblyError for a wheel of another processor, by its file name (PEP 427)."""
    platforms = name.removesuffix(".whl").rpartition("-")[2].split(".")
    if not any(platform == "any" or platform.endswith(MACHINES[arch]) for platform in platforms):
        raise AssemblyError(f"{name}: is not for {arch}")


def main(arguments: list[str] | None = None) -> int:
    """Assemble; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--wheels", type=Path, required=True, metavar="DIR")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--final", type=Path, required=True, metavar="PATH")
    parser.add_argument("--arch", choices=list(MACHINES), required=True)
    options = parser.parse_args(arguments)
    try:
        installed = assemble(options.wheels, options.out, options.final, options.arch)
    except AssemblyError as error:
        print(f"assemble_venv: {error}", file=sys.stderr)
        return 1
    print(f"{options.out}: {len(installed)} wheels")
    return 0


if __name__ == "__main__":
    sys.exit(main())
