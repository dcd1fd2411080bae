from functools import cache

import numpy as np
import pytest
import shapely

from hawk.worlds.generate import WorldOptions, generate_world, share_under
from hawk.worlds.world import World, WorldError

COARSE = WorldOptions(metres_per_pixel=0.2)
SEEDS = (1, 2, 3)


@cache
def _world(seed: int) -> World:
    return generate_world(seed, COARSE)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", SEEDS)
def test_minima_of_a_generated_world(seed: int) -> None:
    world = _world(seed)
    width, height = world.size_m
    assert 100 <= width <= 140
    assert 90 <= height <= 120
    assert len(world.stalls) >= 80
    assert 0.3 <= np.mean([stall.taken for stall in world.stalls]) <= 0.9
    crowns = shapely.union_all([shapely.box(*layer.box) for layer in world.layers if layer.label == "tree"])
    hard = [s.worn or shapely.Polygon(s.corners).intersects(crowns) for s in world.stalls]
    assert np.mean(hard) >= 0.15


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_stalls_lie_in_the_lot_and_do_not_overlap(seed: int) -> None:
    world = _world(seed)
    lot = shapely.union_all([shapely.Polygon(outline) for outline in world.lots]).buffer(0.6)
    quads = [shapely.Polygon(stall.corners) for stall in world.stalls]
    assert all(quad.is_valid and 9 < quad.area < 22 for quad in quads)
    assert all(lot.covers(quad) for quad in quads)
    near = shapely.STRtree(quads).query(quads, predicate="intersects").T
    overlaps = [quads[a].intersection(quads[b]).area for a, b in near if a < b]
    assert max(overlaps) < 0.5


@pytest.mark.parametrize("seed", SEEDS)
def test_truth_is_what_is_drawn(seed: int) -> None:
    world = _world(seed)
    taken = [stall.covered for stall in world.stalls if stall.taken]
    free = [stall.covered for stall in world.stalls if not stall.taken]
    assert np.mean(np.array(taken) > 0.3) > 0.9
    assert np.mean(np.array(free) < 0.15) > 0.9
    for stall in world.stalls:
        sides = np.linalg.norm(np.roll(stall.corners, -1, axis=0) - stall.corners, axis=1)
        assert sides[0] < sides[1]
    assert [stall.id for stall in world.stalls] == list(range(len(world.stalls)))
    assert {"car", "tree", "roof", "wall"} <= {layer.label for layer in world.layers}


@pytest.mark.parametrize("seed", SEEDS)
def test_start_lies_just_inside_the_lot(seed: int) -> None:
    world = _world(seed)
    lot = shapely.union_all([shapely.Polygon(outline) for outline in world.lots])
    start = shapely.Point(world.start())
    assert lot.contains(start)
    assert lot.boundary.distance(start) == pytest.approx(1.0, abs=0.05)


@pytest.mark.slow
def test_same_seed_same_world() -> None:
    again = generate_world(1, COARSE)
    assert np.array_equal(again.ground, _world(1).ground)
    assert again.truth_json() == _world(1).truth_json()
    assert again.truth_json() != _world(2).truth_json()


@pytest.mark.slow
def test_impossible_options_say_what_to_change() -> None:
    with pytest.raises(WorldError, match="widen stalls"):
        generate_world(1, WorldOptions(stalls=(900, 1000)))
    with pytest.raises(WorldError, match="metres_per_pixel"):
        WorldOptions(metres_per_pixel=0.0)
    with pytest.raises(WorldError, match="width"):
        WorldOptions(width=(500, 600))


def test_a_car_beside_a_stall_covers_none_of_it() -> None:
    stall = np.array([(22.95508045411016, -1.9075736721816918), (21.698756119200702, -4.183897279561429)])
    stall = np.vstack([stall, [(17.146108904441228, -1.6712486097425063), (18.402433239350685, 0.6050749976372309)]])
    beside = np.array([(24.211404789019625, 0.3687499351980457), (22.95508045411016, -1.9075736721816916)])
    beside = np.vstack([beside, [(18.402433239350685, 0.6050749976372309), (19.65875757426015, 2.881398605016968)]])
    assert share_under(stall, shapely.Polygon(beside)) < 1e-6
    assert share_under(stall, shapely.Polygon(stall)) == pytest.approx(1, abs=1e-6)
