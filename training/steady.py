"""A picture that is shifted by some pixels shows the same: the term of the loss, and the pairs that it needs.

Convolutions with strides see another picture after a shift (Zhang 2019, arXiv 1904.11486): a car may come and go.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import torch
from torch import Tensor

from hawk.algo.vision.network import CELL_PIXELS
from training.augment import Sample, sample
from training.targets import CORE, VEHICLE, TrainingScene

STEADY_SHARE: Final = 0.5
MOST_CELLS: Final = 16
_EDGE_CELLS: Final = 8
"""Cells at the edges, where one of the two sees less, that are not compared."""


@dataclass(frozen=True, slots=True)
class Pair:
    """Two parts of one changed scene: the second begins ``cells`` (columns, rows) of the answer after the first."""

    first: Sample
    second: Sample
    cells: tuple[int, int]


def draw_pair(scene: TrainingScene, rng: np.random.Generator, side: int) -> Pair:
    """Return two shifted parts of a scene, each of ``side`` pixels, changed at random alike."""
    whole = sample(scene, rng, side + MOST_CELLS * CELL_PIXELS)
    columns, rows = (int(each) for each in rng.integers(1, MOST_CELLS + 1, 2))
    return Pair(_part(whole, (0, 0), side), _part(whole, (columns, rows), side), (columns, rows))


def unsteadiness(answer: Tensor, cells: tuple[int, int], channels: Sequence[int] = (CORE, VEHICLE)) -> Tensor:
    """Return by how much ``channels`` of the last two answers of a batch (B, C, h, w), those of a pair, differ on the
    same ground.
    """
    columns, rows = cells
    first, second = (torch.sigmoid(answer[k, list(channels)]) for k in (-2, -1))
    height, width = first.shape[1:]
    same = first[:, rows:, columns:], second[:, : height - rows, : width - columns]
    inner = slice(_EDGE_CELLS, -_EDGE_CELLS)
    return (same[0][:, inner, inner] - same[1][:, inner, inner]).abs().mean()


def _part(whole: Sample, cells: tuple[int, int], side: int) -> Sample:
    """Return the part of a sample that begins at a cell (column, row)."""
    columns, rows = cells
    inner = side // CELL_PIXELS
    left, top = columns * CELL_PIXELS, rows * CELL_PIXELS
    picture = whole.picture[:, top : top + side, left : left + side]
    target = whole.target[:, rows : rows + inner, columns : columns + inner]
    return Sample(np.ascontiguousarray(picture), np.ascontiguousarray(target), whole.sun)
