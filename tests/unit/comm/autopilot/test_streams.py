from __future__ import annotations

import math

from hawk.comm.autopilot.streams import RateKeeper, Stream, wanted_streams

WANTED = {"FAST": Stream(1, 20.0), "SLOW": Stream(2, 0.5)}


def ids(streams: list[Stream]) -> list[int]:
    return [stream.message_id for stream in streams]


def test_an_interval_is_microseconds() -> None:
    assert Stream(30, 20.0).interval_us == 50_000


def test_everything_is_asked_for_at_first_and_not_again_at_once() -> None:
    keeper = RateKeeper(WANTED)
    assert ids(keeper.due(0.0)) == [1, 2]
    assert keeper.due(0.9) == []
    assert ids(keeper.due(1.0)) == [1, 2]


def test_what_comes_is_not_asked_for_until_it_stops() -> None:
    keeper = RateKeeper(WANTED)
    keeper.due(0.0)
    keeper.seen("FAST", 0.5)
    keeper.seen("SLOW", 0.5)
    assert keeper.due(1.4) == []
    assert ids(keeper.due(1.6)) == [1]
    assert keeper.age("FAST", 1.6) == 1.1
    assert ids(keeper.due(20.0)) == [1, 2]


def test_after_a_boot_everything_is_asked_for_at_once() -> None:
    keeper = RateKeeper(WANTED)
    keeper.due(0.0)
    keeper.seen("FAST", 0.1)
    keeper.forget()
    assert ids(keeper.due(0.2)) == [1, 2]
    assert keeper.age("FAST", 0.2) == math.inf


def test_a_message_that_may_never_come_is_asked_for_less_often() -> None:
    keeper = RateKeeper({"RARE": Stream(3, 10.0, ask_again_s=10.0)})
    assert ids(keeper.due(0.0)) == [3]
    assert keeper.due(9.9) == []
    assert ids(keeper.due(10.0)) == [3]
    assert wanted_streams(20.0)["DISTANCE_SENSOR"] == Stream(132, 10.0, ask_again_s=10.0)


def test_other_messages_do_not_matter() -> None:
    keeper = RateKeeper(WANTED)
    keeper.seen("OTHER", 1.0)
    assert ids(keeper.due(1.0)) == [1, 2]


def test_the_daemon_asks_for_poses_at_the_configured_rate() -> None:
    streams = wanted_streams(25.0)
    assert streams["LOCAL_POSITION_NED"] == Stream(32, 25.0)
    assert streams["ATTITUDE"] == Stream(30, 25.0)
    assert {"GLOBAL_POSITION_INT", "SYS_STATUS", "GPS_RAW_INT", "EXTENDED_SYS_STATE", "HOME_POSITION"} <= set(streams)
