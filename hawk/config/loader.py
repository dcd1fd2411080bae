"""Reads the settings: from ``config.toml``, from environment variables and from the command line, in this order of rank
(the last wins), and checks them as a whole before anything starts.
"""

from __future__ import annotations

import argparse
import difflib
import os
import re
import tomllib
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

from pydantic import ValidationError

from hawk.config.secrets import is_secret
from hawk.config.sections import Config, ConfigError, section_fields
from hawk.formats.validation import wrong_values

ENVIRONMENT_PREFIX = "HAWK_"
"""``HAWK_WEB__PORT=3001`` sets ``port`` of section ``web``."""


class _Removed(NamedTuple):
    """A setting of earlier versions. A value that states what holds now is passed over: the drone starts with it."""

    remedy: str
    holds_now: tuple[object, ...]


_REMOVED: Final = {
    ("vision", "use_network"): _Removed(
        "is no setting any more: the network alone finds stalls. Delete it from your settings", (True, "true")
    ),
}
"""By section and key."""


def config_of(options: argparse.Namespace) -> Config:
    """Return the settings of a command with the options of `hawk.config.options.add_settings`. Raises ConfigError."""
    overrides = {} if options.store is None else {"store": {"directory": options.store}}
    return load_config(options.config, overrides=overrides)


def load_config(
    path: Path | None,
    environment: Mapping[str, str] = os.environ,
    overrides: Mapping[str, Mapping[str, Any]] | None = None,
) -> Config:
    """Return the checked settings.

    ``overrides`` (section -> key -> value) come from the command line. Raises ConfigError naming file, line and key.
    """
    text, written = "", 0.0
    if path is not None:
        try:
            written = path.stat().st_mtime
            text = path.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            raise ConfigError(f"{path}: cannot be read: {error}") from error
    try:
        values: dict[str, Any] = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise ConfigError(f"{path}: not TOML: {error}") from error
    variables: dict[tuple[str, str], str] = {}
    for name in sorted(name for name in environment if name.upper().startswith(ENVIRONMENT_PREFIX)):
        section, key = _setting_of(name)
        value = environment[name]
        variables[section, key] = name
        _section(values, section)[key] = value.replace(",", " ").split() if _is_list(section, key) else value
    for section, settings in (overrides or {}).items():
        _section(values, section).update(settings)
        variables = {at: name for at, name in variables.items() if at[0] != section or at[1] not in settings}
    for (section, key), removed in _REMOVED.items():
        given = values.get(section)
        if isinstance(given, dict) and given.get(key) in removed.holds_now:
            del given[key]
    try:
        config = Config.model_validate(values)
    except ValidationError as error:
        raise ConfigError(_explain(error, path, text, variables)) from None
    for entry in config.schedule:
        entry.hold_since(written)
    return config


def variable_of(section: str, key: str) -> str:
    """Return the environment variable of a setting."""
    return f"{ENVIRONMENT_PREFIX}{section}__{key}".upper()


def _setting_of(variable: str) -> tuple[str, str]:
    """Return section and key of an environment variable; raises ConfigError for one that would change nothing."""
    section, _, key = variable.removeprefix(ENVIRONMENT_PREFIX).lower().partition("__")
    if key and variable.startswith(ENVIRONMENT_PREFIX):
        return section, key
    names = {variable_of(section, key): "" for section in Config.model_fields for key in section_fields(section)}
    near = difflib.get_close_matches(variable.upper(), names, n=1)
    remedy = f"write {near[0]}, or unset it" if near else "its form is HAWK_<SECTION>__<KEY>; unset it"
    raise ConfigError(f"{variable}: is no setting, and would change nothing: {remedy}")


def _is_list(section: str, key: str) -> bool:
    """Return True for a setting that is a list: in the environment its parts stand between commas or spaces."""
    field = section_fields(section).get(key)
    return field is not None and typing.get_origin(field.annotation) in (tuple, list)


def _section(values: dict[str, Any], name: str) -> dict[str, Any]:
    found = values.setdefault(name, {})
    if not isinstance(found, dict):
        raise ConfigError(f"{name}: is a value, must be a section: write [{name}]")
    return found


def _explain(error: ValidationError, path: Path | None, text: str, variables: Mapping[tuple[str, str], str]) -> str:
    """Return one line for each wrong setting: file and line, or environment variable, then key, what is wrong."""
    lines = []
    for wrong in wrong_values(error, Config):
        keys, message = [str(part) for part in wrong.location], wrong.reason
        if wrong.kind == "extra_forbidden":
            similar = f"is not a setting; see config.toml for those that are{_similar(keys)}"
            removed = _REMOVED.get((keys[0], keys[-1]))
            message = similar if removed is None else removed.remedy
        elif wrong.kind != "missing" and not _has_secret(keys):  # a secret, even a part of one, is not repeated
            message = f"{message} (found {wrong.given!r})"
        number = _line_of(keys, text)
        place = f"{path}, line {number}: " if number else f"{path}: " if path else ""
        if len(keys) > 1 and (variable := variables.get((keys[0], keys[1]))):
            place = f"{variable}: "
        lines.append(f"{place}{'.'.join(keys)}: {message}")
    return "\n".join(lines)


def _has_secret(keys: list[str]) -> bool:
    """Return True for a setting, a part of one or a section that holds a secret: an error goes into the journal."""
    fields = section_fields(keys[0]) if len(keys) > 1 else Config.model_fields
    field = fields.get(keys[min(1, len(keys) - 1)])
    return field is not None and is_secret(field.annotation)


def _similar(keys: list[str]) -> str:

    is_key = len(keys) > 1 and keys[0] in Config.model_fields
    names = list(section_fields(keys[0]) if is_key else Config.model_fields)
    near = difflib.get_close_matches(keys[-1], names, n=1)
    return f" (did you mean {near[0]}?)" if near else ""


def _line_of(keys: list[str], text: str) -> int | None:
    """Return the line on which the setting (else its section) stands in the TOML text, counted from 1."""
    section_line = None
    section: list[str] = []
    blocks: dict[str, int] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        header = re.match(r"\s*(\[\[?)\s*([\w.-]+)\s*\]", line)
        if header:
            section = [header.group(2)]
            if header.group(1) == "[[":
                section.append(str(blocks.get(section[0], 0)))
                blocks[section[0]] = int(section[1]) + 1
            if section == keys[: len(section)]:
                section_line = number
        key = re.match(r"\s*([\w-]+)\s*=", line)
        if key and [*section, key.group(1)] == keys[: len(section) + 1]:
            return number
    return section_line


_OPTIONS: Final = (
    ("web", "host", "host"),
    ("web", "port", "port"),
    ("fence", "file", "fence"),
    ("flight", "outline_file", "outline"),
    ("autopilot", "url", "autopilot"),
    ("camera", "url", "camera"),
    ("store", "directory", "store"),
)
"""Section, key, and the option that sets them. A command need not have every option."""


def load_settings(options: argparse.Namespace) -> Config:
    """Return the settings of ``options.config`` with the command line's options applied. Raises ConfigError."""
    overrides: dict[str, dict[str, Any]] = {}
    for section, key, name in _OPTIONS:
        value = getattr(options, name, None)
        if value is not None:
            overrides.setdefault(section, {})[key] = value
    return load_config(options.config, overrides=overrides)


def refuse_existing(path: Path, remedy: str) -> None:
    """Raise ConfigError when the file of ``--out`` is there already, or its folder is closed to this user."""
    try:
        there = path.exists()
    except OSError as error:
        words = f"{path} cannot be written: {error.strerror or error}; name a folder that this user may write"
        raise ConfigError(f"--out: {words}") from error
    if there:
        raise ConfigError(f"--out: {path} exists already: {remedy}")
