"""docs/survey.md names every exit status and every key of the report."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from hawk.model.lot_map import StallState
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import SurveyMap
from hawk.survey import report
from hawk.survey.handset import SurveyStatus
from hawk.survey.truth import GroundTruth

DOCUMENT = (Path(__file__).parents[3] / "docs" / "survey.md").read_text(encoding="utf-8")


def keys_of_the_report() -> set[str]:
    """Return the keys that a survey with a truth has, as far as they are made without a flight."""
    place = GlobalPose(43.0, -79.0, 0.0)
    square = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 5.0], [0.0, 5.0]])
    truth = GroundTruth((square,), (StallState.FREE,), (False,), (square,), place)
    survey = SurveyMap(place, {}, {})
    return {*report.counts(survey), *report.compare(survey, truth)}


@pytest.mark.parametrize("status", SurveyStatus, ids=lambda status: status.name)
def test_every_exit_status_is_documented(status: SurveyStatus) -> None:
    assert re.search(rf"^- {int(status)}: ", DOCUMENT, re.MULTILINE)


def test_every_measure_of_the_report_is_documented() -> None:
    documented = set(re.findall(r"`(\w+)`", DOCUMENT))
    assert keys_of_the_report() <= documented
