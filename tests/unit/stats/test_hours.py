from __future__ import annotations

import numpy as np
import pytest

from hawk.stats.counts import count
from hawk.stats.flow import Flow
from hawk.stats.hours import Hours, flown_hours
from hawk.stats.values import FREE, TAKEN, UNSEEN, Panel
from tests.unit.stats.panels import at, everything, panel


def hours_of(seen: Panel, changes: float = 0.8, drift: float = 0.0) -> Hours:
    return flown_hours(seen, count(seen, everything(seen)), Flow(changes, drift))


def filled(share: float, of: int = 20) -> list[int]:
    return [TAKEN] * round(share * of) + [FREE] * (of - round(share * of))


def test_only_hours_with_a_survey_have_a_value() -> None:
    found = hours_of(panel([at(9.2), at(9.8), at(13.5), at(9.1, days=1)], [filled(0.5)] * 4))
    assert [(day.day, hour) for day, hour in zip(found.day, found.hour, strict=True)] == [(4, 9), (4, 13), (5, 9)]
    assert found.surveys[:, 0].tolist() == [2, 1, 1]
    assert found.mean[:, 0] == pytest.approx([0.5, 0.5, 0.5], abs=1e-4)


def test_the_mean_of_an_hour_follows_the_surveys_before_and_after_it() -> None:
    rising = hours_of(panel([at(8.0), at(9.0), at(10.0)], [filled(0.2), filled(0.4), filled(0.6)]))
    assert rising.mean[:2, 0] == pytest.approx([0.3, 0.5], abs=0.005)


def test_a_second_survey_of_an_hour_makes_its_interval_narrower_and_an_unseen_one_does_not() -> None:
    one, two, blind = (
        float(hours_of(panel(moments, states)).variance[0, 0])
        for moments, states in (
            ([at(9.1)], [filled(0.5)]),
            ([at(9.1), at(9.7)], [filled(0.5)] * 2),
            ([at(9.1), at(9.7)], [filled(0.5), [UNSEEN] * 20]),
        )
    )
    assert two < one / 2
    assert blind == pytest.approx(one, rel=1e-3)


def test_an_hour_in_which_a_group_was_not_seen_has_no_mean() -> None:
    found = hours_of(panel([at(9.1), at(11.7)], [filled(0.5), [UNSEEN] * 20]))
    assert np.isnan(found.mean[:, 0]).tolist() == [False, True]
    assert [each.surveys for each in found.over()] == [1]


@pytest.mark.nightly
def test_means_and_variances_are_those_of_drawn_walks() -> None:
    """A random walk from its looks: the mean over an hour is off by what its variance says."""
    rng, steps, q = np.random.default_rng(3), 240, 0.004
    walks = 0.5 + np.cumsum(rng.normal(0, np.sqrt(q * 4 / steps), (150, steps)), axis=1)
    looks = [15, 100, 200]
    stalls = 1000
    moments = [at(9 + 4 * (k + 1) / steps) for k in looks]
    off = []
    for walk in walks:
        states = [filled(float(np.clip(walk[k], 0, 1)), stalls) for k in looks]
        found = hours_of(panel(moments, states, sure=1.0, a_row=200), changes=0.0, drift=q)
        real = [walk[h * 60 : (h + 1) * 60].mean() for h in (0, 1, 3)]
        off.append((found.mean[:, 0] - real) / np.sqrt(found.variance[:, 0]))
    assert np.std(off, axis=0) == pytest.approx([1, 1, 1], abs=0.2)


def test_the_mean_over_all_hours_counts_the_errors_that_hours_of_one_day_share() -> None:
    same_day = hours_of(panel([at(9.5), at(10.5)], [filled(0.5)] * 2))
    apart = hours_of(panel([at(9.5), at(9.5, days=1)], [filled(0.5)] * 2))
    shared = same_day.spread(np.full((2, 1, 1), 0.5))[0, 0]
    assert shared == pytest.approx(np.full(2, 0.5) @ same_day.alike[0].covariance[0, 0] @ np.full(2, 0.5))
    assert apart.spread(np.full((2, 1, 1), 0.5))[0, 0] == pytest.approx(apart.variance.sum() / 4)
