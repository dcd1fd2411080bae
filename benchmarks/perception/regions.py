"""Regions without outlines of lots and without states: where stalls are found, by setting and by kind of ground.

A region is a picture of a lot or of streets with labelled stalls; parts of the picture may be missing. Without an
outline every unmatched find is a false alarm, because nothing shows stalls that nobody labelled: the true precision is
no lower.
"""

from __future__ import annotations

from argparse import ArgumentTypeError
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Final

from benchmarks.figures import Figure, Section
from benchmarks.perception.measures import Looked, pooled
from benchmarks.perception.places import Place, read_lots

SHOWN: Final = (
    "recall",
    "recall_whole",
    "precision",
    "f1",
    "labels",
    "labels_cut",
    "suggested",
    "suggested_labelled",
    "recall_with_suggested",
)


@dataclass(frozen=True, slots=True)
class Regions:
    """A folder of regions. ``streets``: patterns of names of those that are streets, the others are lots;
    ``left_out``: networks with a pattern of the names of the regions that they were not trained on.
    """

    folder: Path
    streets: tuple[str, ...] = ()
    left_out: tuple[tuple[Path, str], ...] = ()

    def read(self) -> list[Place]:
        """Return the regions. Raises ValueError for a pattern that fits no region."""
        places = list(read_lots(self.folder))
        for pattern in (*self.streets, *(pattern for _, pattern in self.left_out)):
            if not any(fnmatchcase(place.name, pattern) for place in places):
                raise ValueError(f"{pattern!r} fits no region of {self.folder}; name one of its files without .json")
        return places

    def is_street(self, name: str) -> bool:
        """Return True for a region that is streets, not a lot."""
        return any(fnmatchcase(name, pattern) for pattern in self.streets)

    def model(self, name: str) -> Path | None:
        """Return the network that was not trained on a region, None where no other is named."""
        return model_for(self.left_out, name)


def region_section(regions: Regions, looked: Sequence[Looked]) -> Section:
    """Return the rows: all regions, lots, streets, and each kind of ground that is known."""
    groups = {
        "all": list(looked),
        "lots": [one for one in looked if not regions.is_street(one.place.name)],
        "streets": [one for one in looked if regions.is_street(one.place.name)],
    }
    for one in looked:
        if one.place.ground:
            groups.setdefault(f"ground {one.place.ground}", []).append(one)
    figures = []
    for name, members in groups.items():
        measured = pooled(members)
        key = f"regions_{name.replace(' ', '_')}"
        figures += [
            Figure(f"{key}_{measure}", f"{measure.replace('_', ' ')}, {name}", measured[measure])
            for measure in SHOWN
            if measured
        ]
    return Section("regions", figures)


def model_for(left_out: Sequence[tuple[Path, str]], name: str) -> Path | None:
    """Return the first network whose pattern fits a region, None where none does."""
    return next((model for model, pattern in left_out if fnmatchcase(name, pattern)), None)


def left_out_option(text: str) -> tuple[Path, str]:
    """Return network and pattern of ``FILE=PATTERN``. Raises ArgumentTypeError, which argparse prints."""
    model, _, pattern = text.rpartition("=")
    if not Path(model).is_file() or not pattern:
        raise ArgumentTypeError(f"{text!r} names no network; write FILE=PATTERN, as fold_a.onnx=nl_estate_*")
    return Path(model), pattern
