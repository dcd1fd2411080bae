from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="training needs the training extra")

from hawk.algo.vision.network import StallNetwork  # noqa: E402
from training.augment import sample  # noqa: E402
from training.export import export  # noqa: E402
from training.loss import loss  # noqa: E402
from training.network import StallNet  # noqa: E402
from training.settings import TrainingPlan  # noqa: E402
from training.targets import (  # noqa: E402
    ANSWER_CHANNELS,
    CAR,
    CORE,
    CORE_WEIGHT,
    COVER,
    KINDS,
    LABELS,
    LOT,
    PLACE_WEIGHT,
    SHADE,
    TAKEN,
    TARGET_CHANNELS,
    VEHICLE,
    VEHICLE_WEIGHT,
    TrainingScene,
)
from training.train import Batch, learn, train  # noqa: E402

SMALL = (4, 4, 4, 4, 4)


def targets() -> Any:
    target = torch.zeros(1, TARGET_CHANNELS, 32, 32)
    target[:, PLACE_WEIGHT : VEHICLE_WEIGHT + 1] = 1
    target[:, LOT, :, :16] = 1
    target[:, CORE, 4:20, 4:20] = 1
    target[:, 3:9, 4:20, 4:20] = 0.3
    target[:, TAKEN, 4:20, 4:20] = 1
    target[:, VEHICLE, 6:18, 6:18] = 1
    target[:, VEHICLE + 1 : KINDS, 6:18, 6:18] = 0.3
    target[:, KINDS + 1, 6:18, 6:18] = 1
    return target


def perfect(target: Any) -> Any:
    answer = target[:, :ANSWER_CHANNELS].clone()
    for channel in (LOT, CORE, CAR, TAKEN, SHADE, COVER, VEHICLE, *range(KINDS, ANSWER_CHANNELS)):
        answer[:, channel] = torch.where(target[:, channel] > 0.5, 12.0, -12.0)
    return answer


def test_a_perfect_answer_costs_nothing_and_each_fault_costs_something() -> None:
    target = targets()
    best, _ = loss(perfect(target), target)
    assert float(best) < 0.01
    for channel in (*range(KINDS), KINDS + 1):
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
        assert network.eval()(torch.zeros(2, 3, 64, 96), torch.zeros(2, 2)).shape == (2, ANSWER_CHANNELS, 32, 48)


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


class SetPool:
    """A pool of one scene that counts what is asked of it."""

    def __init__(self) -> None:
        image = np.full((100, 100, 3), 90, np.uint8)
        image[:, ::26] = 220
        quads = np.array([[(26, 20), (52, 20), (52, 72), (26, 72)]], np.float32)
        labels = np.ones((100, 100, LABELS), np.uint8)
        self.scene = TrainingScene(image, labels, quads, np.array([True]), np.array([True]))
        self.drawn = 1
        self.asked: list[int] = []

    def __len__(self) -> int:
        return 1

    def __getitem__(self, index: int) -> TrainingScene:
        return self.scene

    def take(self, at_most: int) -> None:
        self.drawn += at_most

    def take_until(self, drawn: int) -> None:
        self.asked.append(drawn)
        self.drawn = max(self.drawn, drawn)


def test_training_ends_in_time_moves_the_weights_and_keeps_them_now_and_then() -> None:
    torch.manual_seed(0)
    network, pool = StallNet(SMALL), SetPool()
    before = network.answer.weight.detach().clone()
    seconds = iter(range(10_000))
    kept: list[StallNet] = []
    plan = TrainingPlan(minutes=0.2, seed=0, batch=2, side=64, bfloat16=False, report_steps=8)
    trained = train(plan, network, pool, kept.append, lambda: float(next(seconds)))  # type: ignore[arg-type]
    assert next(seconds) < 20  # one look at the clock a step, and one more for a report
    assert len(kept) == 1
    assert not torch.equal(trained.answer.weight, before)
    assert not trained.training
    assert pool.drawn * plan.reuse >= 10 * plan.batch


def test_the_same_seed_trains_the_same_weights() -> None:
    weights = []
    for _ in range(2):
        torch.manual_seed(3)
        seconds = iter(range(1000))
        plan = TrainingPlan(minutes=0.1, seed=3, batch=2, side=64, bfloat16=False)
        trained = train(plan, StallNet(SMALL), SetPool(), clock=lambda s=seconds: float(next(s)))  # type: ignore[arg-type,misc]
        weights.append(trained.answer.weight.detach())
    assert torch.equal(*weights)


def test_a_number_of_steps_is_trained_whatever_the_clock_says_and_each_has_its_scenes() -> None:
    weights, pools = [], [SetPool(), SetPool()]
    for pool, tick in zip(pools, (1.0, 1000.0), strict=True):
        torch.manual_seed(3)
        seconds = (tick * k for k in range(1000))
        plan = TrainingPlan(minutes=1, seed=3, steps=12, batch=2, side=64, bfloat16=False, first_scenes=0, reuse=4)
        trained = train(plan, StallNet(SMALL), pool, clock=lambda s=seconds: next(s))  # type: ignore[arg-type,misc]
        weights.append(trained.answer.weight.detach())
    assert torch.equal(*weights)
    assert pools[0].asked == pools[1].asked == [0] + [step * 2 // 4 for step in range(12)]


def test_the_answer_is_the_mean_of_the_planned_states() -> None:
    states: list[Any] = []

    def trained(averaged: tuple[float, ...]) -> Any:
        torch.manual_seed(3)
        plan = TrainingPlan(
            minutes=1, seed=3, steps=8, batch=2, side=64, bfloat16=False, averaged=averaged, report_steps=1
        )
        return train(
            plan,
            StallNet(SMALL),
            SetPool(),  # type: ignore[arg-type]
            lambda mean: states.append(mean.answer.weight.detach().clone()),
        ).answer.weight.detach()

    mean = trained((0.5, 1.0))
    assert not torch.equal(states[3], states[7])
    torch.testing.assert_close(mean, (states[3] + states[7]) / 2)
    torch.testing.assert_close(trained((1.0,)), states[7])


def test_an_exported_network_is_taken_up_as_it_is_and_trains_on(tmp_path: Path) -> None:
    pytest.importorskip("onnx", reason="training needs the training extra")
    from training.resume import ResumeError, load_onnx

    torch.manual_seed(3)
    first, second = StallNet(SMALL), StallNet(SMALL)
    pictures, suns = torch.randn(6, 3, 64, 64) * 0.2, torch.randn(6, 2) * 0.5
    for lit in first.lit:
        torch.nn.init.normal_(lit.out.weight, std=0.3)
    first.train()
    for _ in range(20):  # so that there is something to fold
        first(pictures, suns)
    first.eval()
    export(first, tmp_path / "first.onnx")
    load_onnx(second, tmp_path / "first.onnx", pictures)
    with torch.no_grad():
        said = first(pictures, suns)
        np.testing.assert_allclose(second.eval()(pictures, suns).numpy(), said.numpy(), atol=1e-4)
        assert not torch.equal(second(pictures, suns), second(pictures, 0 * suns))
        dark = first(pictures, 0 * suns)
        near = second.train()(pictures, 0 * suns) - dark
    assert float(near.abs().mean()) < 0.1 * float(dark.abs().mean())
    with pytest.raises(ResumeError, match="train from the beginning"):
        load_onnx(StallNet(), tmp_path / "first.onnx", pictures)


class OlderNet(StallNet):
    """A network of before there were vehicles."""

    def forward(self, picture: Any, sun: Any) -> Any:
        """Return stalls, shade and cover."""
        half = self.features(picture, sun).half
        return torch.cat([self.answer(half), self.further(half)], 1)


def test_a_file_without_vehicles_is_taken_up_and_its_weights_are_written_again_to_the_bit(tmp_path: Path) -> None:
    onnx = pytest.importorskip("onnx", reason="training needs the training extra")
    from training.resume import folded_network

    torch.manual_seed(4)
    older = OlderNet(SMALL).train()
    for _ in range(5):
        older(torch.randn(4, 3, 64, 64), torch.randn(4, 2))
    export(older.eval(), tmp_path / "older.onnx")
    export(folded_network(tmp_path / "older.onnx"), tmp_path / "newer.onnx")
    before, after = (
        {onnx.numpy_helper.to_array(one).tobytes() for one in onnx.load(tmp_path / name).graph.initializer}
        for name in ("older.onnx", "newer.onnx")
    )
    assert before <= after
    picture = np.random.default_rng(0).integers(0, 256, (64, 96, 3), np.uint8)
    first, second = (StallNetwork.load(tmp_path / name).run(picture) for name in ("older.onnx", "newer.onnx"))
    assert first.vehicles is None
    assert second.vehicles is not None
    np.testing.assert_array_equal(first.core, second.core)
    np.testing.assert_array_equal(first.cover, second.cover)


DEVICES = ["cpu", pytest.param("cuda", marks=pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU"))]


def first_loss(device: str, *, bfloat16: bool) -> float:
    """Return the loss of the first step from seed 5, on a batch that follows from the seed alone."""
    torch.manual_seed(5)
    network = StallNet().to(device).train()
    scene, rng = SetPool().scene, np.random.default_rng(5)
    samples = [sample(scene, rng, 64) for _ in range(4)]
    parts = (torch.from_numpy(np.stack([getattr(s, name) for s in samples])) for name in ("picture", "target", "sun"))
    picture, target, sun = parts
    batch = Batch(picture, target, sun, (2, 3))
    return learn(network, torch.optim.AdamW(network.parameters(), 1e-3), batch, bfloat16=bfloat16)["total"]


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("bfloat16", [False, True])
def test_every_device_and_precision_begins_with_the_same_loss(device: str, bfloat16: bool) -> None:
    """bfloat16 has 8 bits: 2^-8 a product, some of it cancels over 64 and more inputs."""
    reference = first_loss("cpu", bfloat16=False)
    assert first_loss(device, bfloat16=bfloat16) == pytest.approx(reference, rel=2**-8 if bfloat16 else 1e-4)
