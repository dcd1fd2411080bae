"""Adjusts the poses of photographs together, as far as they show common ground."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import groupby
from operator import itemgetter
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.picture.reconstruction import headings
from hawk.picture.reconstruction.bundle_adjust import PIXEL, BundleSolution, Priors, bundle_adjust
from hawk.picture.reconstruction.camera_pose import CameraPose
from hawk.picture.reconstruction.features import RATIO, SIDE, Features, Search, Ties, match, neighbours
from hawk.picture.reconstruction.terrain import fit_terrain
from hawk.picture.reconstruction.tracks import Group, drop_outliers, largest_group
from hawk.picture.values import Progress

LEAST_SIGHTS: Final = 20
"""Tied places by which a photograph counts as adjusted."""
AGREE_PIXELS: Final = 4.0
"""A tie farther off than this, pixels of a picture of `SIDE`, is taken as wrong."""
WIDE_SHARE: Final = 0.55
"""Least share of like features that agree on how two photographs lie: by chance some 20 of 40 do on grass."""
LOST_SHARE: Final = 0.35
"""The same for photographs that the first adjustment left out: what is wrong, the second one leaves out."""
NARROW: Final = Search(4.0, 0.9, 0.3)
"""Once adjusted, places are known to some metres, and few other features can be meant."""
HEIGHT_SHARE: Final = 0.05
"""Share of the height above ground by which it may err: barometers, and ground that is not level."""
_OTHER_HEIGHT: Final = 0.1
"""Logarithm of a height by what the files say, from which ties are looked for about the height that neighbours show."""
QUARTER: Final = 4.0
"""Residuals are reported for a picture of a quarter of the size."""
_TURNING_SIGMA: Final = 0.3
_TURNED_SIGMA: Final = math.radians(20)
_STILL: Final = 1e-6
_LIFT_SHARE: Final = 0.3
"""Share of the height by which all may be higher than said: the distances of their places say it, far better."""
_LENS_SIGMA: Final = np.array([0.03, 0.01, 0.01, 0.05, 0.05])
_KNOWN_LENS_SIGMA: Final = np.array([0.01, 0.003, 0.003, 0.01, 0.01])
Step = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Pair:
    """Two photographs whose ties are looked for: their ``numbers``, their poses, and how far is searched."""

    numbers: tuple[int, int]
    first: CameraPose
    second: CameraPose
    search: Search


Keep = Callable[[Sequence[Pair], Callable[[], list[Ties]]], list[Ties]]


@dataclass(frozen=True, slots=True)
class PosePrior:
    """A photograph's pose as its file says, with standard deviations: ``place_m`` horizontally, ``height_m`` of the
    heights against each other, ``tilt`` of roll and pitch and ``heading`` in radians.

    How high all are above the ground is not believed: how far the places are apart says it.
    """

    posed: CameraPose
    place_m: float
    height_m: float
    tilt: float
    heading: float


@dataclass(frozen=True, slots=True)
class Reconstruction:
    """Poses of all photographs in their order; ``is_adjusted`` (N,) those that hang together by ties.

    ``residual``: median distance of ties from where they should show, pixels at a quarter of the picture's size, None
    without any. ``ties``: number of sights of tied places. ``turned``: numbers of those whose heading is not their
    file's, but their neighbours'.
    """

    posed: tuple[CameraPose, ...]
    is_adjusted: NDArray[np.bool_] = field(repr=False)
    residual: float | None
    ties: int
    turned: frozenset[int] = frozenset()


def reconstruct(
    known: Sequence[PosePrior],
    found: Callable[[int], Features],
    *,
    lens_is_known: bool,
    progress: Progress = lambda *_: None,
    keep: Keep = lambda _, make: make(),
    keep_middles: headings.KeepMiddles = lambda _, make: make(),
) -> Reconstruction:
    """Adjust poses and lens; photographs without ties are moved as the others were on the whole.

    Args:
        known: The photographs.
        found: Gives the features of a photograph by its number.
        lens_is_known: The lens was calibrated, not guessed.
        progress: Is called with the step, how much of it is done, and of how much.
        keep: Gives the ties of pairs that an earlier run has kept, or makes and keeps them.
        keep_middles: The same for the middles of photographs, which show headings.
    """
    posed = tuple(one.posed for one in known)
    error_m = max(math.hypot(one.place_m, one.tilt * one.posed.height) for one in known)
    shown = headings.neighbour_headings(posed, error_m, found, keep_middles)
    turned = headings.correct_headings(posed, shown.headings)
    if turned:
        known = [_with_heading(one, turned.get(number)) for number, one in enumerate(known)]
    known = _at_height(known, shown.height)
    posed = tuple(one.posed for one in known)
    within = max(_reach(one) for one in known)
    wide = Search(within, RATIO, WIDE_SHARE)
    ties = _ties(posed, found, lambda _: wide, lambda *done: progress("match", *done), keep)
    first = _settled(known, ties, found, lens_is_known, None)
    if first is None:
        return Reconstruction(posed, np.zeros(len(posed), np.bool_), None, 0, frozenset(turned))
    posed = _carried(known, *first)
    sure, lax = {*first[0].members.tolist()}, Search(within, RATIO, LOST_SHARE)
    ties = _ties(
        posed,
        found,
        lambda pair: NARROW if {*pair} <= sure else lax,
        lambda *done: progress("match again", *done),
        keep,
    )
    group, settled = _settled(known, ties, found, lens_is_known, first) or first
    counted = np.zeros(len(posed), np.bool_)
    counted[group.members[np.bincount(group.sights.shot, minlength=len(group.members)) >= LEAST_SIGHTS]] = True
    levelled = fit_terrain(_carried(known, group, settled), settled.points)
    return Reconstruction(
        levelled, counted, float(np.median(settled.off)) / QUARTER, len(settled.off), frozenset(turned)
    )


def _reach(known: PosePrior) -> float:
    """Return how far the ground of two photographs may be off by their files, metres."""
    return 4 * known.place_m + known.posed.height * (HEIGHT_SHARE + 2 * known.tilt + min(known.heading, 0.3) / 2)


def _with_heading(known: PosePrior, posed: CameraPose | None) -> PosePrior:
    """Return a photograph with the heading that its neighbours show, None: as it is."""
    return known if posed is None else replace(known, posed=posed, heading=min(known.heading, _TURNED_SIGMA))


def _at_height(known: Sequence[PosePrior], height: float | None) -> Sequence[PosePrior]:
    """Return the photographs about the height that their neighbours show, where it is far from what their files say."""
    said = float(np.median([one.posed.height for one in known]))
    if height is None or abs(math.log(height / said)) < _OTHER_HEIGHT:
        return known
    return [replace(one, posed=replace(one.posed, height=one.posed.height * height / said)) for one in known]


def _ties(
    posed: tuple[CameraPose, ...],
    found: Callable[[int], Features],
    search: Callable[[tuple[int, int]], Search],
    step: Step,
    keep: Keep,
) -> list[Ties]:
    """Return the ties of neighbours, each pair searched for as ``search`` says; those of one photograph at a time."""
    pairs, ties, done = neighbours(posed), list[Ties](), 0
    for _, of_one in groupby(pairs, key=itemgetter(0)):
        step(done, len(pairs))
        asked = [Pair(pair, posed[pair[0]], posed[pair[1]], search(pair)) for pair in of_one]
        done += len(asked)
        ties += keep(asked, partial(_matched, asked, posed, found))
    return ties


def _matched(asked: Sequence[Pair], posed: tuple[CameraPose, ...], found: Callable[[int], Features]) -> list[Ties]:
    ties = (match(one.numbers, posed, found, one.search) for one in asked)
    return [tie for tie in ties if tie is not None]


def _settled(
    known: Sequence[PosePrior],
    ties: Sequence[Ties],
    found: Callable[[int], Features],
    lens_is_known: bool,
    before: tuple[Group, BundleSolution] | None,
) -> tuple[Group, BundleSolution] | None:
    """Return the largest group of photographs, settled twice: the second time without the ties that are wrong."""
    group = largest_group(ties, len(known), found)
    if group is None or not group.sights.points:
        return None
    members = [known[int(number)] for number in group.members]
    said, trust = [one.posed for one in members], _trust(members, lens_is_known)
    camera = said[0].camera
    unit = max(1.0, max(camera.width, camera.height) / SIDE)
    begin = None
    if before is not None and np.array_equal(before[0].members, group.members):
        begin = before[1]
    settled = bundle_adjust(said, group.sights, trust, PIXEL * unit, begin)
    sights = drop_outliers(group.sights, settled.off > AGREE_PIXELS * unit)
    if not sights.points:
        return None
    return replace(group, sights=sights), bundle_adjust(said, sights, trust, PIXEL * unit, settled)


def _trust(members: Sequence[PosePrior], lens_is_known: bool) -> Priors:
    place = np.array([(one.place_m, one.place_m, one.height_m) for one in members])
    attitude = np.array([(one.tilt, one.tilt, one.heading) for one in members])
    turning = np.array([[_TURNING_SIGMA if one.posed.line_s else _STILL] * 3 for one in members])
    lift_m = _LIFT_SHARE * float(np.median([one.posed.height for one in members]))
    return Priors(place, attitude, turning, _KNOWN_LENS_SIGMA if lens_is_known else _LENS_SIGMA, lift_m)


def _carried(known: Sequence[PosePrior], group: Group, settled: BundleSolution) -> tuple[CameraPose, ...]:
    """Return all poses: those of the group as settled, the others moved by the middle of what moved these."""
    said = [known[int(number)].posed for number in group.members]
    moved = np.array([_moved(a, b) for a, b in zip(said, settled.posed, strict=True)])
    north, east, scale, turn = np.median(moved, axis=0).tolist()
    by_number = {int(number): one for number, one in zip(group.members, settled.posed, strict=True)}
    camera = settled.posed[0].camera
    return tuple(
        by_number.get(number)
        or replace(
            one.posed, camera=camera, north=one.posed.north + north, east=one.posed.east + east,
            height=one.posed.height * scale,
            attitude=(*one.posed.attitude[:2], one.posed.attitude[2] + turn),
        )
        for number, one in enumerate(known)
    )  # fmt: skip


def _moved(said: CameraPose, now: CameraPose) -> tuple[float, float, float, float]:
    """Return metres north and east, the share of the height, and the turn from one pose to another."""
    turn = math.remainder(now.attitude[2] - said.attitude[2], math.tau)
    return now.north - said.north, now.east - said.east, now.height / said.height, turn
