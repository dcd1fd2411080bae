"""Lines of trees planted behind parked cars."""

from __future__ import annotations

import numpy as np

from hawk.worlds.plan import Axes, SitePlan
from hawk.worlds.scene.canvas import Points

_TREES = ((3.0, 7.0), (1.6, 3.4), (1.8, 3.4))
_HEDGE = ((0.9, 1.8), (0.8, 1.5), (1.8, 4.5))
_COLUMNS = ((1.5, 3.2), (0.6, 1.2), (4.0, 8.0))
"""Distance of the stems, metres; radius of the crowns, metres; height over radius. Columns: poplars, hornbeams."""
_SHARES = (0.5, 0.25, 0.25)
"""Share of each of them."""
_HEIGHT_M = (1.2, 12.0)
_BEHIND_M = (-0.6, 2.2)
"""Distance of the stems behind the stalls' closed ends, metres."""
_ALONG = 0.87
"""Cosine between the directions of two stalls of one row, at least."""
_DEPTH_M = 1.5
"""Closed ends of one row are on one line, within this distance."""
_REACH_M = (14.0, 60.0)
"""Length of the line of trees to either side of its middle."""


def plant_avenue(plan: SitePlan, rng: np.random.Generator) -> None:
    """Plant a line of trees, broad or columnar, or a hedge behind a part of one of the plan's rows if it has any."""
    if not plan.stalls:
        return
    heads = np.array([stall.corners[2:].mean(axis=0) for stall in plan.stalls])
    outward = heads - np.array([stall.corners[:2].mean(axis=0) for stall in plan.stalls])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    picked = int(rng.integers(len(heads)))
    (x, y), (across, down) = heads[picked].tolist(), outward[picked].tolist()
    axes = Axes((x, y), (-down, across), (across, down))
    step, radius, slender = (_TREES, _HEDGE, _COLUMNS)[int(rng.choice(3, p=_SHARES))]
    spacing, crown, tall = rng.uniform(*step), rng.uniform(*radius), rng.uniform(*slender)
    reach, behind = rng.uniform(*_REACH_M), rng.uniform(*_BEHIND_M)
    along = (_row(heads, outward, picked) - axes.origin) @ axes.u
    for u in np.arange(max(along.min() - crown, -reach), min(along.max() + crown, reach), spacing).tolist():
        x, y = axes.at(u + rng.normal(0, 0.1) * spacing, behind + rng.normal(0, 0.2))
        size = crown * rng.uniform(0.75, 1.2)
        plan.plant((x, y), size, tall, _HEIGHT_M)


def _row(heads: Points, outward: Points, picked: int) -> Points:
    """Return the closed ends (N, 2) of the stalls that stand in one row with the picked one."""
    away = heads - heads[picked]
    in_line = np.abs(away @ outward[picked]) < _DEPTH_M
    return np.asarray(heads[in_line & (outward @ outward[picked] > _ALONG)])
