"""``python -m hawk.versions.alive``: status 0 while a daemon runs and its state machine makes progress, else 1.

The health check of a container. It reads the daemon's flight state (`hawk.versions.flight_state`), which needs no
token, no port and no certificate; ``/api/health`` needs a login, and is 503 as well for a camera that is missing, which
a new start of the container does not bring back.

``--on-the-ground``: status 0 when no version would be refused now (`hawk.versions.switch`): an engine that replaces
a container does not ask.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from hawk.versions.flight_state import read_flight_state
from hawk.versions.switch import ASKED_S, RUNTIME_FOLDER, look


def fault(folder: Path, now_s: float) -> str | None:
    """Return what is wrong with the daemon, None when nothing is.

    Args:
        folder: Folder of the daemon's flight state.
        now_s: CLOCK_MONOTONIC, seconds.
    """
    try:
        found = read_flight_state(folder)
    except OSError as error:
        return f"{folder}: cannot be read: {error.strerror}"
    if not found.is_held:
        return f"{folder}: no daemon runs"
    if found.state is None or now_s - found.state.at_s > ASKED_S:
        return f"{folder}: the daemon runs, and its state machine made no progress for {ASKED_S:g} s"
    return None


def main(arguments: Sequence[str] | None = None, environment: Mapping[str, str] = os.environ) -> int:
    """Print the fault; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m hawk.versions.alive", description=(__doc__ or "").split("\n", 1)[0]
    )
    parser.add_argument("--on-the-ground", action="store_true", help="also: the drone is disarmed")
    options = parser.parse_args(arguments)
    folder = Path(environment.get("RUNTIME_DIRECTORY", RUNTIME_FOLDER))
    found = fault(folder, time.monotonic())
    if found is None and options.on_the_ground:
        refusal = look(folder)
        found = None if refusal is None else refusal.reason
    if found is not None:
        print(found, file=sys.stderr)
    return 0 if found is None else 1


if __name__ == "__main__":
    sys.exit(main())
