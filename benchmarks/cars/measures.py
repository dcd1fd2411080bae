"""Measures of an eye for vehicles: matched one to one, by ground, by section, and how well probabilities are meant."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from benchmarks.cars.eyes import LEAST_PROBABILITY, CarEye, SeenVehicles
from benchmarks.cars.labels import HAND_LABELS, LabelError
from benchmarks.cars.scenes import CarScene, shifted
from benchmarks.figures import Figure, Reference, share
from benchmarks.perception.measures import Judged, calibration_error
from hawk.algo.vision.detection import FloatArray
from hawk.lots.survey.section_counts import interval

NEAR_M: Final = 1.5
"""A find is the labelled vehicle whose centre lies within this."""
_FAR: Final = 1e6


@dataclass(frozen=True, slots=True)
class LotSection:
    """A strip of a region: ``outline`` (N, 2), metres, and the number of stalls that its labels have."""

    region: str
    outline: FloatArray = field(repr=False)
    capacity: int


@dataclass(frozen=True, slots=True)
class CarTally:
    """Counts of one picture or more. ``hits`` and ``labels`` by group; ``judged``: probabilities, and whether right.
    ``sections``: vehicles found and labelled in each, and whether its interval holds the labelled ones.
    """

    matched: int = 0
    found: int = 0
    labels: int = 0
    groups: dict[str, tuple[int, int]] = field(default_factory=dict)
    judged: tuple[Judged, ...] = ()
    sections: tuple[tuple[int, int, bool], ...] = ()
    off_m: tuple[float, ...] = ()

    def __add__(self, other: CarTally) -> CarTally:
        names = [*self.groups, *(name for name in other.groups if name not in self.groups)]
        groups = {name: _sum(self.groups.get(name, (0, 0)), other.groups.get(name, (0, 0))) for name in names}
        return CarTally(
            self.matched + other.matched, self.found + other.found, self.labels + other.labels, groups,
            self.judged + other.judged, self.sections + other.sections, self.off_m + other.off_m,
        )  # fmt: skip


def _sum(a: tuple[int, int], b: tuple[int, int]) -> tuple[int, int]:
    return a[0] + b[0], a[1] + b[1]


def measure(eye: CarEye, scene: CarScene, sections: Sequence[LotSection] = ()) -> CarTally:
    """Return the counts of one picture. What is cut, or a person would not bet on, is neither right nor wrong."""
    seen, truth = eye.find(scene), scene.truth
    centres = seen.corners.mean(axis=1)
    is_shown = ~scene.is_missing(centres)
    centres, probability = centres[is_shown], seen.probability[is_shown]
    sure = probability >= LEAST_PROBABILITY
    of_find, of_label = matched(centres[sure], truth.centres)
    counts = truth.is_counted[of_label]
    unmatched = np.setdiff1d(np.arange(int(sure.sum())), of_find)
    false = int((~_within(centres[sure][unmatched], truth.corners[~truth.is_counted])).sum())
    hit = np.zeros(len(truth), np.bool_)
    hit[of_label] = True
    apart = np.hypot(*(centres[sure][of_find] - truth.centres[of_label])[counts].T)
    return CarTally(
        matched=int(counts.sum()),
        found=int(counts.sum()) + false,
        labels=int(truth.is_counted.sum()),
        groups=_groups(scene, hit),
        judged=(judged(seen, scene),),
        sections=tuple(
            _counted(part, centres[sure], probability[sure], truth.centres)
            for part in sections
            if part.region == scene.name
        ),
        off_m=tuple(apart.tolist()),
    )


SHIFTS: Final = ((0, 0), (3, 0), (0, 5), (7, 2), (2, 9), (11, 4), (6, 13), (15, 15))
"""Columns and rows by which a picture is shifted to see whether a find depends on them, pixels."""


def flicker(eye: CarEye, scene: CarScene) -> tuple[int, int]:
    """Return how many labelled vehicles are found in some of eight shifts of a picture but not in all, and in any."""
    times = np.zeros(len(scene.truth), np.intp)
    for columns, rows in SHIFTS:
        one = shifted(scene, columns, rows)
        seen = eye.find(one)
        sure = seen.probability >= LEAST_PROBABILITY
        times[matched(seen.corners[sure].mean(axis=1), one.truth.centres)[1]] += 1
    times = times[scene.truth.is_counted]
    return int(((times > 0) & (times < len(SHIFTS))).sum()), int((times > 0).sum())


def matched(found: FloatArray, true: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the indices of finds (N, 2) and labels (M, 2) that are one: the nearest pairing, none beyond `NEAR_M`."""
    if not len(found) or not len(true):
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    apart = cdist(found, true)
    rows, columns = linear_sum_assignment(np.where(apart <= NEAR_M, apart, _FAR))
    near = apart[rows, columns] <= NEAR_M
    return rows[near], columns[near]


def _within(places: FloatArray, corners: FloatArray) -> NDArray[np.bool_]:
    """Return True (N,) for places (N, 2) that lie within one of the quads (M, 4, 2)."""
    if not len(places) or not len(corners):
        return np.zeros(len(places), np.bool_)
    return np.asarray(shapely.union_all(shapely.polygons(corners)).buffer(0.3).contains(shapely.points(places)))


def _groups(scene: CarScene, hit: NDArray[np.bool_]) -> dict[str, tuple[int, int]]:
    truth = scene.truth
    ground = np.array(truth.ground, object)
    masks = {
        **{name: ground == name for name in ("open", "shade", "crown")},
        "kerb": truth.is_kerb,
        "in a lane": truth.is_moving,
        "long": truth.kind >= 2,
    }
    kept = {name: mask & truth.is_counted for name, mask in masks.items()}
    return {name: (int((hit & mask).sum()), int(mask.sum())) for name, mask in kept.items() if mask.any()}


def judged(seen: SeenVehicles, scene: CarScene) -> Judged:
    """Return the probabilities of the finds in a picture, and which are vehicles; cut and unsure ones are left out."""
    centres = seen.corners.mean(axis=1)
    of_find, of_label = matched(centres, scene.truth.centres)
    right = np.zeros(len(centres), np.bool_)
    right[of_find] = scene.truth.is_counted[of_label]
    out = _within(centres, scene.truth.corners[~scene.truth.is_counted]) & ~right
    out |= scene.is_missing(centres)
    return Judged(seen.probability[~out], right[~out])


def _counted(
    section: LotSection, found: FloatArray, probability: FloatArray, true: FloatArray
) -> tuple[int, int, bool]:
    """Return how many vehicles are found and labelled in a section, and whether its interval holds the labelled."""
    area = shapely.Polygon(section.outline)
    is_found, is_true = (shapely.contains_xy(area, places) for places in (found, true))
    least, most = interval(probability[is_found])
    counted, count = int(is_found.sum()), int(is_true.sum())
    return counted, count, min(least, counted) <= count <= max(most, counted)


def read_sections(path: Path = HAND_LABELS / "sections.json") -> list[LotSection]:
    """Read the sections of the regions; none without the file. Raises LabelError."""
    if not path.exists():
        return []
    try:
        return [
            LotSection(str(one["region"]), np.array(one["outline_m"], np.float64), int(one["capacity"]))
            for one in json.loads(path.read_text())
        ]
    except (KeyError, TypeError, ValueError) as error:
        raise LabelError(f"{path}: not sections of regions ({error})") from error


def figures(tally: CarTally, key: str, reference: CarTally | None = None) -> list[Figure]:
    """Return the rows of a table, those of ``reference`` as the reference."""
    values, former = _values(tally), {} if reference is None else _values(reference)
    return [
        Figure(
            f"{key}_{name.replace(' ', '_')}", name, value,
            reference=Reference("car channel", former[name]) if name in former else None,
        )
        for name, value in values.items()
    ]  # fmt: skip


def _values(tally: CarTally) -> dict[str, float | None]:
    values: dict[str, float | None] = {
        "labels": float(tally.labels),
        "recall": share(tally.matched, tally.labels),
        "precision": share(tally.matched, tally.found),
    }
    values |= {f"recall, {name}": share(*pair) for name, pair in tally.groups.items() if pair[1] != tally.labels}
    if tally.off_m:
        values["centre off p95 m"] = float(np.percentile(tally.off_m, 95))
    values["calibration error"] = calibration_error(tally.judged)
    if tally.sections:
        said, true, held = np.array(tally.sections).T
        values["sections"] = float(len(said))
        values["sections exact"] = float((said == true).mean())
        values["total of sections over true"] = share(float(said.sum()), float(true.sum()))
        values["interval of a section holds the truth"] = float(held.mean())
    return values
