"""Source of a survey by pictures, with what limits it."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import NormalDist
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from hawk.lots.place import ground_about
from hawk.lots.source import Limit, PictureSource, SourceKind
from hawk.lots.values import FinishedSurvey, fitting_name
from hawk.model.lot_map import HELD_SHARE
from hawk.picture.values import COARSE_M, Shot

if TYPE_CHECKING:  # orthophotos have limits without its libraries
    from hawk.picture.adjust.app import Adjusted

SURE_M: Final = 0.3
"""A picture whose place is known to this needs no neighbours: by RTK, or by another program's adjustment."""
LOT_M: Final = 100.0
"""Length of a lot over which an error of turn and scale is judged."""
STALL_M: Final = 2.5
"""Error of a lot's ends against its middle by which a stall there is taken for its neighbour."""
_WITHIN: Final = NormalDist().inv_cdf((1 + HELD_SHARE) / 2)
"""Standard deviations of a normal error within which that share of its values lies."""
UNSEEN_SHARE: Final = 0.02
"""Share of a lot's ground from which it counts as not wholly seen; cars and edges hide less."""


def source_of(kind: SourceKind, name: str, limits: Sequence[Limit] = ()) -> PictureSource:
    """Return the source of a survey. ``name``: that of its folder or file, as the system has it."""
    return PictureSource(kind, fitting_name(name) or kind.value, tuple(limits))


def limits_of(
    shots: Sequence[Shot], adjusted: Adjusted, metres_per_pixel: float, kept: FinishedSurvey
) -> tuple[Limit, ...]:
    """Return what limits a survey by shots, of which some were adjusted."""
    alone = [shot for shot, good in zip(shots, adjusted.is_adjusted, strict=True) if not good]
    found = []
    if any(shot.sigma[0] > SURE_M for shot in alone):
        found.append(Limit.BY_GPS)
    if stretch(shots, adjusted) * LOT_M / 2 > STALL_M:
        found.append(Limit.STRETCHED)
    if metres_per_pixel > COARSE_M:
        found.append(Limit.COARSE)
    if unseen_share(kept) > UNSEEN_SHARE:
        found.append(Limit.PARTLY)
    return tuple(found)


def stretch(shots: Sequence[Shot], adjusted: Adjusted) -> float:
    """Return by how much a map may be turned, radians, and scaled, as a share, in `HELD_SHARE` of all surveys.

    It is 0 where fewer than two shots were adjusted: each lies by its own place then.
    """
    places = np.array([(one.north, one.east) for one in adjusted.posed]).reshape(-1, 2)[adjusted.is_adjusted]
    if len(places) < 2:
        return 0.0
    return _WITHIN * fit_error(places, float(np.median([shot.sigma[0] for shot in shots])))


def fit_error(places: NDArray[np.float64], sigma: float) -> float:
    """Return the standard deviation of a map's turn, radians, and of its scale as a share: both are the same.

    They are those of the least squares similarity between the places (N, 2), metres, and what a receiver said of each
    with this standard deviation along each axis (Umeyama 1991). What all places err by alike turns and scales nothing.
    """
    spread = float(np.sqrt(((places - places.mean(axis=0)) ** 2).sum()))
    return sigma / spread if spread > 0 else np.inf


def unseen_share(kept: FinishedSurvey) -> float:
    """Return the share of a lot's ground that its survey did not see; 0 without a lot."""
    datum = kept.datum.latitude, kept.datum.longitude
    lot = ground_about(datum, kept.outline)
    return float(lot.difference(ground_about(datum, kept.seen)).area / lot.area) if lot.area else 0.0
