"""Missed stalls, false alarms and wrong states by category: numbers to watch one by one, where a total hides them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.figures import Figure, Section
from benchmarks.perception.categories import Categories, Category, categories
from benchmarks.perception.measures import Looked
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import counted_false_alarms

ALL: Final = "all"
NONE: Final = "none"
"""Names of the rows of everything, and of what falls into no category."""

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Row:
    """Counts of one category.

    ``labels`` and those ``missed``; ``judged``: matched labels that are free or taken, and those called ``wrong``;
    ``finds`` and the ``false`` ones among them: counted false alarms of `hawk.survey.accuracy`, all where there is no
    outline of the lot.
    """

    labels: int = 0
    missed: int = 0
    judged: int = 0
    wrong: int = 0
    finds: int = 0
    false: int = 0

    def __add__(self, other: Row) -> Row:
        return Row(*(getattr(self, name) + getattr(other, name) for name in self.__slots__))


def error_rows(looked: Sequence[Looked]) -> dict[str, Row]:
    """Return the counts of all places by category, with those of `ALL` and `NONE`."""
    total: dict[str, Row] = {name: Row() for name in (ALL, *Category, NONE)}
    for one in looked:
        for name, row in _rows(one, categories(one)).items():
            total[name] += row
    return total


def error_section(name: str, looked: Sequence[Looked], prefix: str) -> Section:
    """Return missed, false and wrong of every category as figures."""
    figures = []
    for category, row in error_rows(looked).items():
        title, key = category.replace("_", " "), f"{prefix}{category}"
        figures += [
            Figure(f"{key}_missed", f"{title}: missed of {row.labels} labels", float(row.missed)),
            Figure(f"{key}_false", f"{title}: false of {row.finds} finds", float(row.false)),
            Figure(f"{key}_wrong", f"{title}: wrong of {row.judged} states", float(row.wrong)),
            Figure(f"{key}_labels", f"{title}: labels", float(row.labels)),
        ]
    return Section(f"errors by category, {name}", figures)


@dataclass(frozen=True, slots=True)
class Errors:
    """Masks over the labels (N,) and finds (M,) of a place."""

    missed: Mask
    judged: Mask
    wrong: Mask
    false: Mask


def errors_of(looked: Looked, found: Categories) -> Errors:
    """Return what is wrong at a place."""
    truth, finding, pairs = looked.kept.truth, looked.kept.result.finding, found.matches
    missed = np.ones(len(truth.stalls), np.bool_)
    missed[pairs.true] = False
    real = np.asarray(truth.states, object)
    said = np.asarray(finding.states, object)
    judged = ~missed & ((real == StallState.FREE) | (real == StallState.TAKEN))
    wrong = np.zeros(len(missed), np.bool_)
    wrong[pairs.true] = said[pairs.found] != real[pairs.true]
    return Errors(missed, judged, wrong & judged, counted_false_alarms(finding.stalls, pairs, truth))


def _rows(looked: Looked, found: Categories) -> dict[str, Row]:
    errors = errors_of(looked, found)
    everything = (np.ones(len(errors.missed), np.bool_), np.ones(len(errors.false), np.bool_))
    nothing = _in_none(found.labels, everything[0]), _in_none(found.finds, everything[1])
    chosen: dict[str, tuple[Mask, Mask]] = {
        ALL: everything,
        **{c: (found.labels[c], found.finds[c]) for c in Category},
        NONE: nothing,
    }
    return {name: _row(errors, *masks) for name, masks in chosen.items()}


def _in_none(flags: Mapping[Category, Mask], everything: Mask) -> Mask:
    return np.asarray(~np.any([*flags.values()], axis=0)) if flags else everything


def _row(errors: Errors, labels: Mask, finds: Mask) -> Row:
    counts = (
        labels,
        labels & errors.missed,
        labels & errors.judged,
        labels & errors.wrong,
        finds,
        finds & errors.false,
    )
    return Row(*(int(mask.sum()) for mask in counts))
