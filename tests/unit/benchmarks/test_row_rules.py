"""Rules about rows: the prior of the surest stalls, and one look of the network for all rules."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.perception.places import Place
from benchmarks.perception.row_rules import RULES, Once, RowRule, agrees, main, measure_rules, table
from hawk.algo.vision.network import NetworkMaps
from hawk.algo.vision.rows import RowStalls, row_stalls
from hawk.survey.scoring import LabelledPlace
from tests.unit.benchmarks.test_perception_edges import STALLS
from tests.unit.benchmarks.test_perception_regions import write_region

SURE = [(0.0, 2.5 * k, 0.0, 2.5, 5.0, 0.9) for k in range(6)]


def stalls(
    *weak: tuple[float, float, float, float, float, float], sure: Sequence[tuple[float, ...]] = SURE
) -> RowStalls:
    """Return a row of sure stalls, and weak ones: north, east, angle, width, length, score."""
    return row_stalls(*np.array([*sure, *weak]).T)


@pytest.mark.parametrize(
    ("weak", "agreeing"),
    [
        ((0.0, 15.0, 0.05, 2.6, 5.2, 0.3), True),
        ((8.0, 5.0, np.pi / 2, 2.5, 5.0, 0.3), True),
        ((0.0, 15.0, np.pi - 0.05, 2.5, 5.0, 0.3), True),
        ((0.0, 15.0, 0.4, 2.5, 5.0, 0.3), False),
        ((0.0, 15.0, 0.0, 2.5, 6.2, 0.3), False),
        ((0.0, 15.0, 0.0, 1.9, 5.0, 0.3), False),
    ],
    ids=["alike", "square to it", "alike, the other end first", "turned", "too long", "too narrow"],
)
def test_a_weak_vote_counts_where_it_is_like_the_sure_ones(
    weak: tuple[float, float, float, float, float, float], *, agreeing: bool
) -> None:
    given = stalls(weak)
    assert agrees(given, given.score >= 0.5, 0.15)[-1] == agreeing


def test_two_sure_stalls_are_no_prior() -> None:
    given = stalls((0.0, 5.0, 0.0, 2.5, 5.0, 0.3), sure=SURE[:2])
    assert not agrees(given, given.score >= 0.5, 0.15).any()


def nothing(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.zeros(len(corners))


def test_a_rule_with_a_prior_keeps_the_weak_votes_that_agree() -> None:
    alike, turned = (0.0, 15.0, 0.0, 2.5, 5.0, 0.3), (9.0, 5.0, 0.5, 2.5, 5.0, 0.3)
    assert len(RowRule("prior", agree=0.15).complete(stalls(alike, turned), nothing)) == len(SURE) + 1
    assert len(RowRule("prior", agree=0.15).complete(stalls()[np.zeros(0, np.intp)], nothing)) == 0


class Blank:
    """A network that sees nothing, and counts its pictures."""

    def __init__(self) -> None:
        self.pictures = 0

    def run(self, picture: NDArray[np.uint8], /) -> NetworkMaps:
        self.pictures += 1
        return NetworkMaps(*np.zeros((10, picture.shape[0] // 2, picture.shape[1] // 2), np.float32))


def test_the_network_looks_once_for_all_rules() -> None:
    place = Place("lot", np.full((200, 400, 3), 90, np.uint8), 0.1, LabelledPlace(STALLS, np.full(10, "free", object)))
    network = Blank()
    measured = measure_rules(network, [place, place])
    assert network.pictures == 2
    assert list(measured) == [rule.name for rule in RULES]
    assert {values["recall"] for values in measured.values()} == {0.0}
    assert table("places", measured).splitlines()[2].startswith("| as it flies | – | 0.000 |")


def test_all_who_ask_get_the_same_maps() -> None:
    network = Blank()
    maps, picture = Once(network), np.zeros((64, 64, 3), np.uint8)
    assert maps.run(picture) is maps.run(picture.copy())
    assert network.pictures == 1


@pytest.mark.parametrize("name", ["lots", "tiles", "regions"])
def test_a_folder_that_is_not_there_is_refused(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main([f"--{name}", "nowhere"])
    assert f"--{name}: nowhere is no folder" in capsys.readouterr().err


def test_the_command_prints_a_table_and_writes_the_figures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder, out = tmp_path / "regions", tmp_path / "rules.json"
    folder.mkdir()
    write_region(folder, "office")
    assert main(["--regions", str(folder), "--json", str(out)]) == 0
    assert capsys.readouterr().out.startswith("| regions | precision | recall |")
    figures = json.loads(out.read_text())
    assert figures["regions_as it flies_labels"] == 9
    assert {f"regions_{rule.name}_recall" for rule in RULES} <= set(figures)


def test_the_command_needs_a_folder(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main([])
    assert "name --lots, --tiles or --regions" in capsys.readouterr().err
