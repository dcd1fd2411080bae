from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.worlds.rows import plan_row
from hawk.worlds.style import LotStyle, sample_palette, sample_style
from tests.unit.worlds.builders import EAST, generator, plain_plan, plain_style

SEEDS = range(200)


def drawn(*, calm: bool) -> list[LotStyle]:
    return [sample_style(generator(seed), calm=calm) for seed in SEEDS]


@given(st.floats(2.2, 3.2), st.floats(4.5, 6.2), st.floats(-50, 50))
def test_measures_of_an_angled_row(width: float, length: float, degrees: float) -> None:
    style = plain_style(width=width, length=length, skew=math.radians(degrees))
    assert style.pitch * math.cos(style.skew) == pytest.approx(width), "stalls keep their width"
    assert math.atan2(style.shift, style.depth) == pytest.approx(style.skew)
    assert style.depth <= length + 0.35 * width
    assert plain_style(width=width, length=length).depth == pytest.approx(length)


def test_calm_styles_are_those_of_most_lots() -> None:
    for style in drawn(calm=True):
        assert 2.45 <= style.width <= 2.85
        assert 4.9 <= style.length <= 5.6
        assert 6.0 <= style.aisle <= 7.6
        assert abs(style.skew) <= math.radians(45)
        assert 0.42 <= style.occupancy <= 0.8
        assert not style.unpainted
        assert style.shelters == style.bare_ends == 0


def test_styles_to_train_on_are_wider_than_calm_ones_in_every_measure() -> None:
    calm, wild = drawn(calm=True), drawn(calm=False)
    for name in ("width", "length", "aisle", "occupancy", "line_width", "drop", "worn", "skew"):
        ranges = [np.ptp([getattr(style, name) for style in styles]) for styles in (calm, wild)]
        assert ranges[1] > ranges[0], name
    assert any(style.unpainted for style in wild)
    assert any(style.occupancy < 0.1 for style in wild)
    assert any(style.occupancy > 0.95 for style in wild)


@pytest.mark.parametrize("calm", [True, False])
def test_a_third_of_the_lots_lean_to_either_side(calm: bool) -> None:
    skews = np.array([style.skew for style in drawn(calm=calm)])
    assert 0.2 < (skews != 0).mean() < 0.5
    assert (skews > 0).any()
    assert (skews < 0).any()


def test_the_same_generator_draws_the_same_style() -> None:
    assert sample_style(generator(4)) == sample_style(generator(4))
    assert sample_style(generator(4)) != sample_style(generator(5))


@settings(max_examples=60)
@given(st.integers(0, 10_000), st.floats(30, 182), st.booleans())
def test_every_palette_shows_on_its_ground(seed: int, ground: float, calm: bool) -> None:
    stalls, hatching, signs, white = sample_palette(generator(seed), ground, calm=calm)
    for colour in (stalls, hatching):
        assert np.abs(np.array(colour) - ground).max() >= 15
        assert all(0 <= channel <= 250 for channel in colour)
    assert signs[0] > signs[1] > signs[2], "accessible signs are blue"
    assert min(white) > 190


def test_stall_lines_are_mostly_white_and_sometimes_yellow() -> None:
    colours = np.array([sample_palette(generator(seed), 80.0)[0] for seed in SEEDS])
    yellow = colours[:, 2] - colours[:, 0] > 40
    assert 0.15 < yellow.mean() < 0.5


@pytest.mark.parametrize(
    ("name", "value", "more"),
    [
        ("hairpin", True, "strokes"),
        ("tees", True, "strokes"),
        ("front_line", 1.0, "strokes"),
        ("back_line", 1.0, "strokes"),
        ("hatch", 0.4, "strokes"),
        ("accessible", 1.0, "strokes"),
        ("wheel_stops", True, "blocks"),
        ("trees", 1.0, "trees"),
        ("break_share", 0.4, "islands"),
        ("ends", (0.0, 1.0, 0.0), "islands"),
        ("shelters", 0.4, "buildings"),
        ("occupancy", 1.0, "vehicles"),
    ],
)
def test_each_choice_of_a_style_shows_in_the_plan(name: str, value: object, more: str) -> None:
    counts = []
    for style in (plain_style(), plain_style(**{name: value})):
        plan = plain_plan()
        plan_row(plan, generator(3), EAST, 60.0, style)
        counts.append(len(getattr(plan, more)))
    assert counts[1] > counts[0]


@pytest.mark.parametrize("width", [0.08, 0.2])
def test_lines_are_as_wide_as_the_style_says(width: float) -> None:
    plan = plain_plan()
    plan_row(plan, generator(), EAST, 30.0, plain_style(line_width=width))
    assert all(np.ptp(stroke.polygon[:, 0]) == pytest.approx(width) for stroke in plan.strokes)


def test_kerbs_are_those_of_the_style() -> None:
    for kerb in (None, (200.0, 200.0, 200.0)):
        plan = plain_plan()
        plan_row(plan, generator(1), EAST, 60.0, plain_style(kerb=kerb, break_share=0.3))
        assert {island.kerb for island in plan.islands} == {kerb}
