from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hawk.lots.plan import edits
from hawk.lots.values import BeingEditedError, LotInputError, LotStoreError, NotFoundError, Placed
from tests.examples import examples
from tests.unit.lots.repaints import NOW, WIDER, Archive, extra, flown, repainted, without
from tests.unit.lots.surveys import A_ROW

SOON = settings(max_examples=examples(6), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Archive:
    """One survey; its store is closed."""
    made = Archive(tmp_path_factory.mktemp("first") / "lots.db")
    made.add(flown(1))
    made.store.close()
    return made


@pytest.fixture
def archive(first: Archive, tmp_path: Path) -> Iterator[Archive]:
    made = Archive(Path(shutil.copy(first.store.path, tmp_path)))
    made.lot = first.lot
    yield made
    made.store.close()


@pytest.mark.slow
def test_a_row_painted_again_begins_and_ends_whole_though_some_stalls_are_near_former_ones(
    archive: Archive,
) -> None:
    archive.add(repainted(2))
    begin, end = archive.newest()
    assert begin == set(range(A_ROW + 1, A_ROW + 1 + WIDER))
    assert end == {f"B {number}" for number in range(1, A_ROW + 1)}


@pytest.mark.slow
def test_a_survey_of_the_same_paint_proposes_nothing(archive: Archive) -> None:
    archive.add(flown(2))
    assert archive.changes() == []


@pytest.mark.nightly
def test_taking_over_makes_one_version_in_which_stalls_that_fit_keep_ids_and_labels(archive: Archive) -> None:
    before = archive.stalls()
    saved = archive.add(repainted(2))
    done = archive.take_over(saved.survey, begin="all", end="all", why="painted in May")
    after, layouts = archive.stalls(), archive.read()["layouts"]
    kept = {label: key for label, key in before.items() if not label.startswith("B ")}
    assert {label: after.get(label) for label in kept} == kept
    new = after.keys() - kept.keys()
    assert new == {f"B {number}" for number in range(1, WIDER + 1)}  # the row has gone, and its name is free
    assert not {after[label] for label in new} & {*before.values()}
    assert done.kind == "take_over"
    assert [each["version"] for each in layouts] == [1, 2]
    assert layouts[1]["why"] == "painted in May"
    assert archive.changes() == []


@pytest.mark.nightly
def test_new_stalls_have_the_look_of_the_survey_that_found_them_and_ended_ones_lose_it(archive: Archive) -> None:
    saved, former = archive.add(repainted(2)), {*archive.stalls().values()}
    archive.take_over(saved.survey, begin="all", end="all")
    states = {stall.id: stall.state.value for stall in repainted(2).stalls}
    new = [each for each in archive.read()["stalls"] if each["observed"] is not None and each["id"] not in former]
    assert sorted(each["state"] for each in new) == sorted(states[number] for number in range(21, 39))


@pytest.mark.nightly
def test_the_next_survey_finds_the_new_row_with_its_new_ids(archive: Archive) -> None:
    archive.take_over(archive.add(repainted(2)).survey, begin="all", end="all")
    saved = archive.add(repainted(3))
    assert (saved.placed, saved.known, saved.stalls) == (Placed.REGISTERED, 58, 58)
    assert archive.changes() == []


@pytest.mark.nightly
def test_one_undo_brings_the_former_layout_back_and_the_proposals(archive: Archive) -> None:
    saved = archive.add(repainted(2))
    before = archive.read(), archive.newest()
    done = archive.take_over(saved.survey, begin="all", end="all")
    assert archive.undo(done) == "take_over"
    assert (archive.read(), archive.newest()) == before
    with pytest.raises(LotStoreError, match="was undone already"):
        archive.undo(done)


@pytest.mark.nightly
def test_a_layout_that_a_later_survey_was_placed_on_is_not_undone(archive: Archive) -> None:
    done = archive.take_over(archive.add(repainted(2)).survey, begin="all", end="all")
    archive.add(repainted(3))
    with pytest.raises(LotStoreError, match="cannot be undone: surveys were registered since"):
        archive.undo(done)


@pytest.mark.nightly
def test_confirmed_stalls_end_only_when_they_are_named(archive: Archive) -> None:
    archive.edit({"do": "confirm", "row": "B"})
    saved = archive.add(repainted(2))
    with pytest.raises(LotInputError, match="name nothing"):
        archive.take_over(saved.survey, begin="all", end="all")
    ids = [each["id"] for each in archive.changes()[0]["end"]]
    archive.take_over(saved.survey, begin="all", end=ids)
    assert len(archive.stalls()) == 58


@pytest.mark.slow
def test_a_stall_that_begins_where_another_one_stays_is_refused_with_the_names(archive: Archive) -> None:
    saved = archive.add(repainted(2))
    with pytest.raises(LotInputError, match=r"begin: the new stall would overlap B \d+"):
        archive.take_over(saved.survey, begin=[30])


@pytest.mark.slow
def test_all_leaves_out_what_would_overlap_a_stall_that_stays(archive: Archive) -> None:
    saved = archive.add(extra(repainted(2)))
    archive.take_over(saved.survey, begin="all", end=[])
    assert len(archive.stalls()) == 61


@pytest.mark.nightly
@SOON
@given(drawn=st.data())
def test_any_choice_ends_and_begins_just_what_it_names_and_is_undone_whole(
    tmp_path_factory: pytest.TempPathFactory, drawn: st.DataObject
) -> None:
    archive = Archive(tmp_path_factory.mktemp("taken") / "lots.db")
    archive.add(flown(1))
    gone = drawn.draw(st.sets(st.integers(1, 60), max_size=5))
    saved = archive.add(extra(without(flown(2), *gone)))
    found = archive.changes()[0]
    begin = drawn.draw(st.lists(st.sampled_from([each["id"] for each in found["begin"]]), unique=True))
    ids = [each["id"] for each in found["end"]]
    end = drawn.draw(st.lists(st.sampled_from(ids), unique=True)) if ids else []
    before = archive.read()
    keys = {each["id"] for each in before["stalls"]}
    if not begin and not end:
        with pytest.raises(LotInputError):
            archive.take_over(saved.survey, begin=begin, end=end)
        return
    done = archive.take_over(saved.survey, begin=begin, end=end)
    after = archive.read()
    kept = [each for each in after["stalls"] if each["id"] in keys]
    assert kept == [each for each in before["stalls"] if each["id"] not in end]
    new = [each for each in after["stalls"] if each["id"] not in keys]
    assert len(new) == len(begin)
    assert not {each["label"] for each in new} & {each["label"] for each in kept}
    assert len(after["layouts"]) == 2
    assert archive.undo(done) == "take_over"
    assert archive.read() == before
    archive.store.close()


@pytest.mark.nightly
def test_labels_of_a_take_over_that_was_undone_are_free(archive: Archive) -> None:
    saved = archive.add(extra(flown(2)))
    done = archive.take_over(saved.survey, begin="all")
    labels = {*archive.stalls()}
    archive.undo(done)
    archive.take_over(saved.survey, begin="all")
    assert {*archive.stalls()} == labels


@pytest.mark.slow
def test_a_dropped_find_comes_back_only_after_a_survey_without_it(archive: Archive) -> None:
    done = archive.drop(archive.add(extra(flown(2))).survey, begin="all", end="all")
    assert archive.changes() == []
    archive.add(extra(flown(3)))
    assert archive.changes() == []
    archive.add(flown(4))
    archive.add(extra(flown(5)))
    assert archive.newest() == ({90}, set())
    assert archive.undo(done) == "drop"


@pytest.mark.slow
def test_an_undone_drop_proposes_again(archive: Archive) -> None:
    archive.undo(archive.drop(archive.add(extra(flown(2))).survey, begin=[90]))
    assert archive.newest() == ({90}, set())


@pytest.mark.slow
def test_a_dropped_end_comes_back_only_after_a_survey_that_found_the_stall(archive: Archive) -> None:
    archive.drop(archive.add(without(flown(2), 7)).survey, end="all")
    archive.add(without(flown(3), 7))
    assert archive.changes() == []
    archive.add(flown(4))
    archive.add(without(flown(5), 7))
    assert archive.newest() == (set(), {"A 7"})


@pytest.mark.nightly
def test_a_stall_that_a_person_removed_is_not_proposed_by_surveys_that_see_the_same(archive: Archive) -> None:
    archive.add(flown(2))
    archive.edit({"do": "remove", "stalls": [archive.stalls()["A 7"]]})
    assert archive.changes() == []
    archive.add(flown(3))
    assert archive.changes() == []


@pytest.mark.nightly
def test_a_stall_that_a_person_moved_is_not_proposed_where_it_was(archive: Archive) -> None:
    archive.edit({"do": "move", "stalls": [archive.stalls()["A 1"]], "north": 0.0, "east": -2.0})
    archive.add(flown(2))
    assert archive.changes() == []


@pytest.mark.slow
def test_a_bay_that_no_survey_ever_found_does_not_end(archive: Archive) -> None:
    archive.edit({"do": "add_stall", "north": 0.0, "east": 60.0, "angle": 0.0, "width": 2.5, "length": 5.0})
    archive.add(flown(2))
    assert archive.changes() == []


@pytest.mark.slow
@pytest.mark.parametrize(("score", "ends"), [(0.05, True), (0.3, False), (0.9, False)])
def test_a_given_stall_ends_where_the_flight_saw_none_and_an_earlier_one_did(
    archive: Archive, score: float, ends: bool
) -> None:
    archive.edit({"do": "confirm", "all": True})
    known = archive.stalls()
    labels = sorted(known, key=lambda label: (label[0], int(label[2:])))
    seen = [
        replace(stall, known=known[label], score=score if label == "A 7" else 0.9)
        for stall, label in zip(flown(2).stalls, labels, strict=True)
    ]
    archive.add(flown(2, seen))
    assert archive.newest() == (set(), {"A 7"} if ends else set())


@pytest.mark.nightly
def test_a_find_beside_given_stalls_is_proposed_and_not_counted(archive: Archive) -> None:
    found = extra(flown(2))
    saved = archive.add(replace(found, stalls=(*found.stalls[:-1], replace(found.stalls[-1], is_extra=True))))
    assert archive.newest() == ({90}, set())
    newest = archive.read()["surveys"][-1]
    assert newest["free"] + newest["taken"] + newest["unknown"] == 60
    archive.take_over(saved.survey, begin=[90])
    assert len(archive.stalls()) == 61


@pytest.mark.nightly
def test_an_older_survey_speaks_of_the_ground_that_newer_ones_have_not_seen(archive: Archive) -> None:
    archive.add(without(flown(2), 7, 47))
    newer = without(flown(3), 7)
    north = replace(newer, seen_ground=replace(newer.seen_ground, polygons=(half(newer.seen_ground.polygons[0]),)))
    archive.add(replace(north, stalls=tuple(stall for stall in north.stalls if stall.id <= 20)))
    assert [{each["label"] for each in found["end"]} for found in archive.changes()] == [{"A 7"}, {"C 7"}]


def half(ring: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """Return the northern part of a box, with the first row."""
    south = max(latitude for latitude, _ in ring) - 20 / 111_320
    return tuple((max(latitude, south), longitude) for latitude, longitude in ring)


@pytest.mark.slow
def test_nothing_is_taken_over_while_a_person_edits_the_plan(archive: Archive) -> None:
    saved = archive.add(extra(flown(2)))
    with archive.store.writing() as connection:
        edits.open_edit(connection, archive.lot, {"who": "Ann"}, NOW)
    with pytest.raises(BeingEditedError, match="Ann edits the plan") as refused:
        archive.take_over(saved.survey, begin="all")
    assert refused.value.who == "Ann"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("asked", "refusal"),
    [
        ({}, "begin: and end name nothing"),
        ({"begin": 3}, 'begin: must be a list of ids, or "all"'),
        ({"begin": [1]}, r"begin\[0\]: is no proposal"),
        ({"begin": [True]}, r"begin\[0\]: is no proposal"),
        ({"end": [["a"]]}, r"end\[0\]: is no proposal"),
        ({"begin": "all", "stalls": []}, "stalls: is no field of this request"),
        ({"survey": "x", "begin": "all"}, "survey: has no proposals"),
        ({"begin": "all", "why": 3}, "why: must be text"),
    ],
)
def test_what_cannot_be_taken_over_is_refused_by_its_field(
    archive: Archive, asked: dict[str, Any], refusal: str
) -> None:
    saved = archive.add(extra(flown(2)))
    with pytest.raises(LotInputError, match=refusal):
        archive.take_over(**{"survey": saved.survey, **asked})
    assert len(archive.stalls()) == 60


def test_a_lot_that_is_not_there_is_named(archive: Archive) -> None:
    archive.lot = "0" * 36
    with pytest.raises(NotFoundError, match="lot: there is no lot"):
        archive.take_over("x", begin="all")
