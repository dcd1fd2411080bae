"""Rows completed one lattice at a time, as one would write it down first: the reference for the quick method."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision import quads
from hawk.algo.vision.rows import Evidence, RowOptions, RowStalls, row_of, row_stalls
from hawk.algo.vision.seen import FloatArray

Indices = NDArray[np.intp]


def complete_rows(stalls: RowStalls, evidence: Evidence, options: RowOptions) -> RowStalls:
    group = row_of(stalls)
    size = np.bincount(group)
    least = {1: options.lone_score, 2: options.lone_score * 0.75}
    kept = np.array([score >= least.get(int(size[g]), 0.0) for g, score in zip(group, stalls.score, strict=True)])
    snapped, implied = stalls, []
    for row in np.flatnonzero(size >= 3):
        for lattice in lattices(stalls, np.flatnonzero(group == row), options):
            snapped = lattice.snap(snapped)
            implied.append(lattice.infer(evidence, options))
    result = snapped[kept]
    result = result[quads.suppress(result.corners(), result.score, 0.3)]
    inferred = joined(implied)
    inferred = inferred[quads.suppress(inferred.corners(), inferred.score, 0.25)]
    clear = [
        quads.overlaps(np.tile(c, (len(result), 1, 1)), result.corners()).max() <= 0.25 for c in inferred.corners()
    ]
    return joined([result, inferred[np.array(clear, bool)]])


@dataclass(frozen=True)
class Lattice:
    """One row's: stall k has its centre at origin + axes[0] * t + axes[1] * offset(t), t = first + pitch * k."""

    members: Indices
    places: Indices
    origin: FloatArray
    axes: FloatArray
    first: float
    pitch: float
    offset: FloatArray
    angle: float
    width: float
    length: float

    def centres(self, k: Indices) -> FloatArray:
        t = self.first + self.pitch * np.asarray(k, float)
        offset = np.polyval(self.offset, t)
        return np.asarray(self.origin + np.outer(t, self.axes[0]) + np.outer(offset, self.axes[1]))

    def stalls(self, k: Indices, score: float) -> RowStalls:
        centre, ones = self.centres(k), np.ones(len(k))
        sizes = self.angle * ones, self.width * ones, self.length * ones, score * ones
        made = row_stalls(centre[:, 0], centre[:, 1], *sizes)
        return replace(made, source=np.full(len(k), -1, np.intp))

    def snap(self, stalls: RowStalls) -> RowStalls:
        values = {n: getattr(stalls, n).copy() for n in ("north", "east", "angle", "width", "length")}
        for member, to in zip(self.members, self.centres(self.places), strict=True):
            if np.hypot(*(to - stalls.centres[member])) < 0.8:
                fresh = (*to, self.angle, self.width, self.length)
                for name, value in zip(values, fresh, strict=True):
                    values[name][member] = value
        return replace(stalls, **values)

    def infer(self, evidence: Evidence, options: RowOptions) -> RowStalls:
        last = int(self.places.max())
        parts = []
        for k in range(last + 1):
            one = self.stalls(np.array([k]), 0.3)
            said = evidence(one.corners())
            if k not in self.places and said[0] >= options.gap:
                parts.append(replace(one, score=one.score + 0.3 * said))
        for end in (-np.arange(1, options.maximum_end + 1), last + np.arange(1, options.maximum_end + 1)):
            for step in end:
                one = self.stalls(np.array([step]), 0.25)
                said = evidence(one.corners())
                if said[0] < options.end:
                    break
                parts.append(replace(one, score=one.score + 0.3 * said))
        return joined(parts)


def lattices(stalls: RowStalls, members: Indices, options: RowOptions) -> list[Lattice]:
    row = stalls[members]
    origin = row.centres.mean(axis=0)
    axes = np.linalg.svd(row.centres - origin)[2]
    angle = float(np.angle(np.exp(2j * row.angle).sum()) / 2 % np.pi)
    lean = abs(float(quads.cross(np.array(angle), axes[0])))
    if lean < 0.6 or ((row.centres - origin) @ axes[1]).std() > 0.6:
        return []
    t = (row.centres - origin) @ axes[0]
    order = np.argsort(t, kind="stable")
    guess = float(np.median(row.width)) / lean
    gaps = np.diff(t[order])
    usual = gaps[(gaps > 0.75 * guess) & (gaps < 1.3 * guess)]
    pitch = float(np.median(usual)) if len(usual) >= 2 else guess
    found = []
    for run, places in runs(gaps / pitch, options.maximum_gap):
        if len(run) < 3:
            continue
        index, numbers = order[run], np.array(places)
        line = fitted(t[index], numbers, row.score[index])
        if line is None or not 1.8 < line[1] * lean < 4.2:
            continue
        offset = fitted_offset(t[index], ((row.centres - origin) @ axes[1])[index], row.score[index])
        length = float(np.median(row.length))
        found.append(Lattice(members[index], numbers, origin, axes, *line, offset, angle, line[1] * lean, length))
    return found


def fitted(t: FloatArray, places: Indices, score: FloatArray) -> tuple[float, float] | None:
    design, weight = np.column_stack([np.ones(len(t)), places]), score
    for _ in range(3):
        first, pitch = np.linalg.lstsq(design * weight[:, None], t * weight, rcond=None)[0].tolist()
        weight = score / (1 + ((t - first - pitch * places) / 0.25) ** 2)
    if np.median(np.abs(t - first - pitch * places)) > 0.3 or pitch <= 0:
        return None
    return first, pitch


def fitted_offset(t: FloatArray, residual: FloatArray, score: FloatArray) -> FloatArray:
    if len(t) > 3:
        return np.polyfit(t, residual, 1, w=np.maximum(score, 1e-3))
    return np.array([0.0, float(np.median(residual))])


def runs(steps: FloatArray, maximum_gap: int) -> list[tuple[list[int], list[int]]]:
    found = [([0], [0])]
    for index, step in enumerate(steps.tolist(), 1):
        whole = max(round(step), 1)
        if abs(step - whole) > 0.28 + 0.03 * whole or whole > maximum_gap + 1:
            found.append(([index], [0]))
        else:
            run, places = found[-1]
            run.append(index)
            places.append(places[-1] + whole)
    return found


def joined(parts: list[RowStalls]) -> RowStalls:
    names = ("north", "east", "angle", "width", "length", "score", "source")
    none = np.zeros(0)
    empty = row_stalls(none, none, none, none, none, none)
    return RowStalls(**{n: np.concatenate([getattr(p, n) for p in (empty, *parts)]) for n in names})
