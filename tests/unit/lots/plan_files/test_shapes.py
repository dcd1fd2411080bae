"""Outlines that are no rectangles: those that lean, and those that fill too little of one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hawk.lots.plan import geometry
from tests.unit.lots.plan_files.files import degrees, feature, geojson, left_out, plan


def leaning(degrees_of_lean: float, count: int = 3) -> list[list[tuple[float, float]]]:
    """Return stalls (north, east) of a row along east, 5 m deep and 2.5 m wide, as parallelograms."""
    lean = math.radians(degrees_of_lean)
    pitch, shift = 2.5 / math.cos(lean), 5.0 * math.tan(lean)
    rings = []
    for k in range(count):
        west, east = k * pitch, (k + 1) * pitch
        rings.append([(0.0, west), (0.0, east), (5.0, east + shift), (5.0, west + shift), (0.0, west)])
    return rings


@pytest.mark.parametrize("lean", [0.0, 15.0, 30.0, 45.0])
def test_a_stall_that_leans_is_a_rectangle_of_its_width_area_and_middle(lean: float) -> None:
    found = plan(geojson(feature([degrees(ring)]) for ring in leaning(lean)))
    shapes = found.shapes()
    assert len(shapes) == 3
    assert found.left_out_count == 0
    assert shapes[:, 3] == pytest.approx(np.full(3, 2.5), abs=0.01)
    assert shapes[:, 3] * shapes[:, 4] == pytest.approx(np.full(3, 5.0 * 2.5 / math.cos(math.radians(lean))), rel=0.01)
    assert np.degrees(shapes[:, 2]) % 180 == pytest.approx(np.full(3, lean), abs=0.1) or lean == 0.0
    assert not geometry.overlaps(shapes, np.empty((0, 5)), 0.05)


def test_a_triangle_and_an_angle_are_no_stalls() -> None:
    triangle = [(0.0, 0.0), (5.0, 0.0), (0.0, 5.0), (0.0, 0.0)]
    angle = [(20.0, 0.0), (26.0, 0.0), (26.0, 2.0), (22.0, 2.0), (22.0, 6.0), (20.0, 6.0), (20.0, 0.0)]
    stall = [(40.0, 0.0), (45.0, 0.0), (45.0, 2.5), (40.0, 2.5), (40.0, 0.0)]
    found = plan(geojson(feature([degrees(ring)]) for ring in (triangle, angle, stall)))
    assert len(found.stalls) == 1
    shares = [words.partition("fills ")[2][:3] for words in left_out(found)]
    assert shares == ["50%", "56%"]


def test_outlines_far_from_the_others_are_left_out() -> None:
    near = [
        [(0.0, k * 2.5), (5.0, k * 2.5), (5.0, k * 2.5 + 2.5), (0.0, k * 2.5 + 2.5), (0.0, k * 2.5)] for k in range(3)
    ]
    far = [(n + 30_000.0, e) for n, e in near[0]]
    found = plan(geojson(feature([degrees(ring)]) for ring in (*near, far)))
    assert len(found.stalls) == 3
    assert "is 30 km from the others" in left_out(found)[0]
