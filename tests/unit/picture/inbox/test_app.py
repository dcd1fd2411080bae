from __future__ import annotations

import os
import shutil
import sqlite3
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hawk.picture.inbox.app import MOST_TRIES
from hawk.picture.inbox.journal import Journal
from hawk.picture.inbox.map_process import MapResult
from hawk.store.inbox import LEAST_FREE
from tests.unit.picture.inbox.inboxes import Bench, CutError, cut_after, drop, pictures, rows


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path)


@pytest.fixture(scope="module")
def flights(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, bytes]]:
    """Four flights of four photographs, hours apart: the files of all have the same names."""
    folder = tmp_path_factory.mktemp("flights")
    return [pictures(folder / str(number), minute=120 * number) for number in range(4)]


def parts(files: dict[str, bytes]) -> tuple[dict[str, bytes], dict[str, bytes]]:
    names = sorted(files)
    return {name: files[name] for name in names[:2]}, {name: files[name] for name in names[2:]}


def test_a_folder_that_has_settled_is_mapped_and_moved(bench: Bench, flights: list[dict[str, bytes]]) -> None:
    drop(bench.inbox / "north/DCIM/100MEDIA", flights[0])
    bench.run()
    names = {f"done/north/pictures/{name}" for name in flights[0]}
    assert bench.tree() == names | {"done/north/report.txt"}
    assert bench.store.mapped == ["north"]
    said = bench.report("done/north")
    assert "Stored in store as the first survey of yard." in said
    assert "Stalls: 3. Free 1 (1 to 2 in nine of ten surveys), taken 2, unclear 0." in said
    assert not (bench.inbox / "north").exists()


def test_loose_files_of_two_flights_are_two(bench: Bench, flights: list[dict[str, bytes]]) -> None:
    drop(bench.inbox, flights[0])
    drop(bench.inbox, {f"b{name}": data for name, data in flights[1].items()})
    bench.run()
    assert bench.store.mapped == ["2024-05-01-100000", "2024-05-01-120000"]
    assert sorted(map(len, bench.store.surveys.values())) == [4, 4]


def test_a_part_that_comes_later_makes_one_survey_of_both(bench: Bench, flights: list[dict[str, bytes]]) -> None:
    first, second = parts(flights[0])
    drop(bench.inbox / "north", second)
    bench.run()
    drop(bench.inbox / "upload-2", first)
    bench.run()
    assert list(bench.store.surveys.values()) == [frozenset(flights[0].values())]
    assert bench.store.mapped == ["north", "north"]
    assert "which came in 2 parts" in bench.report("done/north")
    assert not (bench.inbox / "done/upload-2").exists()


def test_a_part_that_could_not_be_mapped_alone_is_mapped_with_the_rest(
    bench: Bench, flights: list[dict[str, bytes]]
) -> None:
    first, second = parts(flights[0])
    bench.store.says = [MapResult(None, "too few photographs")]
    drop(bench.inbox / "north", first)
    bench.run()
    assert "too few photographs." in bench.report("failed/north")
    drop(bench.inbox / "rest", second)
    bench.run()
    assert list(bench.store.surveys.values()) == [frozenset(flights[0].values())]
    assert not any((bench.inbox / "failed").iterdir())


def test_a_part_that_cannot_be_mapped_leaves_the_survey_of_the_first_one(
    bench: Bench, flights: list[dict[str, bytes]]
) -> None:
    first, second = parts(flights[0])
    drop(bench.inbox / "north", first)
    bench.run()
    bench.store.says = [MapResult(None, "say the height")]
    drop(bench.inbox / "rest", second)
    bench.run()
    survey = rows(bench, "SELECT survey FROM flight")[0][0]
    assert f"stays in the store: {survey}." in bench.report("failed/north")
    assert list(bench.store.surveys.values()) == [frozenset(first.values())]


def test_a_flight_half_an_hour_later_over_the_same_lot_is_another_one(bench: Bench, tmp_path: Path) -> None:
    drop(bench.inbox / "first", pictures(tmp_path / "a"))
    bench.run()
    drop(bench.inbox / "second", pictures(tmp_path / "b", minute=30))
    bench.run()
    assert bench.store.mapped == ["first", "second"]


def test_the_same_flight_twice_is_mapped_once(bench: Bench, flights: list[dict[str, bytes]]) -> None:
    drop(bench.inbox / "north", flights[0])
    bench.run()
    drop(bench.inbox / "copy", {f"IMG{name}": data for name, data in flights[0].items()})
    bench.run()
    assert bench.store.mapped == ["north"]
    survey = rows(bench, "SELECT survey FROM flight")[0][0]
    assert f"already mapped as survey {survey}" in bench.report("done/copy")
    assert len(list((bench.inbox / "done/copy/pictures").iterdir())) == 4


def test_an_upload_that_begins_again_adds_the_rest_alone(bench: Bench, flights: list[dict[str, bytes]]) -> None:
    first, second = parts(flights[0])
    drop(bench.inbox / "north", first)
    bench.run()
    drop(bench.inbox / "north", first | second)
    bench.run()
    assert list(bench.store.surveys.values()) == [frozenset(flights[0].values())]
    assert {f"done/north/again/{name}" for name in first} < bench.tree()


def test_a_flight_whose_survey_was_erased_is_mapped_again(bench: Bench, flights: list[dict[str, bytes]]) -> None:
    drop(bench.inbox / "north", flights[0])
    bench.run()
    bench.store.surveys.clear()
    drop(bench.inbox / "again", flights[0])
    bench.run()
    assert len(bench.store.surveys) == 1
    bench.store.surveys.clear()
    shutil.rmtree(bench.inbox / "done/north")
    drop(bench.inbox / "again", parts(flights[0])[0])  # half of it: the other half is nowhere
    bench.run()
    assert list(bench.store.surveys.values()) == [frozenset(parts(flights[0])[0].values())]
    drop(bench.inbox / "rest", parts(flights[0])[1])
    bench.run()
    assert list(bench.store.surveys.values()) == [frozenset(flights[0].values())]


def test_what_cannot_be_mapped_is_moved_with_the_remedy_and_the_next_flight_goes_on(
    bench: Bench, flights: list[dict[str, bytes]]
) -> None:
    drop(bench.inbox / "letters", {"letter.txt": b"no picture"})
    bench.run(3)
    drop(bench.inbox / "north", flights[0])
    bench.run()
    assert bench.store.mapped == ["north"]
    said = bench.report("failed/letters")
    assert f"{bench.inbox}/failed/letters/pictures: no photograph can be used." in said
    assert f"hawk-drone map {bench.inbox}/failed/letters/pictures --out letters-survey" in said


def test_files_that_no_camera_made_keep_their_folders(bench: Bench) -> None:
    drop(bench.inbox / "work/a", {"letter.txt": b"no picture 1"})
    drop(bench.inbox / "work/b/c", {"letter.txt": b"no picture 2"})
    bench.run()
    both = {"failed/work/pictures/a/letter.txt", "failed/work/pictures/b/c/letter.txt"}
    assert bench.tree() == {*both, "failed/work/report.txt"}
    (bench.inbox / "failed/work").rename(bench.inbox / "work")
    bench.run()
    assert bench.tree() == {*both, "failed/work/report.txt"}


def test_a_flight_that_is_moved_back_is_tried_again_as_the_same(bench: Bench, flights: list[dict[str, bytes]]) -> None:
    bench.store.says = [MapResult(None, "say the height")]
    drop(bench.inbox / "north", flights[0])
    bench.run()
    drop(bench.inbox / "failed/north/survey/work", {"features-1": b"x"})
    (bench.inbox / "failed/north").rename(bench.inbox / "north")
    bench.run()
    assert bench.store.mapped == ["north"]
    assert not (bench.inbox / "north").exists()
    assert bench.tree() == {f"done/north/pictures/{name}" for name in flights[0]} | {"done/north/report.txt"}


@pytest.mark.parametrize("name", [b"\xff\xfe..", b"a\nb\x1b[31m", b"-rf", b"~", "é x".encode(), b"a" * 200])
def test_a_name_that_no_program_can_show_is_made_plain(
    bench: Bench, flights: list[dict[str, bytes]], name: bytes
) -> None:
    drop(Path(os.fsdecode(os.fsencode(bench.inbox) + b"/" + name)), flights[0])
    bench.run()
    (kept,) = (bench.inbox / "done").iterdir()
    assert kept.name.isprintable()
    assert not kept.name.startswith(".")
    assert len(bench.store.surveys) == 1


def test_a_film_is_mapped_by_the_name_that_it_has_then(bench: Bench) -> None:
    drop(Path(os.fsdecode(os.fsencode(bench.inbox) + b"/films")), {})
    Path(os.fsdecode(os.fsencode(bench.inbox) + b"/films/\xff:1.MP4")).write_bytes(b"film")
    bench.run()
    assert rows(bench, "SELECT source FROM flight") == [("__1.MP4",)]
    assert (bench.inbox / "done/films/pictures/__1.MP4").read_bytes() == b"film"


def test_a_link_out_of_the_folder_is_left_alone(bench: Bench, tmp_path: Path) -> None:
    (tmp_path / "secret").mkdir()
    (tmp_path / "secret/key.jpg").write_bytes(b"secret")
    (bench.inbox / "link").symlink_to(tmp_path / "secret")
    (bench.inbox / "key.jpg").symlink_to(tmp_path / "secret/key.jpg")
    bench.run()
    assert bench.said == []
    assert (tmp_path / "secret/key.jpg").exists()


@pytest.mark.parametrize("name", ["mapping", "done", "failed"])
def test_a_link_in_place_of_a_folder_of_the_inbox_is_refused(bench: Bench, tmp_path: Path, name: str) -> None:
    (tmp_path / "elsewhere").mkdir()
    (bench.inbox / name).symlink_to(tmp_path / "elsewhere")
    with pytest.raises(OSError, match="is a link"):
        bench.run()


def test_a_disk_that_is_not_mounted_makes_the_inbox_wait(bench: Bench, flights: list[dict[str, bytes]]) -> None:
    drop(bench.inbox / "north", flights[0])
    bench.free = 0
    with bench.running() as step:
        for _ in range(3):
            step()
        bench.inbox.rename(bench.root / "mounted")
        bench.inbox.mkdir()  # the place where it is mounted
        bench.free = 10**12
        step()
        step()
        assert bench.said[-1].outcome == "waits"
        assert bench.tree() == set()
    with pytest.raises(OSError, match=r"holds no north, which .* is the disk mounted"):
        bench.run()
    bench.inbox.rmdir()
    (bench.root / "mounted").rename(bench.inbox)
    bench.run()
    assert bench.store.mapped == ["north"]


def test_flights_under_way_come_back_where_the_journal_was_lost(bench: Bench, flights: list[dict[str, bytes]]) -> None:
    drop(bench.inbox / "north", flights[0])
    bench.free = 0
    bench.run()
    assert (bench.inbox / "mapping/north").is_dir()
    drop(bench.inbox / "mapping/north/survey", {"lot.png": b"picture"})
    (bench.place / "inbox.db").unlink()
    bench.free = 10**12
    drop(bench.inbox / "mapping/anna", {"letter.txt": b"a person's"})
    bench.run()
    (bench.inbox / "mapping/anna/letter.txt").unlink()
    assert list(bench.store.surveys.values()) == [frozenset(flights[0].values())]
    assert bench.tree() == {f"done/north/pictures/{name}" for name in flights[0]} | {"done/north/report.txt"}


def test_a_full_disk_waits_and_goes_on_by_itself(bench: Bench, flights: list[dict[str, bytes]]) -> None:
    bench.free = LEAST_FREE - 1
    drop(bench.inbox / "north", flights[0])
    bench.run()
    assert [event.outcome for event in bench.said] == ["waits"]
    assert "make room" in bench.said[0].words
    bench.free = LEAST_FREE
    bench.run()
    assert bench.store.mapped == ["north"]


def test_a_full_disk_of_the_journal_waits(
    bench: Bench, flights: list[dict[str, bytes]], monkeypatch: pytest.MonkeyPatch
) -> None:
    take = Journal._take

    def full(*_: object) -> None:
        raise sqlite3.OperationalError("database or disk is full")

    monkeypatch.setattr(Journal, "_take", full)
    drop(bench.inbox / "north", flights[0])
    with bench.running() as step:
        for _ in range(3):
            step()
        assert [(event.outcome, "disk is full" in event.words) for event in bench.said] == [("waits", True)]
        monkeypatch.setattr(Journal, "_take", take)
        for _ in range(3):
            step()
    assert bench.store.mapped == ["north"]


def test_an_error_of_the_store_waits(bench: Bench, flights: list[dict[str, bytes]]) -> None:
    bench.store.says = [MapResult(None, "--store: lots.db is damaged: restore a backup")] * 3
    drop(bench.inbox / "north", flights[0])
    bench.run()
    assert bench.store.mapped == ["north"]
    assert not any((bench.inbox / "failed").iterdir())


def test_a_mapping_that_is_killed_is_tried_three_times(bench: Bench, flights: list[dict[str, bytes]]) -> None:
    bench.store.says = [MapResult(None, "Mapping was ended by SIGKILL", 9)] * MOST_TRIES
    drop(bench.inbox / "north", flights[0])
    bench.run()
    assert "Mapping was ended by SIGKILL" in bench.report("failed/north")
    drop(bench.inbox / "south", flights[1])
    bench.run()
    assert bench.store.mapped == ["south"]


def test_a_flight_that_vanishes_while_it_is_mapped_ends_nothing(
    bench: Bench, flights: list[dict[str, bytes]], monkeypatch: pytest.MonkeyPatch
) -> None:
    mapped = bench.store.__call__

    def vanished(one: object, home: Path) -> MapResult:
        shutil.rmtree(home)
        return MapResult(None, f"{home} is not there")

    monkeypatch.setattr(type(bench.store), "__call__", lambda _, one, home: vanished(one, home))
    drop(bench.inbox / "north", flights[0])
    bench.run()
    monkeypatch.setattr(type(bench.store), "__call__", lambda _, one, home: mapped(one, home))
    drop(bench.inbox / "south", flights[1])
    bench.run()
    assert bench.store.mapped == ["south"]


def test_a_drop_that_may_not_be_moved_waits_and_others_go_on(
    bench: Bench, flights: list[dict[str, bytes]], monkeypatch: pytest.MonkeyPatch
) -> None:
    rename = Path.rename

    def refused(path: Path, target: Path) -> Path:
        if "locked" in path.parts:
            raise PermissionError(13, "Permission denied", str(path))
        return rename(path, target)

    monkeypatch.setattr(Path, "rename", refused)
    drop(bench.inbox / "locked", flights[0])
    drop(bench.inbox / "north", flights[1])
    bench.run()
    assert bench.store.mapped == ["north"]
    assert [event.flight for event in bench.said if event.outcome == "waits"][:1] == ["locked"]
    later = {
        f"again/{name}": data + b"\0" for name, data in flights[0].items()
    }  # of the same flight, by the same names
    (bench.inbox / "open/again").mkdir(parents=True)
    drop(bench.inbox / "open", later)
    bench.run()
    monkeypatch.setattr(Path, "rename", rename)
    bench.run()
    assert bench.store.mapped == ["north", "locked"]
    assert frozenset([*flights[0].values(), *later.values()]) in bench.store.surveys.values()


Drop = tuple[int, str, int]
"""Number of a flight, which part of it, and the folder that it is put into; 0 is the inbox itself."""
drops = st.lists(
    st.tuples(st.integers(0, 3), st.sampled_from(["whole", "first", "second"]), st.integers(0, 3)),
    min_size=1,
    max_size=6,
)


@pytest.mark.slow
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(dropped=drops, cuts=st.lists(st.integers(0, 40), max_size=6), between=st.integers(0, 3))
def test_a_cut_at_any_step_loses_nothing_and_maps_nothing_twice(
    tmp_path_factory: pytest.TempPathFactory,
    flights: list[dict[str, bytes]],
    dropped: list[Drop],
    cuts: list[int],
    between: int,
) -> None:
    bench = Bench(tmp_path_factory.mktemp("cut"))
    given_files: Counter[bytes] = Counter()
    for number, (flight, part, folder) in enumerate(dropped):
        first, second = parts(flights[flight])
        files = {"whole": flights[flight], "first": first, "second": second}[part]
        place = bench.inbox / f"drop-{folder}" if folder else bench.inbox
        drop(place, {f"{number}-{name}": data for name, data in files.items()})
        given_files.update(files.values())
        if cuts and number >= between:
            try:
                with cut_after(cuts.pop()), bench.running() as step:
                    for _ in range(6):
                        step()
            except CutError:
                pass
    while cuts:
        try:
            with cut_after(cuts.pop()), bench.running() as step:
                for _ in range(6):
                    step()
        except CutError:
            pass
    bench.run(30)
    stored = Counter(data for survey in bench.store.surveys.values() for data in survey)
    assert set(stored) == set(given_files)
    assert max(stored.values()) == 1
    assert len(bench.store.surveys) == len({flight for flight, _, _ in dropped})
    kept = Counter(path.read_bytes() for path in bench.inbox.rglob("*.JPG"))
    assert kept == given_files
    assert not any((bench.inbox / "mapping").iterdir())
    assert not any((bench.inbox / "failed").iterdir())
