"""The stages from nothing to the weights that ship."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

pytest.importorskip("torch", reason="training needs the training extra")

from training import rows
from training.settings import parse as parse_training
from training.ship import Stage, parse, run, stages

REGIONS = [f"region_{letter}" for letter in "abcdefg"]


@pytest.fixture
def options(tmp_path: Path) -> list[str]:
    ground = tmp_path / "ground"
    ground.mkdir()
    for name in REGIONS:
        (ground / f"{name}.jpg").touch()
    return ["--ground", str(ground), "--folder", str(tmp_path / "made"), "--out", str(tmp_path / "lot.onnx")]


def test_every_region_is_left_out_once(options: list[str]) -> None:
    given = [stage for stage in stages(parse(options)) if stage.name.startswith("ground")]
    *folds, every = [parse_training(stage.arguments) for stage in given]
    assert every.leave_out == []
    assert sorted(name for fold in folds for name in fold.leave_out) == REGIONS
    assert len({fold.seed for fold in folds}) == len(folds) == 3


def test_each_stage_begins_from_what_the_one_before_makes(options: list[str]) -> None:
    first, *trainings, mean, settled, fit = stages(parse(options))
    drawn = parse_training(first.arguments)
    assert len(trainings) == 4
    for training in trainings:
        ground = parse_training(training.arguments)
        assert ground.start_from == ground.teacher == drawn.out
        assert str(ground.keep) in mean.arguments
    assert settled.arguments[0] == mean.arguments[mean.arguments.index("--keep") + 1]
    assert str(settled.result) in fit.arguments
    assert fit.command is rows.main


def test_device_painters_and_seed_reach_every_training(options: list[str]) -> None:
    given = stages(parse([*options, "--device", "cuda", "--painters", "14", "--seed", "40"]))
    trainings = [parse_training(stage.arguments) for stage in given[:5]]
    assert {(training.device, training.painters) for training in trainings} == {("cuda", 14)}
    assert [training.seed for training in trainings] == [40, 41, 42, 43, 44]
    assert [training.steps for training in trainings] == [34_000, 1_500, 1_500, 1_500, 3_000]


def test_textures_reach_the_trainings_with_real_ground(options: list[str]) -> None:
    for given, share in (([], 0.0), (["--textures", "0.4"], 0.4)):
        first, *trainings = (parse_training(stage.arguments) for stage in stages(parse([*options, *given]))[:5])
        assert first.textures == 0
        assert {training.textures for training in trainings} == {share}


def test_a_command_that_was_ended_goes_on_with_the_first_stage_that_is_not_done(tmp_path: Path) -> None:
    ran: list[str] = []

    def stage(name: str, *, fails: bool = False) -> Stage:
        result = tmp_path / name

        def command(_arguments: Sequence[str]) -> None:
            ran.append(name)
            if fails:
                raise KeyboardInterrupt
            result.touch()

        return Stage(name, command, (), result)

    with pytest.raises(KeyboardInterrupt):
        run([stage("first"), stage("second", fails=True), stage("third")])
    run([stage("first"), stage("second"), stage("third")])
    assert ran == ["first", "second", "second", "third"]


def test_a_folder_without_pictures_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        parse(["--ground", str(tmp_path), "--folder", str(tmp_path), "--out", "lot.onnx"])
    assert ended.value.code == 2
    assert "holds no REGION.jpg" in capsys.readouterr().err
