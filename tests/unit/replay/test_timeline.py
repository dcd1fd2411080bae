"""The time line of a recorded flight."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest

from hawk.replay.flight import RecordedFlight, ReplayError
from hawk.replay.timeline import Shown, read_shown
from hawk.store.ring_buffer import Item
from tests.reference.kept import unpack
from tests.unit.replay.recordings import DATUM, S, flight, jpeg, tick, write


def decision(now: float, *acts: dict[str, object], fault: str = "") -> Item:
    return Item("decision", {"acts": list(acts), "fault": fault}, "json", round(now * S), 1)


def command(now: float, kind: str) -> Item:
    content = {"number": 2, "facts": {}, "client": "1", "Type": kind}
    return Item("command", content, "json", round(now * S), 1)


def read(path: Path) -> tuple[Shown, bytes]:
    beside = io.BytesIO()
    return read_shown(RecordedFlight(path), beside), beside.getvalue()


def test_pictures_and_maps_stand_in_the_file_beside_at_their_times(tmp_path: Path) -> None:
    shown, beside = read(write(tmp_path / "a.mcap", flight(3, 2)))
    assert [round(piece.at, 2) for piece in shown.pictures] == [1.5, 2.5, 3.5]
    assert all(beside[piece.offset : piece.offset + piece.length] == jpeg() for piece in shown.pictures)
    maps = [json.loads(beside[piece.offset : piece.offset + piece.length]) for piece in shown.maps]
    assert [len(each["features"]) for each in maps] == [1, 2, 2]
    assert shown.seconds == pytest.approx(3.5)
    assert shown.damage == ""


def test_events_are_states_messages_commands_and_what_was_decided(tmp_path: Path) -> None:
    items = [
        tick(10.5),
        command(11.0, "Arm"),
        decision(11.0, {"act": "EnterState", "name": "Takeoff"}, {"act": "Log", "level": "ok", "text": "Armed."}),
        decision(12.0, {"act": "SendTarget"}, {"act": "Ask"}, {"act": "SettleMode", "mode": 4}),
        decision(13.0, fault="the planner failed"),
    ]
    shown, _ = read(write(tmp_path / "a.mcap", items))
    assert [(round(each.at, 2), each.kind, each.text, each.level) for each in shown.events] == [
        (0.5, "command", "Arm", "info"), (0.5, "state", "Takeoff", "info"), (0.5, "message", "Armed.", "ok"),
        (1.5, "decision", "SettleMode", "info"), (2.5, "decision", "the planner failed", "error"),
    ]  # fmt: skip


def test_the_track_has_a_point_each_fifth_of_a_second(tmp_path: Path) -> None:
    shown, _ = read(write(tmp_path / "a.mcap", [tick(10.0 + 0.05 * k) for k in range(40)]))
    assert [round(at, 2) for at, *_ in shown.track] == [round(0.2 * k, 2) for k in range(10)]
    assert shown.track[0][1:] == (DATUM.latitude, DATUM.longitude, 20.0)


def test_a_clock_that_leaps_stretches_no_line(tmp_path: Path) -> None:
    shown, _ = read(write(tmp_path / "a.mcap", [tick(10.0), tick(9_000.0), tick(9_001.0)]))
    assert shown.seconds == pytest.approx(6.0)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.3, 0.6, 0.95])
def test_a_recording_that_is_cut_is_shown_up_to_there(tmp_path: Path, share: float) -> None:
    path = unpack("faults", tmp_path)
    data = path.read_bytes()
    whole, _ = read(path)
    path.write_bytes(data[: int(share * len(data))])
    cut, _ = read(path)
    assert 0 < cut.seconds < whole.seconds
    assert cut.events == whole.events[: len(cut.events)]
    assert "the file has no end" in cut.damage or "damaged" in cut.damage


def test_content_of_another_version_ends_the_line_there(tmp_path: Path) -> None:
    items = [tick(10.5), decision(11.0, {"act": "EnterState", "name": "Idle"}), decision(12.0, {"of": "another"})]
    shown, _ = read(write(tmp_path / "a.mcap", items))
    assert [event.text for event in shown.events] == ["Idle"]
    assert shown.damage.startswith("at 1.5 s: ")


def test_a_recording_of_which_nothing_is_known_names_its_program(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap", [decision(12.0, {"of": "another"})], is_closed=False)
    with pytest.raises(ReplayError, match=r"use hawk-drone 0\.2\.9, network 0123abcd, which recorded it"):
        read(path)
