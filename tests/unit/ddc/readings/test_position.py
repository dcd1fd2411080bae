"""Jumps between two ticks."""

from __future__ import annotations

import pytest

from hawk.ddc.readings.position import Jumps


def test_of_two_jumps_the_larger_counts_once_whatever_its_sign() -> None:
    jumps = Jumps()
    for metres in (1.0, -4.0, 2.0):
        jumps.note(metres)
    assert jumps.take() == 4.0
    assert jumps.take() == 0.0


@pytest.mark.parametrize("metres", [0.3, -0.3])
def test_the_first_jump_counts_however_small_it_is(metres: float) -> None:
    jumps = Jumps()
    jumps.note(metres)
    assert jumps.take() == 0.3
    assert Jumps().take() == 0.0
