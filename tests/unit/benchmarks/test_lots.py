from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.lots.__main__ import figures, line
from benchmarks.lots.archive import Judged, Repainted, Surveyed, judged, lasting_ids, survey_lot
from benchmarks.lots.looks import Look, StillEye, on_map, true_ids
from benchmarks.lots.visits import BIAS_M, COMPASS, DrawnLot, Visit, visits
from hawk.algo.rows.fit import Rectangles
from hawk.algo.vision.network import StallNetwork
from hawk.lots.values import Placed, Saved
from hawk.worlds.generate import WorldOptions, generate_world
from hawk.worlds.world import World


@pytest.fixture(scope="module")
def world() -> World:
    return generate_world(2)


def visit(number: int, **values: object) -> Visit:
    return replace(Visit(number, 0.0, (0.0, 0.0), 0.0), **values)  # type: ignore[arg-type]


def surveyed(number: int, ids: dict[int, str], placed: Placed = Placed.REGISTERED, **values: object) -> Surveyed:
    return Surveyed(visit(number, **values), Saved(number, "s", "lot", "Lot 1", placed), len(ids), ids)


def test_the_visits_of_a_seed_are_the_same_each_time_and_within_the_errors_of_receiver_and_compass() -> None:
    assert visits(7) == visits(7)
    for each in visits(7):
        assert math.hypot(*each.bias) <= BIAS_M
        assert abs(each.compass) <= COMPASS
    assert [each.part for each in visits(7)] == [1.0, 1.0, 0.5, 1.0, 1.0, 1.0]
    assert [each.repaint for each in visits(7)] == [0, 0, 0, 0, 1, 1]
    assert [each.is_next_door for each in visits(7)] == [False, False, False, True, False, False]


def test_ids_of_before_are_the_same_and_those_of_another_stall_are_wrong() -> None:
    found = judged(
        "one", [surveyed(1, {1: "a", 2: "b"}, Placed.FIRST), surveyed(2, {1: "a", 2: "c"}), surveyed(3, {2: "a"})]
    )
    assert (found.again, found.same, found.wrong) == (3, 1, 1)


def test_an_id_that_goes_to_a_find_between_two_stalls_is_wrong_though_that_is_none() -> None:
    first = replace(surveyed(1, {1: "a", 2: "b"}, Placed.FIRST), at={"a": (0.0, 0.0), "b": (0.0, 2.5), "c": (0.0, 5.0)})
    near = replace(surveyed(2, {1: "a"}), at={"a": (0.0, 0.6), "b": (0.3, 2.5), "c": (0.0, 5.2)})
    between = replace(surveyed(3, {1: "a"}), at={"b": (0.0, 3.75), "c": (0.0, 3.9)})
    assert judged("one", [first, near]).wrong == 0
    assert judged("one", [first, near, between]).wrong == 2


def test_the_lot_next_door_has_stalls_of_its_own_and_its_doubts_do_not_count() -> None:
    found = judged(
        "one",
        [surveyed(1, {1: "a"}, Placed.FIRST), surveyed(2, {1: "z"}, Placed.UNDECIDED, is_next_door=True)],
    )
    assert (found.again, found.wrong, found.doubts, found.surveys) == (0, 0, (), 1)
    wrong = judged("one", [surveyed(1, {1: "a"}, Placed.FIRST), surveyed(2, {5: "a"}, is_next_door=True)])
    assert wrong.wrong == 1


def test_a_survey_that_is_not_registered_is_named_with_its_reason() -> None:
    found = judged("one", [surveyed(1, {1: "a"}, Placed.FIRST), surveyed(2, {}, Placed.UNREGISTERED)])
    assert found.doubts == ("2: unregistered",)
    assert line(found).endswith("; not registered: 2: unregistered")


def test_a_repaint_is_judged_by_the_stalls_that_it_left_alone_and_those_that_it_changed() -> None:
    paint = Repainted(
        gone=frozenset({3, 4}), came=frozenset({8, 9}), closed=frozenset({2}),
        ended=frozenset({"c", "e"}), begun=frozenset({8, 7}),
    )  # fmt: skip
    first = surveyed(1, {1: "a", 2: "b", 3: "c", 4: "d", 5: "e"}, Placed.FIRST)
    after = replace(surveyed(5, {1: "a"}), repainted=paint)
    next_door = surveyed(4, {6: "z"}, Placed.FIRST, is_next_door=True)
    found = judged("one", [first, next_door, after])
    assert (found.stayed, found.kept, found.changed, found.reported) == (2, 1, 4, 2)
    assert "; repaint: 1 of 2 kept, 2 of 4 reported" in line(found)
    shown = {each.key: each.value for each in figures([found])}
    assert (shown["repaint_kept"], shown["repaint_reported"], shown["repaint_changed"]) == (0.5, 0.5, 4.0)


def test_figures_are_shares_over_all_lots() -> None:
    found = {f.key: f.value for f in figures([Judged("a", 5, 10, 9, 1, ("2: x",)), Judged("b", 5, 10, 10, 0, ())])}
    assert (found["same_id"], found["wrong_id"], found["unregistered"]) == (0.95, 1.0, 1 / 8)


@pytest.mark.nightly
def test_true_stalls_are_found_by_their_place_each_once(world: World) -> None:
    centres = np.array([stall.corners.mean(axis=0) for stall in world.stalls])
    count = len(centres)
    found = Rectangles(centres, np.zeros(count), np.full(count, 2.6), np.full(count, 5.2))
    places, _ = on_map(world, found)
    ids = list(range(100, 100 + count))
    assert true_ids(world, places + np.array([0.4, -0.3]), ids) == dict(
        zip(ids, (stall.id for stall in world.stalls), strict=True)
    )
    assert true_ids(world, places[:1] + np.array([500.0, 0.0]), [1]) == {}


@pytest.mark.nightly
def test_a_repainted_stall_that_fits_one_of_before_is_that_one() -> None:
    first, later = (generate_world(6, WorldOptions(repaint=count)) for count in (0, 1))
    lasting = lasting_ids(first, later)
    before, after = ({stall.id: stall.corners for stall in world.stalls} for world in (first, later))
    assert lasting
    for new, old in lasting.items():
        assert new not in before
        assert old not in after
        assert np.hypot(*(after[new].mean(axis=0) - before[old].mean(axis=0))) < 1.3
    assert lasting_ids(first, first) == {}


class TwoVisits(DrawnLot):
    def visits(self) -> list[Visit]:
        return [visit(1, hours=0.0), visit(2, hours=26.5, bias=(1.5, -2.0), compass=math.radians(1.5))]


@pytest.mark.slow
@pytest.mark.nightly
def test_the_stalls_of_a_drawn_lot_keep_their_ids_with_other_cars_and_errors() -> None:
    eye = StillEye(StallNetwork.load(None))
    looks: list[Look] = []

    class Watched(StillEye):
        def look(self, world: World, visit: Visit) -> Look:
            looks.append(eye.look(world, visit))
            return looks[-1]

    found = survey_lot(TwoVisits(2), Watched(StallNetwork.load(None)))
    assert found.doubts == ()
    assert found.wrong == 0
    assert found.same == found.again > 100
    states = [{stall.id: stall.state for stall in look.survey.stalls} for look in looks]
    assert states[0] != states[1]
