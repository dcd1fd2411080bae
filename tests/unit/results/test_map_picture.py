"""The sheet of a lot: its scale bar, north, legend and words."""

from __future__ import annotations

import numpy as np
import pytest

from hawk.model.lot_map import StallState
from hawk.results.map_picture import Caption, scale_bar_m, sheet

CAPTION = Caption("Lot 1", ("2026-02-03", "hawk-drone"), {StallState.FREE: 46, StallState.TAKEN: 60})


def drawn(width: int, metres: float = 0.1, caption: Caption = CAPTION) -> np.ndarray:
    return sheet(np.full((300, width, 3), 90, np.uint8), metres, caption)


def test_the_picture_stays_as_it_is_above_a_strip() -> None:
    wide = drawn(1200)
    assert wide.shape == (396, 1200, 3)
    assert (wide[:300] == 90).all()
    narrow = drawn(400)
    assert narrow.shape == (396, 900, 3)
    assert (narrow[:300, 250:650] == 90).all()
    assert (narrow[:300, :250] == 255).all()


@pytest.mark.parametrize(("metres", "wide", "bar"), [(0.1, 1500, 10), (0.1, 2000, 20), (0.3, 2000, 50), (0.01, 900, 1)])
def test_the_bar_is_a_round_number_of_metres(metres: float, wide: int, bar: int) -> None:
    assert scale_bar_m(metres, wide) == bar


def test_the_bar_is_as_long_as_it_says() -> None:
    strip = drawn(1500)[300:]
    dark = np.flatnonzero((strip[44] < 60).all(axis=1))
    bar = dark[dark > 1500 - 90 - 210]
    bar = bar[bar <= 1500 - 90]
    assert bar[-1] - bar[0] == pytest.approx(scale_bar_m(0.1, 1500) / 0.1, abs=1)


def test_counts_lot_and_date_are_on_it() -> None:
    other = Caption("Étoile", ("2026-02-04", "hawk-drone"), {StallState.FREE: 47, StallState.TAKEN: 60})
    differs = (drawn(1200)[300:] != drawn(1200, caption=other)[300:]).any(axis=2)
    assert differs[:, :400].any(), "lot and date"
    assert differs[:, 552:670].any(), "free stalls"
    assert not differs[:, 672:1000].any(), "taken stalls are as many"
    assert (drawn(1200)[300:, 1140:1180] < 60).any(), "north"
