from __future__ import annotations

import hashlib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.config.sections import StoreSettings
from hawk.store.recording_request import OfferedRecording, Part, PartRefusedError
from hawk.store.recording_requests import PartWriter, RecordingRequests
from hawk.store.recordings import Recordings
from tests.unit.store.recorded import recorded

SURVEY, DRONE, JOURNAL, NAME = "00000000-0000-4000-8000-000000000001", "Drone 1", "000001-day", "20260501T100000Z.mcap"
STEP = 700


class Desk:
    """The requests of a desk, whose program can be killed."""

    def __init__(self, folder: Path) -> None:
        self.settings = StoreSettings(directory=folder)
        self.recordings = Recordings(self.settings)
        self.kill()

    def kill(self) -> None:
        """Start again with what is on the disk."""
        self.requests = RecordingRequests(self.recordings, self.settings)

    def bring(self, data: bytes, survey: str = SURVEY, drone: str = DRONE) -> None:
        """Ask for a survey's recording, and send it in one part."""
        self.requests.ask(survey, drone, JOURNAL, 1.0)
        self.requests.offer(survey, drone, "", [OfferedRecording(NAME, len(data))])
        assert self.put(data, 0, len(data), survey=survey, drone=drone) == ""

    def put(
        self, data: bytes, start: int, end: int, torn: bool = False, survey: str = SURVEY, drone: str = DRONE
    ) -> str:
        """Send a part, or the first half of it; return why it was refused."""
        part = Part(start, end, len(data), hashlib.sha256(data).hexdigest())
        try:
            writer = self.requests.begin(survey, drone, NAME, part)
            if isinstance(writer, PartWriter):
                writer.write(data[start : (start + end) // 2 if torn else end])
                writer.close()
                self.requests.finish(survey, writer.coming)
        except PartRefusedError as error:
            return error.cause
        return ""

    def surveys(self) -> dict[str, list[str]]:
        """Return the surveys for which each recording came, by its name here."""
        return {file: [each.survey for each in came] for file, came in self.requests.origins().items()}

    def files(self) -> dict[str, bytes]:
        found = [path for path in self.recordings.folder.rglob("*") if path.is_file() and path.suffix != ".json"]
        return {path.name: path.read_bytes() for path in found}


ACTS = st.one_of(
    st.tuples(st.just("put"), st.integers(0, 8), st.integers(1, 3)),
    st.tuples(st.just("torn"), st.integers(0, 8), st.integers(1, 3)),
    st.tuples(st.just("kill"), st.just(0), st.just(0)),
    st.tuples(st.just("offer"), st.just(0), st.just(0)),
)


@given(acts=st.lists(ACTS, max_size=30))
def test_parts_in_any_order_doubled_torn_and_killed_give_the_file_or_its_beginning(
    acts: list[tuple[str, int, int]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("desk")
    data = recorded(folder / "r.mcap", JOURNAL, range(20), "x" * 100)
    desk, offered = Desk(folder), [OfferedRecording(NAME, len(data))]
    desk.requests.ask(SURVEY, DRONE, JOURNAL, 1.0)
    desk.requests.offer(SURVEY, DRONE, "", offered)
    for act, first, count in acts:
        start, end = first * STEP, min((first + count) * STEP, len(data))
        if act == "kill":
            desk.kill()
        elif act == "offer" and NAME not in desk.files():
            desk.requests.offer(SURVEY, DRONE, "", offered)
        elif act in ("put", "torn") and start < end:
            desk.put(data, start, end, act == "torn")
        for found in desk.files().values():
            assert data.startswith(found)
    while (received := desk.requests.progress(SURVEY).received) < len(data):
        assert desk.put(data, received, min(received + STEP, len(data))) == ""
    assert desk.files() == {NAME: data}
    assert desk.requests.progress(SURVEY).state == "here"


def test_a_kill_between_the_note_and_the_name_of_a_whole_recording_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data, desk = recorded(tmp_path / "r.mcap", JOURNAL), Desk(tmp_path)
    desk.requests.ask(SURVEY, DRONE, JOURNAL, 1.0)
    desk.requests.offer(SURVEY, DRONE, "", [OfferedRecording(NAME, len(data))])
    with monkeypatch.context() as killed:
        killed.setattr(RecordingRequests, "_settle", lambda *_: None)
        desk.put(data, 0, len(data))
    desk.kill()
    assert desk.requests.progress(SURVEY).state == "here"
    assert desk.files() == {NAME: data}
    assert desk.surveys() == {NAME: [SURVEY]}


def test_what_is_erased_names_the_recordings_that_came_and_a_later_request_forgets_no_earlier_one(
    tmp_path: Path,
) -> None:
    data, desk = recorded(tmp_path / "r.mcap", JOURNAL), Desk(tmp_path)
    second = NAME.replace("T10", "T11")
    desk.requests.ask(SURVEY, DRONE, JOURNAL, 1.0)
    desk.requests.offer(SURVEY, DRONE, "", [OfferedRecording(NAME, len(data)), OfferedRecording(second, 10**6)])
    desk.put(data, 0, len(data))
    desk.requests.offer(SURVEY, DRONE, "never", [])
    desk.requests.take_back(SURVEY)
    desk.recordings.delete(NAME)
    desk.requests.ask(SURVEY, DRONE, JOURNAL, 2.0)
    assert desk.requests.waiting(DRONE) == [SURVEY]
    desk.requests.offer(SURVEY, DRONE, "", [OfferedRecording(NAME, len(data))])
    desk.put(data, 0, len(data))
    assert [*desk.requests.origins()] == [NAME]
    assert [path.name for path in desk.requests.folders_of([SURVEY])] == [SURVEY]


@pytest.mark.parametrize("is_tidied", [False, True], ids=["deleted", "tidied"])
@pytest.mark.parametrize("words", ["x" * 100, "y" * 100], ids=["of the same bytes", "of other bytes"])
def test_the_name_of_one_that_was_deleted_is_that_of_the_next_survey_alone(
    words: str, is_tidied: bool, tmp_path: Path
) -> None:
    first, second = (recorded(tmp_path / "r", JOURNAL, words=each) for each in ("x" * 100, words))
    desk, other = Desk(tmp_path), SURVEY.replace("1", "2")
    desk.bring(first)
    if is_tidied:
        assert desk.recordings.make_room(1) == [NAME]
    else:
        desk.recordings.delete(NAME)
    assert desk.requests.progress(SURVEY).state == "none"
    desk.bring(second, other, "Drone 2")
    desk.kill()
    assert desk.surveys() == {NAME: [other]}
    assert desk.requests.progress(SURVEY).state == "none"
    desk.bring(first)
    again = NAME.replace(".", "-2.")
    assert desk.files() == {NAME: second, again: first}
    assert desk.surveys() == {NAME: [other], again: [SURVEY]}


def test_the_recording_of_a_round_that_came_for_one_lot_is_there_for_the_others(tmp_path: Path) -> None:
    data, desk, other = recorded(tmp_path / "r", JOURNAL), Desk(tmp_path), SURVEY.replace("1", "2")
    later = NAME.replace("T10", "T11")
    offered = [OfferedRecording(NAME, len(data)), OfferedRecording(later, 10**6)]
    desk.requests.ask(other, DRONE, JOURNAL, 1.0)
    desk.bring(data)
    for drone, journal in (("Drone 2", JOURNAL), (DRONE, "000002-day")):
        desk.requests.ask(drone, drone, journal, 1.0)
        assert desk.requests.offer(drone, drone, "", offered)[NAME] == 0, "of another flight"
    assert desk.requests.offer(other, DRONE, "", offered) == {NAME: len(data), later: 0}
    desk.kill()
    assert desk.requests.offer(other, DRONE, "", offered[:1]) == {NAME: len(data)}
    assert desk.requests.progress(other).state == "here"
    assert desk.files() == {NAME: data}
    assert sorted(desk.surveys()[NAME]) == [SURVEY, other]
    desk.recordings.delete(NAME)
    desk.requests.ask(other, DRONE, JOURNAL, 2.0)
    assert desk.requests.offer(other, DRONE, "", offered[:1]) == {NAME: 0}


@pytest.mark.parametrize("sent", [0, 100], ids=["nothing of the second", "a part of the second"])
def test_one_recording_that_two_lots_ask_for_comes_once(tmp_path: Path, sent: int) -> None:
    data, desk, other = recorded(tmp_path / "r", JOURNAL), Desk(tmp_path), SURVEY.replace("1", "2")
    for survey in (SURVEY, other):
        desk.requests.ask(survey, DRONE, JOURNAL, 1.0)
        desk.requests.offer(survey, DRONE, "", [OfferedRecording(NAME, len(data))])
    if sent:
        assert desk.put(data, 0, sent, survey=other) == ""
    assert desk.put(data, 0, len(data)) == ""
    part = Part(sent, sent + 1, len(data), hashlib.sha256(data).hexdigest())
    assert desk.requests.begin(other, DRONE, NAME, part) == len(data), "the rest need not be sent"
    desk.kill()
    assert desk.files() == {NAME: data}
    assert sorted(desk.surveys()[NAME]) == [SURVEY, other]
    assert [desk.requests.progress(each).state for each in (SURVEY, other)] == ["here", "here"]


def test_one_recording_that_two_connections_send_at_once_is_kept_once(tmp_path: Path) -> None:
    data, desk, other = recorded(tmp_path / "r", JOURNAL), Desk(tmp_path), SURVEY.replace("1", "2")
    part, writers = Part(0, len(data), len(data), hashlib.sha256(data).hexdigest()), {}
    for survey in (SURVEY, other):
        desk.requests.ask(survey, DRONE, JOURNAL, 1.0)
        desk.requests.offer(survey, DRONE, "", [OfferedRecording(NAME, len(data))])
        writers[survey] = desk.requests.begin(survey, DRONE, NAME, part)
    for survey, writer in writers.items():
        assert isinstance(writer, PartWriter)
        writer.write(data)
        writer.close()
        assert desk.requests.finish(survey, writer.coming)
    desk.kill()
    assert desk.files() == {NAME: data}
    assert sorted(desk.surveys()[NAME]) == [SURVEY, other]


def test_a_kill_while_a_second_request_takes_a_whole_recording_leaves_it_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data, desk, other = recorded(tmp_path / "r", JOURNAL), Desk(tmp_path), SURVEY.replace("1", "2")
    for survey in (SURVEY, other):
        desk.requests.ask(survey, DRONE, JOURNAL, 1.0)
        desk.requests.offer(survey, DRONE, "", [OfferedRecording(NAME, len(data))])
    desk.put(data, 0, 100, survey=other)
    desk.put(data, 0, len(data))

    def killed(_: RecordingRequests, survey: str, names: object) -> None:
        raise KeyboardInterrupt

    for act in (
        lambda: desk.requests.offer(other, DRONE, "", [OfferedRecording(NAME, len(data))]),
        lambda: desk.put(data, 100, len(data), survey=other),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(RecordingRequests, "_drop_parts", killed)
            with pytest.raises(KeyboardInterrupt):
                act()
        desk.kill()
        desk.surveys()
        assert desk.files()[NAME] == data


def test_a_file_out_of_a_backup_is_the_one_that_came_and_another_of_its_size_is_not(tmp_path: Path) -> None:
    data, desk = recorded(tmp_path / "r", JOURNAL), Desk(tmp_path)
    desk.bring(data)
    path = desk.recordings.folder / NAME
    for restored, state in ((data, "here"), (data[:-1] + b"?", "none")):
        path.unlink()
        path.write_bytes(restored)
        assert desk.requests.progress(SURVEY).state == state
        assert [*desk.requests.origins()] == [NAME] * (state == "here")


def test_after_a_kill_behind_the_last_part_the_next_offer_makes_it_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data, desk = recorded(tmp_path / "r", JOURNAL), Desk(tmp_path)
    with monkeypatch.context() as killed:
        killed.setattr(RecordingRequests, "finish", lambda *_: False)
        desk.bring(data)
    desk.kill()
    assert desk.requests.progress(SURVEY).state == "coming"
    assert desk.requests.offer(SURVEY, DRONE, "", [OfferedRecording(NAME, len(data))]) == {NAME: len(data)}
    assert desk.requests.progress(SURVEY).state == "here"
    assert desk.files() == {NAME: data}
