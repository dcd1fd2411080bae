"""Measures of vehicles: matched one to one, what is cut or unsure left out, sections counted."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.cars.eyes import SeenVehicles
from benchmarks.cars.labels import HAND_LABELS, LabelError, read_truth, truth_of
from benchmarks.cars.measures import CarTally, LotSection, figures, flicker, matched, measure, read_sections
from benchmarks.cars.scenes import CarScene, at_metres, read_regions


def box(x: float, y: float, **said: object) -> dict[str, object]:
    return {"corners_m": [[x - 2.2, y - 0.9], [x - 2.2, y + 0.9], [x + 2.2, y + 0.9], [x + 2.2, y - 0.9]], **said}


def scene(*vehicles: dict[str, object]) -> CarScene:
    return CarScene("a", np.zeros((400, 400, 3), np.uint8), 0.1, truth_of(vehicles))


class Eye:
    """Finds what it is given, each surely."""

    def __init__(self, *places: tuple[float, float], probability: float = 0.9) -> None:
        quads = [box(x, y)["corners_m"] for x, y in places]
        self.seen = SeenVehicles(np.array(quads).reshape(-1, 4, 2), np.full(len(quads), probability))

    def find(self, scene: CarScene) -> SeenVehicles:
        del scene
        return self.seen


def test_each_label_has_one_find_and_each_find_one_label() -> None:
    counts = measure(Eye((10, 10), (10.4, 10.4), (20, 20)), scene(box(10, 10), box(20, 20.5), box(30, 30)))
    assert (counts.matched, counts.found, counts.labels) == (2, 3, 3)


def test_a_find_beyond_a_metre_and_a_half_is_another_one() -> None:
    assert measure(Eye((10, 11.4)), scene(box(10, 10))).matched == 1
    assert measure(Eye((10, 11.6)), scene(box(10, 10))).matched == 0


@pytest.mark.parametrize("flag", ["cut", "unsure"])
def test_what_a_person_would_not_bet_on_is_neither_right_nor_wrong(flag: str) -> None:
    given = scene(box(10, 10, **{flag: True}), box(20, 20))
    with_it, without = measure(Eye((10, 10), (20, 20)), given), measure(Eye((20, 20)), given)
    assert (with_it.matched, with_it.found, with_it.labels) == (without.matched, without.found, without.labels)
    assert (without.matched, without.found, without.labels) == (1, 1, 1)


def test_a_doubtful_find_does_not_count_but_its_probability_is_judged() -> None:
    counts = measure(Eye((10, 10), probability=0.3), scene(box(10, 10)))
    assert (counts.matched, counts.found) == (0, 0)
    assert counts.judged[0].said.tolist() == [0.3]
    assert counts.judged[0].true.tolist() == [True]


def test_recall_is_by_ground_and_kerb() -> None:
    given = scene(box(10, 10, ground="crown"), box(20, 20, ground="shade", kerb=True), box(30, 30))
    counts = measure(Eye((20, 20), (30, 30)), given)
    assert counts.groups == {"open": (1, 1), "shade": (1, 1), "crown": (0, 1), "kerb": (1, 1)}
    rows = {row.text: row.value for row in figures(counts, "x")}
    assert rows["recall, crown"] == 0


def test_sections_are_counted_by_the_middles() -> None:
    outline = np.array([[0, 0], [40, 0], [40, 15], [0, 15]], float)
    given = scene(box(10, 10), box(20, 10), box(20, 25))
    counts = measure(Eye((10, 10), (20, 25)), given, [LotSection("a", outline, 5), LotSection("b", outline, 5)])
    assert counts.sections == ((1, 2, True),), "of two one may be missed"
    rows = {row.text: row.value for row in figures(counts + counts, "x")}
    assert rows["sections"] == 2
    assert rows["total of sections over true"] == 0.5


def test_an_interval_of_a_section_does_not_hold_a_number_far_from_the_finds() -> None:
    outline = np.array([[0, 0], [40, 0], [40, 40], [0, 40]], float)
    given = scene(*(box(10, 4 * k) for k in range(1, 9)))
    counts = measure(Eye((10, 4)), given, [LotSection("a", outline, 9)])
    assert counts.sections == ((1, 8, False),)
    rows = {row.text: row.value for row in figures(counts, "x")}
    assert rows["interval of a section holds the truth"] == 0


def test_nothing_found_and_nothing_labelled_is_no_error() -> None:
    assert measure(Eye(), scene()).labels == 0
    assert matched(np.zeros((0, 2)), np.zeros((3, 2)))[0].size == 0
    assert figures(CarTally(), "x")[0].value == 0


def test_a_finer_picture_is_averaged_and_a_coarse_one_left_out() -> None:
    coarse = at_metres(scene(box(10, 10)), 0.15)
    assert coarse is not None
    assert coarse.image.shape[:2] == (267, 267)
    assert at_metres(coarse, 0.12) is None


def test_a_vehicle_that_some_shifts_lose_flickers() -> None:
    class Steady:
        def find(self, scene: CarScene) -> SeenVehicles:
            return SeenVehicles(scene.truth.corners, np.full(len(scene.truth), 0.9))

    class OneLost:
        def find(self, scene: CarScene) -> SeenVehicles:
            corners = scene.truth.corners if scene.image.shape[1] > 390 else scene.truth.corners[:1]
            return SeenVehicles(corners, np.full(len(corners), 0.9))

    given = scene(box(10, 10), box(20, 20))
    assert flicker(Steady(), given) == (0, 2)
    assert flicker(OneLost(), given) == (1, 2)


def test_damaged_labels_are_named(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps({"vehicles": [{"corners_m": [[1, 2]]}]}))
    with pytest.raises(LabelError, match=r"a\.json"):
        read_truth(path)
    assert read_truth(tmp_path / "none.json") is None
    assert list(read_regions(tmp_path)) == []


def test_the_labels_by_hand_can_be_read_and_their_boxes_are_vehicles() -> None:
    paths = sorted(HAND_LABELS.glob("nl_*.json"))
    assert len(paths) == 11
    for path in paths:
        truth = read_truth(path)
        assert truth is not None
        corners = truth.corners[truth.is_counted]
        sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        assert (sides[:, 0] <= sides[:, 1] + 0.1).all(), f"{path.name}: the short ends first"
        assert ((sides.max(axis=1) > 1.5) & (sides.max(axis=1) < 20)).all(), path.name
    names = {path.stem for path in paths}
    sections = read_sections()
    assert {section.region for section in sections} <= names
    assert all(section.capacity >= 1 for section in sections)
