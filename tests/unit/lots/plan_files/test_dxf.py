"""Plans as DXF: closed polylines, texts in them, units, blocks, and files that are cut or grow without end."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from hawk.lots.values import LotInputError
from tests.unit.lots.plan_files.files import closed, dxf, labels, left_out, plan, row

A_ROW = row(3)


def stalls(scale: float = 1.0) -> Any:
    """Draw a row of three with numbers, a tree, an open line and a building."""

    def draw(_: Any, space: Any) -> None:
        for number, ring in enumerate(A_ROW, 1):
            space.add_lwpolyline(closed(ring, scale), close=True, dxfattribs={"layer": "STALLS"})
            middle = np.mean(closed(ring, scale), axis=0)
            space.add_text(f"P{number}", height=0.3 * scale, dxfattribs={"insert": tuple(middle)})
        space.add_lwpolyline([(0, 20 * scale), (5 * scale, 20 * scale)], dxfattribs={"layer": "LINES"})
        house = [(x * scale, y * scale) for x, y in ((0, 30), (60, 30), (60, 60), (0, 60))]
        space.add_lwpolyline(house, close=True, dxfattribs={"layer": "HOUSE"})

    return draw


def test_closed_polylines_are_stalls_with_the_text_in_them() -> None:
    found = plan(dxf(stalls()))
    assert labels(found) == ["P1", "P2", "P3"]
    assert found.layers == (("HOUSE", 1), ("STALLS", 3))
    assert found.datum is None
    assert "on HOUSE: is 30.00 by 60.00 m" in left_out(found)[0]


def test_a_layer_is_chosen_by_its_name() -> None:
    found = plan(dxf(stalls()), layer="STALLS")
    assert found.left_out_count == 0
    with pytest.raises(LotInputError, match="layer: has no closed polyline; those with some: HOUSE, STALLS"):
        plan(dxf(stalls()), layer="TREES")


@pytest.mark.parametrize(("number", "scale"), [(6, 1.0), (4, 1000.0), (5, 100.0), (2, 1 / 0.3048), (1, 1 / 0.0254)])
def test_units_are_those_of_the_header(number: int, scale: float) -> None:
    found = plan(dxf(stalls(scale), number), layer="STALLS")
    assert found.shapes()[:, 3:] == pytest.approx(np.tile([2.5, 5.0], (3, 1)), rel=1e-3)


@pytest.mark.fault("a DXF says no units", "they are asked for")
@pytest.mark.parametrize(("number", "said"), [(0, "says none"), (13, "says 13")])
def test_units_that_are_not_known_are_asked_for(number: int, said: str) -> None:
    data = dxf(stalls(1000.0), number)
    with pytest.raises(LotInputError, match=rf"units: of the drawing are not known \(\$INSUNITS {said}\): write m, cm"):
        plan(data)
    assert plan(data, units="mm", layer="STALLS").shapes()[0, 4] == pytest.approx(5.0)
    with pytest.raises(LotInputError, match="units: must be one of m, cm"):
        plan(data, units="parsec")


@pytest.mark.fault("somebody names metres for a drawing in millimetres", "it says by which units it would fit")
def test_units_that_were_named_and_fit_nothing_are_refused_with_those_that_do() -> None:
    with pytest.raises(LotInputError, match=r"units: of the drawing do not fit.* by mm they are stalls: write mm"):
        plan(dxf(stalls(1000.0)), units="m", layer="STALLS")


def test_other_polylines_texts_and_mirrored_planes_are_read() -> None:
    def draw(_: Any, space: Any) -> None:
        space.add_polyline2d(closed(A_ROW[0]), close=True)
        space.add_polyline3d([(x, y, 3.0) for x, y in closed(A_ROW[1])], close=True)
        space.add_lwpolyline([(-x, y) for x, y in closed(A_ROW[2])], close=True, dxfattribs={"extrusion": (0, 0, -1)})
        space.add_mtext("{\\fArial|b1;17}", dxfattribs={"insert": (0.0, 0.0)})
        centred = space.add_text("18", dxfattribs={"halign": 1})
        centred.dxf.align_point = (2.5, 0.0)
        space.add_text("far", dxfattribs={"insert": (900.0, 0.0)})

    found = plan(dxf(draw))
    assert labels(found) == ["17", "18", ""]
    assert np.diff(found.shapes()[:, 1]) == pytest.approx([2.5, 2.5])


def test_a_polyline_that_ends_where_it_began_is_closed_and_arcs_are_corners() -> None:
    def draw(_: Any, space: Any) -> None:
        corners = closed(A_ROW[0])
        space.add_lwpolyline([*corners, corners[0]])
        round_end = [(x, y, 0, 0, 0.05 if k == 0 else 0) for k, (x, y) in enumerate(closed(A_ROW[2]))]
        space.add_lwpolyline(round_end, close=True)

    found = plan(dxf(draw))
    assert len(found.stalls) == 2
    assert found.shapes()[1, 3] >= 2.49


def test_blocks_are_taken_apart_with_their_attributes() -> None:
    def draw(document: Any, space: Any) -> None:
        block = document.blocks.new("STALL")
        block.add_lwpolyline([(-1.25, -2.5), (1.25, -2.5), (1.25, 2.5), (-1.25, 2.5)], close=True)
        block.add_attdef("NUMBER", (0, 0))
        for number in range(3):
            turned = {"rotation": 30.0 * number}
            placed = space.add_blockref("STALL", (number * 10.0, 0.0), dxfattribs=turned)
            placed.add_auto_attribs({"NUMBER": f"N{number}"})

    found = plan(dxf(draw))
    assert labels(found) == ["N0", "N1", "N2"]
    angles = [math.degrees(stall.angle) for stall in found.stalls]
    assert angles == pytest.approx([0.0, 150.0, 120.0])


def nested(document: Any, space: Any) -> None:
    """Draw blocks within blocks: a million outlines of a small file."""
    first = document.blocks.new("B0")
    first.add_lwpolyline([(0, 0), (2.5, 0), (2.5, 5), (0, 5)], close=True)
    for depth in range(1, 7):
        block = document.blocks.new(f"B{depth}")
        for k in range(10):
            block.add_blockref(f"B{depth - 1}", (k * 3.0, depth * 6.0))
    space.add_blockref("B6", (0, 0))


@pytest.mark.slow
@pytest.mark.fault(
    "a small file with a plan grows without end: an archive, entities of XML, blocks within blocks",
    "it is refused at a bound, in a process of its own",
)
def test_a_small_file_with_any_number_of_outlines_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hawk.lots.plan_files.dxf._MOST_ENTITIES", 500)
    with pytest.raises(LotInputError, match="has more than 500 entities, with those of its blocks"):
        plan(dxf(nested))
    monkeypatch.setattr("hawk.lots.plan_files.dxf._DEEPEST", 3)
    with pytest.raises(LotInputError, match="has blocks within blocks, more than 3 deep"):
        plan(dxf(nested))


@pytest.mark.fault("a file with a plan is cut, damaged or of another kind")
def test_a_file_that_is_cut_damaged_or_of_another_kind_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    data = dxf(stalls())
    with pytest.raises(LotInputError, match="is cut: a DXF ends with EOF"):
        plan(data[: len(data) // 2])
    with pytest.raises(LotInputError, match=r"cannot be read as DXF|is damaged|holds no stall|are not known"):
        plan(b"0\nSECTION\n2\nENTITIES\nx\ny\n0\nEOF\n")
    with pytest.raises(LotInputError, match="is a DWG: save it as DXF"):
        plan(b"AC1032" + bytes(100))
    monkeypatch.setitem(__import__("sys").modules, "ezdxf", None)
    monkeypatch.setitem(__import__("sys").modules, "ezdxf.filemanagement", None)
    with pytest.raises(LotInputError, match=r'pip install "hawk-drone\[plans\]"'):
        plan(data)


def test_coordinates_of_a_named_system_place_a_drawing() -> None:
    def draw(_: Any, space: Any) -> None:
        for ring in A_ROW:
            space.add_lwpolyline([(x + 691_000, y + 5_334_000) for x, y in closed(ring)], close=True)

    found = plan(dxf(draw), crs="EPSG:25832")
    assert found.datum == pytest.approx((48.13057, 11.56708), abs=1e-3)


def test_a_file_that_was_repaired_is_read_with_a_warning() -> None:
    data = dxf(stalls()).replace(b" 70\n1\n", b" 70\n1x\n", 1)
    found = plan(data, layer="STALLS")
    assert labels(found) == ["P1", "P2", "P3"]
    assert left_out(found) == ["file: was repaired while it was read: compare the preview with the drawing"]
