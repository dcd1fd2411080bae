"""A folder of windows for checking by eye, and the city's totals by what a person wrote there.

``windows.csv`` has a row a window with the program's counts; a person fills in the counts by eye. ``design.json`` says
how the windows were drawn.
"""

from __future__ import annotations

import csv
import io
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final

import cv2
import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from hawk.picture.city.stratified_total import CheckedStratum, CheckedTotal, allocated, checked_total
from hawk.picture.values import CheckSample, PictureError, SampleWindow, cannot_write
from hawk.runtime.files import replace_whole

FOLDER: Final = "check"
TABLE: Final = "windows.csv"
DESIGN: Final = "design.json"
COUNTED: Final = ("free", "taken", "vehicles")
"""Numbers of a window that are checked."""
BY_EYE: Final = "_by_eye"
_PARTS: Final = 3
"""Strata of the windows with a find, by doubt; those without any are one more."""
_LEAST_SPREAD: Final = 0.2
"""Expected difference of a window without doubt, in stalls: the program misses some where it sees none."""


class StratumDesign(BaseModel):
    """A stratum: how many windows it has, and the names of those that were drawn."""

    model_config = ConfigDict(extra="forbid")

    windows: Annotated[int, Field(ge=0)]
    drawn: list[str]


class CheckDesign(BaseModel):
    """Drawing of the windows. ``identity``: of the findings; ``totals``: the program's, of all windows."""

    model_config = ConfigDict(extra="forbid")

    seed: int
    identity: str
    totals: dict[str, int]
    strata: list[StratumDesign]


@dataclass(frozen=True, slots=True)
class CheckedCount:
    """Totals by windows that were checked by eye, by the names of `COUNTED`."""

    totals: Mapping[str, CheckedTotal]
    checked: int
    windows: int

    def values(self) -> dict[str, Any]:
        """Return them as values of JSON."""
        return {
            "windows": self.windows,
            "checked": self.checked,
            **{
                name: {"total": round(each.total, 1), "range": [each.least, each.most]}
                for name, each in self.totals.items()
            },
        }

    @property
    def words(self) -> str:
        """One line for a person."""
        parts = [f"{name} {each.least} to {each.most}" for name, each in self.totals.items()]
        return (
            f"By {self.checked} of {self.windows} windows checked by eye, in nine of ten samples: {', '.join(parts)}."
        )


def strata_of(windows: Sequence[SampleWindow]) -> list[list[SampleWindow]]:
    """Return the windows without a find, and the others in three parts by their doubt."""
    empty = [each for each in windows if not any(each.counts.values()) and not each.doubt]
    others = sorted((each for each in windows if each not in empty), key=lambda each: (each.doubt, each.number))
    return [empty, *([*part] for part in np.array_split(np.array(others, object), _PARTS))]


def write_check(sample: CheckSample, folder: Path, count: int, seed: int) -> Path:
    """Draw windows and write their folder; return it. Raises PictureError, also where counts by eye would be lost."""
    target = folder / FOLDER
    if (target / TABLE).exists() and _has_eyes(target / TABLE):
        raise PictureError(f"--check: {target / TABLE} has counts by eye; use them by --checked, or move the folder")
    windows = sample.windows()
    strata = strata_of(windows)
    spreads = [max(float(np.mean([each.doubt for each in part])) if part else 0.0, _LEAST_SPREAD) for part in strata]
    counts = allocated([len(part) for part in strata], spreads, count)
    random = np.random.default_rng(seed)
    drawn = [
        sorted((part[k] for k in random.choice(len(part), taken, replace=False)), key=lambda each: each.number)
        if taken
        else []
        for part, taken in zip(strata, counts, strict=True)
    ]
    chosen = sorted((each for part in drawn for each in part), key=lambda each: each.number)
    totals = {name: sum(each.counts.get(name, 0) for each in windows) for name in _names(windows)}
    design = CheckDesign(
        seed=seed, identity=sample.identity, totals=totals,
        strata=[
            StratumDesign(windows=len(part), drawn=[each.name for each in taken])
            for part, taken in zip(strata, drawn, strict=True)
        ],
    )  # fmt: skip
    try:
        target.mkdir(parents=True, exist_ok=True)
        for each in chosen:
            replace_whole(target / _picture(each), cv2.imencode(".png", sample.picture(each))[1].tobytes())
        replace_whole(target / "windows.geojson", json.dumps(_geojson(chosen)).encode())
        replace_whole(target / DESIGN, design.model_dump_json(indent=1).encode())
        replace_whole(target / TABLE, _table(chosen, [*totals]).encode())
    except OSError as error:
        raise PictureError(f"--out: {cannot_write(Path(error.filename or target), error)}") from error
    return target


def read_check(sample: CheckSample, table: Path) -> CheckedCount:
    """Return the totals by a table that a person filled in. Raises PictureError naming row, column and remedy."""
    design = _design(table.with_name(DESIGN))
    if design.identity != sample.identity:
        raise PictureError(
            f"--checked: {table} is of other findings: map with the picture, outlines and network of {DESIGN}, or draw "
            "windows again by --check"
        )
    given = _rows(table)
    rows = {row["window"]: row for row in given}
    if len(rows) < len(given):
        twice = Counter(row["window"] for row in given).most_common(1)[0][0]
        raise PictureError(f"--checked: {table} has window {twice} twice: keep one of these rows")
    found: dict[str, CheckedTotal] = {}
    every = [name for part in design.strata for name in part.drawn]
    for name in design.totals:
        seen = [rows.get(window, {}).get(name + BY_EYE, "").strip() for window in every]
        if not any(seen):
            continue
        strata = [
            CheckedStratum(part.windows, np.array([_difference(table, rows, window, name) for window in part.drawn]))
            for part in design.strata
        ]
        found[name] = checked_total(float(design.totals[name]), strata)
    if not found:
        raise PictureError(f"--checked: {table} has no counts by eye: fill in {', '.join(_eyes([*design.totals]))}")
    return CheckedCount(found, len(every), sum(part.windows for part in design.strata))


def _names(windows: Sequence[SampleWindow]) -> list[str]:
    return [name for name in COUNTED if any(name in each.counts for each in windows)]


def _eyes(names: Sequence[str]) -> list[str]:
    return [name + BY_EYE for name in names]


def _picture(window: SampleWindow) -> str:
    return f"{window.number:05d}.png"


def _table(windows: Sequence[SampleWindow], names: Sequence[str]) -> str:
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow(["window", "picture", "doubt", *names, *_eyes(names)])
    for each in windows:
        table.writerow(
            [each.name, _picture(each), each.doubt, *(each.counts[name] for name in names), *("" for _ in names)]
        )
    return out.getvalue()


def _geojson(windows: Sequence[SampleWindow]) -> dict[str, Any]:
    features = [
        {
            "type": "Feature",
            "id": each.name,
            "geometry": {"type": "Polygon", "coordinates": [[[x, y] for y, x in (*each.ring, each.ring[0])]]},
            "properties": {"picture": _picture(each), "doubt": each.doubt, **each.counts},
        }
        for each in windows
    ]
    return {"type": "FeatureCollection", "features": features}


def _design(path: Path) -> CheckDesign:
    try:
        return CheckDesign.model_validate_json(path.read_bytes())
    except OSError as error:
        raise PictureError(f"--checked: {path} cannot be read ({error.strerror}); leave it beside {TABLE}") from error
    except ValidationError as error:
        raise PictureError(f"--checked: {path} is damaged: draw windows again by --check") from error


def _rows(path: Path) -> list[dict[str, str]]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            text = file.read()
    except (OSError, UnicodeDecodeError) as error:
        raise PictureError(f"--checked: {path} cannot be read ({error}); save it as CSV in UTF-8") from error
    rows = csv.DictReader(io.StringIO(text), delimiter=";" if ";" in text.partition("\n")[0] else ",")
    if "window" not in (rows.fieldnames or ()):
        raise PictureError(f"--checked: {path} has no column window; fill in the table that --check wrote")
    return [{key: value or "" for key, value in row.items() if isinstance(key, str)} for row in rows]


def _has_eyes(path: Path) -> bool:
    return any(value.strip() for row in _rows(path) for key, value in row.items() if key.endswith(BY_EYE))


def _difference(table: Path, rows: Mapping[str, dict[str, str]], window: str, name: str) -> float:
    """Return by how much a window differs. Raises PictureError for one that is missing, or holds no number."""
    row = rows.get(window)
    if row is None:
        raise PictureError(f"--checked: {table} lacks the row of window {window}: leave no window out")
    said, own = row.get(name + BY_EYE, "").strip(), row.get(name, "").strip()
    for key, text in ((name + BY_EYE, said), (name, own)):
        if not text.isdecimal() or len(text) > 6:
            shown = f"{text[:20]!r}" if text else "empty"
            raise PictureError(f"--checked: {table}, window {window}: {key} is {shown}: write a whole number")
    return float(int(said) - int(own))
