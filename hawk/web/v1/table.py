"""Every address of the API, in the order of its documentation."""

from __future__ import annotations

from typing import Final

from hawk.web.v1 import asked, figures, models, reads
from hawk.web.v1.answering import Prepare, Read, reader
from hawk.web.v1.asked import Query
from hawk.web.v1.models import Shown
from hawk.web.v1.operations import Operation

LOTS: Final = "Lots"
SURVEYS: Final = "Surveys"
STATISTICS: Final = "Statistics"


def _read(
    path: str, name: str, text: str, tag: str, read: Read, answer: type[Shown], query: type[Query] = Query,
    prepare: Prepare | None = None,
) -> Operation:  # fmt: skip
    return Operation("GET", path, name, text, tag, reader(query, read, prepare), answer, query)


_READS: Final = (
    _read("/lots", "lots", "Lots, the oldest first", LOTS, reads.lots, models.Lots, asked.Listed),
    _read("/lots/{id}", "lot", "A lot", LOTS, reads.lot, models.Lot),
    _read("/lots/{id}/layouts", "layouts", "Versions of a lot's layout, the first one first", LOTS, reads.layouts,
          models.Layouts, asked.Listed),
    _read("/lots/{id}/layouts/{version}/stalls", "layout_stalls", "Stalls of a version of a lot's layout, as they were",
          LOTS, reads.stalls_of_layout, models.PlanStalls, asked.Listed),
    _read("/lots/{id}/stalls", "stalls", "Stalls of a lot's plan with the last look at each", LOTS, reads.stalls,
          models.Stalls, asked.Stalls),
    _read("/stalls/{id}", "stall", "A stall of any layout", LOTS, reads.stall, models.Stall),
    _read("/lots/{id}/zones", "zones", "Zones of a lot's plan, and areas without stalls", LOTS, reads.zones,
          models.Zones, asked.Listed),
    _read("/surveys", "surveys", "Surveys of all lots, and of none", SURVEYS, reads.surveys, models.Surveys,
          asked.Surveys),
    _read("/lots/{id}/surveys", "lot_surveys", "Surveys of a lot", SURVEYS, reads.surveys, models.Surveys,
          asked.Surveys),
    _read("/surveys/{id}", "survey", "A survey", SURVEYS, reads.survey, models.Survey),
    _read("/surveys/{id}/observations", "survey_observations", "Looks of a survey at the stalls of its lot", SURVEYS,
          reads.observations_of_survey, models.Observations, asked.Listed),
    _read("/lots/{id}/observations", "observations", "Looks of all surveys at the stalls of a lot", SURVEYS,
          reads.observations, models.Observations, asked.Observations),
    _read("/lots/{id}/statistics", "statistics", "Figures of a lot's use, as `hawk-drone stats --json` prints them",
          STATISTICS, reads.statistics, figures.Statistics, asked.Statistics, reads.keep_missing_looks),
)  # fmt: skip

OPERATIONS: Final[tuple[Operation, ...]] = (*_READS,)
