"""Recordings of the tree: today's program decides them as they were flown, and makes the map that they hold.

A difference here is a change of how the drone flies or sees. Where it is meant, the commit says why, and
`tests.reference.make` makes the recording or its map again.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from hawk.ddc.replay import compare_recording
from hawk.replay.comparison import Comparison, compare_maps
from hawk.replay.flight import RecordedFlight
from hawk.replay.process import Again, Processed, process
from hawk.results.survey_map import recorded_geojson
from tests.examples import nightly
from tests.reference.kept import FOLDER, MAP, SHA256, machine, unpack

NAMES = sorted(name.removesuffix(".mcap.xz") for name in SHA256)
SOON = ("faults", "survey")
"""Those that `make test` decides again."""
MOST_BYTES = 1_500_000
LEAST_DECISIONS = 500
OTHERS = 0.1
"""Share of stalls that may differ on another kind of machine: floating-point numbers are rounded otherwise there, so
that a stall in doubt may fall to the other side."""


def test_no_recording_changes_unseen() -> None:
    found = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in FOLDER.glob("*.mcap.xz")}
    assert found == SHA256, "say in the commit why a reference is another one now"
    assert max((FOLDER / name).stat().st_size for name in SHA256) < MOST_BYTES


@pytest.mark.slow
@pytest.mark.parametrize("name", [*SOON, *nightly(*(name for name in NAMES if name not in SOON))])
def test_every_decision_is_made_as_it_was(name: str, tmp_path: Path) -> None:
    found = compare_recording(unpack(name, tmp_path))
    assert found.differences == ()
    assert found.left_out == 0
    assert found.decided > LEAST_DECISIONS


@pytest.fixture(scope="module")
def survey(tmp_path_factory: pytest.TempPathFactory) -> Processed:
    flight = RecordedFlight(unpack("survey", tmp_path_factory.mktemp("survey")))
    found = process(flight, Again(flight.settings(), "now"))
    assert flight.damage == ""
    return found


@pytest.mark.slow
def test_the_pictures_of_the_survey_give_the_map_beside_it(survey: Processed) -> None:
    kept = json.loads((FOLDER / MAP).read_text())
    assert survey.datum is not None
    now = recorded_geojson(survey.datum, survey.final.stalls)
    if kept["made_on"] == machine():
        assert json.loads(now) == kept["map"], "the map is another one now: make survey-map again, and say why"
    else:
        check_nearly(compare_maps(json.dumps(kept["map"]), now))
    assert len(kept["map"]["features"]) > 20


@pytest.mark.slow
def test_map_and_plans_made_now_are_those_of_the_flight(survey: Processed) -> None:
    last = survey.last
    assert last is not None
    assert (survey.failed, survey.missing, survey.earlier) == (0, 0, frozenset())
    if json.loads((FOLDER / MAP).read_text())["made_on"] == machine():
        assert survey.equal == survey.compared > 5
        assert survey.planned_equal == survey.planned > 30
    else:
        check_nearly(compare_maps(last.recorded, last.again))


def check_nearly(found: Comparison) -> None:
    """Fail when more stalls differ than another machine's rounding explains; values may all differ in a last digit."""
    others = sum(change.kind != "values" for change in found.changes)
    assert others <= OTHERS * found.recorded, found.changes
