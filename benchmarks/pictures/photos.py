"""Photographs of simulated flights, mapped as a stranger's folder is: counts and places against the truth."""

from __future__ import annotations

import json
import math
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from scipy.spatial import cKDTree

from benchmarks.figures import Figure, Limit, Reference, share
from hawk.lots.survey.source import SourceKind
from hawk.model.pictures import CameraModel
from hawk.picture.photographs.flight import PhotoSurvey, survey_shots
from hawk.picture.photographs.folder import read_folder
from hawk.picture.photographs.shot_detections import Files
from hawk.picture.reconstruction.camera_pose import FloatArray
from hawk.picture.report import free_range
from hawk.picture.values import Progress, Provenance
from hawk.results.survey_map import SurveyMap
from hawk.sim.photos import PhotoOptions, write_photos
from hawk.survey.report import compare, in_range
from hawk.survey.truth import GroundTruth, parse_truth
from hawk.worlds.world import World

TRUTH: Final = "truth.json"
_LEAST, _ROUNDS, _NEAR_M = 8, 8, 1.5


@dataclass(frozen=True, slots=True)
class Judged:
    """A mapped folder beside the truth: the measures of `hawk.survey.report.compare`, whether the interval holds the
    true number of free stalls, the residual of the ties (pixels at a quarter of the size), photographs that were
    adjusted and all of them, seconds of this computer, and the turn (radians) and scale of the map.
    """

    name: str
    measures: dict[str, float]
    is_in_range: bool
    residual: float | None
    adjusted: int
    photographs: int
    took_s: float
    turn: float
    scale: float


@dataclass(frozen=True, slots=True)
class Placed:
    """A survey placed on the truth, with the turn (radians) and the scale that this took."""

    survey: SurveyMap
    turn: float
    scale: float


def survey_folder(
    folder: Path, *, height_m: float | None = None, work: Path | None = None, progress: Progress = lambda *_: None
) -> PhotoSurvey:
    """Return the survey of a folder as `hawk.picture.map_photos` makes it, with the poses."""
    read = read_folder(folder, height_m=height_m)
    provenance = Provenance(folder.resolve().name, SourceKind.PHOTOGRAPHS, read.time_is_sure, height_m)
    return survey_shots(provenance, read, Files(), work=work, progress=progress)


def judge_all(worlds: Iterable[tuple[str, World]]) -> list[Judged]:
    """Photograph and map each world, with the errors of another seed each, and print a line for each."""
    judged = []
    for number, (name, world) in enumerate(worlds, 1):
        judged.append(_judge(name, world, PhotoOptions(noise_seed=number)))
        print(_line(judged[-1]), file=sys.stderr, flush=True)
    return judged


def photo_figures(judged: Sequence[Judged], prefix: str, text: str, *, is_drawn: bool) -> list[Figure]:
    """Return the figures of folders over all stalls together."""
    if not judged:
        return []
    true, found = (sum(one.measures[name] for one in judged) for name in ("true_stalls", "found_stalls"))
    recall = pooled_recall([one.measures for one in judged])
    precision = None if recall is None else share(recall * true, found)
    f1 = None if recall is None or precision is None else 2 * recall * precision / (recall + precision)
    p95 = float(np.nanmax([one.measures["position_error_p95_m"] for one in judged]))
    middle = float(np.nanmedian([one.measures["position_error_p95_m"] for one in judged]))
    limit = Limit(lowest=0.97) if is_drawn else None
    return [
        Figure(f"{prefix}f1", f"{text}: F1 of stalls", f1, limit=limit),
        Figure(f"{prefix}recall", f"{text}: recall", recall),
        Figure(f"{prefix}precision", f"{text}: precision", precision),
        Figure(f"{prefix}p95_m", f"{text}: position, p95, median folder", middle, "m", limit=Limit(highest=0.6)),
        Figure(f"{prefix}p95_worst_m", f"{text}: position, p95, worst folder", p95, "m"),
        Figure(
            f"{prefix}in_range", f"{text}: folders whose interval holds the free stalls",
            share(sum(one.is_in_range for one in judged), len(judged)), limit=Limit(lowest=0.9),
        ),
        Figure(
            f"{prefix}adjusted", f"{text}: photographs adjusted",
            share(sum(one.adjusted for one in judged), sum(one.photographs for one in judged)),
        ),
        Figure(
            f"{prefix}s_per_photo", f"{text}: time a photograph",
            share(sum(one.took_s for one in judged), sum(one.photographs for one in judged)), "s",
        ),
        Figure(
            f"{prefix}turn_deg", f"{text}: turn of the map, median",
            float(np.median([abs(math.degrees(one.turn)) for one in judged])), "degrees",
        ),
        Figure(
            f"{prefix}scale", f"{text}: scale of the map off by, median",
            float(np.median([abs(one.scale - 1) for one in judged])),
        ),
        Figure(f"{prefix}folders", f"{text}: folders", float(len(judged))),
    ]  # fmt: skip


def pooled_recall(reports: Iterable[Mapping[str, float]]) -> float | None:
    """Return the share of the true stalls of all reports (`hawk.survey.report.compare`) that were found."""
    found, true = 0.0, 0.0
    for report in reports:
        found, true = found + report["stall_recall"] * report["true_stalls"], true + report["true_stalls"]
    return share(found, true)


def recall_loss(photographed: Iterable[Mapping[str, float]], flown: Iterable[Mapping[str, float]]) -> Figure:
    """Return the recall that photographs lose, of reports of the same places by photographs and by surveys flown."""
    by_photos, by_flights = pooled_recall(photographed), pooled_recall(flown)
    lost = None if by_photos is None or by_flights is None else by_flights - by_photos
    return Figure(
        "photos_recall_loss", "places: recall lost beside the survey flown", lost,
        reference=Reference("recall as flown", by_flights), limit=Limit(highest=0.02),
    )  # fmt: skip


def place_on(photos: PhotoSurvey, truth: GroundTruth, cameras: Mapping[str, tuple[float, float]]) -> Placed:
    """Return a survey placed on the truth by the similarity that fits best: of photographs' middles, then of stalls.

    Some 18 places that err by 1.5 m and a bias of 2 m move, turn and scale the whole map, which no photograph can know.
    What is measured is how the stalls lie to each other. ``cameras``: true places (x, y) by the photograph's name;
    they look straight down.
    """
    survey = SurveyMap.of(photos.mapped.landed.datum, photos.mapped.landed.current)
    stalls = survey.marked
    true = np.array([corners.mean(axis=0) for corners in truth.stalls])
    if len(stalls) < _LEAST or len(true) < _LEAST:
        return Placed(survey, 0.0, 1.0)
    found = truth.to_world(np.array([(stall.north, stall.east) for stall in stalls]), survey.datum)
    middles = [one.ground(_middle(one.camera))[0] for one in photos.adjusted.posed]
    own = truth.to_world(np.array(middles), survey.datum)
    there = np.array([cameras[shot.name] for shot in photos.shots])
    onto = cv2.estimateAffinePartial2D(own, there, ransacReprojThreshold=5.0)[0]
    for _ in range(_ROUNDS):
        apart, index = cKDTree(true).query(found @ onto[:, :2].T + onto[:, 2])
        near = apart < _NEAR_M
        fitted = cv2.estimateAffinePartial2D(found[near], true[index[near]], ransacReprojThreshold=0.5)[0]
        if fitted is None:
            break
        onto = fitted
    scale, turn = math.hypot(*onto[:, 0]), math.atan2(onto[1, 0], onto[0, 0])  # of (x east, y south)
    back = onto @ np.vstack([np.column_stack([found, np.ones(len(found))]).T])
    moved = back.T - found
    placed = {
        stall.id: replace(
            stall, north=stall.north - dy, east=stall.east + dx, angle=stall.angle + turn,
            width=stall.width * scale, length=stall.length * scale,
        )
        for stall, (dx, dy) in zip(stalls, moved.tolist(), strict=True)
    }  # fmt: skip
    return Placed(replace(survey, stalls=placed), turn, scale)


def _middle(camera: CameraModel) -> FloatArray:
    """Return the middle of a camera's picture, (1, 2)."""
    return np.array([((camera.width - 1) / 2, (camera.height - 1) / 2)])


def _judge(name: str, world: World, options: PhotoOptions) -> Judged:
    with tempfile.TemporaryDirectory(prefix="hawk-photos-") as path:
        folder = Path(path) / "photographs"
        write_photos(world, options, folder)
        began = time.perf_counter()
        survey = survey_folder(folder)
        took = time.perf_counter() - began
        truth: dict[str, Any] = json.loads((folder / TRUTH).read_text())
    truth["origin"] = truth["photos"]["origin"]
    parsed = parse_truth(truth)
    placed = place_on(survey, parsed, {shot["name"]: (shot["x_m"], shot["y_m"]) for shot in truth["photos"]["shots"]})
    measures = compare(placed.survey, parsed)
    free = measures["true_free"]
    return Judged(
        name, measures, in_range(free, free_range(survey.mapped)) is True, survey.adjusted.residual,
        int(survey.adjusted.is_adjusted.sum()), len(survey.shots), took, placed.turn, placed.scale,
    )  # fmt: skip


def _line(one: Judged) -> str:
    m = one.measures
    residual = "none" if one.residual is None else f"{one.residual:.2f}"
    return (
        f"{one.name}: {m['found_stalls']:.0f} of {m['true_stalls']:.0f} stalls, F1 {m['stall_f1']:.3f}, "
        f"p95 {m['position_error_p95_m']:.2f} m, free {m['found_free']:.0f} of {m['true_free']:.0f} "
        f"({'in' if one.is_in_range else 'out of'} range), {one.adjusted} of {one.photographs} adjusted, residual "
        f"{residual}, turn {math.degrees(one.turn):.2f}, scale {one.scale:.4f}, {one.took_s:.0f} s"
    )
