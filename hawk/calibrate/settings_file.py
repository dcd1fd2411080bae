"""A calibration as files: single settings in a settings file (TOML; every other line stays), and a camera_info file."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Final

from hawk.calibrate.lens import NAMES, Lens
from hawk.config.loader import load_config
from hawk.config.sections import ConfigError
from hawk.runtime.files import write_atomically

_HEADER: Final = re.compile(r"\s*\[\s*([\w.-]+)\s*\]")


def changed_text(text: str, section: str, lines: Mapping[str, str]) -> str:
    """Return a file's text with settings of a section replaced, or added behind the section's last line.

    Args:
        text: TOML with every setting on a line of its own, as ``config.toml`` has them.
        section: Name of the section; it is added when it is missing.
        lines: Key to value, both as TOML writes them. A remark behind a value is kept.
    """
    rows = text.splitlines()
    first, last = _section(rows, section)
    if first is None:
        rows += ([""] if rows else []) + [f"[{section}]"]
        first, last = len(rows), len(rows)
    for key, value in lines.items():
        for k in range(first, last):
            found = re.match(rf"(\s*{re.escape(key)}\s*=\s*)(\"[^\"]*\"|'[^']*'|[^#]*?)(\s*#.*)?$", rows[k])
            if found:
                rows[k] = f"{found[1]}{value}{found[3] or ''}"
                break
        else:
            while last > first and not rows[last - 1].strip():
                last -= 1
            rows.insert(last, f"{key} = {value}")
            last += 1
    return "\n".join(rows) + "\n"


def write_settings(path: Path, section: str, lines: Mapping[str, str]) -> None:
    """Replace settings in a file, whole or not at all; owner and mode stay. Raises ConfigError naming file and remedy.

    The new text is read back as the daemon reads it before it takes the old one's place.
    """
    try:
        text = changed_text(path.read_text(encoding="utf-8"), section, lines)
        status = path.stat()
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
        temporary = Path(name)
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            load_config(temporary, environment={})
            shutil.copymode(path, temporary)
            with contextlib.suppress(PermissionError):
                os.chown(temporary, status.st_uid, status.st_gid)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ConfigError(f"--apply: {path} cannot be written: {reason}: write the lines above into it") from error
    except ConfigError as error:
        raise ConfigError(f"--apply: {path} is not changed, since it would be wrong afterwards: {error}") from error


def _section(rows: list[str], section: str) -> tuple[int | None, int]:
    """Return the first row behind the section's header, and the row of the next header; None without the section."""
    first: int | None = None
    for k, row in enumerate(rows):
        header = _HEADER.match(row)
        if header is None:
            continue
        if first is not None:
            return first, k
        if header[1] == section:
            first = k + 1
    return first, len(rows)


def camera_info(lens: Lens, made: datetime) -> str:
    """Return the file's text; error and spreads stand in its remarks."""
    fx, fy, cx, cy = lens.values[:4]
    spreads = ", ".join(f"{name} {spread:.3g}" for name, spread in zip(NAMES, lens.spreads, strict=True))
    return "\n".join(
        [
            f"# hawk-drone calibrate, {made:%Y-%m-%d %H:%M} UTC: {lens.views} views, error {lens.rms:.3f} px",
            f"# standard deviations: {spreads}",
            f"image_width: {lens.width}",
            f"image_height: {lens.height}",
            "camera_name: hawk",
            *_matrix("camera_matrix", 3, 3, (fx, 0, cx, 0, fy, cy, 0, 0, 1)),
            "distortion_model: plumb_bob",
            *_matrix("distortion_coefficients", 1, 5, lens.values[4:]),
            *_matrix("rectification_matrix", 3, 3, (1, 0, 0, 0, 1, 0, 0, 0, 1)),
            *_matrix("projection_matrix", 3, 4, (fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0)),
            "",
        ]
    )


def write_camera_info(lens: Lens, path: Path, made: datetime) -> None:
    """Write the file, whole or not at all. Raises OSError."""
    write_atomically(path, camera_info(lens, made))


def _matrix(name: str, rows: int, columns: int, data: Sequence[float]) -> list[str]:
    return [f"{name}:", f"  rows: {rows}", f"  cols: {columns}", f"  data: [{', '.join(repr(float(v)) for v in data)}]"]
