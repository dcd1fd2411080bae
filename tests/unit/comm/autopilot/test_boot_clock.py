"""The autopilot's boot clock: what late, repeated, corrupt and true stamps do to it."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.comm.autopilot.boot_clock import LATE_S, STAYS_S, BootClock, Reading

KINDS = ("LOCAL_POSITION_NED", "ATTITUDE", "GLOBAL_POSITION_INT", "SYSTEM_TIME")
BOOTED_AT = -100.0
"""Moment of the boot on our clock: at 0 the autopilot has run for 100 s."""


def run(clock: BootClock, start: float, end: float, booted_at: float = BOOTED_AT, delay: float = 0.01) -> list[Reading]:
    """Let every kind come 20 times a second."""
    readings = []
    for step in range(round((end - start) / 0.05)):
        sent = start + 0.05 * step
        readings += [clock.take(kind, sent - booted_at, sent + delay) for kind in KINDS]
    return readings


def events(readings: list[Reading]) -> list[str]:
    return [reading.event for reading in readings if reading.event]


@pytest.fixture
def clock() -> BootClock:
    made = BootClock(1.0)
    assert events(run(made, 0.0, 3.0)) == ["found"]
    return made


def test_one_message_is_no_clock_and_one_kind_is_none() -> None:
    clock = BootClock(1.0)
    readings = [clock.take("ATTITUDE", 100.0 + n, float(n)) for n in range(20)]
    assert readings == [Reading(None)] * 20
    assert clock.to_ours(5.0) is None
    assert clock.newest is None
    found = clock.take("SYSTEM_TIME", 120.0, 20.0)
    assert found == Reading(20.0, "found")
    assert clock.newest == 120.0


def test_the_first_stamp_may_be_corrupt() -> None:
    clock = BootClock(1.0)
    assert clock.take("ATTITUDE", 4_000_000.0, 0.0) == Reading(None)
    readings = run(clock, 0.0, 1.0)
    assert events(readings) == ["found"]
    assert clock.to_ours(100.0) == pytest.approx(0.01)


def test_a_stamp_is_put_on_our_clock_by_the_least_delay(clock: BootClock) -> None:
    assert clock.take("ATTITUDE", 103.0, 3.4).time == pytest.approx(3.01)


@pytest.mark.parametrize("kind", KINDS)
def test_a_late_stamp_is_dropped_and_is_no_boot(clock: BootClock, kind: str) -> None:
    assert clock.take(kind, 101.8, 3.0) == Reading(None)
    assert clock.take(kind, 103.0, 3.01).time == pytest.approx(3.01)


def test_a_repeated_stamp_is_dropped(clock: BootClock) -> None:
    assert clock.take("ATTITUDE", 103.0, 3.01).time is not None
    assert clock.take("ATTITUDE", 103.0, 3.02) == Reading(None)


def test_kinds_may_overtake_each_other_by_a_little(clock: BootClock) -> None:
    assert clock.take("ATTITUDE", 103.2, 3.21).time is not None
    assert clock.take("SYSTEM_TIME", 103.1, 3.22).time == pytest.approx(3.11)


@pytest.mark.fault("One stamp is corrupt: far ahead, or near zero", "Dropped: no boot, the clock stays")
@pytest.mark.parametrize("stamp", [0.0, 0.4, 2.9, 104.0, 200.0, 4_294_967.0])
def test_one_corrupt_stamp_moves_nothing(clock: BootClock, stamp: float) -> None:
    assert clock.take("ATTITUDE", stamp, 3.0) == Reading(None)
    after = run(clock, 3.0, 6.0)
    assert events(after) == []
    assert all(reading.time is not None for reading in after)


@pytest.mark.fault("A proxy replays 2 s of the stream and stays 2 s late", "No boot; poses go on with their true age")
def test_a_stream_that_comes_again_two_seconds_late_is_no_boot(clock: BootClock) -> None:
    """A proxy replays the last two seconds and is two seconds late from then on: nothing else comes."""
    readings = run(clock, 1.0, 6.0, delay=2.01)
    assert events(readings) == []
    assert all(reading.time is None for reading in readings[: len(KINDS) * 39])
    assert all(reading.time is not None for reading in readings[len(KINDS) * 41 :])


@pytest.mark.fault(
    "The autopilot boots",
    "Noticed 0.5 s after the first messages of the new clock; rates asked again, map tie and parameters "
    'dropped, "armed" left to HEARTBEAT',
)
def test_a_boot_is_noticed_within_a_second_of_its_messages(clock: BootClock) -> None:
    readings = run(clock, 5.0, 6.0, booted_at=3.5)
    assert events(readings) == ["booted"]
    noticed = [reading.event for reading in readings].index("booted") * 0.05 / len(KINDS)
    assert STAYS_S <= noticed <= STAYS_S + 0.1
    assert clock.to_ours(1.5) == pytest.approx(5.01)


def test_a_boot_is_noticed_without_a_position(clock: BootClock) -> None:
    found = []
    for step in range(20):
        sent = 5.0 + 0.05 * step
        found += [clock.take(kind, sent - 3.5, sent).event for kind in ("ATTITUDE", "SYSTEM_TIME")]
    assert "booted" in found


def test_one_kind_alone_is_no_boot(clock: BootClock) -> None:
    assert all(clock.take("ATTITUDE", 1.5 + 0.05 * n, 5.0 + 0.05 * n) == Reading(None) for n in range(200))


def test_while_the_old_clock_goes_on_there_is_no_boot(clock: BootClock) -> None:
    for step in range(100):
        sent = 3.0 + 0.1 * step
        assert not events(run(clock, sent, sent + 0.05))
        assert not events(run(clock, sent, sent + 0.05, booted_at=2.99))


def test_a_clock_that_was_mapped_too_late_is_corrected() -> None:
    clock = BootClock(1.0)
    run(clock, 0.0, 1.0, delay=3.0)
    readings = run(clock, 5.0, 6.0)
    assert events(readings) == ["corrected"]
    assert clock.to_ours(105.0) == pytest.approx(5.01)


def test_in_a_fast_simulation_delays_count_times_the_speed() -> None:
    clock = BootClock(4.0)
    run(clock, 0.0, 1.0, delay=0.8)
    assert all(reading.time is not None for reading in run(clock, 1.0, 2.0, delay=0.0))


@pytest.mark.slow
@pytest.mark.fault("Datagrams late by up to 3 s, repeated, reordered, some corrupt", "No boot, no sample of the past")
@given(
    delays=st.lists(st.floats(0.0, 3.0), min_size=60, max_size=240),
    repeated=st.sets(st.integers(0, 239)),
    corrupt=st.dictionaries(st.integers(0, 239), st.floats(0.0, 4e6), max_size=12),
    uptime=st.floats(5.0, 1e5),
    seed=st.integers(0, 2**32 - 1),
)
def test_whatever_the_network_does_there_is_no_boot_and_no_sample_of_the_past(
    delays: list[float], repeated: set[int], corrupt: dict[int, float], uptime: float, seed: int
) -> None:
    """Datagrams late by up to 3 s, repeated, reordered, a few corrupt: time never runs backwards in a kind."""
    clock = BootClock(1.0)
    run(clock, 0.0, 2.0, booted_at=-uptime)
    choose = random.Random(seed)
    arrivals: list[tuple[float, str, float]] = []
    for index, delay in enumerate(delays):
        sent = 2.0 + 0.02 * index
        kind = choose.choice(KINDS)
        stamp = corrupt.get(index, sent + uptime)
        arrivals.append((sent + delay, kind, stamp))
        if index in repeated:
            arrivals.append((sent + delay + choose.uniform(0.0, 3.0), kind, stamp))
        arrivals.append((sent + 0.01, KINDS[index % 4], sent + uptime))  # another copy of the stream goes on
    newest: dict[str, float] = {}
    for arrival, kind, stamp in sorted(arrivals):
        reading = clock.take(kind, stamp, arrival)
        assert reading.event == ""
        if reading.time is not None:
            assert stamp > newest.get(kind, 0.0)
            newest[kind] = stamp
            assert arrival - 3.1 - LATE_S <= reading.time <= arrival + 0.5


@pytest.mark.slow
@given(delays=st.lists(st.floats(0.0, 3.0), min_size=60, max_size=240), uptime=st.floats(5.0, 1e5))
def test_a_link_that_delays_everything_is_no_boot(delays: list[float], uptime: float) -> None:
    clock = BootClock(1.0)
    run(clock, 0.0, 2.0, booted_at=-uptime)
    sent = [(2.0 + 0.02 * index, KINDS[index % 4], delay) for index, delay in enumerate(delays)]
    for arrival, kind, stamp in sorted((at + delay, kind, at + uptime) for at, kind, delay in sent):
        assert clock.take(kind, stamp, arrival).event == ""


@pytest.mark.slow
@given(uptime=st.floats(5.0, 1e5), down=st.floats(0.6, 60.0), late=st.lists(st.floats(0.0, 1.0), max_size=10))
def test_a_boot_is_found_though_old_datagrams_come_after_it(uptime: float, down: float, late: list[float]) -> None:
    clock = BootClock(1.0)
    run(clock, 0.0, 2.0, booted_at=-uptime)
    start = 2.0 + down
    old = sorted((start + delay, "ATTITUDE", uptime + 1.9 - delay) for delay in late)
    found = []
    for step in range(60):
        sent = start + 0.05 * step
        while old and old[0][0] <= sent:
            arrival, kind, stamp = old.pop(0)
            found.append(clock.take(kind, stamp, arrival).event)
        found += [clock.take(kind, 0.5 + 0.05 * step, sent).event for kind in KINDS]
    assert [event for event in found if event] == ["booted"]
