"""Real photographs: a marked lot whose stalls were labelled by hand, and a park without a marked stall."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.figures import Figure, Limit, share
from benchmarks.pictures.photos import survey_folder
from hawk.model.lot_map import StallState
from hawk.picture.photographs.flight import PhotoSurvey
from hawk.survey.accuracy import FloatArray, match

PHOTO_LOT: Final = Path(__file__).with_name("data") / "photo_lot.json"
"""Labels of one photograph of OpenDroneMap/odm_data_garfield_msp, made by hand, with who is parked there in each."""


def lot_figures(folder: Path) -> list[Figure]:
    """Return the figures of the labelled lot (OpenDroneMap/odm_data_garfield_msp).

    The labels lie in one photograph: that one's adjusted pose carries them onto the ground. Their states are those of
    the last photograph that was looked at, as the map's are.
    """
    labels: dict[str, Any] = json.loads(PHOTO_LOT.read_text())
    survey = survey_folder(folder, height_m=labels["pose"]["height_m"])
    truth = _on_ground(survey, labels["photograph"], np.array(list(labels["stalls"].values()), float))
    found = [stall for stall in survey.mapped.landed.current.stalls.values() if stall.state is not StallState.SUGGESTED]
    corners = np.array([stall.corners() for stall in found]).reshape(-1, 4, 2)
    pairs = match(corners, truth)
    apart = corners[pairs.found].mean(axis=1) - truth[pairs.true].mean(axis=1)
    apart = apart - np.median(apart, axis=0)
    taken = labels["taken"][max(labels["taken"])]
    states = [StallState.TAKEN if name in taken else StallState.FREE for name in labels["stalls"]]
    right = sum(found[i].state == states[j] for i, j in zip(pairs.found.tolist(), pairs.true.tolist(), strict=True))
    shown = [shot.name for shot, good in zip(survey.shots, survey.adjusted.is_adjusted, strict=True) if good]
    return [
        *_adjusted(survey, "lot_", "real lot"),
        Figure("lot_photographs", "real lot: photographs adjusted", float(len(shown)), limit=Limit(lowest=28)),
        Figure("lot_recall", "real lot: recall", share(len(pairs.true), len(truth)), limit=Limit(lowest=0.97)),
        Figure("lot_false", "real lot: false stalls", float(len(found) - len(pairs.found)), limit=Limit(highest=0)),
        Figure("lot_state", "real lot: states right", share(right, len(pairs.true)), limit=Limit(lowest=1.0)),
        Figure(
            "lot_p95_m", "real lot: position against each other, p95",
            float(np.percentile(np.hypot(*apart.T), 95)) if len(apart) else math.nan, "m", limit=Limit(highest=0.4),
        ),
    ]  # fmt: skip


def park_figures(folder: Path) -> list[Figure]:
    """Return the figures of the park (pierotofy/drone_dataset_brighton_beach)."""
    survey = survey_folder(folder)
    counts = survey.mapped.landed.current.counts
    return [
        *_adjusted(survey, "park_", "park"),
        Figure(
            "park_photographs", "park: photographs adjusted", float(survey.adjusted.is_adjusted.sum()),
            limit=Limit(lowest=12),
        ),
        Figure("park_stalls", "park: stalls invented", float(counts.total), limit=Limit(highest=0)),
        Figure("park_suggested", "park: cars suggested", float(counts.suggested)),
    ]  # fmt: skip


_RESIDUAL: Final = Limit(highest=2.0)


def _adjusted(survey: PhotoSurvey, prefix: str, text: str) -> list[Figure]:
    residual = survey.adjusted.residual
    return [
        Figure(f"{prefix}residual_px", f"{text}: residual at a quarter of the size, median", residual, limit=_RESIDUAL),
        Figure(f"{prefix}ties", f"{text}: sights of ties", float(survey.adjusted.ties)),
    ]


def _on_ground(survey: PhotoSurvey, photograph: str, corners: FloatArray) -> FloatArray:
    """Return pixels (N, 4, 2) of a photograph on the survey's ground."""
    number = next(k for k, shot in enumerate(survey.shots) if shot.name == photograph)
    return survey.adjusted.posed[number].ground(corners.reshape(-1, 2)).reshape(corners.shape)
