"""Vehicles, trees, buildings and materials as they are drawn."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.worlds.plan import Axes, Building, PlannedStall, Surface, Tree, Vehicle
from hawk.worlds.scene.buildings import draw_building
from hawk.worlds.scene.canvas import Canvas
from hawk.worlds.scene.cars import SPRITE_M, draw_vehicle, footprint_m, outline, sample_kind
from hawk.worlds.scene.light import Sun
from hawk.worlds.scene.materials import Material, grey, sample_material, texture
from hawk.worlds.scene.render import draw_plan, draw_surface
from hawk.worlds.scene.trees import draw_tree, leaf_colours
from tests.unit.worlds.builders import EAST, GREY, SUN, WHITE, generator, plain_plan, square
from training.avenues import plant_avenue
from training.crowded_roofs import draw_crowd

KINDS = ("sedan", "hatch", "suv", "minivan", "pickup", "van", "lorry", "motorcycle")
GROUND = ("asphalt", "concrete", "pavers", "grass", "dirt", "bark", "gravel", "rock", "water", "court", "roof")


@given(st.floats(-50, 50), st.floats(-50, 50), st.floats(-7, 7), st.floats(1, 12), st.floats(0.5, 3))
def test_an_outline_has_its_size_and_points_along_its_heading(
    x: float, y: float, heading: float, length: float, width: float
) -> None:
    corners = outline(x, y, heading, length, width)
    front, back = corners[:2].mean(axis=0), corners[2:].mean(axis=0)
    assert corners.mean(axis=0) == pytest.approx((x, y), abs=1e-9)
    assert math.dist(front, back) == pytest.approx(length)
    assert math.dist(corners[0], corners[1]) == pytest.approx(width)
    assert math.remainder(math.atan2(*(front - back)[::-1]) - heading, math.tau) == pytest.approx(0, abs=1e-6)


def test_vehicles_differ_in_size_by_kind() -> None:
    area = {kind: _area(kind) for kind in KINDS}
    assert area["motorcycle"] < area["hatch"] < area["sedan"] < area["suv"] < area["lorry"]


def _area(kind: str) -> float:
    corners = footprint_m(Vehicle(0.0, 0.0, 0.0, kind))
    return float(np.prod(np.ptp(corners, axis=0)))


@pytest.mark.parametrize("kind", KINDS)
def test_vehicles_of_a_kind_vary_about_its_size_and_in_colour(kind: str) -> None:
    models = [draw_vehicle(generator(seed), kind) for seed in range(25)]
    usual = np.sort(np.ptp(footprint_m(Vehicle(0.0, 0.0, 0.0, kind)), axis=0))
    spread = 0.35 if kind == "lorry" else 0.08
    assert all(model.length == pytest.approx(usual[1], rel=spread) for model in models)
    assert all(model.width == pytest.approx(usual[0], rel=0.06) for model in models)
    assert np.std([model.sprites[0].pixels[..., :3].mean() for model in models]) > 8


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_generator_draws_the_same_vehicle(kind: str) -> None:
    one, two, other = (draw_vehicle(generator(seed), kind) for seed in (5, 5, 6))
    assert all(np.array_equal(a.pixels, b.pixels) for a, b in zip(one.sprites, two.sprites, strict=True))
    assert one.length != other.length


@pytest.mark.parametrize("place", ["stall", "aisle", "road", "yard"])
def test_every_place_has_vehicles_of_its_own(place: str) -> None:
    kinds = [sample_kind(generator(seed), place) for seed in range(600)]
    assert set(kinds) <= set(KINDS)
    common = max(set(kinds), key=kinds.count)
    assert common == ("lorry" if place == "yard" else "sedan")


def test_an_unknown_place_has_no_vehicles() -> None:
    with pytest.raises(KeyError):
        sample_kind(generator(), "sea")


@pytest.mark.parametrize("heading", [0.0, 1.0, math.pi / 2, 4.0])
def test_a_drawn_vehicle_stands_on_its_footprint(heading: float) -> None:
    plan = plain_plan(vehicles=[Vehicle(10.0, 10.0, heading, "suv")])
    body = draw_plan(plan, Canvas(0, 0, 200, 200, 0.1), SUN, generator(2)).layers[0]
    centre = body.corners.mean(axis=0)
    assert centre[:2] == pytest.approx((10, 10), abs=0.05)
    along = body.corners[1] - body.corners[0]
    assert math.remainder(math.atan2(along[1], along[0]) - heading, math.tau) == pytest.approx(0, abs=1e-6)
    assert np.linalg.norm(along) == pytest.approx(4.75, rel=0.08)
    assert body.pixels.shape[1] * SPRITE_M == pytest.approx(np.linalg.norm(along), abs=0.1)


def test_dim_cars_are_a_share_of_all() -> None:
    brightness = {}
    for share in (0.0, 1.0):
        cars = [Vehicle(3.0 + 5 * k, 3.0 + 3 * n, 0.0, "suv") for k in range(3) for n in range(5)]
        plan = plain_plan(vehicles=cars, dim_cars=share)
        drawn = draw_plan(plan, Canvas(0, 0, 200, 200, 0.1), SUN, generator(3))
        bodies = [layer for layer in drawn.layers if layer.height < 1]
        brightness[share] = max(float(np.median(body.pixels[..., :3])) for body in bodies)
    assert brightness[1.0] < 75 < 120 < brightness[0.0]


@pytest.mark.parametrize("height", [1.0, 2.0, 9.0])
def test_crown_slices_are_stacked_over_the_trunk(height: float) -> None:
    tree = Tree(6.0, 7.0, 2.0, height)
    layers, crown = draw_tree(generator(1), tree, leaf_colours(generator(1)), SUN, 0.1)
    assert len(layers) == (3 if height > 1.6 else 1)
    for layer in layers:
        assert layer.corners[:, :2].mean(axis=0) == pytest.approx((6, 7))
        assert np.ptp(layer.corners[:, 0]) == pytest.approx(4.0)
        assert 0 < layer.height <= height
        assert layer.label == "tree"
    assert crown[0, 0] == crown[-1, -1] == 0, "round"


def test_leaves_catch_the_light_on_the_sun_s_side() -> None:
    east, west = Sun((2.0, 0.0), SUN.gain, 0.0), Sun((-2.0, 0.0), SUN.gain, 0.0)
    sides = []
    for sun in (east, west):
        layers, _ = draw_tree(generator(4), Tree(0, 0, 3.0, 7.0), leaf_colours(generator(4)), sun, 0.1)
        pixels = layers[0].pixels.astype(float)
        shown = pixels[..., 3] > 0
        middle = pixels.shape[1] // 2
        left = pixels[:, :middle][shown[:, :middle]][:, 1].mean()
        sides.append(left - pixels[:, middle:][shown[:, middle:]][:, 1].mean())
    assert sides[0] > 0 > sides[1], "shadows fall east where the sun is in the west"


def test_leaves_are_green_but_for_autumn() -> None:
    colours = np.concatenate([leaf_colours(generator(seed)) for seed in range(60)])
    green = (colours[:, 1] >= colours[:, 0]) & (colours[:, 1] > 0.9 * colours[:, 2])
    assert 0.7 < green.mean() < 1.0
    assert colours.min() >= 8


@pytest.mark.parametrize("seed", range(8))
def test_avenue_trees_are_evenly_spaced_along_the_row(seed: int) -> None:
    plan = plain_plan()
    unit = np.array([[0.0, 0.0], [2.5, 0.0], [2.5, 5.0], [0.0, 5.0]])
    plan.stalls = [PlannedStall(unit + np.array([2.5 * k, 0.0]), "perpendicular", False, False, 1.0) for k in range(24)]
    plant_avenue(plan, generator(seed))
    places = np.sort([tree.x for tree in plan.trees])
    steps = np.diff(places)
    assert steps.std() < 0.35 * steps.mean()
    assert all(1.2 <= tree.height <= 12 for tree in plan.trees)


@pytest.mark.parametrize("turn", [0.0, 0.7, 2.5])
def test_walls_reach_from_the_ground_to_the_roof_around_the_footprint(turn: float) -> None:
    building = Building(Axes.turned((5.0, 5.0), turn), 8.0, 6.0, 5.0)
    *walls, roof = draw_building(generator(), building, SUN, 0.1)
    feet = np.concatenate([wall.corners[2:, :2] for wall in walls])
    for corner in building.polygon:
        assert np.linalg.norm(feet - corner, axis=1).min() < 1e-9
    for wall in walls:
        assert wall.corners[:, 2] == pytest.approx((4.99, 4.99, -0.01, -0.01))
        assert wall.label == "wall"
    assert roof.label == "roof"
    assert all(wall.height < roof.height for wall in walls), "a roof is drawn over its walls"


@pytest.mark.slow
@settings(max_examples=20)
@given(st.floats(0, 2 * math.pi))
def test_the_wall_towards_the_sun_is_the_brightest(direction: float) -> None:
    sun = Sun((math.cos(direction), math.sin(direction)), SUN.gain, 0.0)
    *walls, _ = draw_building(generator(1), Building(EAST, 8.0, 6.0, 5.0), sun, 0.2)
    outward = [(0, -1), (1, 0), (0, 1), (-1, 0)]
    facing = [-(x * sun.shadow[0] + y * sun.shadow[1]) for x, y in outward]
    light = [float(wall.pixels[0, 0, :3].mean()) for wall in walls]
    assert light[int(np.argmax(facing))] == max(light)
    assert light[int(np.argmin(facing))] == min(light)


@pytest.mark.parametrize("size", [(3.0, 3.0), (9.0, 20.0), (40.0, 25.0)])
def test_a_roof_s_picture_has_its_size_and_is_opaque(size: tuple[float, float]) -> None:
    for crowd in (None, draw_crowd):
        building = Building(EAST, *size, 4.0, None, crowd=crowd)
        roof = draw_building(generator(3), building, SUN, 0.1)[-1].pixels
        assert roof.shape == (round(size[1] / 0.1), round(size[0] / 0.1), 4)
        assert (roof[..., 3] == 255).all()


@pytest.mark.parametrize("kind", GROUND)
def test_materials_are_of_their_kind_and_vary(kind: str) -> None:
    materials = [sample_material(generator(seed), kind) for seed in range(30)]
    assert {material.kind for material in materials} == {kind}
    assert len({material.colour for material in materials}) >= 25
    for material in materials:
        assert all(0 < channel < 256 for channel in material.colour)
        assert min(material.grain, material.mottle, material.blotch, material.hue, material.joints) >= 0


def test_grass_is_green_and_water_bluish() -> None:
    for seed in range(20):
        blue, green, _ = sample_material(generator(seed), "grass").colour
        assert green > 1.4 * blue
        blue, _, red = sample_material(generator(seed), "water").colour
        assert blue > red


@pytest.mark.parametrize("metres_per_pixel", [0.05, 0.2])
def test_rough_materials_have_more_texture_than_smooth_ones(metres_per_pixel: float) -> None:
    smooth, rough = (
        texture(generator(1), Material("x", (120.0, 120.0, 120.0), *[part] * 3), 90, 90, metres_per_pixel).std()
        for part in (0.0, 0.1)
    )
    assert smooth == pytest.approx(0, abs=1e-3)
    assert 5 < rough < 30


def test_grain_fades_as_pixels_grow() -> None:
    grain = Material("x", (120.0, 120.0, 120.0), 0.1, 0.0, 0.0)
    fine, coarse = (texture(generator(1), grain, 200, 200, scale).std() for scale in (0.05, 0.4))
    assert coarse < 0.7 * fine


def test_hue_varies_the_colour_itself() -> None:
    plain, hued = (
        texture(generator(2), Material("x", (100.0, 100.0, 100.0), 0, 0, 0, hue), 60, 60, 0.1) for hue in (0.0, 0.1)
    )
    assert np.abs(plain[..., 2] - plain[..., 1]).max() < 1e-3
    assert np.abs(hued[..., 2] - hued[..., 1]).max() > 5


def test_slabs_have_joints_at_their_distance() -> None:
    surface = Surface(square(0, 0, 20), Material("concrete", (200.0, 200.0, 200.0), 0, 0, 0, 0, joints=2.0))
    canvas = Canvas(0, 0, 200, 200, 0.1)
    assert draw_surface(canvas, surface, generator(1)) is not None
    dark = canvas.image[5, :, 1] < 199
    assert 8 <= np.flatnonzero(np.diff(dark.astype(int)) == 1).size <= 11
    assert dark.mean() == pytest.approx(0.05, abs=0.02)


def test_a_kerb_surrounds_its_surface() -> None:
    canvas = Canvas(0, 0, 200, 200, 0.1)
    canvas.image[:] = 50
    draw_surface(canvas, Surface(square(5, 5, 10), WHITE, kerb=(0.0, 0.0, 250.0)), generator())
    assert canvas.image[100, 100].mean() == pytest.approx(200, abs=1)
    assert canvas.image[100, 49][2] > 200, "the kerb"
    assert (canvas.image[100, 40] == 50).all()


def test_a_surface_outside_the_canvas_is_not_drawn() -> None:
    canvas = Canvas(0, 0, 50, 50, 0.1)
    assert draw_surface(canvas, Surface(square(80, 80, 5), GREY), generator()) is None


@given(st.integers(0, 5000), st.floats(20, 240), st.floats(0, 10))
def test_greys_are_nearly_grey(seed: int, level: float, tint: float) -> None:
    colour = np.array(grey(generator(seed), level, level, tint))
    assert np.abs(colour - level).max() <= level * tint / 100 * 5 + 9
    assert 4 <= colour.min() <= colour.max() <= 250
