from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="training needs the training extra")

from hawk.algo.vision.network import StallNetwork  # noqa: E402
from training.export import export  # noqa: E402
from training.loss import loss  # noqa: E402
from training.network import StallNet  # noqa: E402
from training.targets import CAR, CORE, CORE_WEIGHT, LOT, PLACE_WEIGHT, TAKEN, TARGET_CHANNELS  # noqa: E402

SMALL = (4, 4, 4, 4, 4)


def targets() -> Any:
    target = torch.zeros(1, TARGET_CHANNELS, 32, 32)
    target[:, [PLACE_WEIGHT, CORE_WEIGHT]] = 1
    target[:, LOT, :, :16] = 1
    target[:, CORE, 4:20, 4:20] = 1
    target[:, 3:9, 4:20, 4:20] = 0.3
    target[:, TAKEN, 4:20, 4:20] = 1
    return target


def perfect(target: Any) -> Any:
    answer = target[:, :10].clone()
    for channel in (LOT, CORE, CAR, TAKEN):
        answer[:, channel] = torch.where(target[:, channel] > 0.5, 12.0, -12.0)
    return answer


def test_a_perfect_answer_costs_nothing_and_each_fault_costs_something() -> None:
    target = targets()
    best, _ = loss(perfect(target), target)
    assert float(best) < 0.01
    for channel in range(10):
        wrong = perfect(target)
        wrong[:, channel] *= -1
        assert float(loss(wrong, target)[0]) > float(best) + 0.02


def test_what_is_not_judged_costs_nothing() -> None:
    target = targets()
    target[:, CORE_WEIGHT, 4:20, 4:20] = 0
    wrong = perfect(target)
    wrong[:, CORE, 4:20, 4:20] = -12
    wrong[:, 3:9] = 5
    assert float(loss(wrong, target)[0]) == pytest.approx(float(loss(perfect(target), target)[0]), abs=1e-4)


def test_the_size_and_shape_of_the_network() -> None:
    network = StallNet()
    assert sum(p.numel() for p in network.parameters()) <= 600_000
    with torch.no_grad():
        assert network.eval()(torch.zeros(2, 3, 64, 96)).shape == (2, 10, 32, 48)


def test_what_is_exported_runs_in_opencv_alike(tmp_path: Path) -> None:
    torch.manual_seed(0)
    path = tmp_path / "deep" / "small.onnx"
    difference = export(StallNet(SMALL), path)
    assert difference <= 1e-4
    picture = np.random.default_rng(0).integers(0, 255, (70, 100, 3), np.uint8)
    assert StallNetwork.load(path).run(picture).lot.shape == (35, 50)


def test_an_export_that_differs_is_refused_and_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("training.export.LARGEST_DIFFERENCE", -1.0)
    with pytest.raises(RuntimeError, match="differ"):
        export(StallNet(SMALL), tmp_path / "net.onnx")
    assert not (tmp_path / "net.onnx").exists()
