"""The head for vehicles learns alone: from what is not left out, and without a change to what is said of stalls."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="training needs the training extra")

from benchmarks.cars.labels import truth_of  # noqa: E402 - after torch
from benchmarks.cars.scenes import CarScene  # noqa: E402
from hawk.algo.vision.network import StallNetwork  # noqa: E402
from tests.unit.benchmarks.test_cars import box  # noqa: E402
from training.export import export  # noqa: E402
from training.network import StallNet  # noqa: E402
from training.targets import LABELS, TrainingScene  # noqa: E402
from training.vehicle_head import BATCH, REAL, Pupil, draw_batch, pupils_of, train, vehicle_region  # noqa: E402

SMALL = (4, 4, 4, 4, 4)
SIDE = 64


class OneScene:
    """A pool of one drawn scene."""

    drawn = 1

    def __len__(self) -> int:
        return 1

    def __getitem__(self, index: int) -> TrainingScene:
        nothing = np.zeros(0, np.bool_)
        image, labels = np.full((200, 200, 3), 90, np.uint8), np.zeros((200, 200, LABELS), np.uint8)
        return TrainingScene(image, labels, np.zeros((0, 4, 2), np.float32), nothing, nothing)

    def take_until(self, drawn: int) -> None:
        self.drawn = drawn


def regions() -> list[object]:
    image = np.random.default_rng(3).integers(0, 255, (500, 500, 3)).astype(np.uint8)
    vehicles = truth_of([box(20, 20), box(30, 30, ground="crown"), box(24, 31, kerb=True), box(40, 9, unsure=True)])
    return [vehicle_region(CarScene(name, image, 0.1, vehicles)) for name in ("a", "b", "c", "d")]


def test_a_region_knows_its_vehicles_and_nothing_else() -> None:
    region = regions()[0]
    scene = region.scene  # type: ignore[attr-defined]
    assert scene.image.shape == (499, 499, 3)
    assert len(scene.quads) == 0
    np.testing.assert_allclose(scene.vehicles.quads.mean(1)[0], (199.5, 199.5))
    assert scene.vehicles.judged.tolist() == [True, True, True, False]
    assert region.share.tolist() == [0.125, 0.5, 0.25, 0.125]  # type: ignore[attr-defined]


def test_every_region_is_left_out_once() -> None:
    pupils = pupils_of(StallNet(SMALL).vehicles, ["a", "b", "c", "d", "e"], 3)
    assert [pupil.name for pupil in pupils] == ["all", "fold-0", "fold-1", "fold-2"]
    assert [sorted(pupil.left_out) for pupil in pupils] == [[], ["a", "d"], ["b", "e"], ["c"]]


def test_a_batch_names_the_region_of_each_picture_and_ends_with_a_pair() -> None:
    seen = set()
    for seed in range(6):
        batch = draw_batch(OneScene(), regions(), np.random.default_rng(seed), SIDE)  # type: ignore[arg-type]
        assert batch.picture.shape == (BATCH, 3, SIDE, SIDE)
        assert batch.regions[-1] == batch.regions[-2]
        seen.add(batch.regions[-1] is None)
        columns, rows = batch.cells
        torch.testing.assert_close(
            batch.picture[-2, :, 2 * rows :, 2 * columns :],
            batch.picture[-1, :, : SIDE - 2 * rows, : SIDE - 2 * columns],
        )
    assert seen == {True, False}, "pairs of drawn and of real ground"
    assert REAL < BATCH


def test_a_pupil_learns_nothing_from_what_it_leaves_out() -> None:
    network = StallNet(SMALL).eval()
    batch = draw_batch(OneScene(), regions()[:1], np.random.default_rng(0), SIDE)  # type: ignore[arg-type]
    changed = batch.picture.clone()
    changed[[name == "a" for name in batch.regions]] = 0.3
    weights = []
    for picture in (batch.picture, changed):
        torch.manual_seed(0)
        pupil = Pupil.of("fold", ["a"], network.vehicles)
        with torch.no_grad():
            features = network.features(picture, batch.sun)
        pupil.learn(features, batch, 0.1, 60)
        weights.append(pupil.head.about[0].weight.detach())
    assert not torch.equal(weights[0], network.vehicles.about[0].weight)
    assert torch.equal(*weights)


def test_stalls_are_the_same_to_the_bit_after_the_training(tmp_path: Path) -> None:
    torch.manual_seed(0)
    network = StallNet(SMALL).eval()
    export(network, tmp_path / "before.onnx")
    pupils = pupils_of(network.vehicles, ["a", "b", "c", "d"], 1)
    train(network, pupils, OneScene(), regions(), 3, 0)  # type: ignore[arg-type]
    network.vehicles = pupils[0].mean
    export(network, tmp_path / "after.onnx")
    picture = np.random.default_rng(1).integers(0, 256, (64, 96, 3), np.uint8)
    before, after = (StallNetwork.load(tmp_path / f"{name}.onnx").run(picture) for name in ("before", "after"))
    for name in ("lot", "core", "car", "taken", "shade", "cover", "width", "sine"):
        np.testing.assert_array_equal(getattr(before, name), getattr(after, name))
    assert before.vehicles is not None
    assert after.vehicles is not None
    assert not np.array_equal(before.vehicles.core, after.vehicles.core)
