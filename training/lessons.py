"""Lessons of an owner's pictures: flights to learn from, later flights to judge by, and whether weights are better.

A folder as ``hawk-drone export LOT --training DIR`` writes it: ``NAME.jpg`` with ``NAME.json``, which says ``lot`` and
``ended``. Needs no torch.
"""

from __future__ import annotations

import json
import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.figures import Figure, Reference
from benchmarks.perception.camera_frames import measure_worlds
from benchmarks.perception.eyes import NetworkEye
from benchmarks.perception.measures import look
from benchmarks.perception.places import Place, read_lots
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.network import StallNetwork
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import Tally

JUDGED_SHARE: Final = 3
"""Of the flights of a lot, one in N judges: the latest ones, one at the least."""
STATE_LOSS: Final = 0.01
"""Least accuracy of states that is lost where one counts as worse: two stalls of 200."""
DRAWN_SEEDS: Final = (901, 902, 903, 904, 905, 906)
"""Drawn worlds that no training sees: it draws scenes, not worlds."""
_MEASURES: Final = {
    "recall": "recall", "precision": "precision", "f1": "F1", "recall_whole": "recall of whole stalls",
    "precision_star": "precision, where the labels are whole", "state_accuracy": "state",
}  # fmt: skip
_QUALITY: Final = (cv2.IMWRITE_JPEG_QUALITY, 95)
_GREY: Final = 128


class LessonError(ValueError):
    """The folder teaches nothing, or cannot be judged; the text names the file and the remedy."""


@dataclass(frozen=True, slots=True)
class Split:
    """Names of the pictures to learn from, and of those of later flights, which judge."""

    learnt: tuple[str, ...]
    judged: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Judgement:
    """Counts of a network over the later flights, and over frames of drawn worlds."""

    later: Tally
    drawn: Tally


def split(folder: Path) -> Split:
    """Return which flights teach and which judge, by lot and time. Raises LessonError."""
    flights: dict[str, list[tuple[str, str]]] = defaultdict(list)
    for path in sorted(folder.glob("*.json")):
        labels = _read(path)
        flights[labels["lot"]].append((labels["ended"], path.stem))
    if not flights:
        raise LessonError(f"{folder}: holds no NAME.json; name the folder that hawk-drone export LOT --training wrote")
    learnt, judged = [], []
    for of_lot in flights.values():
        names = [name for _, name in sorted(of_lot)]
        count = max(1, len(names) // JUDGED_SHARE) if len(names) > 1 else 0
        learnt += names[: len(names) - count]
        judged += names[len(names) - count :]
    if not judged:
        raise LessonError(
            f"{folder}: has one flight of each lot, and nothing later to judge by; fly a lot again and export it again"
        )
    return Split(tuple(sorted(learnt)), tuple(sorted(judged)))


def _read(path: Path) -> dict[str, Any]:
    try:
        labels = json.loads(path.read_text())
        return {**labels, "lot": str(labels["lot"]), "ended": str(labels["ended"])}
    except (KeyError, TypeError, ValueError) as error:
        raise LessonError(f"{path}: no labels with lot and ended ({error}); export the lot again") from error


def judge(network: StallNetwork, places: Sequence[Place], seeds: Sequence[int] = DRAWN_SEEDS) -> Judgement:
    """Look at the later flights and at drawn worlds with a network."""
    looked = look(NetworkEye(network), places)
    return Judgement(sum((one.tally for one in looked), Tally()), measure_worlds(StallDetector(network), seeds))


def refusal(before: Judgement, after: Judgement) -> str:
    """Return why the weights of ``after`` are not taken, nothing where they are better on the later flights and no
    worse on drawn worlds: by no more than one standard error.
    """
    if not after.later.f1 > before.later.f1:
        return f"no better on the later flights: F1 {after.later.f1:.3f}, before {before.later.f1:.3f}"
    if after.later.state_accuracy < before.later.state_accuracy - STATE_LOSS:
        states = f"{after.later.state_accuracy:.3f}, before {before.later.state_accuracy:.3f}"
        return f"states are worse on the later flights: {states}"
    if after.drawn.f1 < before.drawn.f1 - _chance(before.drawn):
        return f"worse on drawn worlds: F1 {after.drawn.f1:.3f}, before {before.drawn.f1:.3f}"
    return ""


def _chance(tally: Tally) -> float:
    """Return the standard error of F1 over the true stalls, as of a share of them."""
    return math.sqrt(tally.f1 * (1 - tally.f1) / tally.true) if tally.true else 0.0


def figures(before: Judgement, after: Judgement) -> list[Figure]:
    """Return the measures of both, those of ``before`` as the reference."""
    found = []
    for key, name, was, now in (
        ("later", "later flights", before.later, after.later),
        ("drawn", "drawn worlds", before.drawn, after.drawn),
    ):
        measured = now.measures(), was.measures()
        for measure, words in _MEASURES.items():
            value, former = (None if math.isnan(each[measure]) else each[measure] for each in measured)
            reference = Reference("the weights before", former)
            found.append(Figure(f"{key}_{measure}", f"{words}, {name}", value, reference=reference))
        found.append(Figure(f"{key}_stalls", f"stalls, {name}", float(now.true)))
    return found


def halves(places: Path, folder: Path) -> tuple[str, ...]:
    """Write each labelled place twice, the other half of its ground grey, as two flights of a lot; return the names.

    The western half of its stalls teaches, the eastern one judges: a lot corrected on one part, measured on the other.
    Raises FileNotFoundError for a picture that cannot be read.
    """
    names = []
    for place in read_lots(places):
        across = place.truth.stalls[:, :, 0]
        middle = np.median(across.mean(axis=1))
        for part, own in (("west", across.max(axis=1) <= middle), ("east", across.min(axis=1) >= middle)):
            if own.any():
                names.append(f"{place.name}-{part}")
                _write_half(place, own, folder / names[-1], is_west=part == "west")
    return tuple(names)


def _write_half(place: Place, own: NDArray[np.bool_], path: Path, *, is_west: bool) -> None:
    """Write one half of a place: its whole stalls, and the picture up to the farthest of them."""
    image, quads = place.image.copy(), place.truth.stalls[own]
    edge = round(float(quads[:, :, 0].max() if is_west else quads[:, :, 0].min()) / place.metres_per_pixel)
    image[:, slice(edge, None) if is_west else slice(None, edge)] = _GREY
    states = ["unclear" if state == StallState.UNKNOWN else str(state) for state in place.truth.states[own]]
    content = {
        "metres_per_pixel": place.metres_per_pixel,
        "lot": place.name,
        "ended": f"2026-01-0{1 if is_west else 2}T00:00:00Z",
        "stalls": [{"corners_m": quad.tolist(), "state": state} for quad, state in zip(quads, states, strict=True)],
        "lots_m": [lot.tolist() for lot in place.truth.lots],
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    path.with_suffix(".jpg").write_bytes(cv2.imencode(".jpg", image, _QUALITY)[1].tobytes())
    path.with_suffix(".json").write_text(json.dumps(content))
