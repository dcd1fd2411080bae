"""Reasons why a stall is hard: categories of labels and finds, by rules on the picture, labels and finds.

An error may fall into several categories, or into none. docs/results/perception.md says how each is decided and where
the rules fail.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.perception.ground_light import GROUND_M, GroundLight, ground_light
from benchmarks.perception.measures import Looked
from benchmarks.perception.paint import brightness, is_marked
from benchmarks.perception.stall_rows import Boxes, Rows, neighbours, spanning
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import Matches, match

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

TREE_OVER, TREE_NEAR_M, TREE_NEAR_M2 = 0.08, 1.5, 3.0
"""A tree: its crown covers this share of the stall, or N square metres within some metres of it."""
SHADE = 0.4
"""Share of a stall in deep shade."""
HARD_SHADOW, HARD_STRIP_M = 0.5, (-0.3, 0.7)
"""Share in shade of the strip along a side, from outside to inside of the stall, across which a shadow falls in."""
LEAST_THROW_M, LEAST_CARS = 0.15, 5
"""Shadows have a direction when those of N cars are thrown this far on average."""
LONG_M, COVERED = 7.5, 0.6
"""A long vehicle's stall: this long, or it covers this share of each of several stalls."""


class Category(StrEnum):
    """Categories."""

    TREE = "tree"
    SHADE = "shade"
    NEIGHBOUR_SHADOW = "neighbour_shadow"
    ROW_END = "row_end"
    PHASE = "phase"
    LONG = "long_vehicle"
    UNMARKED = "unmarked"


Flags = dict[Category, Mask]


@dataclass(frozen=True, slots=True)
class Categories:
    """Masks by category over the labels (N,) and the finds (M,) that count at a place, and their matches."""

    labels: Flags
    finds: Flags
    matches: Matches


def categories(looked: Looked) -> Categories:
    """Return the categories of every label and find of a place."""
    truth, finding = looked.kept.truth, looked.kept.result.finding
    everything = np.concatenate([looked.place.truth.stalls, finding.stalls])
    light = ground_light(looked.place, everything)
    bright = brightness(light.image)
    rows = Rows.of(looked.place.truth.stalls)
    labels, finds = Boxes.of(truth.stalls), Boxes.of(finding.stalls)
    pairs = match(finding.stalls, truth.stalls)
    taken = _vehicles(looked, labels, finds)
    throw = shadow_throw(light, taken)
    kept = ~looked.kept.cut
    loose = np.ones(len(finds), np.bool_)
    loose[pairs.found] = False
    half_off = rows.half_off(finds) & loose[None]
    long_labels, long_finds = _long(labels, finds, truth.stalls, finding.stalls)

    def seen(boxes: Boxes) -> Flags:
        return {
            Category.TREE: _each(boxes, lambda k: has_tree(light, boxes, k)),
            Category.SHADE: _each(boxes, lambda k: _share(light.deep, _whole(boxes, k)) >= SHADE),
            Category.NEIGHBOUR_SHADOW: neighbour_shadow(light, boxes, taken, throw),
            Category.UNMARKED: _each(boxes, lambda k: not is_marked(bright, boxes, k)),
        }

    of_labels: Flags = seen(labels) | {
        Category.ROW_END: rows.is_end[kept],
        Category.PHASE: np.asarray(half_off.any(axis=1))[kept],
        Category.LONG: long_labels,
    }
    of_finds: Flags = seen(finds) | {
        Category.ROW_END: rows.at_end(finds),
        Category.PHASE: np.asarray(half_off.any(axis=0)),
        Category.LONG: long_finds,
    }
    return Categories(_in_order(of_labels), _in_order(of_finds), pairs)


def has_tree(light: GroundLight, boxes: Boxes, number: int) -> bool:
    """Return True where a crown covers a part of the stall or stands beside it."""
    if _share(light.crown, _whole(boxes, number)) >= TREE_OVER:
        return True
    inside, part = _part(light.crown, _grown(boxes, number, TREE_NEAR_M))
    return bool((part & inside).sum() * GROUND_M**2 >= TREE_NEAR_M2)


def shadow_throw(light: GroundLight, vehicles: Boxes) -> Floats:
    """Return the direction (2,) in which vehicles throw their shadows, a unit vector; zero where it does not show.

    The vector from a taken stall's middle to that of the shade in and around it is a shadow's when it is averaged over
    vehicles: dark paint, and neighbours on either side, take themselves out.
    """
    middles = []
    for number in range(len(vehicles)):
        quad = _grown(vehicles, number, 2.0)
        inside, part = _part(light.shade & ~light.deep, quad)
        rows, columns = np.nonzero(part & inside)
        if len(rows):
            low = np.maximum(np.floor(quad.min(axis=0) / GROUND_M), 0)
            there = (np.array([columns.mean(), rows.mean()]) + low + 0.5) * GROUND_M
            middles.append(there - vehicles.centre[number])
    if len(middles) < LEAST_CARS:
        return np.zeros(2)
    mean = np.mean(middles, axis=0)
    size = float(np.hypot(*mean))
    return np.asarray(mean / size) if size >= LEAST_THROW_M else np.zeros(2)


def neighbour_shadow(light: GroundLight, boxes: Boxes, vehicles: Boxes, throw: Floats) -> Mask:
    """Return the stalls (N,) into which the shadow of a vehicle in the stall next to it falls, out of deep shade."""
    flags = np.zeros(len(boxes), np.bool_)
    if not throw.any() or not len(boxes) or not len(vehicles):
        return flags
    sides = neighbours(boxes, vehicles)
    for number, other in np.argwhere(sides != 0):
        onward = boxes.centre[number] - vehicles.centre[other]
        if flags[number] or onward @ throw <= 0.3 * np.hypot(*onward):
            continue
        strip = _strip(boxes, int(number), int(sides[number, other]))
        hard = light.shade & ~light.deep
        flags[number] = _share(hard, strip) >= HARD_SHADOW
    return flags


def _strip(boxes: Boxes, number: int, side: int) -> Floats:
    half, other = boxes.width[number] / 2, boxes.length[number] / 2
    if abs(side) == 2:
        half, other = other, half
    edge = sorted(np.sign(side) * (half - np.array(HARD_STRIP_M)))
    across, along = (float(edge[0]), float(edge[1])), (-0.7 * other, 0.7 * other)
    return boxes.patch(number, along, across) if abs(side) == 2 else boxes.patch(number, across, along)


def _vehicles(looked: Looked, labels: Boxes, finds: Boxes) -> Boxes:
    """Return the stalls with a vehicle: labelled taken; where labels say no state, found taken."""
    states = np.asarray(looked.kept.truth.states, object)
    if (states == StallState.UNKNOWN).all():
        return _some(finds, np.asarray(looked.kept.result.finding.states, object) == StallState.TAKEN)
    return _some(labels, states == StallState.TAKEN)


def _some(boxes: Boxes, mask: NDArray[np.bool_]) -> Boxes:
    mask = np.asarray(mask, np.bool_)
    return Boxes(boxes.centre[mask], boxes.across[mask], boxes.along[mask], boxes.width[mask], boxes.length[mask])


def _long(labels: Boxes, finds: Boxes, label_quads: Floats, find_quads: Floats) -> tuple[Mask, Mask]:
    by_find = spanning(find_quads, label_quads, COVERED)
    by_label = spanning(label_quads, find_quads, COVERED)
    of_labels = (labels.length >= LONG_M) | by_find.any(axis=0) | by_label.any(axis=1)
    of_finds = (finds.length >= LONG_M) | by_find.any(axis=1) | by_label.any(axis=0)
    return np.asarray(of_labels), np.asarray(of_finds)


def _in_order(flags: Flags) -> Flags:
    return {category: flags[category] for category in Category}


def _each(boxes: Boxes, rule: Callable[[int], bool]) -> Mask:
    return np.array([rule(k) for k in range(len(boxes))], np.bool_)


def _whole(boxes: Boxes, number: int) -> Floats:
    return _grown(boxes, number, 0.0)


def _grown(boxes: Boxes, number: int, margin: float) -> Floats:
    width, length = boxes.width[number] / 2 + margin, boxes.length[number] / 2 + margin
    return boxes.patch(number, (-width, width), (-length, length))


def _share(mask: Mask, quad: Floats) -> float:
    """Return the share of a quad (metres) under a mask at `GROUND_M`."""
    inside, part = _part(mask, quad)
    return float(part[inside].mean()) if inside.any() else 0.0


def _part(mask: Mask, quad: Floats) -> tuple[Mask, Mask]:
    """Return which pixels of the block about a quad lie in it, and the mask's block."""
    pixels = quad / GROUND_M
    low = np.maximum(np.floor(pixels.min(axis=0)).astype(int), 0)
    high = np.maximum(np.ceil(pixels.max(axis=0)).astype(int) + 1, low)
    part = mask[low[1] : high[1], low[0] : high[0]]
    drawn = np.zeros(part.shape, np.uint8)
    if drawn.size:
        cv2.fillPoly(drawn, [np.rint(pixels - low - 0.5).astype(np.int32)], (1,))
    return drawn > 0, part
