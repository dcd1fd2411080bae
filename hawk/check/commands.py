"""The command line of ``hawk-drone check`` and ``hawk-drone doctor``.

The parts that look are imported when they are needed: the daemon's start must not wait for them.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import logging
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hawk.config import options as values
from hawk.config.addresses import MOST_PORT
from hawk.config.loader import load_settings, refuse_existing
from hawk.config.sections import Config, ConfigError, StoreSettings

if TYPE_CHECKING:
    from hawk.check.result import CheckResult

CHECK_COMMANDS: Final = frozenset({"check", "doctor"})
EXIT_S: Final = 5.0
"""Real seconds for the process to end after its checks; then its threads are printed and it is ended."""
BUNDLE_S: Final = 60.0
"""The same where a bundle is written after them."""


def add_check_commands(commands: Any) -> None:
    """Add the commands to the subparsers of the command line."""
    check = commands.add_parser("check", help="look at camera, autopilot, disk, clock and network before a flight")
    check.set_defaults(action=_check)
    values.add_settings(check)
    check.add_argument("--host", type=values.some, help="address to serve the page on")
    check.add_argument("--port", type=values.whole(0, MOST_PORT), help="port to serve the page on")
    check.add_argument("--autopilot", metavar="URL", help="MAVSDK connection URL of the autopilot")
    check.add_argument("--camera", metavar="URL", help="URL of the camera")
    check.add_argument("--json", action="store_true", help="print one JSON object and no table")
    doctor = commands.add_parser("doctor", help="collect what a bug report needs, without secrets, in one file")
    doctor.set_defaults(action=_doctor)
    values.add_settings(doctor)
    doctor.add_argument("--out", type=values.new(".tar.gz"), metavar="FILE", help="the file to write (.tar.gz)")


def _check(options: argparse.Namespace) -> int:
    from rich.console import Console

    from hawk.check.result import all_passed, print_json, print_table

    results = make_checks(options, EXIT_S)
    (print_json if options.json else print_table)(Console(), results)
    return 0 if all_passed(results) else 1


def make_checks(options: argparse.Namespace, end_s: float) -> list[CheckResult]:
    """Make all checks with the settings of the command line; the process has ``end_s`` real seconds after them."""
    from hawk.check.run import check_all, usual_tools
    from hawk.comm.clock import Clock
    from hawk.runtime.process import end_within

    log = logging.getLogger("hawk")
    before = log.level
    log.setLevel(logging.CRITICAL + 1)  # the results state it
    try:
        results = asyncio.run(check_all(lambda: load_settings(options), usual_tools(), Clock()))
    finally:
        log.setLevel(before)
    end_within(end_s, sys.stderr)  # a thread that hangs in a library would keep the process
    return results


def _doctor(options: argparse.Namespace) -> int:
    from hawk.check.doctor import LAST_FLIGHT, SecretFilter, collect, write_bundle
    from hawk.config.secrets import secrets_of

    config: Config | None = None
    with contextlib.suppress(ConfigError):  # a check reports it
        config = load_settings(options)
    path = options.out or Path(f"hawk-doctor-{datetime.now(UTC):%Y%m%d-%H%M%S}.tar.gz")
    if not path.name.endswith(".tar.gz"):
        raise ConfigError(f"--out: {path} must end in .tar.gz")
    refuse_existing(path, "name another file")
    folder = options.store or StoreSettings().directory if config is None else config.store.directory
    hidden = SecretFilter([] if config is None else secrets_of(config))
    parts = collect(config, folder, make_checks(options, BUNDLE_S), hidden)
    try:
        bundle = write_bundle(path, parts, time.time())
    except OSError as error:
        print(f"hawk-drone doctor: {path} cannot be written: {error.strerror or error}", file=sys.stderr)
        return 1
    print(f"{bundle.path} holds:")
    for name, size in bundle.parts.items():
        print(f"  {name} ({size} bytes)")
    if LAST_FLIGHT in parts:
        print(parts[LAST_FLIGHT].partition("\n")[0])
    print("Recordings, tokens, logins, keys and passwords are not in it. It holds the places of flights (degrees).")
    print(f"Look through it before you send it: tar -xzf {bundle.path}")
    return 0
