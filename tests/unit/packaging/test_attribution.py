"""Everyone who gets the weights is shown whose pictures and labels they were trained on."""

from __future__ import annotations

import tomllib
from pathlib import Path

from tests.sweep import sweep

ROOT = Path(__file__).parents[3]
CREDITS = (
    "Beeldmateriaal Nederland",
    "beeldmateriaal.nl",
    "CC BY 4.0",
    "ParkingSpaceDetection",
    "Pascal Dubbelman",
    "MIT",
)


@sweep("place", ["NOTICE", "docs/model-card.md", "debian/copyright"])
@sweep("credit", CREDITS)
def test_pictures_and_labels_are_credited(place: str, credit: str) -> None:
    assert credit in (ROOT / place).read_text(encoding="utf-8")


def test_the_wheel_carries_the_notice() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert "NOTICE" in project["license-files"]
