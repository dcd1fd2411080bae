"""``hawk-drone calibrate --in-flight``: latency and mount from a recorded flight, printed or written."""

from __future__ import annotations

import contextlib
import json
import math
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2

from hawk.calibrate.flight import Flight, FlightError, Flown, newest_recording, read_flight
from hawk.calibrate.in_flight import LATENCY, PITCH, ROLL, YAW, Estimate, NoEstimateError, estimate
from hawk.calibrate.pairs import choose_pairs, match_pairs
from hawk.calibrate.settings_file import write_settings
from hawk.config.loader import ENVIRONMENT_PREFIX
from hawk.config.sections import CameraSettings, Config, bounds
from hawk.runtime.process import set_niceness, set_session_niceness
from hawk.store.replay import RecordingError

LARGEST_SPREADS: Final = {
    "latency_s": 0.005,
    "mount_roll_deg": 0.3,
    "mount_pitch_deg": 0.3,
    "mount_yaw_deg": 0.25,
}
"""A result that is less certain is not offered: seconds, and degrees. Half of 10 ms; angles that move the ground at a
travel height of 35 m by a cell or two."""
MOST_ONE_HEADING: Final = 0.75
"""Of `Estimate.one_heading`: two headings 90 degrees apart have 0.71. Along one heading, cars and trees that stand on
one side of the picture look like a mount that leans; half a degree was seen in rendered flights."""
OFFERED_SPREADS: Final = 2.0
"""A setting is offered when it differs from the present one by more than this number of spreads."""
_PLACES: Final = {"latency_s": LATENCY, "mount_roll_deg": ROLL, "mount_pitch_deg": PITCH, "mount_yaw_deg": YAW}
_DIGITS: Final = {"latency_s": 3}
_NEEDED: Final = {
    "latency_s": "turns, starts and stops: fly lanes, and turn the nose at each end",
    "mount_roll_deg": "turns of the nose while it flies, and lanes there and back",
    "mount_pitch_deg": "turns of the nose while it flies, and lanes there and back",
    "mount_yaw_deg": "lanes of 20 m and more in several directions, with starts and stops, for two minutes or longer",
}


@dataclass(frozen=True, slots=True)
class Advice:
    """One setting of section ``[camera]``.

    ``value`` and ``spread`` (one standard deviation) in the setting's unit, ``present`` as it is set now. ``problem``
    says why the value cannot be offered; empty when it can.
    """

    key: str
    value: float
    spread: float
    present: float
    problem: str = ""

    @property
    def is_offered(self) -> bool:
        """True when the value is certain and differs from the present one."""
        return not self.problem and abs(self.value - self.present) > OFFERED_SPREADS * self.spread

    @property
    def line(self) -> str:
        """The line of the settings file."""
        return f"{self.key} = {self.value}"


def advise(estimate: Estimate, flown: Flown, present: CameraSettings) -> list[Advice]:
    """Return each setting's advice."""
    return [_advice(key, estimate, flown, float(getattr(present, key))) for key in _PLACES]


def _advice(key: str, estimate: Estimate, flown: Flown, present: float) -> Advice:
    value, spread = estimate.values[_PLACES[key]], estimate.spreads[_PLACES[key]]
    if key == "latency_s":  # taken later than stamped: the latency is shorter than it was set
        value = flown.latency_s - value
    else:
        value, spread = math.degrees(value), math.degrees(spread)
    value = round(value, _DIGITS.get(key, 2))
    if key == "latency_s" and flown.has_kernel_stamps:
        problem = f"not used: the kernel stamps the pictures, {-estimate.values[LATENCY]:+.3f} s off by this flight"
        return Advice(key, value, spread, present, problem)
    if key != "latency_s" and flown.has_gimbal:
        return Advice(key, value, spread, present, "the camera hangs on a gimbal, whose attitude is its mount")
    leans = key in ("mount_roll_deg", "mount_pitch_deg")
    if leans and estimate.one_heading > MOST_ONE_HEADING:
        return Advice(key, value, spread, present, f"the nose pointed to one side: the flight needs {_NEEDED[key]}")
    return Advice(key, value, spread, present, _problem(key, value, spread))


def _problem(key: str, value: float, spread: float) -> str:
    if not spread <= LARGEST_SPREADS[key]:
        return f"its spread is above {LARGEST_SPREADS[key]:g}: the flight needs {_NEEDED[key]}"
    allowed = bounds("camera", key)
    if allowed is not None and not allowed[0] <= value <= allowed[1]:
        return (
            f"it lies outside {allowed[0]:g} to {allowed[1]:g}: the camera's own time stamps are wrong, or the "
            "autopilot's poses are late"
        )
    return ""


def table(advice: Sequence[Advice]) -> list[str]:
    """Return the results as lines of text."""
    rows = []
    for each in advice:
        unit = "s" if each.key.endswith("_s") else "°"
        digits = _DIGITS.get(each.key, 2)
        row = f"{each.key:<16} {each.value:>9.{digits}f} ± {each.spread:.{digits + 1}f} {unit}  (set: {each.present:g})"
        rows.append(f"{row}  not known: {each.problem}" if each.problem else row)
    return rows


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


def use_least_priority(oom_score: Path = _OOM_SCORE) -> None:
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
