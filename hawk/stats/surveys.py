"""Surveys of a lot by date, each with its share of taken stalls, and a reason where no figure uses it."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from sqlalchemy import Connection, RowMapping, select

from hawk.lots.rows import readable
from hawk.lots.schema import SURVEY
from hawk.lots.survey.counts import counts_of
from hawk.lots.survey.order import newest_first
from hawk.lots.survey.source import SOURCE_COLUMNS, source_json
from hawk.lots.values import moment
from hawk.stats.answers import SurveysUse, SurveyUse
from hawk.stats.counts import count
from hawk.stats.panel import CODES, Period, read_panel
from hawk.stats.values import LEVEL, NOTHING, Estimate, Group, Panel

_SHOWN: Final = ("id", "layout", "placed", "free", "taken", "unknown", "blurred", "simulated", "program", "accuracy")


def surveys_use(connection: Connection, lot: str, period: Period) -> SurveysUse:
    """Return the surveys of a lot that the figures of a period use or leave out, the newest first.

    ``occupancy``: share of taken stalls with its interval, by the looks. ``left_out``: why no figure uses a survey, ""
    for the others. Raises NotFoundError, LotStoreError.
    """
    panel = read_panel(connection, lot, period)
    shares = dict(zip((survey.id for survey in panel.surveys), _shares(panel), strict=True))
    reasons = {each.survey: each.why for each in panel.left_out}
    columns = (SURVEY.c[name] for name in (*_SHOWN, *SOURCE_COLUMNS, "seq", "lot", "began", "ended"))
    asked = select(*columns).where(SURVEY.c.lot == lot, *period.may_have()).order_by(*newest_first())
    rows = [row for row in connection.execute(asked).mappings() if row["id"] in shares or row["id"] in reasons]

    def use(pair: tuple[RowMapping, dict[str, Any]]) -> SurveyUse:
        row, counts = pair
        return SurveyUse(
            **{name: row[name] for name in _SHOWN} | counts | source_json(row),
            began=moment(row["began"]), ended=moment(row["ended"]), occupancy=shares.get(row["id"], NOTHING),
            left_out=reasons.get(row["id"], ""), left_out_code=CODES.get(reasons.get(row["id"], ""), ""),
        )  # fmt: skip

    return SurveysUse(
        lot=lot, name=panel.name, clock=panel.clock_name, interval=LEVEL,
        surveys=readable(use, zip(rows, counts_of(connection, rows), strict=True)),
    )  # fmt: skip


def _shares(panel: Panel) -> list[Estimate]:
    """Return the share of taken stalls of each survey of a panel."""
    counted = count(panel, (Group("", np.ones(len(panel.stalls), np.bool_)),))
    low, high = counted.bounds()
    ends = np.column_stack((counted.share[:, 0], low[:, 0], high[:, 0])).tolist()
    seen = (counted.seen[:, 0] > 0).tolist()
    return [
        Estimate(share, least, most, 1) if is_seen else NOTHING
        for (share, least, most), is_seen in zip(ends, seen, strict=True)
    ]
