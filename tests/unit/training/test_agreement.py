from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.vision import quads
from hawk.algo.vision.network import NetworkMaps
from training.agreement import agreed, labels_of, states
from training.targets import UNKNOWN, draw_targets

BRIGHT = 200


class BrightStalls:
    """A network that takes every bright rectangle that stands upright in the picture for a stall, and dark ones in
    bright ones for cars; ``blind`` to those that lie down.
    """

    def __init__(self, *, blind: bool = False) -> None:
        self.blind = blind

    def run(self, picture: NDArray[np.uint8], _sun: object = None) -> NetworkMaps:
        import cv2

        grey = picture.mean(2)
        count, marks, stats, _ = cv2.connectedComponentsWithStats((grey > BRIGHT / 2).astype(np.uint8))
        is_blue = picture[..., 0] > picture[..., 1] * 0.8  # in any light
        boxes, taken = [], []
        for left, top, width, height, area in stats[1:count].tolist():
            if area < 300 or (self.blind and width > height):
                continue
            boxes.append([(left, top), (left + width, top), (left + width, top + height), (left, top + height)])
            taken.append(bool(is_blue[top : top + height, left : left + width].mean() > 0.5))
        shape = np.zeros((*grey.shape, 4), np.uint8)
        shape[..., 0] = marks > 0
        shape[..., 1] = (marks > 0) & is_blue
        target = draw_targets(
            shape, np.ones(grey.shape, np.uint8), np.array(boxes, float).reshape(-1, 4, 2), np.array(taken, bool),
            np.ones(len(boxes), bool),
        )  # fmt: skip
        lot, core, car = (np.where(target[k] > 0, 0.97, 0.03).astype(np.float32) for k in (0, 1, 2))
        width, length = 2.6 * np.exp(target[7]), 5.2 * np.exp(target[8])
        said = np.where(target[9] > 0, 0.97, 0.03).astype(np.float32)
        none = np.zeros_like(lot)
        places = (10 * target[5], 10 * target[6])
        return NetworkMaps(lot, core, car, target[3], target[4], *places, width, length, said, none, none)


def picture() -> NDArray[np.uint8]:
    """Three stalls, the first of them taken (its blue is as bright as the rest)."""
    noise = np.random.default_rng(5).integers(0, 25, (201, 261, 3))  # ground of one even grey is missing ground
    image = (30 + noise).astype(np.uint8)
    for k, left in enumerate((60, 120, 180)):
        image[70:122, left : left + 26] = (BRIGHT if k == 0 else 120, BRIGHT, BRIGHT)
    return image


def test_what_every_view_shows_is_agreed_on_and_lies_where_it_is() -> None:
    found = agreed(picture(), BrightStalls(), np.random.default_rng(0))  # type: ignore[arg-type]
    assert found.lot.shape == (101, 131)
    assert len(found.quads[found.is_stall]) == 3
    truth = np.array([[(x, 70), (x + 26, 70), (x + 26, 122), (x, 122)] for x in (60, 120, 180)], float)
    order = np.argsort(found.quads[found.is_stall].mean(1)[:, 0])
    assert (quads.overlaps(found.quads[found.is_stall][order], truth) > 0.8).all()
    assert not found.is_doubtful.any()


def test_what_only_some_views_show_is_doubtful() -> None:
    found = agreed(picture(), BrightStalls(blind=True), np.random.default_rng(0))  # type: ignore[arg-type]
    assert not found.is_stall.any()
    assert found.is_doubtful.any()
    core = labels_of(found.core, (201, 261))
    assert core[96, 73] == UNKNOWN
    assert core[10, 10] == 0


def test_the_states_are_those_that_the_views_agree_on() -> None:
    found = agreed(picture(), BrightStalls(), np.random.default_rng(0))  # type: ignore[arg-type]
    truth = np.array([[(x, 70), (x + 26, 70), (x + 26, 122), (x, 122)] for x in (60, 120, 180)], float)
    taken, unclear = states(found, truth)
    assert taken.tolist() == [True, False, False]
    assert not unclear.any()
    assert states(found, np.zeros((0, 4, 2)))[0].shape == (0,)


@pytest.mark.parametrize(("mean", "label"), [(0.9, 1), (0.1, 0), (0.5, UNKNOWN)])
def test_labels_are_sure_or_unknown(mean: float, label: int) -> None:
    labels = labels_of(np.full((50, 60), mean, np.float32), (99, 119))
    assert labels.shape == (99, 119)
    assert set(np.unique(labels)) == {label}
