"""Two sets of features on the ground, and the similarity between them that most features agree on.

Places on the ground are complex: metres north + i east of the drone.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numpy.typing import NDArray

Places = NDArray[np.complex128]
Distances = NDArray[np.float32]

KEY_SHARE = 0.3
"""Another key picture is taken when the ground has moved by this share of the height."""
KEY_TURN = 0.35
"""... or has turned by this angle, radians."""
KEY_STRETCH = 0.2
"""... or has become larger or smaller by this share."""
REACH_M = 1.1
"""A feature is sought this far about the place where it should be: less than half of the narrowest stall's pitch."""
LEAST = 16
"""Least number of features that must agree."""
LEAST_SHARE, SURE_SHARE = 0.3, 0.5
"""Least share of the matched features that must agree; the same of those that were sought everywhere: rows of stalls
repeat."""
OUTLIER_PIXELS = 2.0
NEVER = 1000.0  # more than any Hamming distance of 256 bits


@dataclass(frozen=True, slots=True)
class GroundFeatures:
    """Features on the ground: ``places`` (N,), their ``descriptors`` (N, 32), and ``grain``, a pixel's metres."""

    places: Places = field(repr=False)
    descriptors: NDArray[np.uint8] = field(repr=False)
    grain: float


@dataclass(frozen=True, slots=True)
class Similarity:
    """Ground at ``z`` of the one picture is at ``factor * z + offset`` of the other."""

    factor: complex = 1 + 0j
    offset: complex = 0j

    def then_moved(self, path: complex) -> Similarity:
        """Return the similarity after the drone has flown on by ``path``, metres."""
        return replace(self, offset=self.offset - path)

    def is_far(self, height: float) -> bool:
        """Return True when the two pictures begin to have too little in common; ``height`` over ground, metres."""
        moved, turned = abs(self.offset) > KEY_SHARE * height, abs(cmath.phase(self.factor)) > KEY_TURN
        return moved or turned or abs(math.log(abs(self.factor))) > KEY_STRETCH


def compare(before: GroundFeatures, now: GroundFeatures, expected: Similarity, farthest: float) -> Similarity | None:
    """Return the similarity from the ground of one picture to that of the other; None when too little agrees.

    Features are sought within `REACH_M` of where ``expected`` says that they are; when too few agree there, everywhere,
    and more must agree. A result farther than ``farthest`` (metres) from the expected one is none. RANSAC (Fischler and
    Bolles, 1981) over the features that are each other's nearest by their descriptors.
    """
    if min(len(before.places), len(now.places)) < LEAST:
        return None
    sought = expected.factor * before.places + expected.offset
    distance = hamming(before.descriptors, now.descriptors)
    near = abs(sought[:, None] - now.places[None]) <= REACH_M
    found = _agreed(before, now, np.where(near, distance, NEVER), LEAST_SHARE)
    if found is None or abs(found.offset - expected.offset) > REACH_M:
        found = _agreed(before, now, distance, SURE_SHARE)
    return None if found is None or abs(found.offset - expected.offset) > farthest else found


def _agreed(before: GroundFeatures, now: GroundFeatures, distance: Distances, share: float) -> Similarity | None:
    first, second = mutual(distance)
    if len(first) < LEAST:
        return None
    source, target = _pairs(before.places[first]), _pairs(now.places[second])
    fit, agree = cv2.estimateAffinePartial2D(
        source, target, ransacReprojThreshold=OUTLIER_PIXELS * now.grain, maxIters=500
    )
    if fit is None or np.count_nonzero(agree) < max(LEAST, share * len(first)):
        return None
    return Similarity(complex(fit[0, 0], fit[1, 0]), complex(fit[0, 2], fit[1, 2]))


def mutual(distance: Distances) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the indices of features that are each other's nearest."""
    there, back = distance.argmin(1), distance.argmin(0)
    every = np.arange(len(distance))
    k = np.flatnonzero((back[there] == every) & (distance[every, there] < NEVER))
    return k, there[k]


def hamming(first: NDArray[np.uint8], second: NDArray[np.uint8]) -> Distances:
    """Return the Hamming distances (N, M) of descriptors (N, 32) and (M, 32)."""
    a, b = (np.ascontiguousarray(each).view(np.uint64) for each in (first, second))
    bits = np.zeros((len(a), len(b)), np.uint16)
    for k in range(a.shape[1]):
        bits += np.bitwise_count(a[:, k, None] ^ b[None, :, k])
    return bits.astype(np.float32)


def _pairs(places: Places) -> NDArray[np.float32]:
    return np.column_stack([places.real, places.imag]).astype(np.float32)
