from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

torch = pytest.importorskip("torch", reason="training needs the training extra")

import training.train  # noqa: E402
from tests.unit.training.test_train import SMALL, SetPool  # noqa: E402
from training.checkpoint import CheckpointError, CheckpointFile  # noqa: E402
from training.export import export  # noqa: E402
from training.network import StallNet  # noqa: E402
from training.settings import TrainingPlan  # noqa: E402
from training.train import train  # noqa: E402


def trained(path: Path, steps: int, network: StallNet | None = None) -> tuple[StallNet, SetPool]:
    plan = TrainingPlan(minutes=1, seed=0, steps=steps, batch=2, side=64, bfloat16=False, report_steps=2)
    pool = SetPool()
    made = train(plan, network or StallNet(SMALL), pool, checkpoint=CheckpointFile(path))  # type: ignore[arg-type]
    return made, pool


def test_a_training_goes_on_where_it_was_ended(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    torch.manual_seed(0)
    path = tmp_path / "training.pt"
    trained(path, 4)
    again, _ = trained(path, 8)
    lines = [line.split()[1] for line in capsys.readouterr().out.splitlines() if line.startswith("step")]
    assert lines == ["2", "4", "6", "8"]
    assert not again.training
    assert CheckpointFile(path).drawn() >= 1


def test_without_a_file_it_begins_at_the_beginning(tmp_path: Path) -> None:
    assert CheckpointFile(tmp_path / "none.pt").drawn() == 0


def test_the_checkpoint_of_another_network_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "training.pt"
    trained(path, 2)
    with pytest.raises(CheckpointError, match="another network"):
        trained(path, 4, StallNet((4, 4, 4, 4, 8)))


class EmptyPool(SetPool):
    """As the painter's pool: one that goes on holds no scene until a new one was drawn."""

    def __init__(self, *_: Any, drawn: int = 0, dress: object = None) -> None:
        super().__init__()
        self.drawn, self.first = drawn, drawn

    def __len__(self) -> int:
        return int(self.drawn > self.first)

    def close(self) -> None:
        """Hold no process."""


def test_a_training_from_given_weights_goes_on_from_its_checkpoint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(training.train, "ScenePool", EmptyPool)
    start, kept = tmp_path / "start.onnx", tmp_path / "training.pt"
    given = StallNet(SMALL).eval()
    with torch.no_grad():
        for weights in given.parameters():
            weights.add_(0.1 * torch.randn_like(weights))
    export(given, start)
    settings = ["--start-from", start, "--checkpoint", kept, "--crop", "64", "--batch", "2", "--float32"]
    for steps in (100, 200):
        training.train.main(
            [*map(str, settings), "--widths", "4,4,4,4,8", "--steps", str(steps), "--out", str(tmp_path / "o.onnx")]
        )
    lines = [line.split()[1] for line in capsys.readouterr().out.splitlines() if line.startswith("step")]
    assert lines == ["100", "200"]
