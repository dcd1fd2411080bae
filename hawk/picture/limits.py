"""Limits of a survey by pictures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from hawk.lots.registration.georeference import ground_about
from hawk.lots.survey.source import Limit
from hawk.lots.values import FinishedSurvey
from hawk.picture.values import COARSE_M, Shot

if TYPE_CHECKING:  # orthophotos have limits without its libraries
    from hawk.picture.photographs.scale import Scale
    from hawk.picture.reconstruction.alignment import Reconstruction

SURE_M: Final = 0.3
"""A picture whose place is known to this needs no neighbours: by RTK, or by another program's adjustment."""
LOT_M: Final = 100.0
"""Length of a lot over which an error of turn and scale is judged."""
STALL_M: Final = 2.5
"""Error of a lot's ends against its middle by which a stall there is taken for its neighbour."""
UNSEEN_SHARE: Final = 0.02
"""Share of a lot's ground from which it counts as not wholly seen; cars and edges hide less."""


def limits_of(
    shots: Sequence[Shot], adjusted: Reconstruction, scale: Scale, metres_per_pixel: float, kept: FinishedSurvey
) -> tuple[Limit, ...]:
    """Return what limits a survey by shots, of which some were adjusted."""
    alone = [shot for shot, good in zip(shots, adjusted.is_adjusted, strict=True) if not good]
    found = []
    if any(shot.sigma[0] > SURE_M for shot in alone):
        found.append(Limit.BY_GPS)
    if stretch(adjusted, scale) * LOT_M / 2 > STALL_M:
        found.append(Limit.STRETCHED)
    if metres_per_pixel > COARSE_M:
        found.append(Limit.COARSE)
    if unseen_share(kept) > UNSEEN_SHARE:
        found.append(Limit.PARTLY)
    return tuple(found)


def stretch(adjusted: Reconstruction, scale: Scale) -> float:
    """Return by how much a map may be turned, radians, or scaled, as a share, in nine of ten surveys.

    It is 0 where fewer than two shots were adjusted: each lies by its own place then.
    """
    return max(scale.off, scale.turn) if int(adjusted.is_adjusted.sum()) > 1 else 0.0


def unseen_share(kept: FinishedSurvey) -> float:
    """Return the share of a lot's ground that its survey did not see; 0 without a lot."""
    datum = kept.datum.latitude, kept.datum.longitude
    lot = ground_about(datum, kept.outline)
    return float(lot.difference(ground_about(datum, kept.seen_ground)).area / lot.area) if lot.area else 0.0
