"""Panels of drawn lots for the tests of the statistics."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime, timedelta

import numpy as np
from numpy.typing import NDArray

from hawk.stats.values import TAKEN, UNSEEN, Group, Panel, PanelColumn, PanelRow

MONDAY = datetime(2026, 5, 4, tzinfo=UTC)


def at(hours: float, days: int = 0) -> float:
    """Return a moment by hours after the begin of a Monday, Unix seconds."""
    return (MONDAY + timedelta(days=days, hours=hours)).timestamp()


def panel(moments: Sequence[float], states: Sequence[Sequence[int]], sure: float = 0.999, a_row: int = 10) -> Panel:
    """Return the surveys at some moments that saw these states (S, N), each with a probability."""
    state: NDArray[np.int8] = np.array(states, np.int8).reshape(len(moments), len(states[0]) if states else 0)
    taken = np.where(state == TAKEN, sure, 1 - sure)
    stalls = tuple(
        PanelColumn(f"{k:036d}", f"{chr(65 + k // a_row)} {k % a_row + 1}", chr(65 + k // a_row), "")
        for k in range(state.shape[1])
    )
    surveys = tuple(PanelRow(f"{k:036d}", moment) for k, moment in enumerate(moments))
    taken = np.where(state == UNSEEN, np.nan, taken).astype(np.float32)
    return Panel("lot", "Lot 1", UTC, "UTC", stalls, surveys, (), taken, state, np.ones(state.shape, np.bool_))


def everything(of: Panel) -> list[Group]:
    """Return all stalls as one group."""
    return [Group("all", np.ones(len(of.stalls), np.bool_))]
