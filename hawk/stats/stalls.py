"""Stalls one by one: the share of surveys in which each was taken."""

from __future__ import annotations

import numpy as np
from sqlalchemy import Connection

from hawk.stats.answers import StallsUse
from hawk.stats.panel import Period, read_panel
from hawk.stats.values import DEVIATIONS, LEVEL, TAKEN, UNSEEN, Floats


def stalls_use(connection: Connection, lot: str, period: Period) -> StallsUse:
    """Return of each stall the share of a period's surveys in which it was taken, in columns.

    ``surveys``: those that saw its state; ``share``, ``low``, ``high``: None without any. The shares are those of the
    surveys' moments. Raises NotFoundError, LotStoreError.
    """
    panel = read_panel(connection, lot, period)
    is_seen = panel.is_there & (panel.state != UNSEEN)
    looks = is_seen.sum(axis=0).astype(np.float64)
    taken = (is_seen & (panel.state == TAKEN)).sum(axis=0).astype(np.float64)
    wrong = np.where(is_seen, panel.taken * (1 - panel.taken), np.float32(0)).sum(axis=0, dtype=np.float64)
    low, high = share_bounds(taken, looks, wrong)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = taken / looks
    return StallsUse(
        lot=lot, interval=LEVEL, surveys_in_period=len(panel.surveys),
        ids=[stall.id for stall in panel.stalls], labels=[stall.label for stall in panel.stalls],
        surveys=looks.astype(int).tolist(), share=_listed(share), low=_listed(low), high=_listed(high),
    )  # fmt: skip


def share_bounds(taken: Floats, looks: Floats, wrong: Floats) -> tuple[Floats, Floats]:
    """Return the ends of the interval of shares ``taken / looks``; NaN without looks.

    Wilson's interval (1927) of a share among independent moments, widened by the variance ``wrong`` of the number of
    taken ones by wrong states.
    """
    z = DEVIATIONS
    with np.errstate(divide="ignore", invalid="ignore"):
        share = taken / looks
        middle = (share + z**2 / (2 * looks)) / (1 + z**2 / looks)
        half = z * np.sqrt(share * (1 - share) / looks + z**2 / (4 * looks**2)) / (1 + z**2 / looks)
        off = np.hypot(half, z * np.sqrt(wrong) / looks)
    return np.clip(np.minimum(middle - off, share), 0.0, 1.0), np.clip(np.maximum(middle + off, share), 0.0, 1.0)


def _listed(values: Floats) -> list[float | None]:
    return [round(value, 4) if value == value else None for value in values.tolist()]
