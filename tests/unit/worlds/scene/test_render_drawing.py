import math

import cv2
import numpy as np
import pytest

from hawk.worlds.conditions import draw_puddles
from hawk.worlds.plan import Axes, Block, Building, Gain, Post, SitePlan, Surface, Tree, Vehicle
from hawk.worlds.scene.buildings import draw_building
from hawk.worlds.scene.canvas import Canvas, noise
from hawk.worlds.scene.cars import draw_vehicle, footprint_m, sample_kind
from hawk.worlds.scene.light import Shadows, Sun, sample_sun
from hawk.worlds.scene.materials import Material, sample_material, texture
from hawk.worlds.scene.render import Paint, draw_plan
from hawk.worlds.scene.trees import draw_tree, leaf_colours
from training.scenes import photograph

GREY = Material("asphalt", (100.0, 100.0, 100.0), 0, 0, 0)
WHITE = Material("concrete", (200.0, 200.0, 200.0), 0, 0, 0)
SUN = Sun((2.0, 0.0), (0.5, 0.4, 0.3), 0.0)  # shadows fall east, twice as long as things are high
EAST = Axes((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
KINDS = ("sedan", "hatch", "suv", "minivan", "pickup", "van", "lorry", "motorcycle")


def _rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def _plan(**changes: object) -> SitePlan:
    fields = {"axes": EAST, "ground": GREY, "asphalt": GREY, "palette": [(255.0, 255.0, 255.0)] * 4, "wear": 0.0}
    return SitePlan(**{**fields, **changes})  # type: ignore[arg-type]


def _square(x: float, y: float, side: float) -> np.ndarray:
    return np.array([[x, y], [x + side, y], [x + side, y + side], [x, y + side]])


def test_a_patch_covers_the_area_of_its_polygon() -> None:
    canvas = Canvas(10.0, 20.0, 200, 100, 0.1)
    triangle = np.array([[12.0, 21.0], [20.03, 22.04], [15.0, 28.0]])
    patch = canvas.patch(triangle)
    assert patch is not None
    assert patch.mask.sum() * 0.01 == pytest.approx(cv2.contourArea(triangle.astype(np.float32)), rel=0.03)


def test_pixels_of_a_patch_lie_where_the_ground_frame_says() -> None:
    canvas = Canvas(10.0, 20.0, 200, 100, 0.1)
    patch = canvas.patch(_square(12.0, 21.0, 1.0))
    assert patch is not None
    canvas.cover(patch, (50.0, 60.0, 70.0))
    assert (canvas.image[10:20, 20:30] == (50, 60, 70)).all()
    assert (canvas.image[:9] == 0).all()
    assert canvas.to_px(np.array([12.05, 21.05])) == pytest.approx((20, 10))


@pytest.mark.parametrize("corner", [(-50.0, 0.0), (500.0, 0.0), (0.0, 500.0)])
def test_shapes_outside_a_canvas_are_left_out(corner: tuple[float, float]) -> None:
    canvas = Canvas(0.0, 0.0, 50, 50, 0.1)
    assert canvas.patch(_square(*corner, 2.0)) is None
    assert canvas.strip(_square(*corner, 2.0), 0.2) is None
    assert not canvas.touches(_square(*corner, 2.0))


def test_noise_has_the_deviation_that_was_asked_for() -> None:
    assert noise(_rng(), 200, 300, [1.0], [0.5]).std() == pytest.approx(0.5, rel=0.05)
    smooth = noise(_rng(), 200, 300, [10.0], [0.5])
    assert 0.25 < smooth.std() < 0.6
    assert np.abs(np.diff(smooth, axis=1)).mean() < 0.1


def test_materials_have_their_colour_and_unknown_ones_are_named() -> None:
    for kind in ("asphalt", "concrete", "pavers", "grass", "dirt", "bark", "gravel", "rock", "water", "court", "roof"):
        material = sample_material(_rng(3), kind)
        picture = texture(_rng(), material, 60, 80, 0.1)
        assert picture.shape == (60, 80, 3)
        assert picture.mean((0, 1)) == pytest.approx(material.colour, rel=0.25)
    with pytest.raises(ValueError, match="lava"):
        sample_material(_rng(), "lava")


def test_later_ground_buries_paint_and_what_stood_there() -> None:
    plan = _plan()
    plan.add_surface(Surface(_square(0, 0, 10), GREY))
    plan.line((1, 2), (9, 2), 0.4, 0, 1.0)
    plan.change(_square(0, 0, 10), 0.5)
    plan.trees.append(Tree(8, 5, 1, 3))
    plan.vehicles += [Vehicle(8, 8, 0, "suv"), Vehicle(2, 8, 0, "suv")]
    plan.posts.append(Post(7, 7, 5, 0))
    plan.buildings += [Building(EAST.moved(6, 0), 3, 3, 4), Building(EAST.moved(0, 6), 3, 3, 4)]
    plan.add_surface(Surface(np.array([[5.0, 0], [10, 0], [10, 10], [5, 10]]), WHITE))
    assert [(one.x, one.y) for one in plan.vehicles] == [(2, 8)]
    assert plan.trees == []
    assert plan.posts == []
    assert [one.axes.origin for one in plan.buildings] == [(0, 6)]
    plan.buildings.clear()
    plan.vehicles.clear()
    canvas = Canvas(0, 0, 100, 100, 0.1)
    ground = draw_plan(plan, canvas, SUN, _rng()).ground
    assert ground[20, 20].mean() > 180  # paint that is still there
    assert ground[20, 80].mean() == pytest.approx(200, abs=2)  # buried paint
    assert ground[50, 20].mean() == pytest.approx(50, abs=2)
    assert ground[50, 80].mean() == pytest.approx(200, abs=2)


def test_paint_of_low_strength_and_no_length_is_not_painted() -> None:
    plan = _plan()
    plan.line((0, 0), (0.01, 0), 0.1, 0, 1.0)
    plan.line((0, 0), (5, 0), 0.1, 0, 0.0)
    assert plan.strokes == []


def test_wear_makes_paint_patchy() -> None:
    deviations = []
    for wear in (0.0, 1.0):
        plan = _plan()
        plan.line((0, 5), (10, 5), 8, 0, 0.8)
        canvas = Canvas(0, 0, 100, 100, 0.1)
        paint = Paint(canvas, plan.strokes)
        paint.put_on(0)
        paint.blend(plan.palette, wear, _rng())
        deviations.append(canvas.image[20:80, 20:80].std())
    assert deviations[1] > 3 * deviations[0]


def test_gains_along_a_line() -> None:
    canvas = Canvas(0, 0, 50, 50, 0.1)
    plan = _plan(gains=[Gain(np.array([[0.0, 2.5], [5.0, 2.5]]), 0.5, width=0.4)])
    ground = draw_plan(plan, canvas, SUN, _rng()).ground
    assert ground[24, 25].mean() == pytest.approx(50, abs=3)
    assert ground[10, 25].mean() == pytest.approx(100, abs=1)


def test_islands_lie_over_the_paint() -> None:
    plan = _plan()
    plan.line((0, 5), (10, 5), 0.5, 0, 1.0)
    plan.islands.append(Surface(_square(3, 3, 4), WHITE, kerb=(10.0, 10.0, 10.0), round_m=0.5))
    ground = draw_plan(plan, Canvas(0, 0, 100, 100, 0.1), SUN, _rng()).ground
    assert ground[50, 50].mean() == pytest.approx(200, abs=3)
    assert ground[50, 28:31].mean() < 130
    assert ground[50, 10].mean() > 230


def test_a_block_throws_its_shadow_away_from_the_sun() -> None:
    canvas = Canvas(0, 0, 200, 100, 0.1)
    canvas.image[:] = 100
    shadows = Shadows(canvas, SUN)
    shadows.add_block(_square(4, 4, 1), 2.0)
    shadows.apply(rng=_rng())
    assert canvas.image[45, 70] == pytest.approx((50, 40, 30), abs=6)
    assert (canvas.image[45, 35] == 100).all()
    assert (canvas.image[45, 95] == 100).all()


def test_tall_shadows_fall_on_cars_and_low_ones_do_not() -> None:
    canvas = Canvas(0, 0, 200, 100, 0.1)
    shadows = Shadows(canvas, SUN)
    shadows.add_block(_square(4, 4, 1), 2.0)
    shadows.add_block(_square(4, 7, 1), 2.0, tall=True)
    low, tall = shadows.shade_at(np.array([[7.0, 4.5], [7.0, 7.5]]))
    assert low == pytest.approx((1, 1, 1))
    assert tall == pytest.approx((0.5, 0.4, 0.3), abs=0.01)


def test_suns_differ_and_never_brighten() -> None:
    suns = [sample_sun(_rng(k), calm=bool(k % 2)) for k in range(40)]
    assert len({sun.shadow for sun in suns}) == 40
    assert all(0 < channel <= 1 for sun in suns for channel in sun.gain)
    assert all(0.3 < math.hypot(*sun.shadow) < 1.2 for sun in suns[1::2])


@pytest.mark.parametrize("kind", KINDS)
def test_every_vehicle_is_opaque_in_its_middle_and_as_long_as_it_says(kind: str) -> None:
    for seed in range(6):
        model = draw_vehicle(_rng(seed), kind)
        body = model.sprites[0].pixels
        assert body.dtype == np.uint8
        assert body[body.shape[0] // 2, body.shape[1] // 2, 3] == 255
        assert body.shape[1] * 0.05 == pytest.approx(model.length, abs=0.06)
        assert body.shape[0] * 0.05 == pytest.approx(model.width, abs=0.06)
        heights = [sprite.height for sprite in model.sprites]
        assert heights == sorted(heights)
        assert heights[-1] <= model.height + 1e-9
    with pytest.raises(KeyError):
        draw_vehicle(_rng(), "tank")


def test_kinds_of_vehicles_follow_their_place() -> None:
    stall = [sample_kind(_rng(k), "stall") for k in range(400)]
    yard = [sample_kind(_rng(k), "yard") for k in range(400)]
    assert set(stall) <= set(KINDS)
    assert stall.count("lorry") < 20 < yard.count("lorry")


def test_a_footprint_points_where_the_vehicle_does() -> None:
    corners = footprint_m(Vehicle(5.0, 6.0, math.pi / 2, "lorry"))
    assert corners.mean(0) == pytest.approx((5, 6))
    assert np.ptp(corners[:, 1]) > 2 * np.ptp(corners[:, 0])


def test_a_crown_stays_in_its_square_and_gets_smaller_upwards() -> None:
    layers, crown = draw_tree(_rng(), Tree(3, 4, 2.5, 6), leaf_colours(_rng()), SUN, 0.1)
    assert crown.shape == (50, 50)
    assert 0.35 < (crown > 0).mean() < 0.9
    areas = [(layer.pixels[..., 3] > 127).mean() for layer in layers]
    assert areas == sorted(areas, reverse=True)
    assert [layer.height for layer in layers] == sorted(layer.height for layer in layers)
    assert all(layer.height <= 6 for layer in layers)
    bush, _ = draw_tree(_rng(), Tree(3, 4, 0.6, 1.2), leaf_colours(_rng()), SUN, 0.1)
    assert len(bush) == 1


def test_a_building_has_walls_up_to_its_roof_and_lit_ones_are_brighter() -> None:
    building = Building(Axes.turned((5, 5), 0.4), 20, 12, 6)
    *walls, roof = draw_building(_rng(), building, SUN, 0.1)
    assert len(walls) == 4
    assert roof.pixels.shape[:2] == (120, 200)
    assert roof.corners[:, :2] == pytest.approx(building.polygon)
    assert (roof.corners[:, 2] == 6).all()
    west, east = walls[3], walls[1]
    assert west.pixels[0, 0, :3].mean() > east.pixels[0, 0, :3].mean() + 20  # shadows fall east: the sun is west


def test_blocks_posts_and_shades_are_drawn() -> None:
    plan = _plan(blocks=[Block(_square(2, 2, 1), 0.5, (10.0, 20.0, 200.0))], posts=[Post(2.0, 8.0, 6.0, 0.0)])
    plan.shades.append(np.array([[15.0, 0], [40, 0], [40, 40], [15, 40]]))
    drawn = draw_plan(plan, Canvas(0, 0, 200, 100, 0.1), SUN, _rng())
    assert drawn.ground[25, 25] == pytest.approx((10, 20, 200), abs=3)
    assert drawn.ground[80, 80].mean() < 60  # the post's shadow
    assert drawn.ground[50, 180] == pytest.approx((50, 40, 30), abs=6)
    assert [layer.label for layer in drawn.layers] == ["post"]


def test_puddles_change_wet_ground_only() -> None:
    canvas = Canvas(0, 0, 200, 200, 0.1)
    canvas.image[:] = 150
    draw_puddles(canvas, 0.0, _rng())
    assert (canvas.image == 150).all()
    draw_puddles(canvas, 1.0, _rng())
    assert canvas.image.mean() < 140
    assert canvas.image.min() >= 0


def test_photographs_differ_but_stay_pictures() -> None:
    image = np.linspace(0, 255, 64 * 64 * 3, dtype=np.float32).reshape(64, 64, 3)
    shots = [photograph(_rng(k), image) for k in range(25)]
    assert all(shot.dtype == np.uint8 and shot.shape == (64, 64, 3) for shot in shots)
    assert np.ptp([shot.mean() for shot in shots]) > 25
    assert np.array_equal(shots[0], photograph(_rng(0), image))
