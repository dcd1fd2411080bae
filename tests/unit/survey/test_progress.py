from __future__ import annotations

import io

from rich.console import Console

from hawk.survey.operator import CHECKING, SurveyOperator, SurveyPlan
from hawk.survey.run import SurveyProgress
from tests.unit.survey.fake_drone import FakeDrone


async def shown(*, quiet: bool) -> str:
    """Return the bar's last text for a survey of which the fake drone reports half of the lot as seen."""
    screen = io.StringIO()
    with SurveyProgress(quiet=quiet, console=Console(file=screen, width=160)) as progress:
        outcome = await SurveyOperator(FakeDrone(), SurveyPlan(), progress.show).run()
    assert outcome.explored == 0.5
    return screen.getvalue()


async def test_the_share_is_shown_as_that_of_what_was_found_so_far() -> None:
    text = await shown(quiet=False)
    assert "50 % seen so far" in text
    assert "Coming home" in text
    assert "battery" in text


async def test_a_height_just_below_zero_has_no_sign() -> None:
    screen = io.StringIO()
    with SurveyProgress(quiet=False, console=Console(file=screen, width=160)) as progress:
        progress.show("On the ground", await FakeDrone(height=-0.3).next_heartbeat(1.0))
    assert " 0 m" in screen.getvalue()
    assert "-0 m" not in screen.getvalue()


async def test_while_it_checks_the_failed_checks_are_named() -> None:
    screen = io.StringIO()
    with SurveyProgress(quiet=False, console=Console(file=screen, width=160)) as progress:
        beat = await FakeDrone(failsafes_set=False).next_heartbeat(1.0)
        assert [check.name for check in beat.checks if not check.passed] == ["GPS", "Failsafes"]
        progress.show(CHECKING, beat)
    assert "Checking" in screen.getvalue()
    assert "GPS: off · Failsafes: off" in screen.getvalue()
    assert "battery" not in screen.getvalue()


async def test_quiet_prints_nothing() -> None:
    assert await shown(quiet=True) == ""
