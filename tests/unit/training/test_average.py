from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

torch = pytest.importorskip("torch", reason="training needs the training extra")

from hawk.algo.vision.network import StallNetwork  # noqa: E402
from training.average import average, main  # noqa: E402
from training.export import export  # noqa: E402
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


def test_exported_networks_average_as_they_answer(tmp_path: Path) -> None:
    files = [tmp_path / "before.onnx", tmp_path / "after.onnx"]
    torch.manual_seed(1)
    network = StallNet((4, 6, 4, 8, 4))
    network.train()(torch.randn(4, 3, 64, 64), torch.zeros(4, 2))  # without it all normalisations are alike
    export(network, files[0])
    with torch.no_grad():
        network.answer.bias += 2.0
    export(network, files[1])
    out = tmp_path / "mean.onnx"
    main([*map(str, files), "--out", str(out)])
    picture = np.random.default_rng(1).integers(0, 255, (64, 96, 3), np.uint8)
    before, mean = (raw(path, picture) for path in (files[0], out))
    np.testing.assert_allclose(mean[:, :10], before[:, :10] + 1.0, atol=1e-4)
    np.testing.assert_allclose(mean[:, 10:], before[:, 10:], atol=1e-4)


def test_exported_networks_and_torch_weights_do_not_mix(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["a.onnx", "b.pt", "--out", str(tmp_path / "mean.onnx")])
    assert "not both" in capsys.readouterr().err


def raw(path: Path, picture: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the maps of an exported network."""
    loaded = cv2.dnn.readNetFromONNX(str(path))
    loaded.setInput(cv2.dnn.blobFromImage(picture, 1 / 255, mean=(127.5, 127.5, 127.5)), "image")
    loaded.setInput(np.array([[0.4, -0.2]], np.float32), "sun")
    return np.asarray(loaded.forward(), np.float32)
