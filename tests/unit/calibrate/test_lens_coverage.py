from __future__ import annotations

import math

import numpy as np
import pytest

from hawk.calibrate.camera_command import coverage_lines
from hawk.calibrate.lens import CELL_CORNERS, CELLS, FAR, LEAST_VIEWS, NEAR, TILTED, View, coverage

SIZE = (1280, 720)
LEANS = [(TILTED, 0.0), (-TILTED, 0.0), (0.0, TILTED), (0.0, -TILTED)]


def view(cells: list[tuple[int, int]], *, size: float = 0.5, lean: tuple[float, float] = (0.0, 0.0)) -> View:
    """Enough corners in the middle of each cell (row, column)."""
    middles = [((column + 0.5) / CELLS[0] * SIZE[0], (row + 0.5) / CELLS[1] * SIZE[1]) for row, column in cells]
    corners = np.repeat(np.array(middles), CELL_CORNERS, axis=0)
    return View(corners, np.arange(len(corners), dtype=np.int32), (0.5, 0.5), size, lean)


ALL = [(row, column) for row in range(CELLS[1]) for column in range(CELLS[0])]


def whole() -> list[View]:
    """Views with everything that is needed."""
    views = [view(ALL, lean=lean) for lean in LEANS] + [view(ALL, size=NEAR), view(ALL, size=FAR)]
    return views + [view(ALL)] * (LEAST_VIEWS - len(views))


def test_the_first_word_is_to_show_the_board() -> None:
    assert coverage([], *SIZE).missing == "hold the board into the picture, still and in even light"


@pytest.mark.parametrize(
    ("cell", "words"),
    [
        ((0, 0), "upper left"),
        ((0, 2), "upper middle"),
        ((0, 3), "upper right"),
        ((1, 0), "left"),
        ((1, 2), "right of the middle"),
        ((2, 0), "lower left"),
        ((2, 3), "lower right"),
    ],
)
def test_a_part_of_the_picture_that_is_missing_is_asked_for(cell: tuple[int, int], words: str) -> None:
    views = [view([each for each in ALL if each != cell])]
    assert coverage(views, *SIZE).missing == f"move the board to the {words} of the picture"


def test_the_emptiest_part_is_asked_for_first() -> None:
    few = view([(2, 3)])
    some = View(few.corners[:3], few.ids[:3], few.place, few.size, few.lean)
    views = [view([each for each in ALL if each not in ((0, 0), (2, 3))]), some]
    assert "upper left" in coverage(views, *SIZE).missing


@pytest.mark.parametrize(("k", "edge"), list(enumerate(["left", "right", "top", "bottom"])))
def test_a_tilt_that_is_missing_is_asked_for(k: int, edge: str) -> None:
    views = [view(ALL, lean=lean) for n, lean in enumerate(LEANS) if n != k]
    assert (
        coverage(views, *SIZE).missing == f"tilt the board: its {edge} edge nearer to the camera, by 30 degrees or more"
    )


def test_a_tilt_below_the_limit_does_not_count() -> None:
    views = whole()
    views[0] = view(ALL, lean=(TILTED - math.radians(0.1), 0.0))
    assert "left edge" in coverage(views, *SIZE).missing


def test_near_then_far_then_more_views_are_asked_for() -> None:
    tilted = [view(ALL, lean=lean) for lean in LEANS]
    assert "nearer" in coverage([*tilted, view(ALL, size=NEAR - 0.01)], *SIZE).missing
    near = [*tilted, view(ALL, size=NEAR)]
    assert "move the board away" in coverage([*near, view(ALL, size=FAR + 0.01)], *SIZE).missing
    assert coverage([*near, view(ALL, size=FAR)], *SIZE).missing == "show 9 more views, each at another place and tilt"


def test_nothing_is_missing_when_everything_is_there() -> None:
    there = coverage(whole(), *SIZE)
    assert there.missing == ""
    assert there.share == 1.0


@pytest.mark.parametrize(
    ("change", "differs"),
    [
        ({"place": (0.6, 0.5)}, False),
        ({"place": (0.65, 0.56)}, True),
        ({"lean": (0.21, 0.0)}, True),
        ({"size": 0.71}, True),
    ],
)
def test_a_view_differs_by_place_size_and_tilt(change: dict[str, object], differs: bool) -> None:
    first = view([(0, 0)])
    values = {"corners": first.corners, "ids": first.ids, "place": first.place, "size": first.size, "lean": first.lean}
    assert View(**{**values, **change}).differs(first) is differs  # type: ignore[arg-type]


def test_the_terminal_shows_parts_tilts_and_what_is_next() -> None:
    views = [view([(0, 0), (1, 1)], lean=LEANS[2])]
    few = view([(2, 3)])
    views.append(View(few.corners[:3], few.ids[:3], few.place, few.size, few.lean))
    lines = coverage_lines(coverage(views, *SIZE), "hold the board still")
    assert lines[:3] == ["  ##  ..  ..  ..", "  ..  ##  ..  ..", "  ..  ..  ..   3"]
    assert "views 2/15   tilt: left- right- top+ bottom-   distance: near- far-" in lines[3]
    assert lines[4] == "  next: move the board to the upper middle of the picture  (hold the board still)"
    assert all(line.isascii() for line in lines)
