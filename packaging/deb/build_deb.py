"""Build the Debian package: ``python packaging/deb/build_deb.py --arch amd64|arm64``.

1. `uv export` lists what ``uv.lock`` locks, with hashes; pip downloads those wheels for the processor, and no others.
2. The tree is copied, so that nothing is written into it; the program's own wheel is built there.
3. dpkg-buildpackage assembles the package without a network (``debian/rules``).

``--version V`` builds the same tree under another number, for the test of an upgrade. ``--wheels`` ends before the
third step and prints the folder of wheels, for the container's image. Folders: ``build/deb`` for wheels and trees,
``dist`` for the package.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
PLATFORMS: Final = {
    "amd64": ("manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64"),
    "arm64": ("manylinux_2_28_aarch64", "manylinux_2_27_aarch64", "manylinux_2_17_aarch64", "manylinux2014_aarch64"),
}
"""Wheels for Debian 12 (glibc 2.36) by Debian's name of the processor."""
EXTRAS: Final = ("onnxruntime", "sim")
"""Extras of pyproject.toml that the package has: nobody adds one to it afterwards."""
LOCK_HOSTS: Final = frozenset({"pypi.org", "files.pythonhosted.org"})
"""A lock file that names another host was made from somebody's mirror."""

BUILT: Final = {Path("hawk/web/static"): "make page", Path("hawk/web/docs_site"): "make docs"}
"""Folders that the program's wheel carries and git does not know, with the command that builds each."""
LIST: Final = "requirements.txt"
"""The locked wheels with their hashes, beside them."""
COMPRESSION: Final = "-Zxz -z2"
"""Debian's own format; Debian 12's lintian reads no zstd. A higher level takes longer, here and on the drone."""


class BuildError(Exception):
    """The package cannot be built; the text names the step and the remedy."""


def build(root: Path, arch: str, out: Path, version: str | None = None) -> Path:
    """Build one package; return its path.

    Args:
        root: The project.
        arch: Debian's name of the processor.
        out: Folder for the package.
        version: Another version than that of ``pyproject.toml``.

    Raises:
        BuildError: A step failed.
    """
    version = version or project_version(root)
    tree, wheels = build_wheels(root, arch, version)
    environment = {**os.environ, "DEB_WHEELS": str(wheels), "DEB_PACK_OPTIONS": COMPRESSION}
    command = ["dpkg-buildpackage", "--build=binary", "--no-sign", f"--host-arch={arch}", "--no-check-builddeps"]
    run(command, tree, environment)
    out.mkdir(parents=True, exist_ok=True)
    name = f"hawk-drone_{version}_{arch}.deb"
    return Path(shutil.move(tree.parent / name, out / name))


def build_wheels(root: Path, arch: str, version: str) -> tuple[Path, Path]:
    """Return a copy of the tree, and a folder with the locked wheels, their list and the program's own wheel.

    Raises BuildError.
    """
    work = root / "build" / "deb"
    locked = download(root, arch, work / "wheels" / arch)
    tree = stage(root, work / f"{version}-{arch}" / "hawk-drone", version)
    wheels = work / f"{version}-{arch}" / "wheels"
    gather(locked, wheels)
    pip = [sys.executable, "-m", "pip"]
    run([*pip, "wheel", "--quiet", "--no-deps", "--no-build-isolation", f"--wheel-dir={wheels}", "."], tree)
    return tree, wheels


def project_version(root: Path) -> str:
    """Return the version. Raises BuildError where ``debian/changelog`` has another one."""
    wanted = str(tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["project"]["version"])
    found = re.match(r"hawk-drone \(([^)]+)\)", (root / "debian" / "changelog").read_text("utf-8"))
    if found is None or found.group(1) != wanted:
        raise BuildError(f"debian/changelog: its first entry must be of version {wanted}, as in pyproject.toml")
    return wanted


def requirements(root: Path) -> str:
    """Return the locked wheels of the program, its simulator and both engines, with hashes. Raises BuildError."""
    hosts = set(re.findall(r"https?://([^/\"]+)", (root / "uv.lock").read_text("utf-8")))
    if hosts - LOCK_HOSTS:
        raise BuildError(
            f"uv.lock: names {', '.join(sorted(hosts - LOCK_HOSTS))}; lock it from https://pypi.org/simple"
        )
    extras = [f"--extra={name}" for name in EXTRAS]
    options = ["--frozen", "--no-dev", *extras, "--no-emit-project", "--no-header", "--format=requirements-txt"]
    return run([sys.executable, "-m", "uv", "export", "--quiet", *options], root)


def download(root: Path, arch: str, folder: Path) -> Path:
    """Download the locked wheels of a processor, unless they are there; return their folder. Raises BuildError."""
    wanted = requirements(root)
    stamp = folder / ".requirements"
    digest = hashlib.sha256(wanted.encode()).hexdigest()
    if stamp.is_file() and stamp.read_text("ascii") == digest:
        return folder
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    listed = folder / LIST
    listed.write_text(wanted, "utf-8")
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--require-hashes"]
    command += ["--only-binary=:all:", "--python-version=3.11", "--implementation=cp"]
    command += [f"--abi={abi}" for abi in ("cp311", "abi3", "none")]
    command += [f"--platform={platform}" for platform in PLATFORMS[arch]]
    run([*command, "--requirement", str(listed), "--dest", str(folder)], root)
    stamp.write_text(digest, "ascii")
    return folder


def stage(root: Path, tree: Path, version: str) -> Path:
    """Copy what git knows, the built page and documentation, under a version; return the copy.

    Raises BuildError where one of these two is not built.
    """
    shutil.rmtree(tree.parent, ignore_errors=True)
    listed = run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], root)
    for name in filter(None, listed.split("\0")):
        source, target = root / name, tree / name
        if source.is_symlink() or source.is_file():  # one that was removed is still listed
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source, target, follow_symlinks=False)
    for built, command in BUILT.items():
        if not (root / built / "index.html").is_file():
            raise BuildError(f"{built}: is not built; run: {command}")
        shutil.copytree(root / built, tree / built)
    replace_once(tree / "pyproject.toml", r'^version = "[^"]+"', f'version = "{version}"')
    replace_once(tree / "debian" / "changelog", r"\A(hawk-drone) \([^)]+\)", rf"\1 ({version})")
    return tree


def replace_once(path: Path, pattern: str, text: str) -> None:
    """Replace the first match in a file. Raises BuildError where there is none."""
    changed, count = re.subn(pattern, text, path.read_text("utf-8"), count=1, flags=re.MULTILINE)
    if not count:
        raise BuildError(f"{path}: has no line that fits {pattern}")
    path.write_text(changed, "utf-8")


def gather(wheels: Path, own: Path) -> None:
    """Link the downloaded wheels and their list into the folder that gets the program's own."""
    own.mkdir(parents=True)
    for file in (*wheels.glob("*.whl"), wheels / LIST):
        os.link(file, own / file.name)


def run(command: Sequence[str], folder: Path, environment: dict[str, str] | None = None) -> str:
    """Run a step; return its output. Raises BuildError with the end of what it printed."""
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        words = "\n".join((done.stdout + done.stderr).splitlines()[-40:])
        raise BuildError(f"{' '.join(command[:6])} ... failed with status {done.returncode}:\n{words}")
    return done.stdout


def main(arguments: list[str] | None = None) -> int:
    """Build; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--arch", choices=list(PLATFORMS), required=True)
    parser.add_argument("--out", type=Path, default=ROOT / "dist", metavar="DIR")
    parser.add_argument("--version", metavar="V", help="another version, for tests")
    parser.add_argument("--wheels", action="store_true", help="no package: print the folder of its wheels")
    options = parser.parse_args(arguments)
    try:
        if options.wheels:
            print(build_wheels(ROOT, options.arch, options.version or project_version(ROOT))[1])
            return 0
        path = build(ROOT, options.arch, options.out.resolve(), options.version)
    except BuildError as error:
        print(f"build_deb: {error}", file=sys.stderr)
        return 1
    print(f"{path}: {path.stat().st_size / 1e6:.0f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
