"""The last lines of ``hawk-drone survey``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from hawk.comm.protocol.heartbeat import LeftOutStatus, RoundLotStatus
from hawk.model.plans import LeftOut
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
    _say(Path("out"), DONE, {**COUNTS, **SCORE, "late_frames": 0.0104, "run_is_valid": False})
    printed = capsys.readouterr()
    assert "stall_f1 1.000" in printed.out
    assert printed.err.startswith("VOID: 1.04% of the simulator's pictures")


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


@pytest.mark.parametrize(
    ("left", "words"),
    [
        ((0.0, 0.4, 0.0, 0.0), "Seen: 98.0% of the lot found. Nothing inside the fence was left out."),
        (
            (12.0, 0.0, 30.0, 400.0),
            "Seen: 98.0% of the lot found. Left out: 12 m² outside the fence, 30 m² given up, where pictures showed "
            "nothing new, 400 m² of other ground beside it, where the lot may go on.",
        ),
        ((0.0, 7.0, 0.0, 0.0), "Left out: 7 m² hidden from every place inside the fence."),
    ],
)
def test_what_was_left_out_is_said_with_its_reason(
    left: tuple[float, float, float, float], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    status = LeftOutStatus.of(LeftOut(*left))
    _say(Path("out"), replace(DONE, explored=0.98, left_out=status), {**COUNTS})
    assert words in capsys.readouterr().out
    _say(Path("out"), DONE, {**COUNTS})
    assert "Seen:" not in capsys.readouterr().out


def test_each_lot_of_a_round_is_said_with_what_was_looked_at(capsys: pytest.CaptureFixture[str]) -> None:
    lots = (
        RoundLotStatus(lot="n", name="North", seen=1.0, is_over=True),
        RoundLotStatus(lot="s", name="South", seen=0.38),
        RoundLotStatus(lot="w", name="West", seen=1.0),
    )
    _say(Path("out"), replace(DONE, lots=lots), COUNTS)
    printed = capsys.readouterr().out
    assert "North: 100 % of the stalls looked at\n" in printed
    assert "South: 38 % of the stalls looked at; not finished: fly on with --continue" in printed
    assert "West: 100 % of the stalls looked at; its rim was not looked at: fly on with --continue" in printed
    _say(Path("out"), replace(DONE, lots=lots[:1]), COUNTS)
    assert "North" not in capsys.readouterr().out
