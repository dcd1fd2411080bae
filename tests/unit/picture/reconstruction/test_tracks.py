from __future__ import annotations

import numpy as np

from hawk.picture.reconstruction.features import Features, Ties
from hawk.picture.reconstruction.tracks import drop_outliers, largest_group

FEATURES = Features(np.arange(20.0).reshape(-1, 2), np.zeros((10, 128), np.uint8))


def _ties(first: int, second: int, *pairs: tuple[int, int]) -> Ties:
    here, there = np.array(pairs).T
    return Ties(first, second, here, there)


def _found(_: int) -> Features:
    return FEATURES


def test_features_that_ties_connect_are_one_place() -> None:
    group = largest_group([_ties(0, 1, (2, 3), (5, 5)), _ties(1, 2, (3, 7))], 3, _found)
    assert group is not None
    assert group.members.tolist() == [0, 1, 2]
    assert group.sights.points == 2
    assert sorted(np.bincount(group.sights.point).tolist()) == [2, 3]


def test_the_larger_part_is_taken_and_counts_its_own_photographs() -> None:
    group = largest_group([_ties(0, 1, (1, 1)), _ties(2, 4, (1, 1)), _ties(4, 5, (1, 1))], 6, _found)
    assert group is not None
    assert group.members.tolist() == [2, 4, 5]
    assert group.sights.shot.max() == 2


def test_a_place_that_is_twice_in_one_photograph_is_a_mistake() -> None:
    group = largest_group([_ties(0, 1, (2, 3), (6, 6)), _ties(1, 2, (3, 7)), _ties(0, 2, (4, 7))], 3, _found)
    assert group is not None
    assert group.sights.points == 1
    assert group.sights.pixels.tolist() == [[12.0, 13.0]] * 2


def test_without_ties_nothing_hangs_together() -> None:
    assert largest_group([], 3, _found) is None


def test_places_that_fewer_than_two_photographs_show_go_with_what_is_wrong() -> None:
    group = largest_group([_ties(0, 1, (2, 3), (6, 6)), _ties(1, 2, (3, 7))], 3, _found)
    assert group is not None
    wrong = (group.sights.pixels == [12.0, 13.0]).all(axis=1) & (group.sights.shot == 0)
    left = drop_outliers(group.sights, wrong)
    assert left.points == 1
    assert len(left.pixels) == 3
