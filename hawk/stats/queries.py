"""Statistics of a lot in a store: one call for the command line, the page and other tools."""

from __future__ import annotations

from sqlalchemy import Connection

from hawk.lots.values import LotInputError
from hawk.stats.changes import Changed, changes_between
from hawk.stats.figures import Figures, figures
from hawk.stats.panel import Period, read_panel
from hawk.stats.partition import Partition


def statistics(connection: Connection, lot: str, period: Period, by: Partition | None = None) -> Figures:
    """Return the figures of a lot in a period, by a partition of it.

    Raises NotFoundError, LotStoreError.
    """
    return figures(read_panel(connection, lot, period), by)


def changes(connection: Connection, lot: str, before: str, after: str, period: Period) -> Changed:
    """Return what changed from one survey of a lot to another one, by their ids.

    Raises LotInputError for a survey that the period has not, or whose place or time is not sure; NotFoundError.
    """
    panel = read_panel(connection, lot, period)
    numbers = {survey.id: number for number, survey in enumerate(panel.surveys)}
    reasons = {each.survey: each.why for each in panel.left_out}
    for field, survey in (("before", before), ("after", after)):
        if survey not in numbers:
            words = reasons.get(survey, "is no survey of this lot and period: name another one")
            raise LotInputError(field, words)
    return changes_between(panel, numbers[before], numbers[after])
