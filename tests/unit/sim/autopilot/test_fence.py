from __future__ import annotations

import pytest

from hawk.sim.autopilot.fence import Fence, FenceCommand, FenceError, FenceItem, FenceType, fence_words
from hawk.sim.autopilot.parameters import Parameters, copter_parameters

HOME = (0.0, 0.0, 0.0)
SQUARE = [(-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)]


def items(command: int, count: int, parameter: float | None = None) -> list[FenceItem]:
    return [FenceItem(command, count if parameter is None else parameter, 0.0, 0.0) for _ in range(count)]


def enabled(**values: float) -> Parameters:
    parameters = copter_parameters()
    for name, value in {"FENCE_ENABLE": 1.0, **values}.items():
        parameters.set(name, value)
    return parameters


def square() -> Fence:
    fence = Fence()
    fence.load(items(FenceCommand.INCLUSION_VERTEX, 4), SQUARE)
    return fence


def test_disabled_holds_everything() -> None:
    assert square().breaches((999.0, 0.0, -500.0), HOME, copter_parameters()) is FenceType.NONE


@pytest.mark.parametrize(
    ("place", "breach"),
    [
        ((0.0, 0.0, -50.0), FenceType.NONE),
        ((9.9, 9.9, -50.0), FenceType.NONE),
        ((11.0, 0.0, -50.0), FenceType.POLYGON),
        ((0.0, 0.0, -101.0), FenceType.ALT_MAX),
        ((400.0, 0.0, -101.0), FenceType.POLYGON | FenceType.CIRCLE | FenceType.ALT_MAX),
    ],
)
def test_each_limit_is_reported(place: tuple[float, float, float], breach: FenceType) -> None:
    assert square().breaches(place, HOME, enabled()) == breach


def test_only_the_types_asked_for_count() -> None:
    assert square().breaches((400.0, 0.0, -500.0), HOME, enabled(FENCE_TYPE=4)) == FenceType.POLYGON
    assert square().breaches((0.0, 0.0, 20.0), HOME, enabled(FENCE_TYPE=8)) == FenceType.ALT_MIN


def test_heights_count_from_home() -> None:
    assert square().breaches((0.0, 0.0, -101.0), (0.0, 0.0, -5.0), enabled()) is FenceType.NONE


def test_exclusions_and_circles() -> None:
    fence = Fence()
    fence.load(
        [*items(FenceCommand.INCLUSION_CIRCLE, 1, 30.0), *items(FenceCommand.EXCLUSION_CIRCLE, 1, 5.0)],
        [(0.0, 0.0), (20.0, 0.0)],
    )
    breached = [bool(fence.breaches((north, 0.0, -5.0), HOME, enabled())) for north in (0.0, 14.0, 20.0, 26.0, 31.0)]
    assert breached == [False, False, True, False, True]
    fence.load(items(FenceCommand.EXCLUSION_VERTEX, 4), SQUARE)
    assert fence.breaches((0.0, 0.0, -5.0), HOME, enabled()) == FenceType.POLYGON
    assert fence.breaches((15.0, 0.0, -5.0), HOME, enabled()) is FenceType.NONE


@pytest.mark.parametrize(
    "wrong",
    [
        items(FenceCommand.INCLUSION_VERTEX, 2),
        items(FenceCommand.INCLUSION_VERTEX, 3, 4.0),
        items(FenceCommand.INCLUSION_VERTEX, 3, float("nan")),
        [*items(FenceCommand.INCLUSION_VERTEX, 2, 3.0), *items(FenceCommand.EXCLUSION_VERTEX, 1, 3.0)],
        items(16, 1),
    ],
)
def test_a_wrong_upload_is_refused_and_the_old_fence_stays(wrong: list[FenceItem]) -> None:
    fence = square()
    with pytest.raises(FenceError):
        fence.load(wrong, SQUARE[: len(wrong)])
    assert fence.breaches((11.0, 0.0, -50.0), HOME, enabled()) == FenceType.POLYGON


def test_an_empty_upload_clears() -> None:
    fence = square()
    fence.load([], [])
    assert fence.breaches((200.0, 0.0, -50.0), HOME, enabled()) is FenceType.NONE
    assert fence.items == ()


def test_words_are_joined() -> None:
    assert fence_words(FenceType.ALT_MAX | FenceType.POLYGON) == "Max Alt and Polygon"
