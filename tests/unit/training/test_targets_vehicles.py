from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from hawk.algo.vision.network import VEHICLE_KINDS
from training.pool import training_scene
from training.scenes import SceneVehicle, draw_scene
from training.targets import (
    CORE_WEIGHT,
    KINDS,
    VEHICLE,
    VEHICLE_WEIGHT,
    VehicleLabels,
    draw_targets,
)


def box(x: float, y: float, length: float = 46.0, width: float = 19.0) -> list[list[float]]:
    half = (length / 2, width / 2)
    return [[x + sx * half[0], y + sy * half[1]] for sx, sy in ((1, 1), (1, -1), (-1, -1), (-1, 1))]


def drawn(vehicles: VehicleLabels | None, known: int = 1) -> np.ndarray:
    labels, none = np.zeros((128, 160, 4), np.uint8), np.zeros(0, np.bool_)
    seen = np.full((128, 160), known, np.uint8)
    return draw_targets(labels, seen, np.zeros((0, 4, 2)), none, none, None, vehicles)


def of(*boxes: list[list[float]], kind: int = 0, judged: bool = True) -> VehicleLabels:
    return VehicleLabels(
        np.array(boxes, np.float32).reshape(-1, 4, 2), np.full(len(boxes), kind), np.full(len(boxes), judged)
    )


def test_bumper_to_bumper_cars_have_two_cores() -> None:
    target = drawn(of(box(40, 60), box(88, 60)))
    row = target[VEHICLE, 30]
    assert np.flatnonzero(np.diff(row)).size == 4  # two starts, two ends
    assert target[VEHICLE].sum() == pytest.approx(2 * 0.74**2 * 46 * 19 / 4, rel=0.1)


@pytest.mark.parametrize("kind", range(len(VEHICLE_KINDS)))
def test_a_core_says_its_kind_and_nothing_else_does(kind: int) -> None:
    target = drawn(of(box(60, 60), kind=kind))
    core = target[VEHICLE] > 0
    assert (target[KINDS + kind] > 0).sum() == core.sum()
    others = [k for k in range(len(VEHICLE_KINDS)) if k != kind]
    assert not target[[KINDS + k for k in others]].any()


def test_what_may_be_one_or_none_is_not_judged() -> None:
    target = drawn(of(box(60, 60), judged=False))
    assert not target[VEHICLE].any()
    assert (target[VEHICLE_WEIGHT] == 0).sum() == pytest.approx(46 * 19 / 4, rel=0.15)
    assert target[CORE_WEIGHT].all()  # stalls are known there


def test_nothing_is_judged_where_nobody_labelled_vehicles_or_ground_is_missing() -> None:
    assert not drawn(None)[VEHICLE_WEIGHT].any()
    assert not drawn(of(box(60, 60)), known=0)[VEHICLE_WEIGHT].any()


@pytest.mark.slow
def test_drawn_vehicles_lie_where_the_picture_shows_cars() -> None:
    shares = []
    for seed in range(6):
        scene = draw_scene(np.random.default_rng((41, seed)), 320)
        for one in scene.vehicles:
            inside = _inside(one, scene.car.shape)
            if one.covered < 0.1 and inside.sum() > 300:
                shares.append(scene.car[inside].mean())
    assert len(shares) > 8
    assert np.median(shares) > 0.85


def _inside(vehicle: SceneVehicle, shape: tuple[int, ...]) -> np.ndarray:

    mask = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(mask, np.round(vehicle.quad).astype(np.int32), 1)
    return mask > 0


def test_motorcycles_and_hidden_vehicles_are_not_judged() -> None:
    scene = draw_scene(np.random.default_rng(3), 64)
    quad = np.array(box(30, 30))
    given = (SceneVehicle(quad, "sedan", 0.0), SceneVehicle(quad, "motorcycle", 0.0), SceneVehicle(quad, "coach", 0.9))
    kept = training_scene(replace(scene, vehicles=given))
    assert kept.vehicles is not None
    assert kept.vehicles.judged.tolist() == [True, False, False]
    assert VEHICLE_KINDS[kept.vehicles.kind[2]] == "lorry"
