"""The detector for pictures from straight above."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.rows.lot import RowStalls
from hawk.algo.vision import quads
from hawk.algo.vision.detector import BEYOND_CELLS
from hawk.algo.vision.network import NetworkMaps, StallNetwork
from hawk.model.lot_map import StallState
from hawk.picture.orthophoto.tile_detector import GROUND_M, TileDetector, at_ground_scale, program_name, states_of
from hawk.picture.values import PictureError
from tests.unit.picture.orthophoto.drawn import METRES, detector, lot_picture
from training.crossings import plan_crossing_site
from training.scenes import draw_scene

pytestmark = pytest.mark.slow


def test_states_near_a_half_are_unknown_as_the_mapper_calls_them() -> None:
    states = states_of(np.array([0.0, 0.39, 0.45, 0.55, 0.61, 1.0]))
    assert states == (
        StallState.FREE,
        StallState.FREE,
        StallState.UNKNOWN,
        StallState.UNKNOWN,
        StallState.TAKEN,
        StallState.TAKEN,
    )


def test_a_scale_may_differ_between_columns_and_rows() -> None:
    image = np.zeros((100, 200, 3), np.uint8)
    image[:, 100:] = 200
    shown = at_ground_scale(image, (GROUND_M / 2, GROUND_M * 3))
    assert shown.shape == (300, 100, 3)
    assert (shown[:, :50].max(), shown[:, 50:].min()) == (0, 200)


def test_the_same_ground_at_another_scale_shows_the_same_stalls() -> None:
    whole = detector().detect(lot_picture(), METRES)
    wide = np.repeat(lot_picture(), 2, axis=1)
    found = detector().detect(wide, (METRES / 2, METRES))
    assert len(whole.stalls) > 30
    assert len(found.stalls) == len(whole.stalls)
    assert np.abs(found.stalls - whole.stalls).max() < 0.02
    assert found.states == whole.states


def test_nothing_is_found_where_a_picture_shows_no_ground() -> None:
    picture = lot_picture()
    valid = np.ones(picture.shape[:2], np.bool_)
    valid[:, 350:] = False
    found = detector().detect(picture, METRES, valid)
    whole = detector().detect(picture, METRES)
    assert 5 < len(found.stalls) < len(whole.stalls) - 5
    assert found.stalls.mean(axis=1)[:, 0].max() < 350 * METRES + 0.5
    assert not found.lot[:, round(35.5 / found.lot_m) :].any()
    inner = whole.stalls.mean(axis=1)[:, 0] < 30.0
    assert abs(int((found.stalls.mean(axis=1)[:, 0] < 30.0).sum()) - int(inner.sum())) <= 1


def test_a_network_that_cannot_be_used_is_refused_by_its_name(tmp_path: Path) -> None:
    with pytest.raises(PictureError, match=r"^--model: .*none\.onnx cannot be read: .*; name an ONNX file"):
        TileDetector.load(tmp_path / "none.onnx")
    (tmp_path / "text.onnx").write_text("no network")
    with pytest.raises(
        PictureError, match=r"^--model: .*text\.onnx is not an ONNX file[^\[]*name a network \(\.onnx\)"
    ):
        TileDetector.load(tmp_path / "text.onnx")


def test_a_survey_names_the_program_and_its_network() -> None:
    assert len(detector().model) == 64
    assert program_name(detector().model).endswith(f"network {detector().model[:8]}")


def row_of_stalls(stalls: int, margin_m: float) -> NDArray[np.uint8]:
    """Return a drawn row of free stalls of 2.5 by 5 m, with its lines, and that much ground about it."""
    pixels = [round(margin_m / METRES) + round(k * 2.5 / METRES) for k in range(stalls + 1)]
    high = round((2 * margin_m + 5.0) / METRES)
    picture = np.full((high, pixels[-1] + round(margin_m / METRES) + 1, 3), 90, np.uint8)
    top, bottom = round(margin_m / METRES), round((margin_m + 5.0) / METRES)
    for column in pixels:
        picture[top:bottom, column : column + 1] = 230
    picture[top : top + 1, pixels[0] : pixels[-1]] = 230
    return picture


@pytest.mark.parametrize("margin_m", [0.0, 0.3, 9.0])
def test_a_row_is_found_in_a_picture_that_is_cut_close_to_it(margin_m: float) -> None:
    picture = row_of_stalls(12, margin_m)
    found = detector().detect(picture, METRES)
    assert len(found.stalls) >= 11
    high, wide = np.array(picture.shape[:2]) * METRES
    places = found.stalls.mean(axis=1)
    assert ((places > 0) & (places < (wide, high))).all()
    assert found.lot.shape == detector().detect(picture, METRES, ends=(False, False, False, False)).lot.shape


def test_ground_that_was_cut_off_is_not_looked_beyond(monkeypatch: pytest.MonkeyPatch) -> None:
    looked = TileDetector.load()
    shapes: list[tuple[int, ...]] = []
    run = StallNetwork.run

    def noted(self: StallNetwork, picture: NDArray[np.uint8], sun: NDArray[np.float32] | None = None) -> NetworkMaps:
        shapes.append(picture.shape)
        return run(self, picture, sun)

    monkeypatch.setattr(StallNetwork, "run", noted)
    picture, beyond = np.full((96, 128, 3), 90, np.uint8), round(BEYOND_CELLS * 2)
    for ends in ((False, False, False, False), (True, False, False, True), (True, True, True, True)):
        looked.detect(picture, GROUND_M, ends=ends)
    assert shapes == [(96, 128, 3), (96 + beyond, 128 + beyond, 3), (96 + 2 * beyond, 128 + 2 * beyond, 3)]


def test_vehicles_of_a_drawn_lot_are_those_on_its_taken_stalls() -> None:
    found = detector().detect(lot_picture(), METRES)
    assert found.vehicles is not None
    sure = found.vehicles.corners[found.vehicles.probability >= 0.5].mean(axis=1)
    taken = found.stalls[found.taken > 0.5].mean(axis=1)
    apart = np.hypot(*(taken[:, None] - sure[None]).T)
    assert (apart.min(axis=1) < 1.5).mean() > 0.9
    assert (apart.min(axis=0) < 1.5).mean() > 0.8, "some stand beside stalls"


def test_cars_that_wait_at_a_crossing_are_on_no_stall() -> None:
    rng = np.random.default_rng((5252, 8))
    crossing = draw_scene(rng, 704, plan_site=lambda rng: plan_crossing_site(rng, (0.0, 0.0)))
    found = detector().detect(crossing.image, METRES)
    assert len(found.stalls) == 0
    assert len(found.suggested) > 10
    assert found.vehicles is not None
    assert len(found.vehicles) > 10


def test_each_stall_that_is_taken_out_is_suggested_once(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = detector().detect(lot_picture(), METRES)

    def without_the_first(stalls: RowStalls, *_: object) -> NDArray[np.bool_]:
        return np.arange(len(stalls)) >= 12

    monkeypatch.setattr("hawk.picture.orthophoto.tile_detector.are_shown", without_the_first)
    found = detector().detect(lot_picture(), METRES)
    assert (found.stalls == whole.stalls[12:]).all()
    assert (found.suggested[:12] == whole.stalls[:12]).all()
    assert quads.suppress(found.suggested, np.zeros(len(found.suggested)), 0.1).all()
    assert len(found.suggested) == len(whole.suggested) + 12
