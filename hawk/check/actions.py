"""Work of ``hawk-drone check`` and ``hawk-drone doctor``."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import logging
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from rich.console import Console

from hawk.check.doctor import LAST_FLIGHT, SecretFilter, collect, write_bundle
from hawk.check.result import CheckResult, all_passed, print_json, print_table
from hawk.check.run import check_all, usual_tools
from hawk.comm.clock import Clock
from hawk.config.loader import load_settings, refuse_existing
from hawk.config.secrets import secrets_of
from hawk.config.sections import Config, ConfigError, StoreSettings
from hawk.runtime.process import end_within

EXIT_S: Final = 5.0
"""Real seconds for the process to end after its checks; then its threads are printed and it is ended."""
BUNDLE_S: Final = 60.0
"""The same where a bundle is written after them."""


def check(options: argparse.Namespace) -> int:
    """Make the checks and print them; return the exit status."""
    results = make_checks(options, EXIT_S)
    (print_json if options.json else print_table)(Console(), results)
    return 0 if all_passed(results) else 1


def make_checks(options: argparse.Namespace, end_s: float) -> list[CheckResult]:
    """Make all checks with the settings of the command line; the process has ``end_s`` real seconds after them."""
    log = logging.getLogger("hawk")
    before = log.level
    log.setLevel(logging.CRITICAL + 1)  # the results state it
    try:
        results = asyncio.run(check_all(lambda: load_settings(options), usual_tools(), Clock()))
    finally:
        log.setLevel(before)
    end_within(end_s, sys.stderr)  # a thread that hangs in a library would keep the process
    return results


def doctor(options: argparse.Namespace) -> int:
    """Write what a bug report needs into one file; return the exit status. Raises ConfigError."""
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
