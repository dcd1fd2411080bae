"""The command line of ``hawk-drone check`` and ``hawk-drone doctor``.

`hawk.check.actions` looks. It is imported when it is needed: the daemon's start must not wait for it.
"""

from __future__ import annotations

import argparse
from typing import Any, Final

from hawk.config import options as values
from hawk.config.addresses import MOST_PORT

CHECK_COMMANDS: Final = frozenset({"check", "doctor"})


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
    from hawk.check.actions import check

    return check(options)


def _doctor(options: argparse.Namespace) -> int:
    from hawk.check.actions import doctor

    return doctor(options)
