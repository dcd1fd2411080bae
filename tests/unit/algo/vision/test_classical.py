from __future__ import annotations

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.algo.vision import decode, quads
from hawk.algo.vision.classical import ClassicalFinder
from hawk.algo.vision.rows import complete_rows, row_stalls
from hawk.algo.vision.seen import FloatArray, Found, GroundImage
from hawk.survey.scoring import match
from training.targets import shape_of

NORTH_UP = np.array([[0.0, -0.1, 0.0], [0.1, 0.0, 0.0]])
SIDE = 0.1
WHITE, YELLOW, BLUE = (225, 225, 225), (60, 190, 225), (190, 110, 50)
ASPHALT = (92, 90, 88)


@dataclass
class Drawing:
    """A picture of 0.1 m a pixel to paint on, metres from its middle, turned by ``turn``."""

    turn: float = 0.0
    size: tuple[int, int] = (420, 420)
    ground: tuple[int, int, int] = ASPHALT
    seed: int = 4
    image: NDArray[np.uint8] = field(init=False)

    def __post_init__(self) -> None:
        self.image = np.full((*self.size, 3), self.ground, np.uint8)

    def pixels(self, points: FloatArray) -> FloatArray:
        c, s = math.cos(self.turn), math.sin(self.turn)
        middle = np.array(self.size[::-1]) / 2
        return np.asarray(np.asarray(points, float) @ np.array([[c, s], [-s, c]]) / SIDE + middle)

    def line(self, first: FloatArray, last: FloatArray, colour: tuple[int, int, int], width: float = 0.12) -> None:
        along = np.asarray(last, float) - first
        aside = np.array([-along[1], along[0]]) / np.hypot(*along) * width / 2
        self.fill(np.array([first - aside, first + aside, last + aside, last - aside]), colour)

    def fill(self, polygon: FloatArray, colour: tuple[int, int, int]) -> None:
        points = np.rint(self.pixels(polygon) * 16).astype(np.int32)
        cv2.fillPoly(self.image, [points], colour, cv2.LINE_AA, 4)

    def picture(self) -> GroundImage:
        rng = np.random.default_rng(self.seed)
        soft = cv2.GaussianBlur(self.image, (3, 3), 0.6)
        noisy = np.clip(soft + rng.normal(0, 3, soft.shape), 0, 255).astype(np.uint8)
        return GroundImage(noisy, NORTH_UP, np.ones(self.size, np.bool_))


def paint_row(
    drawing: Drawing, *, count: int = 8, pitch: float = 2.6, length: float = 5.2, lean: float = 0.0,
    colour: tuple[int, int, int] = WHITE, at: float = 0.0, skip: tuple[int, ...] = (), cars: tuple[int, ...] = (),
) -> FloatArray:  # fmt: skip
    """Paint a row across (x), lines along (y), shifted by ``lean`` a metre; return its stalls (N, 4, 2) in pixels.

    ``skip`` are lines left unpainted, ``cars`` the stalls with one on.
    """
    x = (np.arange(count + 1) - count / 2) * pitch
    low = np.column_stack([x, lean * x + at - length / 2])
    high = low + np.array([0.0, length])
    for k in range(count + 1):
        if k not in skip:
            drawing.line(low[k], high[k], colour)
    for k in cars:
        park(drawing, (low[k] + high[k + 1]) / 2, k)
    # as the rectangle along the lines that a stall is matched by
    shift = np.array([0.0, lean * pitch / 2])
    corners = np.stack([low[:-1] + shift, low[1:] - shift, high[1:] - shift, high[:-1] + shift], axis=1)
    return drawing.pixels(corners)


def park(drawing: Drawing, middle: FloatArray, kind: int) -> None:
    """Draw a car with dark windows and its shade."""
    paint = [(40, 40, 160), (215, 215, 215), (45, 42, 40), (140, 90, 40)][kind % 4]
    box = np.array([[-0.9, -2.2], [0.9, -2.2], [0.9, 2.2], [-0.9, 2.2]])
    drawing.fill(middle + box + (0.25, 0.2), (45, 44, 44))
    drawing.fill(middle + box, paint)
    drawing.fill(middle + box * (0.8, 0.22) + (0, 0.8), (25, 22, 20))
    drawing.fill(middle + box * (0.8, 0.12) - (0, 1.3), (25, 22, 20))
    drawing.fill(
        middle + box * (0.75, 0.3) - (0, 0.2),
        (min(255, paint[0] + 25), min(255, paint[1] + 25), min(255, paint[2] + 25)),
    )


def found_quads(found: Found, ground: GroundImage) -> FloatArray:
    table = np.array([(s.north, s.east, s.angle, s.width, s.length) for s in found.stalls]).reshape(-1, 5)
    return ground.pixel_points(quads.corners(*table.T))


def shares(drawing: Drawing, true: FloatArray) -> tuple[float, float]:
    """Return recall and precision of what is found on a drawing."""
    ground = drawing.picture()
    found = found_quads(ClassicalFinder().find(ground), ground)
    right = len(match(found, true))
    return right / len(true), right / max(len(found), 1)


@pytest.mark.parametrize("turn", [0.0, 0.4, math.pi / 2, 2.2])
def test_a_row_with_cars_is_found_with_its_states(turn: float) -> None:
    drawing, cars = Drawing(turn), (1, 2, 3, 6)
    true = paint_row(drawing, cars=cars)
    ground = drawing.picture()
    found = ClassicalFinder().find(ground)
    pairs = match(found_quads(found, ground), true)
    assert len(pairs) == len(true) == len(found.stalls)
    assert {int(t) for f, t in zip(pairs.found, pairs.true, strict=True) if found.stalls[f].taken > 0.5} == set(cars)


@pytest.mark.parametrize("colour", [WHITE, YELLOW, BLUE])
def test_paint_of_every_colour_counts(colour: tuple[int, int, int]) -> None:
    drawing = Drawing(0.3)
    recall, precision = shares(drawing, paint_row(drawing, colour=colour))
    assert recall >= 0.85
    assert precision == 1.0


def test_yellow_paint_as_light_as_its_concrete_is_seen_by_its_colour() -> None:
    drawing = Drawing(0.2, ground=(165, 165, 165))
    assert shares(drawing, paint_row(drawing, colour=(95, 170, 185)))[0] >= 0.85


def test_worn_paint_is_found_where_the_ground_is_smooth() -> None:
    drawing = Drawing(1.0)
    recall, precision = shares(drawing, paint_row(drawing, colour=(118, 118, 118)))
    assert recall >= 0.75
    assert precision == 1.0


@pytest.mark.parametrize("lean", [0.35, 0.58, -0.58])
def test_angled_rows(lean: float) -> None:
    drawing = Drawing(0.5, size=(480, 480))
    recall, precision = shares(drawing, paint_row(drawing, lean=lean, cars=(2, 5)))
    assert recall >= 0.85
    assert precision >= 0.85


def test_long_lines_are_two_stalls_head_to_head() -> None:
    drawing = Drawing(0.8)
    behind = paint_row(drawing, at=-2.6, cars=(0, 4))
    ahead = paint_row(drawing, at=2.6, cars=(1, 5))
    recall, precision = shares(drawing, np.concatenate([behind, ahead]))
    assert recall >= 0.9
    assert precision >= 0.9


def test_a_line_that_is_hidden_is_bridged() -> None:
    drawing = Drawing(0.1)
    true = paint_row(drawing, skip=(4,), cars=(3, 4))
    assert shares(drawing, true) == (1.0, 1.0)


def test_two_rows_across_each_other_are_both_found() -> None:
    drawing = Drawing(0.0, size=(560, 560))
    true = [paint_row(drawing, at=-16)]
    drawing.turn = math.pi / 2
    true.append(paint_row(drawing, at=16))
    recall, precision = shares(drawing, np.concatenate(true))
    assert recall >= 0.9
    assert precision >= 0.9


@pytest.mark.slow
@settings(max_examples=25)
@given(turn=st.floats(0, math.pi), pitch=st.floats(2.4, 3.1), seed=st.integers(0, 99))
def test_the_direction_of_a_row_does_not_matter(turn: float, pitch: float, seed: int) -> None:
    drawing = Drawing(turn, seed=seed)
    recall, precision = shares(drawing, paint_row(drawing, pitch=pitch, cars=(1, 4)))
    assert recall >= 0.85
    assert precision >= 0.85


def road(drawing: Drawing) -> None:
    for x in (-5.2, 5.2):
        drawing.line(np.array([x, -21.0]), np.array([x, 21.0]), WHITE)
    for x in (-1.7, 1.7):
        for y in range(-20, 20, 9):
            drawing.line(np.array([x, float(y)]), np.array([x, y + 3.0]), WHITE)


def lanes(drawing: Drawing) -> None:
    for k in range(7):
        drawing.line(np.array([(k - 3) * 3.0, -21.0]), np.array([(k - 3) * 3.0, 21.0]), WHITE)


def roof(drawing: Drawing) -> None:
    drawing.fill(np.array([[-15, -9], [15, -9], [15, 9], [-15, 9.0]]), (170, 170, 172))
    for k in range(11):
        drawing.line(np.array([(k - 5) * 2.6, -9.0]), np.array([(k - 5) * 2.6, 9.0]), (205, 205, 205), 0.15)


def crosswalk(drawing: Drawing) -> None:
    for k in range(10):
        drawing.line(np.array([(k - 5) * 1.2, -2.0]), np.array([(k - 5) * 1.2, 2.0]), WHITE, 0.5)


def hatching(drawing: Drawing, pitch: float = 1.0) -> None:
    for k in range(14):
        drawing.line(np.array([(k - 7) * pitch, -2.5]), np.array([(k - 7) * pitch, 2.5]), WHITE)


def gravel(drawing: Drawing) -> None:
    rng = np.random.default_rng(drawing.seed)
    rough = cv2.GaussianBlur(rng.normal(0, 60, drawing.image.shape).astype(np.float32), (0, 0), 1.2)
    drawing.image[:] = np.clip(drawing.image + rough * 2, 0, 255).astype(np.uint8)


@pytest.mark.parametrize("turn", [0.0, 0.37, 1.2])
@pytest.mark.parametrize("paint", [road, lanes, roof, crosswalk, hatching, gravel])
def test_what_is_no_row_is_not_taken_for_one(paint: object, turn: float) -> None:
    drawing = Drawing(turn)
    assert callable(paint)
    paint(drawing)
    assert ClassicalFinder().find(drawing.picture()).stalls == ()


@pytest.mark.parametrize("pitch", [0.8, 1.1, 1.3, 1.5])
def test_stripes_closer_than_a_stall_is_wide_are_no_row(pitch: float) -> None:
    drawing = Drawing(0.6)
    hatching(drawing, pitch)
    assert ClassicalFinder().find(drawing.picture()).stalls == ()


@pytest.mark.parametrize("shape", [(200, 200), (32, 32), (7, 300)])
def test_bare_ground_and_blackness_show_nothing(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(5)
    for image in (rng.normal(90, 4, (*shape, 3)).astype(np.uint8), np.zeros((*shape, 3), np.uint8)):
        found = ClassicalFinder().find(GroundImage(image, NORTH_UP, np.ones(shape, np.bool_)))
        assert found.stalls == ()
        assert (found.lot.values == 0.5).all()


def test_nothing_is_found_where_the_camera_saw_nothing() -> None:
    drawing = Drawing()
    paint_row(drawing)
    picture = drawing.picture()
    valid = picture.valid.copy()
    valid[:, 210:] = False
    values = np.where(valid[..., None], picture.values, 0).astype(np.uint8)
    found = ClassicalFinder().find(GroundImage(values, NORTH_UP, valid))
    assert found.stalls
    assert all(s.east < 21.0 for s in found.stalls)


def test_maps_distinguish_lot_car_and_core() -> None:
    drawing = Drawing(size=(600, 600))
    drawing.fill(np.array([[-30, -30], [30, -30], [30, -4], [-30, -4.0]]), (60, 120, 70))  # grass behind the row
    true = paint_row(drawing, cars=(2,))
    found = ClassicalFinder().find(drawing.picture())
    assert found.lot.values.shape == found.core.values.shape == found.car.values.shape == (300, 300)
    middle = np.rint(true.mean(axis=1) / 2).astype(int)[:, ::-1]
    aisle, grass, far = (310 // 2 + 18, 150), (240 // 2, 150), (280, 10)
    for at in middle.tolist():
        assert found.lot.values[tuple(at)] > 0.8
        assert found.core.values[tuple(at)] > 0.5
    assert found.lot.values[aisle] > 0.7
    assert found.lot.values[grass] < 0.4
    assert found.lot.values[far] == 0.5
    assert found.car.values[tuple(middle[2])] > 0.6
    assert found.car.values[tuple(middle[5])] < 0.3
    assert found.core.values[aisle] < 0.2


def test_the_core_map_is_evidence_for_stalls_that_were_not_found() -> None:
    """Given a part of the row only, completing it by the core map gives the rest, and nothing past its ends."""
    drawing = Drawing()
    true = paint_row(drawing, count=9, cars=(3, 6))
    ground = drawing.picture()
    core = ClassicalFinder().find(ground).core

    def evidence(corners: FloatArray) -> FloatArray:
        share = (np.arange(9) + 0.5) / 9 * 0.7 + 0.15
        weights = np.stack(np.meshgrid(share, share), -1).reshape(-1, 2)
        across, along = weights[:, :1], weights[:, 1:]
        near = corners[:, None, 0] * (1 - across) + corners[:, None, 1] * across
        far = corners[:, None, 3] * (1 - across) + corners[:, None, 2] * across
        points = core.pixel_points(near * (1 - along) + far * along)
        return np.asarray(decode.sample(core.values, points).mean(axis=1))

    centre, angle, width, length = shape_of(ground.map_points(true))
    known = np.array([1, 2, 5, 7])
    north, east = centre[known].T
    some = row_stalls(north, east, angle[known], width[known], length[known], np.full(len(known), 0.9))
    completed = complete_rows(some, evidence)
    pairs = match(completed.corners(), ground.map_points(true))
    assert len(pairs) == len(true) == len(completed)
