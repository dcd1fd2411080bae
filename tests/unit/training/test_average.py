from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="training needs the training extra")

from hawk.algo.vision.network import StallNetwork  # noqa: E402
from training.average import average, main  # noqa: E402
from training.network import StallNet  # noqa: E402


def test_the_average_of_states_is_the_mean_of_each_weight_and_keeps_whole_numbers_whole() -> None:
    one = {"weight": torch.tensor([1.0, 2.0]), "batches": torch.tensor(10)}
    two = {"weight": torch.tensor([3.0, 6.0]), "batches": torch.tensor(20)}
    mean = average([one, two])
    assert mean["weight"].tolist() == [2.0, 4.0]
    assert mean["batches"].item() == 15
    assert mean["batches"].dtype == one["batches"].dtype


def test_states_of_different_networks_are_refused() -> None:
    with pytest.raises(ValueError, match="different networks"):
        average([{"weight": torch.zeros(2)}, {"weight": torch.zeros(3)}])
    with pytest.raises(ValueError, match="at least one"):
        average([])


def test_the_command_writes_a_network_that_runs(tmp_path: Path) -> None:
    files = []
    for seed in (1, 2):
        torch.manual_seed(seed)
        files.append(tmp_path / f"{seed}.pt")
        torch.save(StallNet().state_dict(), files[-1])
    out = tmp_path / "mean.onnx"
    main([*map(str, files), "--out", str(out)])
    assert StallNetwork.load(out).run(np.zeros((64, 96, 3), np.uint8)).core.shape == (32, 48)
