from __future__ import annotations

import numpy as np
import pytest

from hawk.picture.reconstruction.features import Features, Search, alike, alike_near, features, match, neighbours
from tests.unit.picture.flights import flight, found


@pytest.mark.nightly
def test_ties_join_the_same_ground() -> None:
    seen = found(flight())
    ties = match((0, 1), flight().true, seen.__getitem__, Search(4.0, 0.9, 0.3))
    assert ties is not None
    here = flight().true[0].ground(seen[0].pixels[ties.here])
    there = flight().true[1].ground(seen[1].pixels[ties.there])
    assert np.percentile(np.hypot(*(here - there).T), 90) < 0.2


def test_poses_that_err_are_searched_wider() -> None:
    seen = found(flight())
    posed = [one.posed for one in flight().known]
    ties = match((0, 1), posed, seen.__getitem__, Search(12.0, 0.8, 0.55))
    assert ties is not None
    here = flight().true[0].ground(seen[0].pixels[ties.here])
    there = flight().true[1].ground(seen[1].pixels[ties.there])
    assert np.percentile(np.hypot(*(here - there).T), 90) < 0.2


def test_features_that_lie_dense_are_searched_otherwise_and_give_the_same_ties(monkeypatch: pytest.MonkeyPatch) -> None:
    ties = []
    for share in (0.0, 2.0):
        monkeypatch.setattr("hawk.picture.reconstruction.features.DENSE_SHARE", share)
        ties.append(match((0, 1), flight().true, found(flight()).__getitem__, Search(4.0, 0.9, 0.3)))
    dense, near = ties
    assert dense is not None
    assert near is not None
    assert (dense.here.tolist(), dense.there.tolist()) == (near.here.tolist(), near.there.tolist())


def test_ground_without_features_gives_no_ties() -> None:
    plain = features(np.full((360, 480, 3), 90, np.uint8))
    assert match((0, 1), flight().true, [plain, plain].__getitem__, Search(4.0, 0.9, 0.3)) is None


@pytest.mark.slow
def test_pictures_of_other_ground_give_no_ties() -> None:
    seen = [found(flight())[0], features(np.asarray(flight().pictures[0][:, ::-1], np.uint8))]
    assert match((0, 1), flight().true, seen.__getitem__, Search(12.0, 0.8, 0.55)) is None


def test_both_searches_find_the_same_best() -> None:
    rng = np.random.default_rng(2)
    shares = rng.exponential(1.0, (30, 128))
    lengths = np.linalg.norm(shares, axis=1, keepdims=True)
    first = Features(np.zeros((30, 2)), (shares / lengths * 512).clip(0, 255).astype(np.uint8))
    second = Features(np.zeros((30, 2)), first.descriptors[rng.permutation(30)])
    every = tuple(values.ravel() for values in np.indices((30, 30)))
    wide, near = alike(first, second, 0.8), alike_near(first, second, every, 0.8)  # type: ignore[arg-type]
    assert {*zip(*map(np.ndarray.tolist, wide), strict=True)} == {*zip(*map(np.ndarray.tolist, near), strict=True)}
    assert len(wide[0]) == 30


def test_neighbours_show_common_ground() -> None:
    pairs = neighbours(flight().true, most=2)
    assert (0, 1) in pairs
    assert all(first < second for first, second in pairs)


@pytest.mark.slow
@pytest.mark.parametrize("most", [1, 5])
def test_the_strongest_features_come_first(most: int) -> None:
    every = features(flight().pictures[0])
    assert every.strongest(most).pixels.tolist() == every.pixels[:most].tolist()
