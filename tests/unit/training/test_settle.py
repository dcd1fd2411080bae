from __future__ import annotations

import pytest

torch = pytest.importorskip("torch", reason="training needs the training extra")

from training.network import StallNet  # noqa: E402
from training.settle import settle  # noqa: E402

SMALL = (4, 4, 4, 4, 4)


def test_the_first_normalisation_holds_the_statistics_of_what_it_is_given() -> None:
    torch.manual_seed(1)
    network = StallNet(SMALL)
    pictures = [(torch.randn(4, 3, 64, 64) * 0.3 + 0.1, torch.zeros(4, 2)) for _ in range(5)]
    settled = settle(network, pictures)
    convolution, normalisation = settled.down1[0][0], settled.down1[0][1]
    with torch.no_grad():
        means = torch.stack([convolution(picture).mean((0, 2, 3)) for picture, _ in pictures])
    torch.testing.assert_close(normalisation.running_mean, means.mean(0))
    assert int(normalisation.num_batches_tracked) == 5
    assert not settled.training


def test_the_weights_stay_as_they_are() -> None:
    torch.manual_seed(1)
    network = StallNet(SMALL)
    before = {name: value.clone() for name, value in network.named_parameters()}
    settle(network, [(torch.randn(2, 3, 64, 64), torch.zeros(2, 2))])
    for name, value in network.named_parameters():
        assert torch.equal(value, before[name])
