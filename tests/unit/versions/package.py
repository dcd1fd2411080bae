"""A small virtual environment, as the Debian package carries it."""

from __future__ import annotations

from pathlib import Path


def make_package(folder: Path, version: str) -> Path:
    """Make it; the command's text is its version."""
    module = folder / "lib" / "python3.11" / "site-packages" / "hawk"
    module.mkdir(parents=True)
    (module / "__init__.py").write_text(f"VERSION = {version!r}\n")
    (folder / "bin").mkdir()
    command = folder / "bin" / "hawk-drone"
    command.write_text(version)
    command.chmod(0o755)
    (folder / "pyvenv.cfg").write_text("home = /usr/bin\n")
    return folder
