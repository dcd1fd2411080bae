"""Photographs that look ahead, which their files do not say: the ground that neighbours show, and the horizon, do."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median
from typing import Final

from hawk.formats.image import NoImage
from hawk.picture.adjust.app import Known
from hawk.picture.adjust.tilt import has_horizon, tilts
from hawk.picture.looked import Looked
from hawk.picture.values import Shot

MOST_DEG: Final = 30.0
"""Off straight down, the median of a flight whose files say no angles, above which its photographs look ahead.

One photograph errs far more, by a rolling shutter, trees, or little common ground: those of a flight straight down had
a median of 23 degrees (docs/results/pictures.md).
"""
LEAST_DEG: Final = 20.0
"""Off straight down, from which a photograph of such a flight is left out."""
_REMEDY: Final = "turn the camera down, to -90"


def oblique_of(shots: Sequence[Shot], known: Sequence[Known], looked: Looked) -> dict[str, str]:
    """Return the names of shots that look too far off straight down, of those whose files say no angles; and why."""
    asked = [number for number, shot in enumerate(shots) if shot.attitude is None]
    if not asked:
        return {}
    seen = tilts([one.posed for one in known], asked, looked.features_of(shots))
    middle = math.degrees(median(seen.values())) if seen else 0.0
    found = {}
    for number in asked:
        shot = shots[number]
        if middle > MOST_DEG and math.degrees(seen.get(number, 0.0)) > LEAST_DEG:
            found[shot.name] = (
                f"looks about {middle:.0f} degrees or more off straight down, by the ground that its neighbours show, "
                f"and its file says no angles; {_REMEDY}"
            )
        elif _shows_sky(looked, shot):
            found[shot.name] = f"shows sky above the horizon, and its file says no angles; {_REMEDY}"
    return found


def _shows_sky(looked: Looked, shot: Shot) -> bool:
    try:
        return has_horizon(looked.picture(shot))
    except NoImage:  # the map says so
        return False
