"""A recording names its program and settings, and gives its messages by time, up to the damage."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.replay.flight import LONGEST_GAP_S, Origin, RecordedFlight, ReplayError, play
from hawk.store.replay import Recorded
from tests.unit.replay.recordings import DATUM, flight, frame, recorded_frame, tick, write


def test_a_recording_names_program_network_and_survey(tmp_path: Path) -> None:
    found = RecordedFlight(write(tmp_path / "a.mcap", flight(), survey="000007-x"))
    assert str(found.maker) == "hawk-drone 0.2.9, network 0123abcd"
    assert (found.survey, found.utc) == ("000007-x", "2026-05-04T00:00:00+00:00")
    older = RecordedFlight(write(tmp_path / "b.mcap", flight(), network=""))
    assert str(older.maker) == "hawk-drone 0.2.9, network not noted"


def test_settings_of_rooms_that_do_not_see_may_be_of_another_version(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap", [], configuration='{"wings": {"count": 2}, "vision": {"minimum_height_m": 9.0}}')
    assert RecordedFlight(path).settings().vision.minimum_height_m == 9.0


@pytest.mark.parametrize("configuration", ['{"vision": {"eyes": 3}}', "not JSON", "3"])
def test_settings_that_cannot_be_used_name_the_version_that_can(configuration: str, tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap", flight(), configuration=configuration)
    with pytest.raises(
        ReplayError, match=r"its settings cannot be used by this version: .*use hawk-drone 0\.2\.9, network 0123abcd"
    ):
        RecordedFlight(path).settings()


@pytest.mark.parametrize("content", [b"", b"notes of a flight" * 9, b"\x89MCAP0\r\n"])
def test_what_is_no_recording_is_refused_with_the_remedy(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "notes.mcap"
    path.write_bytes(content)
    with pytest.raises(ReplayError, match=r"notes\.mcap: .*name a recording of STORE/recordings"):
        RecordedFlight(path)


def test_a_recording_of_a_newer_format_is_refused(tmp_path: Path) -> None:
    found = RecordedFlight(write(tmp_path / "a.mcap", flight(), format="3"))
    with pytest.raises(ReplayError, match="newer version"):
        list(found.messages())


def test_a_file_without_an_end_is_read_and_its_damage_named(tmp_path: Path) -> None:
    whole = RecordedFlight(write(tmp_path / "a.mcap", flight()))
    torn = RecordedFlight(write(tmp_path / "b.mcap", flight(), is_closed=False))
    assert [one.data for one in torn.messages()] == [one.data for one in whole.messages()]
    assert whole.damage == ""
    assert "the file has no end" in torn.damage
    assert whole.seconds == pytest.approx(15.0 - 10.5)


def test_bytes_that_are_no_record_end_the_reading_there(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap", flight(), is_closed=False)
    with path.open("ab") as file:
        file.write(b"\x05" + (30).to_bytes(8, "little") + b"\xff" * 30)  # a message of no channel
    found = RecordedFlight(path)
    assert len(list(found.messages())) > 4
    assert "is damaged" in found.damage


def test_damage_that_a_reader_finds_ends_the_reading_there_unless_it_is_the_first(tmp_path: Path) -> None:
    found = RecordedFlight(write(tmp_path / "a.mcap", flight()))
    taken: list[str] = []

    def take(message: Recorded) -> bool:
        if taken.count("frame_input") == 2:
            raise ReplayError("a torn picture")
        taken.append(message.topic)
        return message.topic == "frame_input"

    found.follow(take)
    assert found.damage == "a torn picture"
    taken += ["frame_input", "frame_input"]
    with pytest.raises(ReplayError, match=r"a\.mcap: a torn picture; use hawk-drone 0\.2\.9"):
        RecordedFlight(found.path).follow(_refuse)


def _refuse(_: Recorded) -> bool:
    raise ReplayError("a torn picture")


def test_messages_are_played_as_they_came(tmp_path: Path) -> None:
    found = RecordedFlight(write(tmp_path / "a.mcap", [tick(10.0), tick(10.05), recorded_frame(frame(1), 11.0)]))
    times = [(one.message.topic, round(one.at, 3)) for one in found.played()]
    assert times[:2] == [("tick", 0.0), ("tick", 0.05)]
    assert times[-1] == ("frame_input", 1.0)


@given(st.lists(st.floats(-1e9, 1e9), max_size=30))
def test_a_clock_that_jumps_never_turns_play_back_nor_stops_it(times: list[float]) -> None:
    played = [one.at for one in play(Recorded("tick", time, b"") for time in times)]
    assert len(played) == len(times)
    steps = [late - early for early, late in pairwise(played)]
    assert all(-1e-9 <= step <= LONGEST_GAP_S + 1e-6 for step in steps)


def test_the_origin_is_that_of_the_facts(tmp_path: Path) -> None:
    nowhere = Origin()
    nowhere.look(Recorded("tick", 1.0, b'{"facts":{"now":1.0}}'))
    assert nowhere.datum is None
    origin = Origin()
    for message in RecordedFlight(write(tmp_path / "a.mcap", [tick(10.0)])).messages():
        origin.look(message)
    assert origin.datum == DATUM
    assert origin.arm_altitude == pytest.approx(40.0)


@pytest.mark.parametrize("data", [b'{"facts":{"position":{"datum":{}}}}', b'{"datum":{}}', b'{"datum":{"a'])
def test_facts_of_another_version_are_refused(data: bytes) -> None:
    with pytest.raises(ReplayError, match=r"the position at 1\.00 s cannot be read"):
        Origin().look(Recorded("tick", 1.0, data))
