"""``hawk-drone calibrate --in-flight``: latency and mount from a recorded flight, printed or written."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from pathlib import Path
from typing import Final

import cv2

from hawk.calibrate.advice import Advice, advise, table
from hawk.calibrate.flight import Flight, FlightError, newest_recording, read_flight
from hawk.calibrate.in_flight import Estimate, NoEstimateError, estimate
from hawk.calibrate.pairs import choose_pairs, match_pairs
from hawk.calibrate.settings_file import write_settings
from hawk.config.sections import ENVIRONMENT_PREFIX, Config
from hawk.runtime.process import set_niceness, set_session_niceness
from hawk.store.replay import RecordingError

_FAILED: Final = 1
_LEAST: Final = 19  # niceness
_OOM_SCORE: Final = Path("/proc/self/oom_score_adj")  # proc(5)


def estimate_flight(recording: Path) -> tuple[Flight, Estimate]:
    """Return a recorded flight and its estimate; takes a minute of one core and some 100 MB.

    Raises FlightError, RecordingError, NoEstimateError.
    """
    cv2.setNumThreads(1)  # the daemon may run beside it
    flight = read_flight(recording)
    pairs = choose_pairs(flight)
    return flight, estimate(flight.track, match_pairs(flight, pairs), flight.camera)


def give_way(oom_score: Path = _OOM_SCORE) -> None:
    """Let everything else go first: for the daemon's estimate after a landing. A program short of memory ends this one.

    The daemon's own priority and protection (packaging/systemd) are inherited otherwise.
    """
    set_session_niceness(_LEAST)
    set_niceness(_LEAST)
    with contextlib.suppress(OSError):
        oom_score.write_text("800")


def run_in_flight(config: Config, recording: Path | None, apply_to: Path | None, *, as_json: bool) -> int:
    """Estimate, print and write; return the exit status.

    ``recording`` None: the newest of the store. ``apply_to``: the settings file that is changed; None: none is. Raises
    ConfigError for a settings file that cannot be written.
    """
    try:
        path = recording or newest_recording(config.store.directory)
        flight, found = estimate_flight(path)
    except (FlightError, RecordingError, NoEstimateError) as error:
        print(f"hawk-drone calibrate: {error}", file=sys.stderr)
        return _FAILED
    advice = advise(found, flight.flown, config.camera)
    if as_json:
        print(json.dumps({"recording": str(path), "pairs": found.pairs, "settings": [_plain(each) for each in advice]}))
    else:
        print(f"{path}: {found.pairs} pairs of pictures")
        print("\n".join(table(advice)))
    offered = [each for each in advice if each.is_offered]
    if not as_json:
        _say(offered, advice)
    if apply_to is not None and offered:
        write_settings(apply_to, "camera", {each.key: str(each.value) for each in offered})
        print(f"{apply_to}: changed. Start the daemon again, and look at the next flight.", file=sys.stderr)
        for each in offered:
            name = f"{ENVIRONMENT_PREFIX}CAMERA__{each.key.upper()}"
            if name in os.environ:
                print(f"{name} is set in the environment and outranks the file: remove it there.", file=sys.stderr)
    return _FAILED if all(each.problem for each in advice) else 0


def _say(offered: list[Advice], advice: list[Advice]) -> None:
    if offered:
        print("Write this into the settings, section [camera], or run this again with --apply:", file=sys.stderr)
        print("\n".join(each.line for each in offered), file=sys.stderr)
    elif not all(each.problem for each in advice):
        print("The settings agree with what is known: nothing is to be changed.", file=sys.stderr)


def _plain(advice: Advice) -> dict[str, object]:
    return {
        "setting": f"camera.{advice.key}",
        "value": advice.value,
        "spread": advice.spread,
        "present": advice.present,
        "offered": advice.is_offered,
        "problem": advice.problem,
    }
