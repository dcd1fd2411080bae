"""The last lines of ``hawk-drone survey``."""

from __future__ import annotations

from pathlib import Path

import pytest

from hawk.survey.handset import SurveyStatus
from hawk.survey.operator import SurveyOutcome
from hawk.survey.run import _say

SCORE = dict.fromkeys(
    (
        "stall_f1",
        "stall_precision",
        "stall_recall",
        "recall_whole",
        "state_accuracy",
        "lot_iou",
        "lot_seen",
        "stalls_seen",
        "stall_recall_seen",
    ),
    1.0,
)
COUNTS = {"stalls": 2, "free": 1, "taken": 1, "unknown": 0, "free_range": None}
DONE = SurveyOutcome(SurveyStatus.DONE, "The whole lot was seen.", True, True, 120.0, 300.0, 1.0)


def test_a_run_with_late_pictures_says_that_its_figures_count_for_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    _say(Path("out"), DONE, {**COUNTS, **SCORE, "late_frames": 0.21, "run_is_valid": False})
    printed = capsys.readouterr()
    assert "stall_f1 1.000" in printed.out
    assert printed.err.startswith("VOID: 21% of the simulator's pictures")


@pytest.mark.parametrize("values", [{"late_frames": 0.005, "run_is_valid": True}, {}])
def test_a_valid_run_and_a_real_flight_have_no_such_warning(
    values: dict[str, object], capsys: pytest.CaptureFixture[str]
) -> None:
    _say(Path("out"), DONE, {**COUNTS, **values})
    assert capsys.readouterr().err == ""


def test_the_bounds_of_the_free_ones_stand_beside_their_number(capsys: pytest.CaptureFixture[str]) -> None:
    _say(Path("out"), DONE, {**COUNTS, "free_range": (0, 3)})
    assert "2 stalls: 1 free (between 0 and 3), 1 taken" in capsys.readouterr().out
    _say(Path("out"), DONE, COUNTS)
    assert "2 stalls: 1 free, 1 taken" in capsys.readouterr().out
