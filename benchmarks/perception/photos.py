"""Photographs of a real flight over one labelled lot: what is found in each, and where it is found.

The labels of one photograph are carried to the others by their features (`benchmarks.perception.photo_match`). A
photograph that shows less than half of the stalls, or whose features do not surround them, is left out and named.

Relief: what stands up shows farther from the point below the camera than its foot. It is given as the height whose
displacement r h / H (Wolf, Dewitt and Wilkinson, Elements of Photogrammetry, 4th ed., 6-8) explains where the centres
of stalls are found.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
import pymap3d
import shapely
from numpy.typing import NDArray

from benchmarks.figures import Figure, Section
from benchmarks.perception.eyes import Eye
from benchmarks.perception.measures import Looked, line, look, pooled
from benchmarks.perception.photo_labels import PhotoLabels
from benchmarks.perception.photo_match import Carried, Features, Levelled, features, level, place
from benchmarks.perception.photo_shots import Shot, photographs, read_shot
from benchmarks.perception.places import Place
from hawk.model.lot_map import StallState
from hawk.picture.orthophoto.tile_detector import GROUND_M
from hawk.survey.accuracy import FloatArray, LabelledPlace, match

AROUND_M: Final = 8.0
"""Features this far around the lot place a photograph: farther off, trees rise and the ground slopes."""
LEAST_SHOWN: Final = 0.5
BESIDE_M: Final = 3.0
LEAST_WITHIN: Final = 0.7
"""Least share of the stalls that lie between a photograph's features, or so near to them: beyond, a homography
misleads.
"""
SHOWN: Final = (
    "recall", "precision", "free_recall", "state_accuracy", "centre_p95_m", "length_sigma_m", "labels", "labels_cut",
)  # fmt: skip
_LARGEST_M: Final = 1.0
"""A centre farther off than this is another error than relief."""


@dataclass(frozen=True, slots=True)
class Photos:
    """A folder of photographs of one flight, and the labels of the lot below it."""

    folder: Path
    labels: PhotoLabels = field(repr=False)


@dataclass(frozen=True, slots=True)
class Offsets:
    """Matched stalls: ``places`` (N, 2) are their labels' centres from the point below the camera, ``errors`` (N, 2)
    how far from these they were found, both by the height of the camera; ``height_m`` (N,) is that height, and
    ``taken`` (N,) true of taken and false of free stalls.
    """

    places: FloatArray = field(repr=False)
    errors: FloatArray = field(repr=False)
    height_m: FloatArray = field(repr=False)
    taken: NDArray[np.bool_] = field(repr=False)

    def relief(self, *, taken: bool) -> tuple[float, float, int]:
        """Return the height (metres) whose relief explains the errors, its standard error, and the number of stalls:
        the least squares of ``error = place * h``, both by the height of the camera.
        """
        chosen = (self.taken == taken) & (np.hypot(*self.errors.T) * self.height_m < _LARGEST_M)
        places, errors = self.places[chosen], self.errors[chosen] * self.height_m[chosen, None]
        weight = float((places**2).sum())
        if not weight:
            return math.nan, math.nan, 0
        found = float((places * errors).sum()) / weight
        return found, math.sqrt(float(((errors - places * found) ** 2).mean()) / weight), int(chosen.sum())


@dataclass(frozen=True, slots=True)
class Seen:
    """Findings in a photograph. ``apart_m`` is the distance of the point below the camera from EXIF's place,
    ``scale`` the height that the features give over EXIF's, ``lean`` (radians) the angle between the camera's axis by
    XMP and by the features.
    """

    carried: Carried = field(repr=False)
    looked: Looked = field(repr=False)
    offsets: Offsets = field(repr=False)
    apart_m: float
    scale: float
    lean: float


def photo_section(eye: Eye, photos: Photos) -> Section:
    """Look at the photographs, print a line for each, and return the figures."""
    labels = photos.labels
    own = labels.shot
    first = Carried(own, labels.height_m, np.zeros(2), np.eye(3), np.zeros((0, 2)), 0.0)
    labelled = look_at(eye, labels, own, first)
    common = lot_features(labels)
    others, left_out = [], 0
    for path in photographs(photos.folder):
        if path.name == labels.photograph:
            continue
        shot = read_shot(path)
        carried = place(common, shot, labels.height_of(shot))
        reason = _unfit(labels, carried)
        if reason or carried is None:
            print(f"  {path.name}: left out, {reason}")
            left_out += 1
        else:
            others.append(look_at(eye, labels, shot, carried))
    figures = [*_found("photo_", "the labelled one", [labelled]), *_found("photos_", "the others", others)]
    figures.append(Figure("photos_seen", "the others: photographs", float(len(others))))
    figures.append(Figure("photos_left_out", "photographs left out", float(left_out)))
    return Section("photographs of a real flight", [*figures, *_placed(others), *_relief([labelled, *others])])


def lot_features(labels: PhotoLabels) -> Features:
    """Return the features of the labelled photograph in and near the lots."""
    found = features(level(labels.shot, labels.height_m))
    near = shapely.union_all([shapely.Polygon(lot) for lot in labels.lots]).buffer(AROUND_M)
    inside = shapely.contains_xy(near, found.points[:, 0], found.points[:, 1])
    return Features(found.points[inside], found.descriptors[inside])


def shown(labels: PhotoLabels, carried: Carried) -> NDArray[np.bool_]:
    """Return which stalls (N,) a photograph shows whole."""
    camera = carried.shot.camera
    pixels = carried.shot.pixels(carried.carry(labels.stalls).reshape(-1, 2), carried.height_m)
    inside = (pixels >= 0) & (pixels <= (camera.width - 1, camera.height - 1))
    return np.asarray(inside.all(axis=1).reshape(-1, 4).all(axis=1))


def look_at(eye: Eye, labels: PhotoLabels, shot: Shot, carried: Carried) -> Seen:
    """Return what is found in a photograph that was placed. ``shot`` is as its tags say."""
    picture = level(carried.shot, carried.height_m)
    stalls = picture.corners(carried.carry(labels.stalls))
    size = np.array(picture.missing.shape[::-1]) * GROUND_M
    in_view = np.any((stalls > 0).all(axis=2) & (stalls < size).all(axis=2), axis=1)
    truth = LabelledPlace(
        stalls[in_view],
        labels.states(shot.name)[in_view],
        tuple(picture.corners(carried.carry(lot)) for lot in labels.lots),
    )
    at = Place(shot.name, picture.image, GROUND_M, truth, missing=picture.missing)
    looked = look(eye, [at])[0]
    print(f"  {shot.name}: {line(looked.tally.measures())}, {looked.tally.true} labels, {len(carried.ties)} features")
    by_exif = pymap3d.geodetic2ned(
        shot.latitude, shot.longitude, shot.altitude,
        labels.shot.latitude, labels.shot.longitude, labels.shot.altitude,
    )  # fmt: skip
    apart = math.dist(carried.foot, (float(by_exif[0]), float(by_exif[1])))
    lean = math.acos(min(1.0, float(shot.axis() @ carried.shot.axis())))
    scale = carried.height_m / labels.height_of(shot)
    return Seen(carried, looked, _offsets(looked, picture, carried.height_m), apart, scale, lean)


def _unfit(labels: PhotoLabels, carried: Carried | None) -> str:
    """Return why a photograph is left out; empty when it is not."""
    if carried is None:
        return "too few features in common with the labelled one"
    seen = shown(labels, carried)
    if seen.mean() < LEAST_SHOWN:
        return f"it shows {seen.mean():.0%} of the stalls"
    ground = shapely.MultiPoint(carried.ties).convex_hull.buffer(BESIDE_M)
    within = float(shapely.contains_xy(ground, *labels.stalls[seen].mean(axis=1).T).mean())
    return "" if within >= LEAST_WITHIN else f"its features surround only {within:.0%} of the stalls that it shows"


def _offsets(looked: Looked, picture: Levelled, height_m: float) -> Offsets:
    """Return the offsets of the matched stalls whose state is labelled."""
    finding, truth = looked.kept.result.finding, looked.kept.truth
    pairs = match(finding.stalls, truth.stalls)
    states = np.asarray(truth.states, object)[pairs.true]
    known = (states == StallState.FREE) | (states == StallState.TAKEN)
    found, label = finding.stalls[pairs.found][known].mean(axis=1), truth.stalls[pairs.true][known].mean(axis=1)
    places = picture.points((label - GROUND_M / 2) / GROUND_M)
    errors = (found - label)[:, ::-1] * (-1.0, 1.0)
    return Offsets(
        places / height_m,
        errors / height_m,
        np.full(len(places), height_m),
        np.asarray(states[known] == StallState.TAKEN),
    )


def _found(prefix: str, text: str, seen: Sequence[Seen]) -> list[Figure]:
    values = pooled([one.looked for one in seen])
    return [
        Figure(prefix + name, f"{text}: {name.removesuffix('_m').replace('_', ' ')}", values[name], _unit(name))
        for name in SHOWN
        if name in values
    ]


def _unit(name: str) -> str:
    return "m" if name.endswith("_m") else ""


def _placed(seen: Sequence[Seen]) -> list[Figure]:
    """Return how far EXIF and XMP are from what the features say, and how well these agree."""
    if not seen:
        return []
    scale = np.array([one.scale for one in seen])
    middle = {
        "photos_residual_m": ("features: distance from their place", [one.carried.residual_m for one in seen], "m"),
        "photos_exif_place_m": ("EXIF's place off by", [one.apart_m for one in seen], "m"),
        "photos_lean_deg": ("XMP's attitude off by", [math.degrees(one.lean) for one in seen], "degrees"),
    }
    figures = [
        Figure(key, f"{text}, median", float(np.median(values)), unit) for key, (text, values, unit) in middle.items()
    ]
    figures.append(Figure("photos_scale", "scale over that of EXIF's altitude, mean", float(scale.mean())))
    figures.append(Figure("photos_scale_sigma", "its standard deviation", float(scale.std())))
    return figures


def _relief(seen: Sequence[Seen]) -> list[Figure]:
    """Return the relief of free and of taken stalls over all photographs."""
    parts = [one.offsets for one in seen]
    every = Offsets(
        np.concatenate([part.places for part in parts]),
        np.concatenate([part.errors for part in parts]),
        np.concatenate([part.height_m for part in parts]),
        np.concatenate([part.taken for part in parts]),
    )
    figures = []
    for name, taken in (("free", False), ("taken", True)):
        height, error, count = every.relief(taken=taken)
        figures.append(Figure(f"photos_relief_{name}_m", f"relief of {name} stalls", height, "m"))
        figures.append(Figure(f"photos_relief_{name}_sigma_m", "its standard error", error, "m"))
        figures.append(
            Figure(f"photos_relief_{name}_stalls", f"{name} stalls found, over all photographs", float(count))
        )
    return figures
