from __future__ import annotations

import json
from pathlib import Path

import pytest

from proving.faults.fault import DOWN, UP, Fault, Outcome, See, When
from proving.faults.record import REAL, SIMULATED, keep_outcome, name_of, read_outcomes
from proving.faults.run import ALL
from proving.faults.table_vehicle import VEHICLE

FIRST, SECOND, THIRD = (Fault(name, When.HOVERING, (See(DOWN, 9.0),)) for name in ("one", "two", "three"))
FAULTS = (FIRST, SECOND, THIRD)


def test_an_outcome_replaces_the_one_before_and_leaves_the_others(tmp_path: Path) -> None:
    file = tmp_path / "outcomes.json"
    assert read_outcomes(file, FAULTS) == ()
    third = Outcome(THIRD, (3.0,), (), ("3 stalls",), ("recall 0.98",))
    keep_outcome(file, third, FAULTS)
    keep_outcome(file, Outcome(FIRST, (), ("not seen",)), FAULTS)
    assert read_outcomes(file, FAULTS) == (Outcome(FIRST, (), ("not seen",)), third)
    keep_outcome(file, Outcome(FIRST, (1.0,)), FAULTS)
    assert read_outcomes(file, FAULTS) == (Outcome(FIRST, (1.0,)), third)
    assert [line[:12] for line in file.read_text().splitlines()[1:-1]] == ['"hovering: o', '"hovering: t']


def test_outcomes_of_faults_that_are_gone_are_left_out(tmp_path: Path) -> None:
    file = tmp_path / "outcomes.json"
    keep_outcome(file, Outcome(Fault("gone", When.ARMED, ()), (1.0,)), (Fault("gone", When.ARMED, ()),))
    keep_outcome(file, Outcome(SECOND, (2.0,)), FAULTS)
    assert list(json.loads(file.read_text())) == ["hovering: two"]


@pytest.mark.parametrize(("file", "faults"), [(SIMULATED, ALL), (REAL, VEHICLE)], ids=["simulated", "real"])
def test_every_fault_was_flown_and_ended_as_it_must(file: Path, faults: tuple[Fault, ...]) -> None:
    outcomes = {name_of(outcome.fault): outcome for outcome in read_outcomes(file, faults)}
    assert set(outcomes) == set(map(name_of, faults))
    for name, outcome in outcomes.items():
        sights = [step for step in outcome.fault.steps if isinstance(step, See)]
        assert outcome.passed, name
        assert len(outcome.seconds) == len(sights), f"{name}: fly it again, it has other sights now"
        looked = 0.0  # a sight that is there when it is looked for was not late
        for see, seconds in zip(sights, outcome.seconds, strict=True):
            assert seconds <= max(see.within_s, looked) + 0.5, f"{name}: {see.words}"
            looked = seconds


def test_a_sight_with_its_seconds_and_limit() -> None:
    assert See(DOWN, 9.0).words_with(2.5) == "landed, motors off: 2.5 of 9 s"
    assert See(DOWN, 9.0).words_with(None) == "landed, motors off (≤ 9 s)"
    assert See(UP, 9.0, lasts=True).words_with(9.0) == "in the air (for 9 s)"
