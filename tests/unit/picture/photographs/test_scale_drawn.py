"""Scales that witnesses choose, and the questions where they differ."""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from itertools import product
from pathlib import Path
from typing import Any

from hawk.picture.photographs.scale import (
    HeightPrior,
    ScaleEstimate,
    by_height,
    by_places,
    by_stalls,
    choose_scale,
    fitting_height,
    middle_height,
    scale_poses,
)
from hawk.picture.values import PictureError
from tests.golden import check_values
from tests.unit.picture.photographs.test_scale import drawn

HERE = Path(__file__).parent / "scale_drawn"
PLACES = {
    "none": None,
    "sure": ScaleEstimate(1.02, 0.02, 0.01),
    "other": ScaleEstimate(1.4, 0.03, 0.02),
    "poor": ScaleEstimate(1.3, 0.1, 0.1),
}
SAID = {
    "files": HeightPrior(),
    "given": HeightPrior(55.0),
    "doubted": HeightPrior(doubt="a gives no height"),
    "none": HeightPrior(is_none=True),
}
STALLS = {"none": None, "as the height": ScaleEstimate(1.0, 0.08), "as other places": ScaleEstimate(1.42, 0.08)}


def _plain(value: Any) -> Any:
    if hasattr(value, "__dataclass_fields__"):
        return {key: _plain(each) for key, each in asdict(value).items()}
    return ("inf" if math.isinf(value) else round(value, 6)) if isinstance(value, float) else value


def test_every_choice_between_witnesses() -> None:
    found, height = {}, ScaleEstimate(1.0, 0.05)
    for places, said, stalls in product(PLACES, SAID, STALLS):
        looked: list[float] = []

        def look(factor: float, stalls: str = stalls, looked: list[float] = looked) -> ScaleEstimate | None:
            looked.append(round(factor, 3))
            return STALLS[stalls]

        try:
            scale = _plain(choose_scale("yard", PLACES[places], height, SAID[said], 60.0, look))
        except PictureError as question:
            scale = str(question)
        found[f"places {places}, height {said}, stalls {stalls}"] = [scale, looked]
    check_values(HERE / "choices.json", found, digits=6)


def test_what_witnesses_say() -> None:
    found: dict[str, Any] = {}
    for seed, lanes, count in ((1, 2, 3), (2, 3, 6), (3, 1, 2)):
        flight = drawn(seed, None, lanes, count)
        timeless = [replace(shot, time=None) for shot in flight.shots]
        found[f"{lanes} by {count}"] = [
            _plain(each)
            for each in (
                by_places(flight.shots, flight.known, flight.adjusted),
                by_places(timeless, flight.known, flight.adjusted),
                *(by_height(flight.known, flight.adjusted, lens_is_known=known) for known in (True, False)),
                middle_height(flight.adjusted),
                scale_poses(flight.adjusted, 1.25).posed[1].north,
            )
        ]
    found["stalls"] = [_plain(by_stalls([2.4] * count)) for count in (5, 6)]
    found["metres"] = [round(each, 6) for each in ScaleEstimate(1.1, 0.04).metres(50.0)]
    pairs = ((1.0, 0.05, 1.2, 0.02), (1.0, 0.05, 1.11, 0.02), (1.0, 0.08, 1.2, 0.05))
    found["differ"] = [ScaleEstimate(a, b).differs(ScaleEstimate(c, d)) for a, b, c, d in pairs]
    found["fitting"] = [
        fitting_height(PLACES["sure"], STALLS[stalls], metres) for stalls in STALLS for metres in (15.0, 19.9, 60.4)
    ]
    check_values(HERE / "witnesses.json", found, digits=6)
