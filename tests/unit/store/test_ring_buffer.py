from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hawk.store.ring_buffer import Item, Ring

S = 1_000_000_000


def record(seconds: float, name: str = "tick", size: int = 100) -> Item:
    return Item(name, seconds, "json", round(seconds * S), size)


def frame(seconds: float, size: int = 1000) -> Item:
    return Item("frame_input", seconds, "frame", round(seconds * S), size)


def test_messages_come_back_in_their_order_and_once() -> None:
    ring = Ring()
    items = [record(1), frame(1), record(1), frame(1.5), record(2)]
    for item in items:
        ring.add(item, is_entry=False)
    assert ring.take() == items
    assert ring.take() == []


def test_it_holds_a_minute_and_begins_at_an_entry() -> None:
    ring = Ring()
    for second in range(500):
        ring.add(frame(second), is_entry=False)
        ring.add(record(second, "memory" if second % 50 == 0 else "tick"), is_entry=second % 50 == 0)
    held = ring.take()
    records = [item for item in held if item.kind == "json"]
    assert records[0] == record(400, "memory")  # 450 is no minute ago
    assert len(records) == 100
    assert [item.payload for item in held if item.kind == "frame"] == list(range(439, 500))


def test_records_without_an_entry_begin_again_when_they_are_too_many() -> None:
    ring = Ring(record_bytes=1000)
    kept = [ring.add(record(number), is_entry=number == 0) for number in range(11)]
    assert kept == [True] * 10 + [False]
    assert ring.take() == []


def test_records_that_no_entry_leads_to_go_as_soon_as_one_comes() -> None:
    ring = Ring()
    before = [record(1), frame(1), record(1.5)]
    for item in before:
        ring.add(item, is_entry=False)
    entry, after = record(2, "memory"), record(2)
    assert ring.add(entry, is_entry=True)
    assert ring.add(after, is_entry=False)
    assert ring.take() == [before[1], entry, after]


@given(st.lists(st.tuples(st.sampled_from(["entry", "record", "frame"]), st.integers(1, 900)), max_size=80))
def test_it_never_holds_more_bytes_than_its_limits(given_items: list[tuple[str, int]]) -> None:
    ring = Ring(record_bytes=2000, frame_bytes=1500)
    for number, (kind, size) in enumerate(given_items):
        ring.add(frame(number, size) if kind == "frame" else record(number, kind, size), is_entry=kind == "entry")
        assert ring._records_size <= 2000
        assert ring._frames_size <= 1500
    held = ring.take()
    assert sum(item.size for item in held) <= 3500
    assert [item.time_ns for item in held] == sorted(item.time_ns for item in held)
