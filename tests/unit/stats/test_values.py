from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hawk.stats.values import Group, summed


@given(st.integers(0, 5), st.integers(1, 40), st.integers(0, 4), st.integers(0, 2**32 - 1))
def test_sums_over_groups_are_those_of_their_members(surveys: int, stalls: int, count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    groups = [Group(str(number), rng.random(stalls) < rng.choice([0.0, 0.3, 1.0])) for number in range(count)]
    is_seen, chance = rng.random((surveys, stalls)) < 0.5, rng.random((surveys, stalls)).astype(np.float32)
    for values, error in ((is_seen, 0.0), (chance, 1e-5)):
        found = [values[:, group.members].sum(axis=1, dtype=np.float64) for group in groups]
        expected = np.stack(found, 1) if found else np.zeros((surveys, 0))
        np.testing.assert_allclose(summed(values, groups), expected, rtol=error, atol=error)
