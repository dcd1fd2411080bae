from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.model.shards import Sharded, differing

CHANGE = st.tuples(st.dictionaries(st.integers(0, 40), st.integers(0, 3)), st.lists(st.integers(0, 40), max_size=6))


def empty() -> Sharded[int, object]:
    return Sharded(lambda key: key // 4)


@pytest.mark.slow
@given(st.lists(CHANGE, max_size=8))
def test_it_is_a_dictionary_that_never_changes(changes: list[tuple[dict[int, int], list[int]]]) -> None:
    now: Sharded[int, object] = empty()
    model: dict[int, object] = {}
    for news, gone in changes:
        before, held = now, dict(model)
        values = {key: (value, object()) for key, value in news.items()}
        now = now.changed(values, gone)
        model = {key: value for key, value in model.items() if key not in gone} | values
        assert dict(before) == held
        assert dict(now) == model
        assert len(now) == len(model)
        assert now == model
        assert all((key in now) is (key in model) for key in range(41))
        expected = {key for key in held.keys() | model.keys() if held.get(key) is not model.get(key)}
        assert set(differing(now, before)) == expected
        assert set(differing(now, held)) == expected
        assert set(differing(dict(now), before)) == expected


def test_what_did_not_change_is_shared_and_not_looked_at() -> None:
    seen: list[int] = []

    def shard_of(key: int) -> int:
        seen.append(key)
        return key // 100

    whole = Sharded[int, int](shard_of).changed({key: key for key in range(10_000)})
    seen.clear()
    changed = whole.changed({4321: -1})
    assert len(seen) <= 2
    assert list(differing(changed, whole)) == [4321]
    assert changed[4321] == -1
    assert whole[4321] == 4321


def test_no_change_is_the_very_mapping() -> None:
    whole = empty().changed({1: "a"})
    assert whole.changed({}) is whole


def test_it_cannot_be_written() -> None:
    with pytest.raises(TypeError):
        empty()[1] = 2  # type: ignore[index]


def test_a_missing_key_is_an_error() -> None:
    with pytest.raises(KeyError):
        empty()[1]
