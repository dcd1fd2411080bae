"""Every setting with its text, unit, bounds, default and present value: for the page, programs and the documentation.

The texts are the comments of ``config.toml``, which comes with the program; bounds and defaults are those of
`hawk.config.sections`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from pydantic import SecretStr

from hawk.config.secrets import SecretUrl
from hawk.config.sections import Config, bounds, section_fields

Value = bool | int | float | str | list[str] | None

SET: Final = "(set)"
"""Stands for the value of a token."""
UNITS: Final = {
    "_m_s": "m/s",
    "_cm_per_pixel": "cm/pixel",
    "_percent": "%",
    "_deg": "°",
    "_hz": "Hz",
    "_days": "days",
    "_gb": "GB",
    "_mb": "MB",
    "_m": "m",
    "_s": "s",
    "_h": "h",
}
"""Unit by the end of a setting's name, the longest first."""
_OWN_UNITS: Final = {("web", "video_width"): "pixels"}
_HEADER = re.compile(r"\[(\w+)\]")
_SETTING = re.compile(r"(?:# )?(\w+) = (.+?)(?:  # .*)?")


@dataclass(frozen=True, slots=True)
class Setting:
    """One setting. ``lowest`` and ``highest`` are allowed; None for what is no number. ``unit`` may be empty."""

    section: str
    key: str
    text: str
    unit: str
    value: Value
    default: Value
    lowest: float | None
    highest: float | None


def reference_text() -> str:
    """Return ``config.toml`` as it comes with the program; empty when it cannot be read: no flight needs it.

    A package has it in `hawk`; a checkout in the project's root.
    """
    here = Path(__file__).parents[1]
    packaged = here / "config.toml"
    try:
        return (packaged if packaged.is_file() else here.parent / "config.toml").read_text(encoding="utf-8")
    except OSError:
        return ""


def texts(reference: str) -> dict[tuple[str, str], str]:
    """Return the comment above each setting, by section and key; settings without one share that of the line before."""
    found: dict[tuple[str, str], str] = {}
    section, last = "", ""
    comment: list[str] = []
    for line in reference.splitlines():
        if header := _HEADER.fullmatch(line):
            section, comment, last = header[1], [], ""
        elif section and (setting := _SETTING.fullmatch(line)) and setting[1] in section_fields(section):
            last = " ".join(comment) or last
            found[section, setting[1]] = last
            comment = []
        elif line.startswith("# "):
            comment.append(line.removeprefix("# ").strip())
        else:
            comment = []
    return found


def settings(config: Config, reference: str) -> list[Setting]:
    """Return all settings in the order of the configuration, without secrets."""
    comments, defaults = texts(reference), Config()
    return [
        _setting(section, key, comments, config, defaults) for section, _ in defaults for key in section_fields(section)
    ]


def _setting(section: str, key: str, comments: dict[tuple[str, str], str], config: Config, defaults: Config) -> Setting:
    lowest, highest = bounds(section, key) or (None, None)
    usual = getattr(getattr(defaults, section), key)
    value, default = _shown(getattr(getattr(config, section), key), usual), _shown(usual, usual)
    return Setting(section, key, comments.get((section, key), ""), _unit(section, key), value, default, lowest, highest)


def _unit(section: str, key: str) -> str:
    own = _OWN_UNITS.get((section, key))
    return own or next((unit for end, unit in UNITS.items() if key.endswith(end)), "")


def _shown(value: Any, usual: Any) -> Value:
    """Return a value that JSON holds, without secrets. ``usual``: the program's own, which is none."""
    if value is None or isinstance(value, bool | int | float):
        return value
    if isinstance(value, SecretStr):
        return SET
    if isinstance(value, list | tuple | set | frozenset):
        return [str(each) for each in value]
    return value.get_secret_value() if isinstance(value, SecretUrl) and value == usual else str(value)
