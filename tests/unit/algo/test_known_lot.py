from __future__ import annotations

import copy
import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon

from hawk.algo.known_lot import FIRST_TRY, PAUSE, PlanRegistration, adjoining, plan_rectangles
from hawk.algo.registration.likelihood import StallMap
from hawk.algo.registration.whole_map import Doubt
from hawk.algo.rows.fit import Rectangles
from hawk.model.known_lot import KnownLot, KnownStall


def rows_of(*counts: int) -> NDArray[np.float64]:
    """Rows of stalls, 16 m apart, with their numbers of stalls: (N, 5)."""
    return np.array([[16.0 * r, 2.6 * k, 0.0, 2.6, 5.2] for r, count in enumerate(counts) for k in range(count)])


def lot_of(stalls: NDArray[np.float64]) -> KnownLot:
    known = tuple(KnownStall(str(k), n, e, a, w, le) for k, (n, e, a, w, le) in enumerate(stalls.tolist()))
    (low, high) = stalls[:, :2].min(0) - 8, stalls[:, :2].max(0) + 8
    ring = ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]))
    return KnownLot("lot", known, ((ring,),))


def seen(stalls: NDArray[np.float64], margin_m: float = 8.0) -> StallMap:
    ground = shapely.MultiPoint(stalls[:, :2]).envelope.buffer(margin_m, join_style="mitre")
    return StallMap(Rectangles(stalls[:, :2], *stalls[:, 2:].T), MultiPolygon([ground]))


def moved(stalls: NDArray[np.float64], north: float, east: float, turn: float) -> NDArray[np.float64]:
    c, s = math.cos(turn), math.sin(turn)
    places = stalls[:, :2] @ np.array([[c, s], [-s, c]]) + (north, east)
    return np.column_stack([places, (stalls[:, 2] + turn) % math.pi, stalls[:, 3:]])


def look(placing: PlanRegistration, found: StallMap, frames: int = 400) -> Rectangles | None:
    for _ in range(frames):
        plans = placing.go_on(len(found.stalls), lambda: found)
        if plans is not None:
            (placed,) = plans
            return placed
    return None


@pytest.mark.slow
@pytest.mark.parametrize(("north", "east", "turn"), [(0.0, 0.0, 0.0), (1.4, -1.1, 0.02), (-2.8, 2.2, -0.03)])
def test_the_plan_is_found_where_the_flight_sees_the_lot(north: float, east: float, turn: float) -> None:
    stalls = rows_of(14, 9, 12)
    there = moved(stalls, north, east, turn)
    placed = look(PlanRegistration(lot_of(stalls)), seen(there))
    assert placed is not None
    assert np.hypot(*(placed.centres - there[:, :2]).T).max() < 0.05


@pytest.mark.nightly
def test_a_row_without_an_end_in_view_is_not_certain_and_is_looked_at_again() -> None:
    stalls = rows_of(40)
    part = stalls[10:30]
    placing, asked = PlanRegistration(lot_of(stalls)), []

    def found() -> StallMap:
        asked.append(True)
        return seen(part, margin_m=-0.1)

    for _ in range(20 * PAUSE):
        assert placing.go_on(len(part), found) is None
    assert placing.doubt is Doubt.ALIKE
    assert len(asked) > 2


def test_a_few_stalls_are_not_compared() -> None:
    placing = PlanRegistration(lot_of(rows_of(14, 9, 12)))

    def never() -> StallMap:
        raise AssertionError

    for _ in range(2 * PAUSE):
        assert placing.go_on(FIRST_TRY - 1, never) is None
    assert placing.doubt is Doubt.TOO_FEW


@pytest.mark.slow
def test_a_copy_begins_its_comparison_again() -> None:
    stalls = rows_of(14, 9, 12)
    placing = PlanRegistration(lot_of(stalls))
    found = seen(stalls)
    placing.go_on(len(stalls), lambda: found)
    assert look(copy.deepcopy(placing), found) is not None


def test_known_ground_that_crosses_itself_is_mended() -> None:
    stalls = rows_of(14, 9, 12)
    bow = ((-10.0, -10.0), (45.0, 45.0), (45.0, -10.0), (-10.0, 45.0))
    lot = KnownLot("lot", lot_of(stalls).stalls, ((bow,),))
    assert len(plan_rectangles(lot)) == len(stalls)
    PlanRegistration(lot)


def test_lots_that_lie_beside_each_other_adjoin_and_one_farther_off_does_not() -> None:
    stalls = rows_of(14, 9, 12)
    beside, beyond = (moved(stalls, north, 0.0, 0.0) for north in (60.0, 200.0))
    first, second, third = (
        replace(lot_of(each), id=name) for each, name in ((stalls, "a"), (beside, "b"), (beyond, "c"))
    )
    assert adjoining([first, third, second]) == [[first, second]]
    assert adjoining([first, third]) == []


def test_rows_that_go_on_in_the_next_lot_have_their_place_by_both_plans() -> None:
    stalls = rows_of(20, 20)
    seam = 9.5 * 2.6
    is_first = stalls[:, 1] < seam
    pieces = (((-8.0, -8.0), (24.0, seam)), ((-8.0, seam), (24.0, 58.0)))
    first, second = (
        replace(lot_of(stalls[mine]), ground=((((a, b), (c, b), (c, d), (a, d)),),))
        for mine, ((a, b), (c, d)) in zip((is_first, ~is_first), pieces, strict=True)
    )
    there = moved(stalls, 0.9, -1.1, 0.01)
    alone = PlanRegistration(first)
    assert look(alone, seen(there)) is None
    assert alone.doubt is Doubt.ALIKE
    both = PlanRegistration(first, second)
    plans = next(filter(None, (both.go_on(len(there), lambda: seen(there)) for _ in range(400))))
    for plan, mine in zip(plans, (is_first, ~is_first), strict=True):
        assert np.hypot(*(plan.centres - there[mine, :2]).T).max() < 0.05
