from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.store.journal_state import MAX_KEY, MAX_VALUE, check, pack, read_records

entries = st.lists(st.tuples(st.text(min_size=1, max_size=40), st.binary(max_size=300)), max_size=12)


def packed(items: list[tuple[str, bytes]]) -> bytes:
    return b"".join(pack(key, value) for key, value in items)


@pytest.mark.slow
@given(entries)
def test_what_was_packed_is_read_back(items: list[tuple[str, bytes]]) -> None:
    assert read_records(packed(items)) == (items, 0)


@given(entries, st.tuples(st.text(min_size=1, max_size=40), st.binary(max_size=300)), st.data())
def test_a_torn_tail_is_dropped_and_all_before_it_kept(
    items: list[tuple[str, bytes]], last: tuple[str, bytes], data: st.DataObject
) -> None:
    torn = pack(*last)[: data.draw(st.integers(0, len(pack(*last)) - 1))]
    found, lost = read_records(packed(items) + torn)
    assert found == items
    assert lost == len(torn)


@pytest.mark.slow
@given(entries.filter(lambda items: len(items) >= 2), st.data())
def test_a_damaged_byte_costs_one_record_and_makes_none_up(items: list[tuple[str, bytes]], data: st.DataObject) -> None:
    whole = bytearray(packed(items))
    position = data.draw(st.integers(0, len(whole) - 1))
    whole[position] ^= data.draw(st.integers(1, 255))
    found, lost = read_records(bytes(whole))
    assert lost > 0
    assert any(found == items[:index] + items[index + 1 :] for index in range(len(items)))


@given(st.binary(max_size=2000))
def test_rubbish_is_never_a_record_and_never_an_error(rubbish: bytes) -> None:
    found, lost = read_records(rubbish)
    assert found == []
    assert lost == len(rubbish)


def test_an_empty_file_is_an_empty_journal() -> None:
    assert read_records(b"") == ([], 0)


def test_rubbish_between_records_is_passed_over() -> None:
    data = pack("a", b"1") + b"\xa5HJ1 no record" + pack("b", b"2")
    assert read_records(data)[0] == [("a", b"1"), ("b", b"2")]


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("", b"", "1 to 1000 bytes"),
        ("k" * (MAX_KEY + 1), b"", "1 to 1000 bytes"),
        ("k", bytes(MAX_VALUE + 1), "'k' has"),
    ],
)
def test_what_is_too_long_is_refused_by_name(key: str, value: bytes, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        check(key, value)
