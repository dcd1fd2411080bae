"""Build the Debian package: ``python packaging/deb/build_deb.py --arch amd64|arm64 [--release bookworm|trixie]``.

1. `uv export` lists what ``uv.lock`` locks, with hashes; of it, pip downloads the wheels for the release's Python and
   the processor, and no others.
2. The tree is copied, so that nothing is written into it; the program's own wheel is built there.
3. dpkg-buildpackage assembles the package without a network (``debian/rules``).

``--version V`` builds the same tree under another number, for the test of an upgrade. ``--wheels`` ends before the
third step and prints the folder of wheels, for the container's image. Folders: ``build/deb`` for wheels and trees,
``dist`` for the package. A package of a later release has a higher version, so it replaces the one of the release
before.
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
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final, NamedTuple

from packaging.markers import Marker, default_environment

ROOT: Final = Path(__file__).resolve().parents[2]
PLATFORMS: Final = {
    "amd64": ("manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64"),
    "arm64": ("manylinux_2_28_aarch64", "manylinux_2_27_aarch64", "manylinux_2_17_aarch64", "manylinux2014_aarch64"),
}
"""Wheels for Debian 12 (glibc 2.36) and later by Debian's name of the processor."""
MACHINES: Final = {"amd64": "x86_64", "arm64": "aarch64"}
EXTRAS: Final = ("sim",)
"""Extras of pyproject.toml that the package has: nobody adds one to it afterwards. Not ONNX Runtime: it takes 80 MB and
three quarters of OpenCV's time."""
LOCK_HOSTS: Final = frozenset({"pypi.org", "files.pythonhosted.org"})
"""A lock file that names another host was made from somebody's mirror."""

BUILT: Final = {Path("hawk/web/static"): "make page", Path("hawk/web/docs_site"): "make docs"}
"""Folders that the program's wheel carries and git does not know, with the command that builds each."""
LIST: Final = "requirements.txt"
"""The locked wheels of a release and a processor with their hashes, beside them."""
COMPRESSION: Final = "-Zxz -z2"
"""Debian's own format; Debian 12's lintian reads no zstd. A higher level takes longer, here and on the drone."""


class Release(NamedTuple):
    """A release of Debian: the end of the package's version there, and its Python."""

    suffix: str
    python_full: str

    @property
    def python(self) -> str:
        """The Python's version as its command has it, "3.11"."""
        return self.python_full.rpartition(".")[0]


RELEASES: Final = {"bookworm": Release("deb12", "3.11.2"), "trixie": Release("deb13", "3.13.5")}
"""By the name that Debian's archive has for it."""


class BuildError(Exception):
    """The package cannot be built; the text names the step and the remedy."""


def build(root: Path, arch: str, release: str, out: Path, version: str | None = None) -> Path:
    """Build one package; return its path.

    Args:
        root: The project.
        arch: Debian's name of the processor.
        release: One of `RELEASES`.
        out: Folder for the package.
        version: Another version than that of ``pyproject.toml``.

    Raises:
        BuildError: A step failed.
    """
    version = version or project_version(root)
    tree, wheels = build_wheels(root, arch, release, version)
    python = RELEASES[release].python
    environment = {**os.environ, "DEB_WHEELS": str(wheels), "DEB_PYTHON": python, "DEB_PACK_OPTIONS": COMPRESSION}
    command = ["dpkg-buildpackage", "--build=binary", "--no-sign", f"--host-arch={arch}", "--no-check-builddeps"]
    run(command, tree, environment)
    out.mkdir(parents=True, exist_ok=True)
    name = f"hawk-drone_{package_version(version, release)}_{arch}.deb"
    return Path(shutil.move(tree.parent / name, out / name))


def build_wheels(root: Path, arch: str, release: str, version: str) -> tuple[Path, Path]:
    """Return a copy of the tree, and a folder with the locked wheels, their list and the program's own wheel.

    Raises BuildError.
    """
    work = root / "build" / "deb"
    locked = download(root, arch, release, work / "wheels" / f"{release}-{arch}")
    tree = stage(root, work / f"{version}-{release}-{arch}" / "hawk-drone", version, release)
    wheels = tree.parent / "wheels"
    gather(locked, wheels)
    pip = [sys.executable, "-m", "pip"]
    run([*pip, "wheel", "--quiet", "--no-deps", "--no-build-isolation", f"--wheel-dir={wheels}", "."], tree)
    return tree, wheels


def package_version(version: str, release: str) -> str:
    """Return the package's version in a release: "0.2.0+deb12"."""
    return f"{version}+{RELEASES[release].suffix}"


def project_version(root: Path) -> str:
    """Return the version. Raises BuildError where ``debian/changelog`` has another one."""
    wanted = str(tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["project"]["version"])
    found = re.match(r"hawk-drone \(([^)]+)\)", (root / "debian" / "changelog").read_text("utf-8"))
    if found is None or found.group(1) != wanted:
        raise BuildError(f"debian/changelog: its first entry must be of version {wanted}, as in pyproject.toml")
    return wanted


def requirements(root: Path) -> str:
    """Return what is locked of the program and its simulator for every Python, with hashes. Raises BuildError."""
    hosts = set(re.findall(r"https?://([^/\"]+)", (root / "uv.lock").read_text("utf-8")))
    if hosts - LOCK_HOSTS:
        raise BuildError(
            f"uv.lock: names {', '.join(sorted(hosts - LOCK_HOSTS))}; lock it from https://pypi.org/simple"
        )
    extras = [f"--extra={name}" for name in EXTRAS]
    options = ["--frozen", "--no-dev", *extras, "--no-emit-project", "--no-header", "--format=requirements-txt"]
    return run([sys.executable, "-m", "uv", "export", "--quiet", *options], root)


def chosen(listed: str, arch: str, release: str) -> str:
    """Return the lines of a list that hold for a release and a processor, without their conditions.

    pip would judge the conditions by the Python that it runs in.
    """
    return "".join(_held(listed.replace("\\\n", "\\").splitlines(), conditions(arch, release)))


def _held(lines: Sequence[str], about: dict[str, str]) -> Iterator[str]:
    for line in lines:
        wanted, *hashes = (part.strip() for part in line.split("\\"))
        if not wanted or wanted.startswith("#"):
            continue
        name, _, condition = (part.strip() for part in wanted.partition(";"))
        if not condition or Marker(condition).evaluate(about):
            yield " \\\n    ".join((name, *hashes)) + "\n"


def conditions(arch: str, release: str) -> dict[str, str]:
    """Return what conditions of requirements ask about (PEP 508), for a release and a processor."""
    about = RELEASES[release]
    return {
        **{key: str(value) for key, value in default_environment().items()},
        "implementation_name": "cpython",
        "implementation_version": about.python_full,
        "os_name": "posix",
        "platform_machine": MACHINES[arch],
        "platform_python_implementation": "CPython",
        "platform_system": "Linux",
        "python_full_version": about.python_full,
        "python_version": about.python,
        "sys_platform": "linux",
        "extra": "",
    }


def download(root: Path, arch: str, release: str, folder: Path) -> Path:
    """Download the locked wheels of a release and a processor, unless they are there; return their folder.

    Raises BuildError.
    """
    wanted = chosen(requirements(root), arch, release)
    stamp = folder / ".requirements"
    digest = hashlib.sha256(wanted.encode()).hexdigest()
    if stamp.is_file() and stamp.read_text("ascii") == digest:
        return folder
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    listed = folder / LIST
    listed.write_text(wanted, "utf-8")
    python = RELEASES[release].python
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--require-hashes"]
    command += ["--only-binary=:all:", f"--python-version={python}", "--implementation=cp"]
    command += [f"--abi={abi}" for abi in (f"cp{python.replace('.', '')}", "abi3", "none")]
    command += [f"--platform={platform}" for platform in PLATFORMS[arch]]
    run([*command, "--requirement", str(listed), "--dest", str(folder)], root)
    stamp.write_text(digest, "ascii")
    return folder


def stage(root: Path, tree: Path, version: str, release: str) -> Path:
    """Copy what git knows, the built page and documentation, under a version and a release's; return the copy.

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
    replace_once(
        tree / "debian" / "changelog", r"\A(hawk-drone) \([^)]+\)", rf"\1 ({package_version(version, release)})"
    )
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
    parser.add_argument("--release", choices=list(RELEASES), default="bookworm", help="of Debian (default bookworm)")
    parser.add_argument("--out", type=Path, default=ROOT / "dist", metavar="DIR")
    parser.add_argument("--version", metavar="V", help="another version, for tests")
    parser.add_argument("--wheels", action="store_true", help="no package: print the folder of its wheels")
    options = parser.parse_args(arguments)
    try:
        if options.wheels:
            print(build_wheels(ROOT, options.arch, options.release, options.version or project_version(ROOT))[1])
            return 0
        path = build(ROOT, options.arch, options.release, options.out.resolve(), options.version)
    except BuildError as error:
        print(f"build_deb: {error}", file=sys.stderr)
        return 1
    print(f"{path}: {path.stat().st_size / 1e6:.0f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
