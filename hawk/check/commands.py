"""The command line of ``hawk-drone check`` and ``hawk-drone doctor``.

The parts that look are imported when they are needed: the daemon's start must not wait for them.
"""

from __future__ import annotations

import argparse
import asyncio
import logging
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hawk.config import Config, load_config

if TYPE_CHECKING:
    from hawk.check.result import CheckResult

CHECK_COMMANDS: Final = frozenset({"check"})
EXIT_S: Final = 5.0


def add_check_commands(commands: Any) -> None:
    """Add the commands to the subparsers of the command line."""
    check = commands.add_parser("check", help="look at camera, autopilot, disk, clock and network before a flight")
    check.set_defaults(action=_check)
    _add_settings(check)
    check.add_argument("--host", help="address to serve the page on")
    check.add_argument("--port", type=int, help="port to serve the page on")
    check.add_argument("--autopilot", metavar="URL", help="MAVSDK connection URL of the autopilot")
    check.add_argument("--camera", metavar="URL", help="URL of the camera")
    check.add_argument("--json", action="store_true", help="print one JSON object and no table")


def _add_settings(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", type=Path, metavar="FILE", help="settings (TOML); without it every default")
    parser.add_argument("--store", type=Path, metavar="DIR", help="folder of the daemon's files")


def load_settings(options: argparse.Namespace) -> Config:
    """Return the settings with the command line's options applied. Raises ConfigError."""
    overrides: dict[str, dict[str, Any]] = {}
    for section, key, name in (
        ("web", "host", "host"),
        ("web", "port", "port"),
        ("autopilot", "url", "autopilot"),
        ("camera", "url", "camera"),
        ("store", "directory", "store"),
    ):
        value = getattr(options, name, None)
        if value is not None:
            overrides.setdefault(section, {})[key] = value
    return load_config(options.config, overrides=overrides)


def _check(options: argparse.Namespace) -> int:
    from rich.console import Console

    from hawk.check.report import print_json, print_table
    from hawk.check.result import all_passed

    results = make_checks(options)
    (print_json if options.json else print_table)(Console(), results)
    return 0 if all_passed(results) else 1


def make_checks(options: argparse.Namespace) -> list[CheckResult]:
    """Make all checks with the settings of the command line."""
    from hawk.check.run import check_all, usual_tools
    from hawk.comm.clock import Clock
    from hawk.process import end_within

    log = logging.getLogger("hawk")
    before = log.level
    log.setLevel(logging.CRITICAL + 1)  # the results state it
    try:
        results = asyncio.run(check_all(lambda: load_settings(options), usual_tools(), Clock()))
    finally:
        log.setLevel(before)
    end_within(EXIT_S, sys.stderr)  # a thread that hangs in a library would keep the process
    return results
