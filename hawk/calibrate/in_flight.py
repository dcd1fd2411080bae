"""Latency and mount of the camera, estimated from what two pictures of a flight share.

A point of the ground is seen in the first picture, is carried to the second by the drone's poses at both exposures, and
is compared with what the second picture shows. Sought are the error of the exposures' times and the mount's angles.
Errors of a pair alone are estimated with it: its movement, height and turn as the autopilot reports them, within what
is usual for GNSS, barometer and compass. The ground is a plane that may lean a little; a point may stand above it, so
that it says little along the line on which roofs and trees move. A constant error of the compass turns the drone's
movement only, a turned mount also the movement of the picture when the drone leans: the compass is estimated too, so
that its error does not look like the mount's.

The method is that of Gauss and Newton with weights by Cauchy's function; a pair's own errors are eliminated first
(Schur). The spread is the larger one of two: that of the normal equations, and that of White's "sandwich" over blocks
of 10 s, in which errors stay alike.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.calibrate.flight import Track
from hawk.calibrate.pairs import MARGIN_S, Matches, carried, mounted
from hawk.model.pictures import CameraModel

Floats = NDArray[np.float64]

LATENCY, ROLL, PITCH, YAW = range(4)
"""Places of the results in an estimate."""
_SLOPE, _COMPASS = slice(4, 6), 6
_UNKNOWNS = 7  # the four results, the ground's slope to north and east, the compass's error
_OWN, _HEIGHT = 5, 2  # of a pair: movement north and east, height, climb (metres), turn (radians)
LEAST_PAIRS: Final = 20
"""Fewer pairs give no estimate."""
BLOCK_S: Final = 10.0
"""Errors of GNSS stay alike for so long."""
_LEAST_BLOCKS = 3

_POINT_SIGMA = 0.7 / 460  # focal lengths: 0.7 pixels of a picture 640 wide
_STANDING_SIGMA = 4.0  # metres that a point may stand above the ground: roofs, trees
_SLOPE_SIGMA = 0.02
_COMPASS_SIGMA = math.radians(2.0)  # as in hawk.algo.mapper.register
_HEIGHT_SIGMA = 2.0  # metres: barometer, and ground that is not level
_CLIMB_SIGMA = 0.1
_TURN_SIGMA = math.radians(0.3)
_MOVE_SIGMA, _MOVE_SIGMA_S = 0.02, 0.05  # metres, and metres a second between the pictures
_LEAN_SIGMA = math.radians(0.2)  # error of roll and pitch between two moments: moves what is seen by so much
_CAUCHY = 2.0  # standard deviations
_STEPS = np.array([2e-3, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4])
_OWN_STEPS = np.array([1e-3, 1e-3, 1e-2, 1e-3, 1e-4])
_ROUNDS = 20
_DONE = 1e-5
_COARSE_S = np.arange(-1.4, 1.41, 0.1)
_COARSE_POINTS = 5
_COARSE_TURNS = np.radians(np.arange(-180, 180, 20))


_USUAL = 4.0  # standard deviations of a pair's own errors
_LEAST_USUAL = 0.5  # of all pairs; 1.0 in flights that fit, 0.04 where the times were off by 2.5 s
_NO_FIT = (
    f"the pictures do not fit the poses of this flight: set camera.latency_s to within {MARGIN_S:g} s, calibrate the "
    "lens, and look at the compass; a mirrored or frozen picture does not fit either"
)


class NoEstimateError(Exception):
    """Nothing can be estimated from this flight; the text says why, and the remedy."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """Results of a flight.

    ``values`` and ``spreads`` (4,): seconds by which the pictures were taken later than they are stamped; roll, pitch
    and yaw of the mount, radians. A spread is one standard deviation. ``pairs`` counts the pairs of pictures.
    ``one_heading`` is 1 where the nose pointed to one side all the time, 0 where it pointed everywhere alike: the
    length of the headings' mean.
    """

    values: tuple[float, float, float, float]
    spreads: tuple[float, float, float, float]
    pairs: int
    one_heading: float


@dataclass(frozen=True, slots=True)
class _Problem:
    """Matches as arrays over pairs (P) and points (K); ``seen`` (P, K) is True where there is a point."""

    track: Track
    times: Floats = field(repr=False)
    """(2, P): of both exposures, as stamped."""
    ground: Floats = field(repr=False)
    first: Floats = field(repr=False)
    second: Floats = field(repr=False)
    seen: NDArray[np.bool_] = field(repr=False)
    own_sigma: Floats = field(repr=False)
    """(P, 5): usual errors of a pair."""

    def residual(self, sought: Floats, own: Floats) -> Floats:
        """Return (P, K, 2): what is expected in the second picture less what it shows, standard deviations.

        Args:
            sought: (7,): seconds, mount's roll, pitch and yaw (radians), slope to north and east (metres per metre),
                the compass's error (radians).
            own: (P, 5): errors of each pair.
        """
        before, now = (self.track.at(times + sought[LATENCY]) for times in self.times)
        now[:, :2] += own[:, :2]
        before[:, 2] += own[:, 2] - self.ground
        now[:, 2] += own[:, 2] + own[:, 3] - self.ground
        before[:, 5] += sought[_COMPASS]
        now[:, 5] += sought[_COMPASS] + own[:, 4]
        mount = mounted(sought[ROLL : YAW + 1])
        expected = carried(self.first, before, now, mount, (float(sought[4]), float(sought[5])))
        off = (expected - self.second) / _POINT_SIGMA
        off[~self.seen | ~np.isfinite(off).all(-1)] = 0.0
        return np.asarray(off)


def estimate(track: Track, matches: Sequence[Matches], camera: CameraModel) -> Estimate:
    """Return latency and mount with their spreads. ``camera`` has the mount as it was set. Raises NoEstimateError."""
    if len(matches) < LEAST_PAIRS:
        raise NoEstimateError(
            f"only {len(matches)} pairs of pictures show the same ground, {LEAST_PAIRS} are needed: fly for at least a "
            "minute over ground with marks"
        )
    problem = _problem(track, matches)
    sought = _coarse(problem, np.array([0.0, camera.mount_roll, camera.mount_pitch, camera.mount_yaw, 0.0, 0.0, 0.0]))
    own = np.zeros_like(problem.own_sigma)
    for _ in range(_ROUNDS):
        step, own_step, _, _ = _normal(problem, sought, own)
        sought = sought + step
        own = own + own_step
        if not np.isfinite(sought).all() or abs(sought[LATENCY]) > MARGIN_S:
            raise NoEstimateError(_NO_FIT)
        if np.abs(step).max() < _DONE:
            break
    usual = np.linalg.norm(own / problem.own_sigma, axis=1) < _USUAL
    if usual.mean() < _LEAST_USUAL:
        raise NoEstimateError(_NO_FIT)
    _, _, information, scores = _normal(problem, sought, own)
    spreads = _spreads(information, scores, problem.times[0])
    yaw = math.remainder(float(sought[YAW]), math.tau)
    return Estimate(
        (float(sought[LATENCY]), float(sought[ROLL]), float(sought[PITCH]), yaw),
        (float(spreads[LATENCY]), float(spreads[ROLL]), float(spreads[PITCH]), float(spreads[YAW])),
        len(matches),
        float(abs(np.exp(1j * track.at(problem.times[0])[:, 5]).mean())),
    )


def _problem(track: Track, matches: Sequence[Matches]) -> _Problem:
    size = (len(matches), max(len(each.first) for each in matches))
    first, second, seen = np.zeros((*size, 2)), np.zeros((*size, 2)), np.zeros(size, np.bool_)
    for k, each in enumerate(matches):
        count = len(each.first)
        first[k, :count], second[k, :count], seen[k, :count] = each.first, each.second, True
    times = np.array([(m.pair.before.captured, m.pair.now.captured) for m in matches]).T
    height = np.array([m.pair.before.over_ground for m in matches])
    move = np.hypot(_MOVE_SIGMA + _MOVE_SIGMA_S * (times[1] - times[0]), _LEAN_SIGMA * height)
    others = np.tile([_HEIGHT_SIGMA, _CLIMB_SIGMA, _TURN_SIGMA], (len(matches), 1))
    ground = np.array([m.pair.before.ground for m in matches])
    return _Problem(track, times, ground, first, second, seen, np.column_stack([move, move, others]))


def _coarse(problem: _Problem, start: Floats) -> Floats:
    """Return the start with the latency and yaw, of a coarse grid, by which most points are where they are expected."""
    few = replace(
        problem,
        first=problem.first[:, ::_COARSE_POINTS],
        second=problem.second[:, ::_COARSE_POINTS],
        seen=problem.seen[:, ::_COARSE_POINTS],
    )
    none = np.zeros_like(problem.own_sigma)
    best, least = start, math.inf
    for seconds, turn in product(_COARSE_S, _COARSE_TURNS):
        tried = start + np.array([seconds, 0.0, 0.0, turn, 0.0, 0.0, 0.0])
        off = np.hypot(*np.moveaxis(few.residual(tried, none), -1, 0))
        cost = float(np.log1p((off / 20.0) ** 2).sum())
        if cost < least:
            best, least = tried, cost
    return best


def _normal(problem: _Problem, sought: Floats, own: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return a step of Gauss and Newton: of the sought (7,), of the pairs' own errors (P, 5); the information (7, 7)
    that is left after their elimination, and each pair's part of the gradient (P, 7).
    """
    count = len(own)
    to_sought = _slopes(problem, sought, own, _STEPS, is_own=False)
    to_own = _slopes(problem, sought, own, _OWN_STEPS, is_own=True)
    soft = _softened(to_own[..., _HEIGHT])
    off = soft(problem.residual(sought, own).reshape(count, -1, 1))[..., 0]
    to_sought, to_own = soft(to_sought), soft(to_own)
    sizes = np.hypot(off[:, 0::2], off[:, 1::2])
    weight = np.repeat(1 / (1 + (sizes / _CAUCHY) ** 2), 2, axis=1)
    usual = own / problem.own_sigma
    trust = 1 / (1 + (np.linalg.norm(usual, axis=1) / (2 * _CAUCHY)) ** 2)
    prior = trust[:, None] / problem.own_sigma**2
    weighed, weighed_own = to_sought * weight[..., None], to_own * weight[..., None]
    a = np.einsum("pki,pkj->pij", weighed_own, to_own) + prior[:, :, None] * np.eye(_OWN)
    b = np.einsum("pki,pkj->pij", weighed_own, to_sought)
    c = np.einsum("pki,pkj->pij", weighed, to_sought)
    own_slope = np.einsum("pki,pk->pi", weighed_own, off) + prior * own
    slope = np.einsum("pki,pk->pi", weighed, off)
    share = np.linalg.solve(a, b)
    parts = c - b.transpose(0, 2, 1) @ share
    scores = slope - np.einsum("pij,pi->pj", share, own_slope)
    firm = np.diag([*[1e-9] * 4, *[_SLOPE_SIGMA**-2] * 2, _COMPASS_SIGMA**-2])
    information = parts.sum(0) + firm
    held = np.where(np.arange(_UNKNOWNS) >= 4, sought, 0.0)
    step = -np.linalg.solve(information, scores.sum(0) + firm @ held)
    own_step = -np.linalg.solve(a, own_slope[..., None])[..., 0] - share @ step
    return step, own_step, information, scores


def _softened(by_height: Floats) -> Callable[[Floats], Floats]:
    """Return the weighing of residuals and derivatives (P, 2 K, N) that lets each point stand above the ground.

    Roofs and trees move along one line, ``by_height`` (P, 2 K) for a metre: along it a point says less, across it as
    much as any.
    """
    line = by_height.reshape(len(by_height), -1, 2)
    size = np.linalg.norm(line, axis=2, keepdims=True)
    along = line / np.maximum(size, 1e-12)
    less = 1 - 1 / np.hypot(1.0, _STANDING_SIGMA * size)

    def soften(values: Floats) -> Floats:
        pairs = values.reshape(*line.shape, -1)
        share = np.einsum("pkc,pkcn->pkn", along, pairs)
        return np.asarray((pairs - (less * along)[..., None] * share[:, :, None, :]).reshape(values.shape))

    return soften


def _slopes(problem: _Problem, sought: Floats, own: Floats, steps: Floats, *, is_own: bool) -> Floats:
    """Return the residuals' derivatives (P, 2 K, N), by differences."""
    here = problem.residual(sought, own)
    columns = []
    for k, step in enumerate(steps):
        change = np.zeros(len(steps))
        change[k] = step
        there = problem.residual(sought, own + change) if is_own else problem.residual(sought + change, own)
        columns.append(((there - here) / step).reshape(len(own), -1))
    return np.stack(columns, -1)


def _spreads(information: Floats, scores: Floats, times: Floats) -> Floats:
    """Return standard deviations (7,): the larger ones of the normal equations and of the blocks' scores."""
    inverse = np.linalg.inv(information)
    blocks, which = np.unique(np.floor((times - times.min()) / BLOCK_S), return_inverse=True)
    if len(blocks) < _LEAST_BLOCKS:
        raise NoEstimateError(
            f"the pairs of pictures lie within {len(blocks) * BLOCK_S:.0f} s: fly for at least a minute over the lot"
        )
    sums = np.zeros((len(blocks), _UNKNOWNS))
    np.add.at(sums, which, scores - scores.mean(0))
    spread = inverse @ (sums.T @ sums) @ inverse * len(blocks) / (len(blocks) - 1)
    return np.asarray(np.sqrt(np.maximum(np.diag(inverse), np.diag(spread))))
