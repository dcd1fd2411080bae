"""Build a release: ``python packaging/release.py --sign KEY`` (or ``--unsigned``, to try it).

Wheel and source archive, and the Debian packages where ``make deb`` builds them, go to ``dist/VERSION`` with
``SHA256SUMS`` and its OpenPGP signature. Refused are a tree with changes, a commit without the tag ``vVERSION`` or with
another version's, and a version that the change log does not have.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parent.parent
SUMS: Final = "SHA256SUMS"
IN_THE_WHEEL: Final = (
    "hawk/web/static/index.html",
    "hawk/web/docs_site/index.html",
    "hawk/config.toml",
    "share/man/man1/hawk-drone.1",
)
"""Files, or their ends, that a wheel without is not released: what its build could have left out."""


class ReleaseError(RuntimeError):
    """Nothing can be released so; the text gives the remedy."""


def release(root: Path, key: str | None, build: Callable[[Path, Path], None]) -> list[Path]:
    """Build into ``dist/VERSION`` and return its files. Raises ReleaseError.

    Args:
        root: The repository.
        key: The OpenPGP key to sign with, None for no signature.
        build: Builds the packages of the repository into a folder.
    """
    version = check_tree(root)
    target = root / "dist" / version
    if target.exists():
        raise ReleaseError(f"{target.relative_to(root)} is there already: remove it")
    target.mkdir(parents=True)
    build(root, target)
    check_wheel(_wheel_beside_archive(target, version))
    (target / SUMS).write_text(checksums(target), encoding="ascii")
    if key is not None:
        sign(target / SUMS, key)
    return sorted(target.iterdir())


def check_tree(root: Path) -> str:
    """Return the version that the tree releases. Raises ReleaseError."""
    version = str(tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"])
    if changes := _git(root, "status", "--porcelain"):
        raise ReleaseError(f"the tree has changes: commit or remove {changes.splitlines()[0][3:]}")
    tags = [tag for tag in _git(root, "tag", "--points-at", "HEAD").split() if re.match(r"v\d", tag)]
    if tags != [f"v{version}"]:
        found = f"is tagged {', '.join(tags)}" if tags else "has no tag"
        raise ReleaseError(f"version is {version} and the commit {found}: tag it v{version} and nothing else")
    if not re.search(rf"^## {re.escape(version)}\b", (root / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE):
        raise ReleaseError(f"CHANGELOG.md has no section {version}: date the section Unreleased")
    return version


def build_packages(root: Path, target: Path) -> None:
    """Build wheel and source archive, and the Debian packages where the Makefile builds them. Raises ReleaseError."""
    environment = {**os.environ, "SOURCE_DATE_EPOCH": _git(root, "log", "-1", "--format=%ct")}
    _run(
        root, [sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-t", "wheel", "-d", str(target)], environment
    )
    if not re.search(r"^deb:", (root / "Makefile").read_text(encoding="utf-8"), re.MULTILINE):
        return
    _run(root, ["make", "deb"], environment)
    packages = list((root / "dist").glob(f"*_{target.name}+deb*_*.deb"))
    if not packages:
        raise ReleaseError(f"make deb left no package of {target.name} in dist: see its output")
    for package in packages:
        package.rename(target / package.name)


def check_wheel(wheel: Path) -> None:
    """Look for what a wheel must carry. Raises ReleaseError."""
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    missing = [wanted for wanted in IN_THE_WHEEL if not any(name.endswith(wanted) for name in names)]
    if missing:
        raise ReleaseError(f"{wheel.name} lacks {', '.join(missing)}: run make page docs, then build again")


def checksums(folder: Path) -> str:
    """Return the SHA-256 of each file, as ``sha256sum`` writes and reads it."""
    files = sorted(path for path in folder.iterdir() if path.is_file() and not path.name.startswith(SUMS))
    return "".join(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in files)


def sign(sums: Path, key: str) -> None:
    """Write the detached signature and verify it. Raises ReleaseError."""
    signature = sums.with_name(f"{sums.name}.asc")
    make = ["gpg", "--batch", "--yes", "--armor", "--local-user", key, "--output", str(signature), "--detach-sign"]
    _run(sums.parent, [*make, str(sums)])
    _run(sums.parent, ["gpg", "--batch", "--verify", str(signature), str(sums)])


def _wheel_beside_archive(folder: Path, version: str) -> Path:
    """Return the wheel. Raises ReleaseError where wheel or source archive are missing, or of another version."""
    wheels = list(folder.glob(f"hawk_drone-{version}-*.whl"))
    archives = list(folder.glob(f"hawk_drone-{version}.tar.gz"))
    if len(wheels) != 1 or len(archives) != 1:
        raise ReleaseError(f"the build left no wheel and source archive of {version}: see its output")
    return wheels[0]


def _git(root: Path, *arguments: str) -> str:
    run = subprocess.run(["git", *arguments], cwd=root, capture_output=True, text=True, check=False)
    if run.returncode:
        raise ReleaseError(f"git {arguments[0]}: {run.stderr.strip()}")
    return run.stdout.rstrip()


def _run(folder: Path, command: list[str], environment: dict[str, str] | None = None) -> None:
    try:
        status = subprocess.run(command, cwd=folder, env=environment, check=False).returncode
    except FileNotFoundError:
        raise ReleaseError(f"{command[0]} is not installed") from None
    if status:
        raise ReleaseError(f"{' '.join(command[:4])} ... ended with status {status}: see its output")


def main(arguments: list[str] | None = None) -> int:
    """Release; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    how = parser.add_mutually_exclusive_group(required=True)
    how.add_argument("--sign", metavar="KEY", help="fingerprint of the OpenPGP key; gpg must have its private part")
    how.add_argument("--unsigned", action="store_true", help="no signature: to try it")
    options = parser.parse_args(arguments)
    try:
        made = release(ROOT, options.sign, build_packages)
    except ReleaseError as error:
        print(f"release: {error}", file=sys.stderr)
        return 1
    for path in made:
        print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1e6:.2f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
