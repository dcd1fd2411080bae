"""What does not lie on the ground: it does not stay put while the drone flies past.

Laid on the ground plane, what is h metres high moves against the ground by h / (H - h) of the way that the drone flies,
H metres high. That share is its lean. `hawk.algo.mapper.slip` measures it for single stalls from frame to frame: within
a few metres of way no stall gets so far that its neighbour is taken for it, which fusing over a whole pass would do.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper.table import Rows

RAISED = 0.06
"""Lean of what stands off the ground: 2 m seen from 35 m. Stalls on the ground stay below it, with cars on them too."""
_SIGMA = 0.08  # of one look: 0.15 m of noise in two places, over the way between two frames
_MOST_LOOKS = 20.0


def note(rows: Rows, leans: NDArray[np.float64]) -> None:
    """Add a look at each of the stalls (N,); NaN where this frame does not tell."""
    told = np.isfinite(leans)
    rows["lean_looks"] = np.minimum(rows["lean_looks"] + told, _MOST_LOOKS)
    step = (np.where(told, leans, 0) - rows["lean"]) / np.maximum(rows["lean_looks"], 1)
    rows["lean"] += np.where(told, step, 0)
    rows["raised"] = rows["lean"] > RAISED + _SIGMA / np.sqrt(np.maximum(rows["lean_looks"], 1))
