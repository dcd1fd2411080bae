from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from training.settings import TrainingPlan, computes_bfloat16, parse, plan_of, rate

OUT = ["--out", "lot.onnx"]


def plan(*arguments: str) -> TrainingPlan:
    return plan_of(parse([*OUT, *arguments]))


def test_without_options_it_trains_for_an_hour_from_seed_0() -> None:
    assert plan() == TrainingPlan(minutes=60.0, seed=0)
    options = parse(OUT)
    assert options.out == Path("lot.onnx")
    assert options.keep is None
    assert options.start_from is None
    assert options.widths is None


def test_widths_are_five_whole_numbers() -> None:
    assert parse([*OUT, "--widths", "16,32,64,112,160"]).widths == (16, 32, 64, 112, 160)


@pytest.mark.parametrize(
    ("arguments", "field", "value"),
    [
        (["--minutes", "7.5"], "minutes", 7.5),
        (["--steps", "34000"], "steps", 34000),
        (["--seed", "3"], "seed", 3),
        (["--crop", "320"], "side", 320),
        (["--batch", "4"], "batch", 4),
        (["--rate", "7e-4"], "rate", 7e-4),
        (["--threads", "2"], "threads", 2),
        (["--painters", "3"], "painters", 3),
        (["--float32"], "bfloat16", False),
        (["--device", "cuda"], "device", "cuda"),
    ],
)
def test_each_option_changes_its_own_setting_only(arguments: list[str], field: str, value: object) -> None:
    changed, usual = plan(*arguments), plan()
    assert getattr(changed, field) == value
    others = [name for name in TrainingPlan.__dataclass_fields__ if name != field]
    assert [getattr(changed, name) for name in others] == [getattr(usual, name) for name in others]


def test_textures_are_cut_from_real_ground(capsys: pytest.CaptureFixture[str]) -> None:
    assert parse(OUT).textures == 0
    assert parse([*OUT, "--ground", "pictures", "--textures", "0.5"]).textures == 0.5
    with pytest.raises(SystemExit):
        parse([*OUT, "--textures", "0.5"])
    assert "--textures needs --ground" in capsys.readouterr().err


def test_the_commands_of_the_model_card_are_understood() -> None:
    card = (Path(__file__).parents[3] / "docs" / "model-card.md").read_text(encoding="utf-8")
    commands = [line.strip().split()[3:] for line in card.splitlines() if "python -m training.train" in line]
    assert len(commands) >= 2
    for command in commands:
        assert plan_of(parse(command)).steps is not None


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "--out"),
        ([*OUT, "--steps", "10", "--minutes", "3"], "not allowed with"),
        ([*OUT, "--widths", "16,32"], "--widths: must be 5 whole numbers with commas, not '16,32'"),
        ([*OUT, "--widths", "16,32,a,1,2"], "--widths: must be a whole number from 1, not 'a'"),
        ([*OUT, "--steps", "0"], "--steps: must be a whole number from 1"),
        ([*OUT, "--steps", "-5"], "--steps"),
        ([*OUT, "--minutes", "0"], "--minutes: must be a number above 0"),
        ([*OUT, "--minutes", "nan"], "--minutes"),
        ([*OUT, "--minutes", "long"], "--minutes"),
        ([*OUT, "--rate", "-1"], "--rate: must be a number above 0"),
        ([*OUT, "--batch", "0"], "--batch: must be a whole number from 1"),
        ([*OUT, "--crop", "100"], "--crop: must be a multiple of 32, not 100"),
        ([*OUT, "--crop", "0"], "--crop"),
        ([*OUT, "--painters", "x"], "--painters"),
    ],
)
def test_a_bad_option_is_named_and_ends_with_two(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        parse(arguments)
    assert ended.value.code == 2
    assert words in capsys.readouterr().err


def test_the_rate_warms_up_and_falls_to_a_hundredth() -> None:
    assert rate(0, 0.0) == pytest.approx(0.05 * 1.01)
    assert rate(25, 0.0) == pytest.approx(0.55 * 1.01)
    assert rate(1000, 0.0) == pytest.approx(1.01)
    assert rate(1000, 0.5) == pytest.approx(0.51)
    assert rate(1000, 1.0) == pytest.approx(0.01)
    assert rate(1000, 1.7) == pytest.approx(0.01), "past its time it does not rise again"


@given(st.integers(0, 10_000), st.floats(0, 1), st.floats(0, 1))
def test_the_rate_never_rises_after_the_warm_up(step: int, one: float, two: float) -> None:
    early, late = sorted((one, two))
    assert 0 < rate(step + 50, late) <= rate(step + 50, early) <= 1.01
    assert rate(step, early) <= rate(step + 1, early)


def test_the_states_to_average_come_from_the_second_half_and_end_with_the_last() -> None:
    averaged = plan().averaged
    assert averaged == tuple(sorted(averaged))
    assert min(averaged) >= 0.5
    assert averaged[-1] == 1.0


@pytest.mark.parametrize(
    ("flags", "has"), [("fpu avx2 avx512f avx512_bf16", True), ("asimd bf16", True), ("fpu avx2 avx512f", False)]
)
def test_a_processor_names_its_instructions_for_bfloat16(tmp_path: Path, flags: str, has: bool) -> None:
    (tmp_path / "cpuinfo").write_text(f"processor : 0\nflags : {flags}\n")
    assert computes_bfloat16(tmp_path / "cpuinfo") is has
    assert not computes_bfloat16(tmp_path / "none")
