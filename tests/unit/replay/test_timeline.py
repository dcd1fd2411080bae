"""The time line of a recorded flight."""

from __future__ import annotations

import io
import json
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from hawk.formats.box import RefusedError
from hawk.replay.film import Film, PackedFilm, Piece
from hawk.replay.flight import RecordedFlight, ReplayError
from hawk.replay.timeline import MOST, Thinned, packed_film, read_film
from hawk.store.ring_buffer import Item
from tests.reference.kept import unpack
from tests.unit.replay.recordings import DATUM, S, flight, jpeg, tick, write


def decision(now: float, *acts: dict[str, object], fault: str = "") -> Item:
    return Item("decision", {"acts": list(acts), "fault": fault}, "json", round(now * S), 1)


def command(now: float, kind: str) -> Item:
    content = {"number": 2, "facts": {}, "client": "1", "Type": kind}
    return Item("command", content, "json", round(now * S), 1)


def message(now: float, text: str, **more: object) -> Item:
    said = {"number": 1, "time": "", "level": "info", "text": text, "details": "", **more}
    return Item("message", said, "json", round(now * S), 1)


def facts(now: float, **of: object) -> Item:
    """Return a tick with these facts, and a pose."""
    item = tick(now)
    item.payload["facts"].update(of)
    return item


class Read:
    """A film, and its pieces as bytes."""

    def __init__(self, path: Path) -> None:
        beside = io.BytesIO()
        self.film, pictures, maps = read_film(RecordedFlight(path), beside)
        self.packed = PackedFilm.of(self.film, pictures, maps)
        self._files = {False: path.read_bytes(), True: beside.getvalue()}

    def picture(self, number: int) -> bytes:
        return self._bytes(self.packed.picture(number))

    def map(self, number: int) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self._bytes(self.packed.map(number)))
        return found

    def _bytes(self, piece: Piece | None) -> bytes:
        assert piece is not None
        return self._files[piece.is_beside][piece.offset : piece.offset + piece.length]


def film(path: Path, *items: Item) -> Film:
    return Read(write(path / "a.mcap", items)).film


def test_pictures_and_maps_stand_in_the_recording_at_their_times(tmp_path: Path) -> None:
    read = Read(write(tmp_path / "a.mcap", flight(3, 2)))
    assert read.film.pictures == [1.5, 2.5, 3.5]
    assert [read.picture(number) for number in range(3)] == [jpeg()] * 3
    assert [len(read.map(number)["features"]) for number in range(3)] == [1, 2, 2]
    assert (read.packed.picture(3), read.packed.map(3)) == (None, None)
    assert json.loads(read.packed.text)["maps"] == read.film.maps
    assert read.film.seconds == pytest.approx(3.5)
    assert read.film.problem == ""


def test_pictures_of_a_packed_recording_stand_in_the_file_beside(tmp_path: Path) -> None:
    path, packed = write(tmp_path / "a.mcap", flight(2, 2)), tmp_path / "packed.mcap"
    with path.open("rb") as source, packed.open("wb") as target:
        writer = Writer(target, chunk_size=2_000)
        writer.start(profile="hawk", library="another")
        reader = make_reader(source)
        for metadata in reader.iter_metadata():
            writer.add_metadata(metadata.name, dict(metadata.metadata))
        ids: dict[int, int] = {}
        for schema, channel, each in reader.iter_messages():
            assert schema is not None
            if channel.id not in ids:
                made = writer.register_schema(schema.name, schema.encoding, schema.data)
                ids[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, made)
            writer.add_message(ids[channel.id], each.log_time, each.data, each.publish_time)
        writer.finish()  # type: ignore[no-untyped-call]
    read = Read(packed)
    assert [read.picture(number) for number in range(2)] == [jpeg()] * 2
    assert len(read.map(1)["features"]) == 2


def test_phases_are_the_states_and_messages_come_with_their_sentences(tmp_path: Path) -> None:
    said = {"text": "At 20 m.", "code": "at-height", "values": {"height": 20}}
    made = film(
        tmp_path,
        tick(10.5),
        command(11.0, "Arm"),
        decision(11.0, {"act": "EnterState", "name": "Takeoff"}, {"act": "Log", "level": "ok", "text": "Armed."}),
        message(11.1, "Armed.", level="ok"),
        decision(12.0, {"act": "SendTarget"}, {"act": "Ask"}, {"act": "SetDatum", "place": 4}),
        message(12.0, "At 20 m.", sentences=[said]),
    )
    assert [(each.at, each.state) for each in made.phases] == [(0.5, "Takeoff")]
    assert [(each.at, each.level, each.text) for each in made.messages] == [
        (0.6, "ok", "Armed."),
        (1.5, "info", "At 20 m."),
    ]
    assert [each.model_dump() for each in made.messages[1].sentences] == [said]


def test_a_recording_of_before_has_the_messages_of_its_decisions(tmp_path: Path) -> None:
    made = film(tmp_path, decision(11.0, {"act": "Log", "level": "ok", "text": "Armed."}))
    assert [(each.text, each.sentences) for each in made.messages] == [("Armed.", [])]


def test_the_track_has_a_point_each_fifth_of_a_second(tmp_path: Path) -> None:
    made = film(tmp_path, *(moved(10.0 + 0.05 * k, north=k) for k in range(40)))
    assert [row[0] for row in made.track] == [round(0.2 * k, 2) for k in range(10)]
    assert made.track[1] == [0.2, 4.0, 0.0, 20.0, 0.0]
    assert made.datum == [DATUM.latitude, DATUM.longitude]


def moved(now: float, north: float) -> Item:
    item = tick(now)
    item.payload["facts"]["position"]["pose"]["map"]["north"] = north
    return item


def test_values_are_those_of_their_time_and_written_where_they_change(tmp_path: Path) -> None:
    fence = {"polygon": [[0, 0], [0, 9], [9, 9]], "zones": [[[1, 1], [1, 2], [2, 2]]]}
    seen = [{"north": 1.0, "east": 2.0}] * 4
    sight = {"counts": {"free": 1, "taken": 2, "unknown": 3}, "footprint": seen}
    battery = {"info": {"percentage": 91.4}, "reserve": {"time_left": 700.2}}
    position = {**tick(11.0).payload["facts"]["position"], "home": {"north": 0.0, "east": 0.0}}
    given = {"sight": sight, "battery": battery, "limits": {"fence": fence}, "position": position}
    made = film(tmp_path, tick(10.0), *(facts(11.0 + k, **given) for k in range(5)))
    assert made.counts == [[1.0, 1, 2, 3]]
    assert made.battery == [[1.0, 91, 700]]
    assert made.homes == [[1.0, 0.0, 0.0]]
    assert made.footprints == [[1.0, *[1.0, 2.0] * 4]]
    assert [(each.at, each.ring, each.zones) for each in made.fences] == [(1.0, fence["polygon"], fence["zones"])]


def test_another_origin_of_the_map_moves_what_comes_after(tmp_path: Path) -> None:
    later = tick(11.0)
    later.payload["facts"]["position"]["datum"]["latitude"] += 10 / 111_200
    made = film(tmp_path, tick(10.0), later)
    assert made.track[1][1] == pytest.approx(10.0, abs=0.1), "metres north of the first origin"


def test_the_moment_is_that_of_the_surveys(tmp_path: Path) -> None:
    computer = Read(write(tmp_path / "a.mcap", [tick(12.0)])).film.began
    drawn = Read(write(tmp_path / "b.mcap", [tick(12.0)], zero_utc="2024-01-02T10:00:00+00:00")).film.began
    assert computer == datetime(2026, 5, 4, 0, 0, 2, tzinfo=UTC)
    assert drawn == datetime(2024, 1, 2, 10, 0, 12, tzinfo=UTC)


def test_a_clock_that_leaps_stretches_no_line(tmp_path: Path) -> None:
    made = film(tmp_path, tick(10.0), tick(9_000.0), tick(9_001.0))
    assert made.seconds == pytest.approx(6.0)
    assert made.clock == [[5.0, 8985.0]]


def test_what_becomes_too_much_is_thinned_evenly() -> None:
    rows: Thinned[int] = Thinned()
    for number in range(4 * MOST):
        rows.put(0.2 * number, number)
    assert MOST / 2 <= len(rows.rows) <= MOST
    apart = [after - before for (before, _), (after, _) in pairwise(rows.rows)]
    assert max(apart) <= 2 * min(apart) + 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.3, 0.6, 0.95])
def test_a_recording_that_is_cut_is_shown_up_to_there(tmp_path: Path, share: float) -> None:
    path = unpack("faults", tmp_path)
    data = path.read_bytes()
    whole = Read(path).film
    path.write_bytes(data[: int(share * len(data))])
    cut = Read(path).film
    assert 0 < cut.seconds < whole.seconds
    assert cut.messages == whole.messages[: len(cut.messages)]
    assert cut.phases == whole.phases[: len(cut.phases)]
    assert "the file has no end" in cut.problem or "damaged" in cut.problem


def test_content_of_another_version_ends_the_line_there(tmp_path: Path) -> None:
    items = [tick(10.5), decision(11.0, {"act": "EnterState", "name": "Idle"}), decision(12.0, {"of": "another"})]
    made = film(tmp_path, *items)
    assert [each.state for each in made.phases] == ["Idle"]
    assert made.problem.startswith("at 1.5 s: ")


def test_a_recording_of_which_nothing_is_known_names_its_program(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap", [decision(12.0, {"of": "another"})], is_closed=False)
    with pytest.raises(ReplayError, match=r"use hawk-drone 0\.2\.9, network 0123abcd, which recorded it"):
        Read(path)
    with pytest.raises(RefusedError, match="which recorded it"):
        packed_film(b"", {"recording": str(path), "beside": str(tmp_path / "beside")})
