"""A known lot by its name or id; and a survey that never took off leaves earlier results as they are."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Self

import pytest

from hawk.cli import main
from hawk.comm.protocol.commands import SurveyAgain
from hawk.config.sections import ConfigError
from hawk.survey import run
from hawk.survey.handset import SurveyStatus
from hawk.survey.operator import NOTHING_LEFT, SurveyOutcome, SurveyPlan

LOTS = [{"id": "1a", "name": "Market"}, {"id": "2b", "name": "Lot 2"}, {"id": "3c", "name": "market"}]


def test_a_lot_is_named_by_its_id_or_by_a_name_that_no_other_has() -> None:
    assert run.lot_named("1a", LOTS) == "1a"
    assert run.lot_named("LOT 2", LOTS) == "2b"


@pytest.mark.parametrize(
    ("wanted", "lots", "words"),
    [
        ("Harbour", LOTS, "--again: no lot has the name or id 'Harbour'; known lots: Market, Lot 2, market"),
        ("Market", LOTS, "--again: 2 lots are called 'Market': write the id of one of them: 1a, 3c"),
        ("Market", [], "known lots: there is none: survey a lot first"),
    ],
)
def test_a_lot_that_is_not_known_is_refused_with_the_remedy(wanted: str, lots: list[Any], words: str) -> None:
    with pytest.raises(ConfigError) as refused:
        run.lot_named(wanted, lots)
    assert words in str(refused.value)


OPTIONS = run.SurveyOptions(
    out=Path("out"), simulation=None, url="http://127.0.0.1:1", token=None, certificate=None, config=None, fence=None,
    outline=None, truth=None, set_failsafes=False, continues=True, again=None, due=False, timeout_s=60.0, quiet=True,
)  # fmt: skip


def test_several_lots_are_one_command_and_due_names_none() -> None:
    assert run.again_command(OPTIONS, ()) is None
    both = run.again_command(replace(OPTIONS, again=["lot 2", "3c"]), LOTS)
    assert both == SurveyAgain(lots=["2b", "3c"])
    assert run.again_command(replace(OPTIONS, due=True), ()) == SurveyAgain(due=True)
    with pytest.raises(ConfigError, match="--again: no lot has the name or id 'Harbour'"):
        run.again_command(replace(OPTIONS, again=["1a", "Harbour"]), LOTS)
    with pytest.raises(ConfigError, match="--again: 13 lots are too many for one flight: at most 12"):
        run.again_command(replace(OPTIONS, again=["1a"] * 13), LOTS)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["--again", "A", "--due"], "--again: not together with --due, which chooses the lots"),
        (["--due", "--outline", __file__], "--outline: not together with --again and --due"),
        (["--again", "A", "--again", "B", "--outline", __file__], "--outline: not together with --again and --due"),
    ],
)
def test_options_that_contradict_each_other_are_refused(
    given: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["survey", "--url", "http://127.0.0.1:1", "--out", "o", *given]) != 0
    assert words in capsys.readouterr().err


class Client:
    """A drone that answers what a survey asks before it flies."""

    def __init__(self, *_: object, **__: object) -> None:
        pass

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        pass

    async def lots(self) -> list[dict[str, Any]]:
        return [dict(lot) for lot in LOTS]


def texts_in(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir()}


async def test_a_survey_that_never_took_off_writes_over_no_results(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plans: list[SurveyPlan] = []
    outcome = SurveyOutcome(SurveyStatus.FAILED, NOTHING_LEFT, True, True, None, None, None)

    async def refused() -> SurveyOutcome:
        return outcome

    def operator(_drone: object, plan: SurveyPlan, _show: object) -> SimpleNamespace:
        plans.append(plan)
        return SimpleNamespace(run=refused, interrupt=lambda: None)

    monkeypatch.setattr(run, "DroneClient", Client)
    monkeypatch.setattr(run, "SurveyOperator", operator)
    earlier = {name: f"yesterday's {name}" for name in ("stalls.csv", "stalls.geojson", "map.png", "report.json")}
    for name, text in earlier.items():
        (tmp_path / name).write_text(text)
    options = replace(OPTIONS, out=tmp_path, again=["1a"])
    assert await run.run_survey(options) == SurveyStatus.FAILED
    assert texts_in(tmp_path) == earlier
    assert NOTHING_LEFT in capsys.readouterr().out
    assert plans[0].again == SurveyAgain(lots=["1a"])
