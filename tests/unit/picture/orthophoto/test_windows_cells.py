"""Cells of a window's core."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis.extra.numpy import array_shapes, arrays

from hawk.picture.orthophoto.windows import Mask, decode_runs, encode_runs, lot_cells


@settings(max_examples=50)
@given(arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=9)))
def test_a_mask_survives_its_packing(mask: Mask) -> None:
    again = decode_runs(encode_runs(mask))
    assert again.shape == mask.shape
    assert np.array_equal(again, mask)
    assert encode_runs(again) == encode_runs(mask)


@pytest.mark.parametrize("runs", [[], [2, 2], [2, 2, 3], [2, 2, 5, -1], [0, 0, 0]])
def test_runs_that_do_not_fill_a_mask_are_refused(runs: list[int]) -> None:
    with pytest.raises(ValueError, match=r"fill|unpack"):
        decode_runs(runs)


def test_the_cells_of_a_core_are_those_of_its_ground() -> None:
    mask = np.zeros((100, 100), np.bool_)
    mask[40:, 60:] = True
    cells = lot_cells(mask, (0.1, 0.1), np.array([2.0, 2.0, 10.0, 10.0]))
    assert cells.shape == (20, 20)
    assert np.array_equal(np.argwhere(cells)[0], (5, 10))
    assert cells[5:, 10:].all()
