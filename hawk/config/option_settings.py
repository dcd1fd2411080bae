"""The settings with a command line's options applied: one reading for every command."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any, Final

from hawk.config.sections import Config, ConfigError, load_config

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
