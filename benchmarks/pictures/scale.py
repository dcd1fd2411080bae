"""Scale of maps by photographs whose files say a wrong height: whether the bound that is given holds the true one.

Each folder is drawn as ``hawk-sim photos`` does, small, with a height that errs by up to half. Where it is asked about,
the answer is the value that the question names. No stalls are mapped: the places of the cameras show the scale.
"""

from __future__ import annotations

import json
import re
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from benchmarks.figures import Figure, Limit, share
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.network import StallNetwork
from hawk.lots.survey.source import SourceKind
from hawk.picture.checkpoints import Checkpoints
from hawk.picture.photographs.folder import read_folder
from hawk.picture.photographs.shot_detections import Files, ShotReader
from hawk.picture.photographs.shot_poses import ReconstructedShots, pose_shots
from hawk.picture.values import PictureError, Provenance
from hawk.sim.photos import TRUTH, Errors, PhotoOptions, write_photos
from hawk.worlds.generate import generate_world

_WRONG_PERCENT: Final = 50.0
_WORLDS: Final = 8
_WIDTH: Final = 800
_OVERLAPS: Final = ((0.6, 0.5), (0.5, 0.4), (0.7, 0.6))
_FITS: Final = re.compile(r"--height ([0-9.]+) would fit")


@dataclass(frozen=True, slots=True)
class Scaled:
    """A folder: the height that its files say by the true one, whether it was asked about, the map's size by the true
    one, the bound that was given as a share, photographs, and seconds.
    """

    said: float
    was_asked: bool
    size: float
    bound: float
    photographs: int
    took_s: float

    @property
    def is_held(self) -> bool:
        """True where the true scale lies within the bound."""
        return abs(1.0 / self.size - 1.0) <= self.bound


def measure(count: int) -> list[Scaled]:
    """Draw and scale this many folders; print a line each."""
    finder = StallDetector(StallNetwork.load(None, "auto", 1))
    found = []
    for number in range(1, count + 1):
        with tempfile.TemporaryDirectory(prefix="hawk-scale-") as path:
            found.append(_scaled(Path(path), number, finder))
        one = found[-1]
        print(
            f"{number}: {one.photographs} photographs, height {100 * (one.said - 1):+.0f} %, "
            f"{'asked' if one.was_asked else 'not asked'}, map {100 * (one.size - 1):+.2f} %, bound "
            f"{100 * one.bound:.1f} %, {'held' if one.is_held else 'NOT held'}, {one.took_s:.0f} s",
            file=sys.stderr, flush=True,
        )  # fmt: skip
    return found


def scale_figures(scaled: Sequence[Scaled]) -> list[Figure]:
    """Return the figures of all folders together."""
    held = share(sum(one.is_held for one in scaled), len(scaled))
    far = [one for one in scaled if abs(one.said - 1) > 0.2]
    return [
        Figure("scale_held", "folders whose bound holds the true scale", held, limit=Limit(lowest=0.9)),
        Figure("scale_off", "scale of the map off by, median", float(np.median([abs(one.size - 1) for one in scaled]))),
        Figure("scale_off_most", "the same, worst folder", max(abs(one.size - 1) for one in scaled)),
        Figure("scale_bound", "bound that is given, median", float(np.median([one.bound for one in scaled]))),
        Figure(
            "scale_asked_far", "heights wrong by more than 20 % that are asked about",
            share(sum(one.was_asked for one in far), len(far)),
        ),
        Figure("scale_folders", "folders", float(len(scaled))),
    ]  # fmt: skip


def _scaled(path: Path, number: int, finder: StallDetector) -> Scaled:
    folder = path / "photographs"
    options = PhotoOptions(
        width=_WIDTH, overlap=_OVERLAPS[number % len(_OVERLAPS)], noise_seed=number,
        errors=Errors(height=_WRONG_PERCENT),
    )  # fmt: skip
    write_photos(generate_world(1 + number % _WORLDS), options, folder)
    truth = json.loads((folder / TRUTH).read_text())["photos"]
    began, was_asked = time.perf_counter(), False
    try:
        posed = _posed(folder, path / "work", finder, None)
    except PictureError as error:
        fits = _FITS.search(str(error))
        if fits is None:
            raise
        was_asked = True
        posed = _posed(folder, path / "work", finder, float(fits[1]))
    places = {shot["name"]: complex(-shot["y_m"], shot["x_m"]) for shot in truth["shots"]}
    own = np.array([complex(one.north, one.east) for one in posed.adjusted.posed])[posed.adjusted.is_adjusted]
    true = np.array([places[shot.name] for shot in posed.shots])[posed.adjusted.is_adjusted]
    size = float(abs(np.polyfit(true, own, 1)[0]))
    took = time.perf_counter() - began
    return Scaled(truth["errors"]["height"], was_asked, size, posed.scale.off, len(posed.shots), took)


def _posed(folder: Path, work: Path, finder: StallDetector, height_m: float | None) -> ReconstructedShots:
    read = read_folder(folder, height_m=height_m)
    kept = Checkpoints(work)
    taken = Provenance(folder.name, SourceKind.PHOTOGRAPHS, height_m=height_m)
    return pose_shots(taken, read.shots, ShotReader(Files(), kept), kept, finder, lambda *_: None)
