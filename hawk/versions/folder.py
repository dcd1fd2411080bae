"""The folder of versions: a virtual environment for each, one in force, one before it.

    /opt/hawk/lib/venv-0.3.0/    a version, at the path that it was built for
    /opt/hawk/current            symbolic link to the version in force; the unit starts what is below it
    /opt/hawk/previous           symbolic link to the version that was in force before

dpkg owns none of these: it replaces the package's files while the drone may fly, and a daemon loads modules until its
end. They are hard links to the package's files where both are on one file system, so a version needs its space once.
Each step survives a power cut: a version gets its name when it is complete and on the disk, and a link is replaced by
rename(2).
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Final

PREFIX: Final = "venv-"
PYTHONS: Final = ("python", "python3")
"""Links to the interpreter, beside one of its own name."""
READY: Final = ".was-ready"
"""Mark in a version's folder: its daemon was ready (READY=1) at least once."""
FAILED: Final = ".failed"
"""Mark: it was left because it did not start."""
FAILURES: Final = ".failed-starts"
"""Number of its starts that failed before it was ever ready."""
_VERSION: Final = re.compile(r"[0-9][A-Za-z0-9.+~-]*")
_INTERPRETER: Final = re.compile(r"^executable = (/usr/bin/python3\.[0-9]+)$", re.MULTILINE)


class VersionError(Exception):
    """A version cannot be used; the text names the remedy."""


@dataclass(frozen=True, slots=True)
class Versions:
    """The versions below ``root``."""

    root: Path = Path("/opt/hawk")

    @property
    def current(self) -> str | None:
        """Version in force, None when there is none."""
        return self._named_by("current")

    @property
    def previous(self) -> str | None:
        """Version that was in force before it, None when there is none."""
        return self._named_by("previous")

    @property
    def kept(self) -> list[str]:
        """Every version that is there, complete, in the order of their names."""
        return sorted(p.name.removeprefix(PREFIX) for p in self._lib.glob(f"{PREFIX}*") if _is_complete(p))

    def folder(self, version: str) -> Path:
        """Return the folder of a version. Raises VersionError for a name that no version has."""
        if not _VERSION.fullmatch(version):
            raise VersionError(f"{version!r} is no version; `hawk-drone versions` lists those that are kept")
        return self._lib / f"{PREFIX}{version}"

    def prepare(self, package: Path, version: str) -> Path:
        """Copy a version from the package's files under a name that is not in use; return its folder.

        Compiled files are written into it, since a daemon cannot write them. Raises OSError, VersionError.
        """
        python = interpreter(package)
        fresh = self.folder(version).with_name(f".new-{version}")
        _remove(fresh)
        fresh.parent.mkdir(parents=True, exist_ok=True)
        _link_tree(package, fresh)
        for name in (*PYTHONS, python.name):
            (fresh / "bin" / name).symlink_to(python)
        _compile(python, fresh, self.folder(version))
        os.sync()
        return fresh

    def put(self, fresh: Path, version: str) -> None:
        """Give a prepared version its name; one of the same name is replaced."""
        folder, old = self.folder(version), self._lib / f".old-{version}"
        _remove(old)
        with contextlib.suppress(FileNotFoundError):
            folder.rename(old)
        fresh.rename(folder)
        _sync_folder(self._lib)
        _remove(old)

    def switch(self, version: str, previous: str | None) -> None:
        """Put a version in force, and note which one was before it. Raises VersionError when it is not there."""
        folder = self.folder(version)
        if not _is_complete(folder):
            raise VersionError(f"version {version} is not kept; kept: {', '.join(self.kept) or 'none'}")
        if previous is None:
            (self.root / "previous").unlink(missing_ok=True)
        else:
            self._point("previous", self.folder(previous))
        self._point("current", folder)
        _sync_folder(self.root)

    def has_python(self, version: str) -> bool:
        """Return True when the Python of a version is installed: an upgrade of Debian brings another one."""
        return (self.folder(version) / "bin" / PYTHONS[0]).exists()

    def prune(self) -> list[str]:
        """Remove what is neither in force nor the one before; return their versions."""
        wanted = {self.current, self.previous}
        removed = [version for version in self.kept if version not in wanted]
        stray = [p for name in (".new-*", ".old-*") for p in self._lib.glob(name)]
        for folder in [*stray, *(self.folder(version) for version in removed)]:
            _remove(folder)
        return removed

    def note_ready(self, version: str) -> None:
        """Note that a version's daemon was ready; it is never left by itself from now on."""
        folder = self.folder(version)
        (folder / READY).touch()
        for name in (FAILED, FAILURES):
            (folder / name).unlink(missing_ok=True)

    def was_ready(self, version: str) -> bool:
        """Return True when a version's daemon was ready once."""
        return (self.folder(version) / READY).exists()

    def note_failed_start(self, version: str) -> int:
        """Count a start that failed; return the number of them."""
        path = self.folder(version) / FAILURES
        try:
            before = int(path.read_text("ascii"))
        except (OSError, ValueError):  # none, or a power cut left an empty file
            before = 0
        path.write_text(f"{before + 1}\n", "ascii")
        return before + 1

    def note_failed(self, version: str) -> None:
        """Note that a version was left because it did not start."""
        (self.folder(version) / FAILED).touch()

    def has_failed(self, version: str) -> bool:
        """Return True when a version was left because it did not start."""
        return (self.folder(version) / FAILED).exists()

    @property
    def _lib(self) -> Path:
        return self.root / "lib"

    def _named_by(self, link: str) -> str | None:
        try:
            target = Path(os.readlink(self.root / link))
        except OSError:
            return None
        name = target.name
        is_ours = target.parent == self._lib and name.startswith(PREFIX) and _is_complete(target)
        return name.removeprefix(PREFIX) if is_ours else None

    def _point(self, link: str, folder: Path) -> None:
        fresh = self.root / f".{link}"
        fresh.unlink(missing_ok=True)
        fresh.symlink_to(folder)
        fresh.rename(self.root / link)


def interpreter(package: Path) -> Path:
    """Return Debian's Python for which the wheels of a package were chosen. Raises VersionError, OSError."""
    found = _INTERPRETER.search((package / "pyvenv.cfg").read_text("ascii"))
    if found is None:
        raise VersionError(f"{package / 'pyvenv.cfg'} names no Python of Debian; install the package again")
    path = Path(found[1])
    if not path.exists():
        raise VersionError(f"{path} is missing; run: apt-get install {path.name}")
    return path


def _compile(python: Path, fresh: Path, final: Path) -> None:
    """Write compiled files by the version's own Python; a module that it cannot compile is left as it is."""
    command = [str(python), "-IS", "-m", "compileall", "-qq", "-j", "1", "-s", str(fresh), "-p", str(final)]
    subprocess.run([*command, str(fresh / "lib")], check=False)


def _is_complete(folder: Path) -> bool:
    return (folder / "pyvenv.cfg").is_file()


def _remove(folder: Path) -> None:
    if folder.exists():
        shutil.rmtree(folder)


def _link_tree(source: Path, target: Path) -> None:
    """Copy a tree, files as hard links where the file system is the same."""

    def link(old: str, new: str) -> None:
        try:
            os.link(old, new)
        except OSError as error:
            if error.errno not in (errno.EXDEV, errno.EPERM, errno.EMLINK):
                raise
            shutil.copy2(old, new)

    shutil.copytree(source, target, copy_function=link)


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
