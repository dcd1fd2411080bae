"""The recall that photographs lose, and what a folder's figures are made of."""

from __future__ import annotations

import math

import pytest

from benchmarks.pictures.photos import Judged, photo_figures, pooled_recall, recall_loss


def report(recall: float, true: float, found: float = 10.0, p95: float = 0.2) -> dict[str, float]:
    return {"stall_recall": recall, "true_stalls": true, "found_stalls": found, "position_error_p95_m": p95}


def judged(measures: dict[str, float], *, is_in_range: bool = True) -> Judged:
    return Judged("one", measures, is_in_range, 0.1, 5, 6, 12.0, math.radians(-0.2), 1.01)


def test_a_large_place_counts_by_its_stalls() -> None:
    assert pooled_recall([report(1.0, 90), report(0.5, 10)]) == pytest.approx(0.95)
    assert pooled_recall([]) is None


def test_recall_lost_is_that_of_the_flights_less_that_of_the_photographs() -> None:
    lost = recall_loss([report(0.90, 100)], [report(0.95, 100)])
    assert lost.value == pytest.approx(0.05)
    assert lost.passed is False
    gained = recall_loss([report(0.96, 100)], [report(0.95, 100)])
    assert gained.passed is True
    assert gained.reference is not None
    assert gained.reference.value == pytest.approx(0.95)


def test_figures_are_of_all_folders_together() -> None:
    folders = [judged(report(1.0, 10, 10)), judged(report(0.8, 10, 10, p95=0.9), is_in_range=False)]
    by_key = {figure.key: figure for figure in photo_figures(folders, "photos_", "drawn", is_drawn=True)}
    assert by_key["photos_f1"].value == pytest.approx(0.9)
    assert by_key["photos_f1"].passed is False
    assert by_key["photos_in_range"].value == pytest.approx(0.5)
    assert by_key["photos_p95_worst_m"].value == pytest.approx(0.9)
    assert by_key["photos_adjusted"].value == pytest.approx(10 / 12)
    assert by_key["photos_turn_deg"].value == pytest.approx(0.2)
    assert photo_figures([], "photos_", "drawn", is_drawn=True) == []
