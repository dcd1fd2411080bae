"""A widened network gives the same answer as the narrow one, and learns with its new channels."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="training needs the training extra")

from hawk.algo.vision.network import StallNetwork  # noqa: E402
from training.export import export  # noqa: E402
from training.network import StallNet  # noqa: E402
from training.resume import widths_of_onnx  # noqa: E402
from training.widen import WidenError, main, widen, widths_of_state  # noqa: E402

NARROW, WIDE = (4, 6, 4, 8, 4), (4, 8, 10, 8, 12)


def seen(network: StallNet) -> StallNet:
    """Return it after some pictures, so that its normalisations differ from new ones."""
    network.train()
    for _ in range(5):
        network(torch.randn(4, 3, 64, 64), torch.randn(4, 2))
    network.eval()
    return network


def test_the_wider_network_answers_as_before() -> None:
    torch.manual_seed(1)
    narrow, wide = seen(StallNet(NARROW)), StallNet(WIDE)
    widen(narrow, wide)
    picture = torch.randn(2, 3, 64, 96)
    with torch.no_grad():
        sun = torch.randn(2, 2)
        np.testing.assert_allclose(wide.eval()(picture, sun).numpy(), narrow(picture, sun).numpy(), atol=1e-5)
    assert widths_of_state(wide.state_dict()) == WIDE


def test_new_channels_learn() -> None:
    torch.manual_seed(2)
    wide = StallNet(WIDE)
    widen(seen(StallNet(NARROW)), wide)
    taken_of_new = wide.down4[0][0].weight.detach()[: NARROW[3], NARROW[2] :].clone()
    assert float(taken_of_new.abs().max()) == 0.0
    wide.train()(torch.randn(2, 3, 64, 64), torch.zeros(2, 2)).square().mean().backward()
    gradient = wide.down4[0][0].weight.grad
    assert gradient is not None
    assert float(gradient[:, NARROW[2] :].abs().max()) > 0.0


def test_of_equal_widths_it_is_a_copy() -> None:
    first, second = seen(StallNet(NARROW)), StallNet(NARROW)
    widen(first, second)
    assert all(
        torch.equal(value, second.state_dict()[name])
        for name, value in first.state_dict().items()
        if value.dtype.is_floating_point
    )


def test_a_narrower_network_is_refused_with_both_widths() -> None:
    with pytest.raises(WidenError, match=r"\(4, 6, 4, 8, 4\) has fewer channels than \(4, 8, 10, 8, 12\)"):
        widen(StallNet(WIDE), StallNet(NARROW))


def test_an_exported_file_says_its_widths(tmp_path: Path) -> None:
    pytest.importorskip("onnx", reason="training needs the training extra")
    from training.resume import widths_of_onnx

    export(seen(StallNet(WIDE)), tmp_path / "wide.onnx")
    assert widths_of_onnx(tmp_path / "wide.onnx") == WIDE


def test_the_command_writes_a_network_that_answers_as_the_narrow_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    torch.manual_seed(4)
    narrow, small, large = seen(StallNet(NARROW)), tmp_path / "narrow.onnx", tmp_path / "wide.onnx"
    export(narrow, small)
    main([str(small), "--widths", ",".join(map(str, WIDE)), "--seed", "3", "--out", str(large)])
    assert widths_of_onnx(large) == WIDE
    picture = np.random.default_rng(0).integers(0, 256, (64, 96, 3), np.uint8)
    before, after = (StallNetwork(path.read_bytes()).run(picture) for path in (small, large))
    np.testing.assert_allclose(after.core, before.core, atol=1e-4)
    with pytest.raises(SystemExit):
        main([str(large), "--widths", ",".join(map(str, NARROW)), "--out", str(small)])
    assert "has fewer channels" in capsys.readouterr().err
