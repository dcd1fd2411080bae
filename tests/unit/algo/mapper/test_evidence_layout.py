from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hawk.algo.mapper.evidence import EVIDENCE_M, cell_evidence, moved, outline, quality_mask
from hawk.algo.vision.detection import CameraView
from tests.unit.algo.synthetic import SyntheticVision, pose_at, rows_lot


def test_what_a_picture_shows_lands_on_its_place_on_the_map() -> None:
    truth = rows_lot(turn=0.5)
    seen = SyntheticVision(truth).look(pose_at(2.0, -3.0, 1.1), 1.0)
    evidence = cell_evidence(seen, 0.6, 0.85)
    assert evidence is not None
    stalls = truth.stalls[np.hypot(truth.stalls[:, 0] - 2.0, truth.stalls[:, 1] + 3.0) < 10]
    cells = np.round(evidence.window.cells_of(stalls[:, 0], stalls[:, 1])).astype(int)
    assert (evidence.core[cells[:, 1], cells[:, 0]] > 0.8).all()
    assert (evidence.lot[cells[:, 1], cells[:, 0]] > 1).all()
    assert (evidence.mask[cells[:, 1], cells[:, 0]] == 2).all()


def test_every_direction_gives_the_same_map() -> None:
    vision = SyntheticVision(rows_lot())
    sums = []
    for yaw in (0.0, 0.7, 2.0, 4.0):
        evidence = cell_evidence(vision.look(pose_at(0, 0, yaw), 1.0), 0.6, 0.85)
        assert evidence is not None
        north = -(np.arange(evidence.window.rows) + evidence.window.row + 0.5) * EVIDENCE_M
        east = (np.arange(evidence.window.columns) + evidence.window.column + 0.5) * EVIDENCE_M
        near = (np.abs(north)[:, None] < 8) & (np.abs(east)[None] < 8)
        sums.append(float(evidence.core[near].sum()))
    assert max(sums) / min(sums) < 1.06  # the truth itself is drawn in whole cells


def test_the_edge_is_left_out_and_the_border_is_not_good() -> None:
    mask = quality_mask(np.ones((140, 240), np.bool_), 0.2, 0.6, 0.8)
    assert mask[2, 100] == 0
    assert mask[5, 100] == 1
    assert mask[16, 100] == 2
    assert mask[70, 15] == 1
    assert mask[70, 30] == 2


def test_a_picture_that_shows_nothing_gives_no_evidence() -> None:
    seen = SyntheticVision(rows_lot()).look(pose_at(0, 0), 1.0)
    blind = replace(seen, lot=replace(seen.lot, valid=np.zeros_like(seen.lot.valid)))
    assert cell_evidence(blind, 0.6, 0.85) is None
    assert not quality_mask(np.zeros((5, 5), np.bool_), 0.2, 0.6, 0.85).any()


def test_a_correction_moves_the_outline() -> None:
    image = SyntheticVision(rows_lot()).look(pose_at(5, 6), 1.0).lot
    shift = np.array([[1.0, 0, 2.0], [0, 1.0, -1.0]])
    assert outline(moved(image, shift)) == pytest.approx(outline(image) + np.array([2.0, -1.0]))


def test_a_correction_moves_the_cameras_own_picture_as_well() -> None:
    image = SyntheticVision(rows_lot()).look(pose_at(5, 6), 1.0).lot
    to_image = np.array([[0.0, 20.0, 640.0], [-20.0, 0.0, 360.0], [0.001, 0.0, 1.0]])
    view = CameraView(np.zeros((720, 1280, 3), np.uint8), to_image)
    turn = np.array([[np.cos(0.2), -np.sin(0.2), 2.0], [np.sin(0.2), np.cos(0.2), -1.0]])
    corrected = moved(replace(image, view=view), turn).view
    assert corrected is not None
    place = np.array([3.0, 4.0, 1.0])
    assert corrected.to_image @ (*(turn @ place), 1.0) == pytest.approx(to_image @ place)
