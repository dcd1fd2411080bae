"""A small virtual environment, as the Debian package carries it."""

from __future__ import annotations

from pathlib import Path

PYTHON = Path("/usr/bin/python3").resolve()
"""Debian's own, here."""


def make_package(folder: Path, version: str) -> Path:
    """Make it; the command's text is its version."""
    module = folder / "lib" / PYTHON.name / "site-packages" / "hawk"
    module.mkdir(parents=True)
    (module / "__init__.py").write_text(f"VERSION = {version!r}\n")
    (folder / "bin").mkdir()
    command = folder / "bin" / "hawk-drone"
    command.write_text(version)
    command.chmod(0o755)
    (folder / "pyvenv.cfg").write_text(f"home = /usr/bin\nexecutable = {PYTHON}\n")
    return folder
