from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.lots import commands
from hawk.lots.known_lot import known_lot
from hawk.lots.pins import fitted
from hawk.lots.plan import edits
from hawk.lots.registration.frames import Move, same_stalls
from hawk.lots.registration.georeference import about
from hawk.lots.values import (
    BeingEditedError,
    KnownGround,
    LotInputError,
    LotStoreError,
    MappedGround,
    Registration,
)
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import to_global
from tests.unit.lots.repaints import NOW, Archive, flown
from tests.unit.lots.surveys import DATUM

HERE = (DATUM.latitude, DATUM.longitude)


@pytest.fixture
def archive(tmp_path: Path) -> Iterator[Archive]:
    made = Archive(tmp_path / "lots.db")
    made.add(flown(1))
    yield made
    made.store.close()


def pin(archive: Archive, *points: object) -> dict[str, Any]:
    with archive.store.writing() as connection:
        return commands.pin(connection, archive.lot, {"points": list(points)}, "operator", NOW).model_dump()


def undo(archive: Archive, seq: int) -> str:
    with archive.store.writing() as connection:
        return commands.undo(connection, seq, NOW)


def earth(north: float, east: float) -> list[float]:
    return [float(each) for each in to_global(DATUM, np.array([[north, east]]))[0]]


def point(place: tuple[float, float], move: Move) -> dict[str, list[float]]:
    ((north, east),) = move.of(np.array([place])).tolist()
    return {"from": earth(*place), "to": earth(north, east)}


def on_earth(archive: Archive) -> np.ndarray[Any, Any]:
    """Return the middles of the stalls as they are shown: metres about the first datum."""
    shown = archive.read()
    places = np.array([(each["north"], each["east"]) for each in shown["stalls"]])
    return about(HERE, to_global(GlobalPose(shown["datum"][0], shown["datum"][1], 0.0), places))[:, :2]


@pytest.mark.slow
def test_one_point_shifts_the_lot_with_its_outline_and_keeps_its_coordinates(archive: Archive) -> None:
    before, outline = archive.read(), ring(archive)
    answer = pin(archive, point((-9.0, 20.0), Move(2.0, -3.0)))
    after = archive.read()
    assert (answer["north"], answer["east"], answer["turn"], answer["residual"]) == (2.0, -3.0, 0.0, 0.0)
    names = ("id", "label", "north", "east", "angle", "width", "length")
    was, now = ([[stall[name] for name in names] for stall in each["stalls"]] for each in (before, after))
    assert now == was
    assert about(HERE, np.array([after["datum"]]))[0, :2] == pytest.approx([2.0, -3.0], abs=1e-3)
    assert ring(archive) == pytest.approx(outline + np.array([2.0, -3.0]), abs=0.01)
    assert after["datum_is_pinned"] is True
    assert [each["version"] for each in after["layouts"]] == [1]


def ring(archive: Archive) -> np.ndarray[Any, Any]:
    return about(HERE, np.array(archive.read()["outline"][0]))[:, :2]


@pytest.mark.nightly
def test_two_points_turn_the_lot_about_where_they_are_in_one_version_that_is_undone_once(archive: Archive) -> None:
    archive.add(flown(2))
    archive.edit({"do": "forbid", "outline": [[20, 0], [24, 0], [24, 4]], "name": "shed"})
    before, was = archive.read(), on_earth(archive)
    move = Move(1.0, 2.0, math.radians(3.0))
    answer = pin(archive, point((0.0, 0.0), move), point((-18.0, 45.0), move))
    after = archive.read()
    assert answer["turn"] == pytest.approx(3.0, abs=1e-3)
    assert answer["residual"] == pytest.approx(0.0, abs=1e-3)
    assert on_earth(archive) == pytest.approx(move.of(was), abs=2e-3)
    assert after["stalls"][0]["angle"] == pytest.approx(before["stalls"][0]["angle"] + math.radians(3.0), abs=1e-5)
    assert [(each["id"], each["label"]) for each in after["stalls"]] == [
        (each["id"], each["label"]) for each in before["stalls"]
    ]
    corner = Move(turn=math.radians(3.0)).of(np.array([[24.0, 4.0]]))[0]
    assert after["zones"][0]["outline"][2] == pytest.approx(corner.tolist(), abs=1e-4)
    assert after["layouts"][-1]["why"].startswith("pinned to the map, turned by 3.00")
    assert undo(archive, answer["seq"]) == "pin"
    assert archive.read() == before
    with pytest.raises(LotStoreError, match="was undone already"):
        undo(archive, answer["seq"])


@pytest.mark.nightly
def test_a_survey_after_the_turn_is_placed_on_the_same_stalls(archive: Archive) -> None:
    move = Move(0.0, 0.0, math.radians(-2.0))
    pin(archive, point((0.0, 0.0), move), point((0.0, 40.0), move))
    with archive.store.reading() as connection:
        known = known_lot(connection, archive.lot, HERE)
    turned = move.of(np.array([(each.north, each.east) for each in flown(1).stalls]))
    assert [(each.north, each.east) for each in known.stalls] == [pytest.approx(each, abs=0.01) for each in turned]
    assert [each.label for each in known.stalls] == [each["label"] for each in archive.read()["stalls"]]
    assert archive.changes() == []


@pytest.mark.slow
def test_without_points_the_lot_is_where_its_surveys_have_it_again(archive: Archive) -> None:
    was = on_earth(archive)
    move = Move(4.0, 1.0, math.radians(5.0))
    pin(archive, point((0.0, 0.0), move), point((-18.0, 45.0), move))
    pin(archive)
    assert archive.read()["datum_is_pinned"] is False
    assert on_earth(archive) == pytest.approx(was, abs=2e-3)


@pytest.mark.slow
def test_an_edit_from_before_a_turn_is_undone_after_the_turn_is(archive: Archive) -> None:
    seq = archive.edit({"do": "move", "stalls": [archive.stalls()["A 1"]], "north": 0.0, "east": -2.0})
    move = Move(0.0, 0.0, math.radians(2.0))
    answer = pin(archive, point((0.0, 0.0), move), point((0.0, 40.0), move))
    with pytest.raises(LotStoreError, match="undo the later changes first"):
        undo(archive, seq)
    assert [undo(archive, answer["seq"]), undo(archive, seq)] == ["pin", "plan"]


@given(
    st.floats(-15, 15), st.floats(-15, 15), st.floats(-0.1, 0.1),
    st.floats(-50, 50), st.floats(-50, 50), st.floats(-3, 3), st.floats(12, 40), st.floats(0.98, 1.02),
)  # fmt: skip
def test_two_points_are_met_in_turn_and_middle_and_what_is_left_is_reported(
    north: float, east: float, turn: float, a: float, b: float, heading: float, apart: float, scale: float
) -> None:
    here = np.array([a, b]) + np.array([[0.0, 0.0], [math.cos(heading), math.sin(heading)]]) * apart
    middle = here.mean(axis=0)
    there = Move(turn=turn).of((here - middle) * scale) + middle + [north, east]
    found = fitted([(here[0], there[0]), (here[1], there[1])])
    assert found.move.turn == pytest.approx(turn, abs=1e-9)
    assert found.residual == pytest.approx((scale - 1) * apart, abs=1e-9)
    assert found.move.of(here).mean(axis=0) == pytest.approx(there.mean(axis=0), abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("points", "refusal"),
    [
        (None, "points: must be a list"),
        ([{}] * 3, "points: must be a list"),
        ([{"from": [52.0, 5.0]}], r"points\[0\]: must be an object with from and to"),
        ([{"from": [52.0, 5.0], "to": [52.0, "5"]}], r"points\[0\].to: must be \[latitude"),
        ([{"from": [52.0, 5.0], "to": [52.0, math.nan]}], r"points\[0\].to: must be \[latitude"),
        ([{"from": [52.0, 5.0], "to": [99.0, 5.0]}], r"points\[0\].to: must be degrees"),
        ([{"from": [10.0, 5.0], "to": [10.0, 5.0]}], r"points\[0\].from: must lie at this lot"),
        ([point((0.0, 0.0), Move(31.0))], r"points\[0\].to: is 31 m from where the lot has it, 30 m is the most"),
        ([point((0.0, 0.0), Move()), point((0.0, 9.0), Move())], "points: are 9.0 m apart: take points 10 m"),
        ([point((0.0, 0.0), Move(turn=0.2)), point((0.0, 20.0), Move(turn=0.2))], "points: turn the lot by 11.5°, 10°"),
    ],
)
def test_points_that_cannot_be_are_refused_with_the_remedy(archive: Archive, points: Any, refusal: str) -> None:
    before = archive.read()
    with pytest.raises(LotInputError, match=refusal), archive.store.writing() as connection:
        commands.pin(connection, archive.lot, {"points": points}, "operator", NOW)
    assert archive.read() == before


@pytest.mark.slow
def test_a_lot_is_not_pinned_while_a_person_edits_its_plan(archive: Archive) -> None:
    with archive.store.writing() as connection:
        edits.open_edit(connection, archive.lot, {"who": "Ann"}, NOW)
    with pytest.raises(BeingEditedError):
        pin(archive, point((0.0, 0.0), Move(1.0)))


@pytest.mark.slow
def test_a_receiver_that_is_surer_counts_for_more_in_the_mean(archive: Archive) -> None:
    away = replace(DATUM, latitude=earth(-4.0, 0.0)[0])
    archive.add(replace(flown(2), datum=away, accuracy=0.02), farther_north)
    sure, usual = 1 / (0.02**2 + 0.3**2), 1 / (1.5**2 + 0.3**2)
    north = about(HERE, np.array([archive.read()["datum"]]))[0, 0]
    assert north == pytest.approx(-4.0 * sure / (sure + usual), abs=1e-3)


@pytest.mark.slow
def test_receivers_that_say_nothing_count_alike(archive: Archive) -> None:
    archive.add(replace(flown(2), datum=replace(DATUM, latitude=earth(-4.0, 0.0)[0])), farther_north)
    assert about(HERE, np.array([archive.read()["datum"]]))[0, 0] == pytest.approx(-2.0, abs=1e-3)


def farther_north(known: KnownGround, found: MappedGround) -> Registration:
    """Find the stalls of a survey whose receiver has them 4 m too far south."""
    move = Move(north=4.0)
    return Registration(4.0, 0.0, 0.0, same_stalls(known.stalls, move.stalls(found.stalls)))
