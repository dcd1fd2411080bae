from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import shapely

from benchmarks.chain_flight import campaign, flight, pairs
from benchmarks.figures import BenchmarkError
from hawk.survey.truth import parse_truth
from hawk.worlds.world import TrueStall, World

SCALE = 0.25
COLOUR = {"a": 90, "b": 160}


def place(name: str, size_m: tuple[float, float] = (60.0, 40.0)) -> World:
    """A lot in the picture's east, with one stall in its south-eastern corner; the stall is white."""
    width, height = size_m
    ground = np.full((round(height / SCALE), round(width / SCALE), 3), COLOUR[name], np.uint8)
    lot = np.array([[20, 4], [width - 6, 4], [width - 6, height - 4], [20, height - 4]], float)
    corner = np.array([width - 6 - 2.5, height - 4 - 5.0])
    stall = corner + np.array([[0, 0], [2.5, 0], [2.5, 5], [0, 5]])
    low, high = np.round(stall[0] / SCALE).astype(int), np.round(stall[2] / SCALE).astype(int)
    ground[low[1] : high[1], low[0] : high[0]] = 255
    return World(name, SCALE, ground, stalls=(TrueStall(7, stall, taken=True),), lots=(lot,))


@pytest.mark.parametrize("seed", range(6))
def test_labels_move_with_their_pictures(seed: int) -> None:
    world = pairs.pair_of([place("a"), place("b")], seed)
    assert [stall.id for stall in world.stalls] == [0, 1]
    for stall in world.stalls:
        low, high = (np.round(edge / SCALE).astype(int) for edge in (stall.corners.min(0), stall.corners.max(0)))
        assert (world.ground[low[1] : high[1], low[0] : high[0]] == 255).all()
        assert shapely.area(shapely.polygons(stall.corners)) == pytest.approx(12.5)
    assert int((world.ground == 255).all(axis=2).sum()) == 2 * 12.5 / SCALE**2, "nothing of a label was cut off"


@pytest.mark.parametrize("seed", range(6))
def test_nothing_but_a_drive_lies_between_the_two_lots(seed: int) -> None:
    world = pairs.pair_of([place("a"), place("b")], seed)
    west, east = (shapely.Polygon(lot) for lot in world.lots)
    low, high = pairs.DRIVE_M
    assert low - SCALE <= west.distance(east) <= high + SCALE
    beside = min(west.bounds[3], east.bounds[3]) - max(west.bounds[1], east.bounds[1])
    assert beside >= pairs.LEAST_FACING_M


def test_a_seed_gives_one_world_and_another_seed_another() -> None:
    places = [place("a"), place("b")]
    one, same = (pairs.pair_of(places, 3) for _ in range(2))
    assert (one.ground == same.ground).all()
    assert len({pairs.pair_of(places, seed).ground.tobytes() for seed in range(6)}) > 1


def test_the_fence_holds_both_lots_as_one() -> None:
    world = pairs.pair_of([place("a"), place("b")], 1)
    lot = flight.lot_of(parse_truth(world.truth_json()), world.start())
    fence = shapely.Polygon(lot.fence.polygon)
    assert fence.covers(lot.shape)
    assert fence.area < lot.shape.convex_hull.buffer(2 * flight.FENCE_M).area


def test_lots_that_nowhere_face_each_other_are_no_pair() -> None:
    narrow = [place(name, (40.0, 20.0)) for name in ("a", "b")]
    with pytest.raises(ValueError, match="no two places"):
        pairs.pair_of([World(w.name, SCALE, w.ground) for w in narrow], 1)


def test_pairs_of_a_folder_are_chosen_by_name_and_need_two_places(tmp_path: Path) -> None:
    for name in ("a", "b"):
        world = place(name)
        cv2.imwrite(str(tmp_path / f"{name}.jpg"), world.ground)
        (tmp_path / f"{name}.json").write_text(json.dumps(world.truth_json()))
    names = [name for name, _ in campaign.pairs(tmp_path, 3)]
    assert [name.split(",")[0] for name in names] == ["pair 1", "pair 2", "pair 3"]
    assert [name for name, _ in campaign.pairs(tmp_path, 3, "pair 2,*")] == names[1:2]
    assert [name for name, _ in campaign.lots(tmp_path, "b*")] == ["b"]
    (tmp_path / "a.json").unlink()
    with pytest.raises(BenchmarkError, match="two places"):
        next(campaign.pairs(tmp_path, 3))
