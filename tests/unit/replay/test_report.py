"""A processed recording in words and as JSON: which program made which map, and what differs."""

from __future__ import annotations

import json
from pathlib import Path

from hawk.model.lot_map import StallState
from hawk.model.plans import PathPlan
from hawk.replay.flight import Maker, RecordedFlight
from hawk.replay.process import process
from hawk.replay.report import SHOWN_CHANGES, Report
from tests.unit.replay.recordings import (
    FakeAgain,
    fake,
    flight,
    frame,
    recorded_frame,
    recorded_map,
    stalls,
    tick,
    write,
)

NOW = Maker("0.3.0", "ffff0000")


def report(path: Path, **changes: object) -> Report:
    found = RecordedFlight(path)
    return Report.of(found, NOW, process(found, fake(**changes)[0]))  # type: ignore[arg-type]


def test_an_equal_map_is_said_to_be_equal_with_both_programs(tmp_path: Path) -> None:
    found = report(write(tmp_path / "a.mcap", flight(4, 3)))
    assert found.is_equal
    lines = found.text().splitlines()
    assert lines[0] == f"{tmp_path / 'a.mcap'}: recording of 2026-05-04T00:00:00+00:00"
    assert "  recorded by hawk-drone 0.2.9, network 0123abcd" in lines
    assert "  made now by hawk-drone 0.3.0, network ffff0000" in lines
    assert lines[-1] == "  stalls: 3 recorded, 3 now; 4 of 4 recorded maps are equal byte for byte"
    values = json.loads(json.dumps(found.json()))
    assert values["is_equal"] is True
    assert values["recorded_by"] == {"version": "0.2.9", "network": "0123abcd"}
    assert (values["pictures"], values["changes"]) == (4, [])


def test_what_differs_is_a_table_and_whole_in_json(tmp_path: Path) -> None:
    items = [tick(10.5), recorded_map(stalls(3), 11.0)]
    items += [recorded_frame(frame(1, sequence=7), 11.1), recorded_frame(frame(9), 12.0)]
    found = report(write(tmp_path / "a.mcap", items), state=StallState.FREE)
    assert not found.is_equal
    text = found.text()
    assert "the last map: 2 lost, 1 of another state" in text
    assert "taken -> free" in text
    assert "pictures missing in the recording: 1; the map" in text
    values = found.json()
    assert values["numbers"] == {"lost": 2, "found": 0, "moved": 0, "state": 1, "values": 0}
    assert [each["kind"] for each in values["changes"]] == ["lost", "lost", "state"]
    assert values["changes"][0]["recorded"]["id"] == 2
    assert values["changes"][0]["now"] is None


def test_a_long_table_is_cut_and_says_so(tmp_path: Path) -> None:
    items = [tick(10.5), recorded_map(stalls(SHOWN_CHANGES + 6), 11.0), recorded_frame(frame(1), 11.1)]
    text = report(write(tmp_path / "a.mcap", items), most=1).text()
    assert text.count("lost  ") == SHOWN_CHANGES
    assert "and 5 more: --json has all" in text


def test_doubts_are_said(tmp_path: Path) -> None:
    items = [tick(10.5), recorded_map(stalls(3, seen=40), 11.0), recorded_frame(frame(1, map_problem="dark"), 11.1)]
    text = report(write(tmp_path / "a.mcap", items, is_closed=False)).text()
    assert "processed up to the damage at 0.6 s: the file has no end" in text
    assert "pictures that could not be used: 1; the first: dark" in text
    assert "it began with a map of 3 stalls, which the recording does not hold" in text
    assert "2 of before not seen again" in text


def test_another_plan_is_a_difference(tmp_path: Path) -> None:
    items = [*flight(4, 3), tick(15.05, PathPlan(height=24.0))]
    assert report(write(tmp_path / "a.mcap", items)).is_equal
    items[-1] = tick(15.05, PathPlan(height=25.0))
    found = report(write(tmp_path / "b.mcap", items))
    assert not found.is_equal
    assert found.text().endswith("plans: 0 of 1 recorded plans are equal")
    assert "4 of 4 recorded maps are equal" in found.text()
    assert (found.json()["plans_compared"], found.json()["plans_equal"]) == (1, 0)


def test_a_recording_without_a_map_is_not_compared(tmp_path: Path) -> None:
    found = report(write(tmp_path / "a.mcap", [tick(10.5), recorded_frame(frame(1), 11.0)]))
    assert found.is_equal
    assert found.text().endswith("stalls: 1 now; the recording holds no map to compare them with")
    assert found.json()["stalls_recorded"] is None
    assert found.json()["stalls_now"] == len(FakeAgain().map.stalls) + 1
