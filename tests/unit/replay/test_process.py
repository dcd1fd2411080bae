"""Recorded pictures are processed again, and each recorded map is compared with the one of the same frame."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from hawk.config.sections import Config, VisionSettings
from hawk.model.plans import PathPlan
from hawk.replay.flight import RecordedFlight, ReplayError
from hawk.replay.process import Again, process
from hawk.store.frame_codec import encode_frame
from tests.unit.replay.recordings import (
    KNOWN,
    S,
    fake,
    flight,
    frame,
    recorded_frame,
    recorded_map,
    stalls,
    tick,
    write,
)


def test_each_recorded_map_is_compared_with_that_of_the_frame_after_it(tmp_path: Path) -> None:
    again, seen = fake()
    shown: list[int] = []
    done = process(RecordedFlight(write(tmp_path / "a.mcap", flight(4, 3))), again, shown.append)
    assert (done.frames, done.compared, done.equal, done.missing, done.failed) == (4, 4, 4, 0, 0)
    assert shown == [1, 2, 3, 4]
    assert [one.sequence for one in seen.frames] == [1, 2, 3, 4]
    assert done.last is not None
    assert done.last.is_equal
    assert done.earlier == frozenset()
    assert done.seconds == pytest.approx(4.5)


def test_a_map_that_is_another_one_is_noticed(tmp_path: Path) -> None:
    again, _ = fake(width=2.6)
    done = process(RecordedFlight(write(tmp_path / "a.mcap", flight(4, 3))), again)
    assert (done.compared, done.equal) == (4, 0)


def test_the_first_plan_behind_each_frame_is_compared_with_the_one_that_is_made(tmp_path: Path) -> None:
    items = [tick(10.0, PathPlan(height=99.0)), recorded_frame(frame(1), 11.0)]
    items += [tick(11.05, PathPlan(height=21.0)), tick(11.1, PathPlan(height=99.0)), recorded_frame(frame(2), 12.0)]
    items += [tick(12.05), recorded_frame(frame(3), 13.0), tick(13.05, PathPlan(height=99.0))]
    done = process(RecordedFlight(write(tmp_path / "a.mcap", items)), fake()[0])
    assert (done.planned, done.planned_equal) == (2, 1)


def test_pictures_that_the_recording_lost_are_counted(tmp_path: Path) -> None:
    items = [tick(10.5), *(recorded_frame(frame(number), 11.0 + number) for number in (1, 2, 5, 9))]
    done = process(RecordedFlight(write(tmp_path / "a.mcap", items)), fake()[0])
    assert (done.frames, done.missing) == (4, 5)
    assert (done.compared, done.last) == (0, None)


def test_pictures_that_cannot_be_used_are_counted_with_the_first_reason(tmp_path: Path) -> None:
    frames = [frame(1), frame(2, map_problem="torn"), frame(3, map_problem="dark")]
    items = [recorded_frame(one, 12.0) for one in frames]
    done = process(RecordedFlight(write(tmp_path / "a.mcap", items)), fake()[0])
    assert (done.frames, done.failed, done.failure) == (3, 2, "torn")


def test_the_plan_of_a_known_lot_is_the_same_object_in_every_frame(tmp_path: Path) -> None:
    again, seen = fake()
    items = [recorded_frame(frame(number, known=(KNOWN,)), 11.0 + number) for number in (1, 2)]
    other = replace(KNOWN, id="other")
    items += [recorded_frame(frame(number, known=(other,)), 11.0 + number) for number in (3, 4)]
    process(RecordedFlight(write(tmp_path / "a.mcap", items)), again)
    one, two, three, four = (each.known for each in seen.frames)
    assert one is two
    assert three is four
    assert (one, three) == ((KNOWN,), (other,))


def test_stalls_of_an_earlier_flight_are_known_by_their_looks(tmp_path: Path) -> None:
    items = [tick(10.5), recorded_map(stalls(3, seen=7), 11.0), recorded_frame(frame(1), 11.1)]
    done = process(RecordedFlight(write(tmp_path / "a.mcap", items)), fake()[0])
    assert done.earlier == {1, 2, 3}


def test_another_survey_begins_where_the_recorded_map_is_empty_again(tmp_path: Path) -> None:
    again, seen = fake()
    items = [tick(10.5), recorded_map(stalls(3, seen=7), 11.0), recorded_frame(frame(1), 11.1)]
    items += [recorded_map({}, 16.0), recorded_frame(frame(2), 16.1)]
    done = process(RecordedFlight(write(tmp_path / "a.mcap", items)), again)
    assert seen.begun == 1
    assert done.earlier == frozenset()


def test_a_clock_that_jumps_changes_nothing(tmp_path: Path) -> None:
    items = flight(4, 3)
    leaps = [replace(item, time_ns=item.time_ns + (3600 * S if number % 2 else 0)) for number, item in enumerate(items)]
    done = process(RecordedFlight(write(tmp_path / "a.mcap", leaps)), fake()[0])
    assert (done.frames, done.compared, done.equal) == (4, 4, 4)


@pytest.mark.slow
def test_a_recording_that_is_cut_at_any_byte_is_processed_up_to_there_or_refused(tmp_path: Path) -> None:
    whole = write(tmp_path / "a.mcap", flight(3, 3)).read_bytes()
    path = tmp_path / "cut.mcap"
    read = []
    for end in range(0, len(whole), 397):
        path.write_bytes(whole[:end])
        frames, said = _cut(path)
        read.append(frames)
        assert ("the file has no end" in said) if frames else (str(path) in said)
    assert read == sorted(read)
    assert set(read) == {0, 1, 2, 3}


def _cut(path: Path) -> tuple[int, str]:
    """Return how many pictures are processed, and the damage or the refusal."""
    try:
        found = RecordedFlight(path)
        return process(found, fake()[0]).frames, found.damage
    except ReplayError as error:
        return 0, str(error)


def test_a_recording_without_pictures_is_refused_with_the_remedy(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap", [tick(10.5)])
    with pytest.raises(ReplayError, match="holds no pictures; name the recording of a flight with a camera"):
        process(RecordedFlight(path), fake()[0])
    torn = write(tmp_path / "b.mcap", [tick(10.5)], is_closed=False)
    with pytest.raises(ReplayError, match=r"holds no pictures \(the file has no end"):
        process(RecordedFlight(torn), fake()[0])


def test_pictures_of_another_version_are_refused_and_the_program_named(tmp_path: Path) -> None:
    items = [recorded_frame(frame(1, state="Swimming"), 11.0)]
    with pytest.raises(ReplayError, match=r"the picture at 11\.00 s cannot be read.*use hawk-drone 0\.2\.9"):
        process(RecordedFlight(write(tmp_path / "a.mcap", items)), fake()[0])


def test_a_picture_that_cannot_be_read_ends_the_processing_there(tmp_path: Path) -> None:
    items = [*flight(2, 2), recorded_frame(frame(3, state="Swimming"), 14.0), recorded_frame(frame(4), 15.0)]
    found = RecordedFlight(write(tmp_path / "a.mcap", items))
    assert process(found, fake()[0]).frames == 2
    assert "the picture at 14.00 s cannot be read" in found.damage


def test_a_recording_of_the_first_format_is_processed(tmp_path: Path) -> None:
    from mcap.writer import CompressionType, Writer

    path = tmp_path / "old.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.NONE, use_chunking=False)
        writer.start(profile="hawk", library="hawk-drone")
        writer.add_metadata("hawk", {"version": "0.1.0", "clock": "10.0", "configuration": "{}"})
        frames = writer.register_channel("frame_input", "hawk-frame", schema_id=0)
        for number in (1, 2):
            writer.add_message(frames, number * S, encode_frame(frame(number)), number * S)
        writer.finish()  # type: ignore[no-untyped-call]
    found = RecordedFlight(path)
    assert found.settings() == Config()
    assert str(found.maker) == "hawk-drone 0.1.0, network not noted"
    assert process(found, fake()[0]).frames == 2


def test_a_file_that_is_no_network_is_refused_by_the_name_of_its_option(tmp_path: Path) -> None:
    wrong = tmp_path / "notes.onnx"
    wrong.write_text("notes")
    with pytest.raises(ReplayError, match=r"^--model: .*notes\.onnx is not an ONNX file"):
        Again(Config(), "1", wrong)
    gone = Config(vision=VisionSettings(model=tmp_path / "gone.onnx"))
    with pytest.raises(ReplayError, match=r"the recording's settings: .*gone\.onnx.*or give that network by --model"):
        Again(gone, "1")


@pytest.mark.slow
def test_the_network_that_makes_the_map_now_is_named(tmp_path: Path) -> None:
    from hawk.algo.vision.network_file import network_name, packaged_weights

    copy = tmp_path / "copy.onnx"
    copy.write_bytes(packaged_weights())
    assert Again(Config(), "9", copy).maker == Again(Config(), "9").maker
    assert Again(Config(), "9").maker.network == network_name(None) != "unknown"
