from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import pytest

from benchmarks import __main__ as command
from benchmarks import kill_under_load, surveys, whole_daemon
from benchmarks.figures import BenchmarkError, Figure, Section
from benchmarks.perception.sections import Material
from benchmarks.surveys import Survey


async def two_kills(kills: int, seed: int, folder: Path) -> tuple[list[Figure], str]:
    return [Figure("kills", "kills measured", float(kills))], ""


async def no_simulator(seconds: float, seed: int, folder: Path) -> tuple[list[Figure], str]:
    raise BenchmarkError("hawk-sim did not start")


def test_one_section_is_measured_printed_and_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(kill_under_load, "measure", two_kills)
    out = tmp_path / "results" / "out.json"
    assert command.main(["--only", "kill", "--kills", "2", "--json", str(out)]) == 0
    assert json.loads(out.read_text()) == {"kills": 2.0}
    assert "kills measured" in capsys.readouterr().out


def test_a_section_that_fails_does_not_lose_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(kill_under_load, "measure", two_kills)
    monkeypatch.setattr(whole_daemon, "measure", no_simulator)
    out = tmp_path / "out.json"
    assert command.main(["--only", "kill,latency", "--json", str(out)]) == command.EXIT_FAILED
    assert json.loads(out.read_text()) == {"kills": 60.0}
    assert "latency: not measured: hawk-sim did not start" in capsys.readouterr().out


def test_kept_results_never_mix_with_those_of_an_earlier_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(whole_daemon, "measure", no_simulator)
    for _ in range(2):
        command.main(["--only", "latency", "--keep", str(tmp_path / "kept")])
    assert len(list((tmp_path / "kept").iterdir())) == 2


def test_surveys_are_flown_in_the_condition_that_was_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    flown: list[list[str]] = []

    async def survey(seeds: Sequence[int], folder: Path, simulated: Sequence[str]) -> tuple[list[Figure], str]:
        flown.append(list(simulated))
        return [Figure("surveys", "surveys", float(len(seeds)))], ""

    monkeypatch.setattr(surveys, "measure", survey)
    command.main(["--only", "seeds"])
    command.main(["--only", "seeds", "--condition", "night", "--gnss-sigma", "1"])
    later = ["--at", "2026-05-04T10:30", "--repaint", "2", "--gnss-bias=-3,1", "--compass-error", "4"]
    command.main(["--only", "seeds", *later])
    assert flown == [
        [],
        ["--condition=night", "--gnss-sigma=1.0"],
        ["--at=2026-05-04T10:30", "--repaint=2", "--gnss-bias=-3,1", "--compass-error=4.0"],
    ]


def test_places_are_flown_with_their_cars_moved(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    flown: list[tuple[str, list[str]]] = []

    async def fly(name: str, world: Sequence[str], folder: Path) -> Survey:
        flown.append((name, list(world)))
        raise BenchmarkError("enough is known")

    monkeypatch.setattr(surveys, "_fly", fly)
    (tmp_path / "north.json").write_text('{"metres_per_pixel": 0.1}')
    for cars in ([], ["--cars", "3"]):
        assert command.main(["--only", "places", "--places", str(tmp_path), *cars]) == command.EXIT_FAILED
    (name, still), (_, moved) = flown
    assert name == "north"
    assert moved == [*still, "--cars=3"]


def test_perception_has_names_of_its_own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    looked_at: list[Material] = []

    def measured(network: object, material: Material) -> list[Section]:
        looked_at.append(material)
        return [Section("tiles", [Figure("recall_whole", "recall of whole stalls", 0.5)])]

    monkeypatch.setattr(command, "network_sections", measured)
    out = tmp_path / "out.json"
    command.main(["--only", "perception", "--tiles", "t", "--places", "p", "--seeds", "2-3", "--json", str(out)])
    assert json.loads(out.read_text()) == {"perception_recall_whole": 0.5}
    assert looked_at == [Material(lots=Path("p"), tiles=Path("t"), seeds=[2, 3])]


@pytest.mark.parametrize("name", command.SECTIONS)
def test_every_section_that_can_be_chosen_can_be_measured(name: str, tmp_path: Path) -> None:
    assert callable(command._work(name, command.options_of().parse_args([]), tmp_path))


@pytest.mark.parametrize(
    "arguments", [["--only", "kill,speed"], ["--only", "kill,places"], ["--seeds", "x"], ["--condition", "fog"]]
)
def test_wrong_options_are_refused_with_the_option(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        command.main(arguments)
    assert ended.value.code == 2
    assert arguments[0] in capsys.readouterr().err
