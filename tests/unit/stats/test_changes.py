from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hawk.stats.changes import changes_between
from hawk.stats.counts import WIDER
from hawk.stats.values import DEVIATIONS, FREE, TAKEN, UNSEEN, Panel
from tests.unit.stats.panels import at, panel

SURE = 0.999


def placed(of: Panel, east: list[float], there: list[list[bool]]) -> Panel:
    """Return the panel with its stalls at metres east, and in the layouts of some surveys."""
    stalls = tuple(
        replace(stall, shape=(0.0, metres, 0.0, 2.5, 5.0)) for stall, metres in zip(of.stalls, east, strict=True)
    )
    return replace(of, stalls=stalls, is_there=np.array(there))


def test_the_change_of_free_stalls_has_the_errors_of_both_surveys() -> None:
    found = changes_between(
        panel([at(8), at(9)], [[FREE] * 6 + [TAKEN] * 4, [TAKEN] * 4 + [FREE] * 3 + [TAKEN] * 3]), 0, 1
    )
    off = DEVIATIONS * np.sqrt(WIDER * 20 * SURE * (1 - SURE))
    assert (found.free.value, found.came.value, found.left.value) == (-3.0, 4.0, 1.0)
    assert found.free.low == pytest.approx(-3 - off, abs=1e-3)
    assert found.free.high == pytest.approx(-3 + off, abs=1e-3)


def test_a_stall_that_became_unclear_is_a_change_and_no_figure_counts_it() -> None:
    found = changes_between(panel([at(8), at(9)], [[TAKEN, FREE], [UNSEEN, FREE]]), 0, 1)
    assert [(each.label, each.before, each.after, each.chance) for each in found.stalls] == [
        ("A 1", "taken", "unknown", None)
    ]
    assert (found.compared, found.unknown, found.free.value) == (1, 1, 0.0)


def test_stalls_that_one_survey_alone_has_are_named_not_left_out_in_silence() -> None:
    three = placed(panel([at(8), at(9)], [[FREE] * 3] * 2), [0, 10, 20], [[True, True, False], [True, False, True]])
    found = changes_between(three, 0, 1)
    assert ([each.label for each in found.gone], [each.label for each in found.begin]) == (["A 2"], ["A 3"])
    assert (found.compared, found.matched, found.free.value) == (1, 0, 0.0)


def test_a_row_that_was_drawn_again_is_compared_by_its_ground() -> None:
    states = [[TAKEN, FREE, UNSEEN, UNSEEN], [UNSEEN, UNSEEN, FREE, FREE]]
    there = [[True, True, False, False], [False, False, True, True]]
    four = placed(panel([at(8), at(9)], states), [0, 2.5, 0.4, 2.9], there)
    found = changes_between(four, 0, 1)
    assert (found.compared, found.matched, found.begin, found.gone, found.free.value) == (2, 2, (), (), 1.0)
    (changed,) = found.stalls
    assert (changed.label, changed.id, changed.former) == ("A 3", four.stalls[2].id, four.stalls[0].id)


@pytest.mark.parametrize(("apart", "is_same"), [(1.2, True), (1.3, False), (2.4, False)])
def test_stalls_that_share_half_of_their_ground_or_less_are_two(apart: float, is_same: bool) -> None:
    two = placed(panel([at(8), at(9)], [[TAKEN, UNSEEN], [UNSEEN, FREE]]), [0, apart], [[True, False], [False, True]])
    found = changes_between(two, 0, 1)
    assert (found.matched, len(found.begin), len(found.gone)) == ((1, 0, 0) if is_same else (0, 1, 1))


def test_a_stall_that_was_drawn_again_is_the_one_with_which_it_shares_most() -> None:
    states = [[TAKEN, FREE, UNSEEN], [UNSEEN, UNSEEN, FREE]]
    three = placed(panel([at(8), at(9)], states), [1.2, 0.2, 0.0], [[True, True, False], [False, False, True]])
    found = changes_between(three, 0, 1)
    assert (found.matched, [each.label for each in found.gone], found.free.value) == (1, ["A 1"], 0.0)
