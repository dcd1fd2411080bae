from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import cv2
import numpy as np
import pytest

from hawk.calibrate.camera_command import Session
from hawk.calibrate.lens import LEAST_CORNERS, MOST_RMS, NAMES, BoardFinder, Collector, Lens, LensError, View, calibrate
from hawk.calibrate.settings_file import camera_info, write_camera_info
from hawk.comm.cameras.calibration import load_calibration
from hawk.config.sections import CameraSettings
from tests.unit.calibrate.boards import TRUE, Picture, Studio

SIZE = (TRUE.width, TRUE.height)
GOOD = Lens(*SIZE, (702.0, 698.0, 492.0, 262.0, -0.2, 0.05, 0.001, -0.001, 0.01), (0.3,) * 4 + (0.001,) * 5, 0.2, 20)


@pytest.fixture(scope="session")
def views(pictures: list[Picture]) -> list[View]:
    finder = BoardFinder(*SIZE)
    found = [finder.find(picture) for picture in pictures]
    return [view for view in found if view is not None]


@pytest.mark.nightly
def test_rendered_boards_give_the_lens_they_were_seen_by(views: list[View]) -> None:
    assert len(views) == 19
    lens = calibrate(views, *SIZE)
    found = dict(zip(NAMES, lens.values, strict=True))
    assert lens.rms < 0.25
    assert found["fx"] == pytest.approx(TRUE.fx, abs=1.5)
    assert found["fy"] == pytest.approx(TRUE.fy, abs=1.5)
    assert found["cx"] == pytest.approx(TRUE.cx, abs=1.5)
    assert found["cy"] == pytest.approx(TRUE.cy, abs=1.5)
    assert found["k1"] == pytest.approx(TRUE.distortion[0], abs=0.003)
    assert found["k2"] == pytest.approx(TRUE.distortion[1], abs=0.006)
    assert lens.problems == []
    assert lens.left_out == 0
    true = (TRUE.fx, TRUE.fy, TRUE.cx, TRUE.cy)
    assert (np.abs(np.array(lens.values[:4]) - true) < 4 * np.array(lens.spreads[:4])).all()


@pytest.mark.slow
def test_the_lens_bends_every_part_of_the_picture_as_the_true_one_within_half_a_pixel(views: list[View]) -> None:
    lens = calibrate(views, *SIZE)
    rows, columns = np.mgrid[10 : TRUE.height : 40, 10 : TRUE.width : 40].astype(float)
    seen = np.stack([columns, rows], -1).reshape(-1, 1, 2)
    fx, fy, cx, cy = lens.values[:4]
    true = np.array([[TRUE.fx, 0, TRUE.cx], [0, TRUE.fy, TRUE.cy], [0, 0, 1.0]])
    found = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])
    one = cv2.undistortPoints(seen, true, np.array(TRUE.distortion)).reshape(-1, 2)
    other = cv2.undistortPoints(seen, found, np.array(lens.values[4:])).reshape(-1, 2)
    # a small turn of the camera is no error of its lens
    turn, _ = cv2.findHomography(other, one)
    again = cv2.perspectiveTransform(other.reshape(-1, 1, 2), turn).reshape(-1, 2)
    assert np.abs(again - one).max() * TRUE.fx < 0.5


@pytest.mark.slow
@pytest.mark.nightly
def test_k3_is_left_out_where_its_spread_does_not_distinguish_it_from_zero(views: list[View]) -> None:
    lens = calibrate(views, *SIZE)
    assert (lens.values[8], lens.spreads[8]) == (0.0, 0.0)


@pytest.mark.slow
def test_a_view_that_does_not_fit_is_left_out(views: list[View]) -> None:
    rng = np.random.default_rng(1)
    moved = replace(views[3], corners=views[3].corners + rng.normal(0, 3.0, views[3].corners.shape))
    lens = calibrate([*views[:3], moved, *views[4:]], *SIZE)
    assert lens.left_out == 1
    assert lens.rms < 0.25
    assert lens.problems == []


@pytest.mark.slow
def test_a_bent_board_is_not_accepted(views: list[View]) -> None:
    """Corners that are off everywhere: nothing can be left out."""
    rng = np.random.default_rng(2)
    bent = [replace(view, corners=view.corners + rng.normal(0, 1.0, view.corners.shape)) for view in views]
    lens = calibrate(bent, *SIZE)
    assert lens.rms > MOST_RMS
    assert "it must be below 0.5: is the board flat" in lens.problems[0]


@pytest.mark.slow
def test_boards_that_are_hardly_tilted_leave_the_focal_length_uncertain(studio: Studio) -> None:
    finder = BoardFinder(*SIZE)
    flat = [finder.find(studio.view((0.5 * k, 0, 90, 0, 0, 16.0 + k), seed=k)) for k in range(7)]
    lens = calibrate([view for view in flat if view is not None], *SIZE)
    assert any("the focal length is uncertain by" in problem for problem in lens.problems)


@pytest.mark.slow
def test_boards_that_are_not_tilted_at_all_are_missing_tilts_whatever_their_spread(studio: Studio) -> None:
    """The focal length is then off by a quarter, and OpenCV's spread does not show it."""
    session = Session(must_be_still=False)
    for k, (x, y) in enumerate([(-4, -2), (0, -2), (4, -2), (-4, 2), (0, 2), (4, 2)]):
        assert session.take(studio.view((0, 0, 90, x, y, 16.0), seed=k))
    session.try_lens(at_once=True)
    assert session.lens is None
    assert session.problems[-1].startswith("views are missing")


def test_too_few_views_are_refused(views: list[View]) -> None:
    with pytest.raises(LensError, match="5 views of the board, at least 6 are needed"):
        calibrate(views[:5], *SIZE)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"rms": 0.5}, "the error is 0.50 px, it must be below 0.5"),
        ({"spreads": (1.5, *GOOD.spreads[1:])}, "the focal length is uncertain by 0.21%"),
        ({"spreads": (*GOOD.spreads[:3], 2.0, *GOOD.spreads[4:])}, "the centre is uncertain by 0.21% of the width"),
        ({"spreads": (float("nan"), *GOOD.spreads[1:])}, "the focal length"),
    ],
)
def test_error_and_spreads_decide(change: dict[str, object], words: str) -> None:
    assert GOOD.problems == []
    (problem,) = replace(GOOD, **change).problems  # type: ignore[arg-type]
    assert words in problem


def test_the_daemon_reads_the_file_as_the_lens_is(tmp_path: Path) -> None:
    path = tmp_path / "camera.yaml"
    write_camera_info(GOOD, path, datetime(2026, 1, 2, 3, 4, tzinfo=UTC))
    model = load_calibration(CameraSettings(calibration=path)).for_size(*SIZE)
    assert (model.fx, model.fy, model.cx, model.cy) == GOOD.values[:4]
    assert model.distortion == GOOD.values[4:]
    assert (model.width, model.height) == SIZE
    head = camera_info(GOOD, datetime(2026, 1, 2, 3, 4, tzinfo=UTC)).splitlines()[:2]
    assert head[0] == "# hawk-drone calibrate, 2026-01-02 03:04 UTC: 20 views, error 0.200 px"
    assert head[1].startswith("# standard deviations: fx 0.3, fy 0.3,")


# -- views -------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_picture_without_the_board_has_no_view() -> None:
    noise = np.random.default_rng(1).integers(0, 255, (540, 960, 3), np.uint8)
    assert BoardFinder(*SIZE).find(noise) is None


def test_a_board_that_is_hardly_in_the_picture_has_no_view(studio: Studio) -> None:
    assert BoardFinder(*SIZE).find(studio.view((0, 0, 90, 13.5, 0, 14.0))) is None


@pytest.mark.parametrize(
    ("turn", "k", "sign"), [((0, 30), 0, 1), ((0, -30), 0, -1), ((30, 0), 1, -1), ((-30, 0), 1, 1)]
)
def test_the_tilt_is_the_board_s(studio: Studio, turn: tuple[int, int], k: int, sign: int) -> None:
    """Turned clockwise about y (down) the right edge goes away."""
    view = BoardFinder(*SIZE).find(studio.view((turn[0], turn[1], 0, 0, 0, 18.0)))
    assert view is not None
    assert np.degrees(view.lean[k]) == pytest.approx(-sign * 30, abs=5)
    assert abs(np.degrees(view.lean[1 - k])) < 5


@pytest.mark.slow
def test_the_size_is_that_of_the_whole_board_however_little_is_seen(studio: Studio) -> None:
    finder = BoardFinder(*SIZE)
    whole, part = (finder.find(studio.view((0, 0, 90, x, 0, 16.0))) for x in (0, 8))
    assert whole is not None
    assert part is not None
    assert LEAST_CORNERS <= len(part.ids) < len(whole.ids)
    assert part.size == pytest.approx(whole.size, rel=0.1)


def test_only_still_and_different_views_are_kept(views: list[View]) -> None:
    collector = Collector(TRUE.width, [])
    first, second = views[0], views[5]
    assert collector.take(None) == "the board is not seen"
    assert collector.take(first) == "hold the board still"
    moved = replace(first, corners=first.corners + 3.0)
    assert collector.take(moved) == "hold the board still"
    assert collector.take(moved) == ""
    assert collector.take(first) == "hold the board still"
    assert collector.take(first) == "this view is there already"
    collector.take(second)
    assert collector.take(second) == ""
    assert len(collector.views) == 2


def test_pictures_of_a_folder_need_not_be_still(views: list[View]) -> None:
    collector = Collector(TRUE.width, [], must_be_still=False)
    assert [collector.take(view) for view in views[:2]] == ["", ""]
