"""Mean occupancy of a group over each hour in which it was surveyed, with its variance.

A survey shows a moment; an hour is more than that. Between looks the share of taken stalls is a random walk: its mean
over an hour, given all surveys of that day, is normal, with a mean and a covariance in closed form.
Hours without a survey have no value.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import date
from typing import Final

import numpy as np

from hawk.stats.counts import Counted
from hawk.stats.flow import Flow
from hawk.stats.values import DEVIATIONS, NOTHING, Bools, Estimate, Floats, Ints, Panel

HOUR_S: Final = 3600.0
_WIDE: Final = 1e3
"""Variance of a share of which nothing is known yet."""
_UNSEEN: Final = 1e6
"""Variance of a look that saw nothing of a group."""
_LEAST: Final = 1e-9


_ALL: Final = slice(None)


@dataclass(frozen=True, slots=True)
class Alike:
    """Days with k hours each: ``hours`` (D, k) are their numbers, ``covariance`` (D, G, k, k) of their means."""

    hours: Ints = field(repr=False)
    covariance: Floats = field(repr=False)


@dataclass(frozen=True, slots=True)
class Hours:
    """The K flown hours of a period, by their time, for G groups.

    ``day``, ``hour``: date and hour of the lot's clock; ``surveys`` (K, G): how many saw a group in it; ``capacity``
    (K, G): stalls, the mean over these surveys, 0 without one; ``mean`` (K, G): share of taken ones over the hour, NaN
    where no survey saw one; ``variance`` (K, G) of the mean; ``alike``: the covariances among the hours of a day.
    """

    day: tuple[date, ...]
    hour: tuple[int, ...]
    surveys: Floats = field(repr=False)
    capacity: Floats = field(repr=False)
    mean: Floats = field(repr=False)
    variance: Floats = field(repr=False)
    alike: tuple[Alike, ...] = field(repr=False)

    def bounds(self) -> tuple[Floats, Floats]:
        """Return the ends of the interval of each mean, (K, G)."""
        off = DEVIATIONS * np.sqrt(self.variance)
        return np.clip(self.mean - off, 0.0, 1.0), np.clip(self.mean + off, 0.0, 1.0)

    def spread(self, weights: Floats, groups: slice = _ALL) -> Floats:
        """Return the variance of sums over hours by weights, (K, C, G) -> (C, G). Days are independent."""
        total = np.zeros(weights.shape[1:])
        for each in self.alike:
            part = weights[each.hours]
            total += np.einsum("dkcg,dgkl,dlcg->cg", part, each.covariance[:, groups], part, optimize=True)
        return np.maximum(total, 0.0)

    def over(self, chosen: Bools | None = None) -> list[Estimate]:
        """Return the mean of each group over the hours in which it was seen: all, or the ``chosen`` ones (K,)."""
        known = self.known(chosen)
        return self._sums(known.astype(np.float64), known, np.maximum(known.sum(axis=0), 1))

    def load(self, chosen: Bools | None = None) -> list[Estimate]:
        """Return the space-hours that were taken of each group: its share times its stalls, hour by hour."""
        return self._sums(self.capacity, self.known(chosen), np.ones(self.capacity.shape[1], np.int64))

    def known(self, chosen: Bools | None = None) -> Bools:
        """Return in which hours each group was seen (K, G), all or the ``chosen`` ones (K,)."""
        is_seen = np.isfinite(self.mean)
        return is_seen if chosen is None else is_seen & chosen[:, None]

    def _sums(self, weights: Floats, known: Bools, parts: Ints) -> list[Estimate]:
        """Return the sums of each group over ``known`` hours (K, G) by weights (K, G), divided by ``parts`` (G,)."""
        weights = np.where(known, weights, 0.0)
        value = np.nansum(self.mean * weights, axis=0) / parts
        off, most = np.sqrt(self.spread(weights[:, None])[0]) / parts, weights.sum(axis=0) / parts
        surveys = np.where(known, self.surveys, 0.0).sum(axis=0)
        return [
            around(float(value[k]), float(off[k]), int(surveys[k]), high=float(most[k])) if surveys[k] else NOTHING
            for k in range(len(parts))
        ]


def around(value: float, deviation: float, surveys: int, low: float = 0.0, high: float = 1.0) -> Estimate:
    """Return a figure with its interval by a standard deviation, not below ``low`` or above ``high``."""
    off, value = DEVIATIONS * deviation, min(max(value, low), high)  # a sum may be beyond an end by its rounding
    return Estimate(value, max(value - off, low), min(value + off, high), surveys)


def flown_hours(panel: Panel, counted: Counted, flow: Flow) -> Hours:
    """Return the mean share of each group of ``counted`` over every hour with a survey."""
    days = _days(panel)
    first = dict(
        zip([day.day for day in days], np.cumsum([0, *(len(day.hours) for day in days)]).tolist(), strict=False)
    )
    count = sum(len(day.hours) for day in days)
    groups = counted.capacity.shape[1]
    mean, variance, surveys, capacity = (np.zeros((count, groups)) for _ in range(4))
    sizes: dict[tuple[int, int], list[_Day]] = defaultdict(list)
    for day in days:
        sizes[len(day.surveys), len(day.hours)].append(day)
    walk = flow.walk(counted.capacity.max(axis=0, initial=1.0))
    alike = []
    for members in sizes.values():
        shares = _shares(members, counted, walk)
        hours = np.array([first[day.day] + np.arange(len(day.hours)) for day in members])
        mean[hours], surveys[hours], capacity[hours] = shares.mean, shares.surveys, shares.capacity
        variance[hours] = np.maximum(np.swapaxes(np.diagonal(shares.covariance, axis1=2, axis2=3), 1, 2), 0.0)
        alike.append(Alike(hours, shares.covariance))
    return Hours(
        tuple(day.day for day in days for _ in day.hours), tuple(hour for day in days for hour in day.hours),
        surveys, capacity, mean, variance, tuple(alike),
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Day:
    """Surveys (n,) of one day by their numbers, and the hours (k,) in which they lie.

    ``since``: when the first of these hours began, UTC, Unix seconds. ``moments`` (n,), ``begins`` (k,): hours since
    then. ``of_hour`` (n,): hour of each survey.
    """

    day: date
    since: float
    surveys: list[int]
    moments: list[float]
    begins: list[float]
    hours: list[int]
    of_hour: list[int]


def _days(panel: Panel) -> list[_Day]:
    days: dict[date, _Day] = {}
    for number, (survey, local) in enumerate(zip(panel.surveys, panel.local_times, strict=True)):
        begin = survey.at - (local.minute * 60 + local.second + local.microsecond / 1e6)
        day = days.get(local.date())
        if day is None:
            day = days[local.date()] = _Day(local.date(), begin, [], [], [], [], [])
        begins = round((begin - day.since) / HOUR_S, 6)
        if begins not in day.begins:
            day.begins.append(begins)
            day.hours.append(local.hour)
        day.surveys.append(number)
        day.moments.append((survey.at - day.since) / HOUR_S)
        day.of_hour.append(day.begins.index(begins))
    return list(days.values())


@dataclass(frozen=True, slots=True)
class _Shares:
    """Hours of D days: ``surveys``, ``capacity``, ``mean`` (D, k, G) and ``covariance`` (D, G, k, k), as in `Hours`."""

    surveys: Floats
    capacity: Floats
    mean: Floats
    covariance: Floats


def _shares(days: Sequence[_Day], counted: Counted, walk: Floats) -> _Shares:
    """Return the hours of D days with as many surveys (n) and hours (k) each.

    ``walk`` (G,): variance of each group's share that an hour adds. Of a random walk W from a wide begin, looks with
    noise R at moments t and the mean over an hour h are normal: with A = cov(W(t), W(t)) + R and C = cov(h, W(t)), the
    mean is C A⁻¹ y, and the covariance cov(h, h) - C A⁻¹ Cᵀ.
    """
    numbers = np.array([day.surveys for day in days])
    moments, begins = np.array([day.moments for day in days]), np.array([day.begins for day in days])
    seen = np.swapaxes(counted.seen[numbers] > 0, 1, 2)
    share = np.where(seen, np.nan_to_num(np.swapaxes(counted.share[numbers], 1, 2)), 0.0)
    noise = np.where(seen, np.nan_to_num(np.swapaxes(counted.variance[numbers], 1, 2)) + _LEAST, _UNSEEN)
    scale = walk[None, :, None, None]
    looks = _WIDE + scale * np.minimum(moments[:, :, None], moments[:, None, :])[:, None]
    known = looks + noise[..., None] * np.eye(moments.shape[1])
    across = _WIDE + scale * _mean_of_earlier(begins, moments)[:, None]
    weights = np.linalg.solve(known, np.swapaxes(across, 2, 3))
    mean = np.einsum("dgnk,dgn->dkg", weights, share)
    covariance = _WIDE + scale * _between(begins)[:, None] - across @ weights
    is_in = np.array([np.arange(len(day.hours))[:, None] == np.array(day.of_hour) for day in days], np.float64)
    counts = np.einsum("dkn,dgn->dkg", is_in, seen.astype(np.float64))
    stalls = np.where(seen, np.swapaxes(counted.capacity[numbers], 1, 2), 0.0)
    capacity = np.einsum("dkn,dgn->dkg", is_in, stalls) / np.maximum(counts, 1.0)
    means = np.where(counts > 0, np.clip(mean, 0.0, 1.0), np.nan)
    return _Shares(counts, capacity, means, covariance)


def _mean_of_earlier(begins: Floats, moments: Floats) -> Floats:
    """Return the mean, over each hour (D, k), of the smaller of its moment and that of each look (D, n): (D, k, n)."""
    begin, moment = begins[:, :, None], moments[:, None, :]
    within = np.clip(moment, begin, begin + 1.0)
    return np.asarray((within**2 - begin**2) / 2 + moment * (begin + 1.0 - within), np.float64)


def _between(begins: Floats) -> Floats:
    """Return the mean of the smaller moment over each pair of hours, (D, k, k): their covariance by the walk."""
    earlier = np.minimum(begins[:, :, None], begins[:, None, :])
    same = np.eye(begins.shape[1], dtype=bool)
    return np.where(same, earlier + 1 / 3, earlier + 1 / 2)
