"""Every figure of a drawn week, to the last decimal that is shown: a factor or a bound that moves shows here.

That such figures hold the truth of drawn lots is another question (docs/statistics.md).
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from zoneinfo import ZoneInfo

import numpy as np
import pytest

from hawk.lots.values import moment
from hawk.stats.aggregates import cds_aggregates
from hawk.stats.changes import changes_between
from hawk.stats.figures import figures
from hawk.stats.flow import Moves
from hawk.stats.hour_use import asked_use
from hawk.stats.partition import Partition
from hawk.stats.serialize import asked_csv, asked_text, figures_csv, figures_text
from hawk.stats.turnover import least, longest_gap, most
from hawk.stats.use_query import asked_of
from hawk.stats.values import FREE, NO_TIME, TAKEN, UNSEEN, LeftOut, Panel, PanelColumn, groups_of
from tests.golden import check_text, check_values
from tests.unit.stats.panels import at, everything, panel

HERE = Path(__file__).parent / "drawn_week"
FLOWN = [at(hours, days) for days in (0, 1, 2, 3, 6, 7) for hours in (8.1, 8.45, 8.8, 9.3, 9.9, 13.25)]
"""A quarter of an hour to hours apart, on four days of a week, a Sunday on which nothing was seen, and a Monday."""
SHARES = (0.35, 0.95, 0.6, 1.0, 0.7, 0.8)
FULL, BLIND = 3, 4
"""Days on which every stall is taken, and on which the pictures show none."""
STALLS, A_ROW, NEW, BEGIN = 60, 20, 50, 14
KINDS = ("", "", "", "disabled", "charging")


@cache
def week() -> Panel:
    """Return surveys of cars that come and leave; some stalls are unseen or not sure, ten begin between two surveys."""
    rng = np.random.default_rng(7)
    taken = rng.random(STALLS) < 0.6
    states, chances, there = [], [], []
    for number in range(len(FLOWN)):
        day = number // 6
        taken = np.where(rng.random(STALLS) < (0.25 if day != FULL else 1.0), rng.random(STALLS) < SHARES[day], taken)
        exists = np.arange(STALLS) < (NEW if number < BEGIN else STALLS)
        is_seen = (rng.random(STALLS) > 0.1) & exists & (day != BLIND)
        states.append(np.where(is_seen, np.where(taken, TAKEN, FREE), UNSEEN).tolist())
        sure = 1 - 0.02 * rng.random(STALLS)
        chances.append(np.where(is_seen, np.where(taken, sure, 1 - sure), np.nan))
        there.append(exists)
    drawn = panel(FLOWN, states, a_row=A_ROW)
    stalls = tuple(
        PanelColumn(
            each.id, each.label, each.row, KINDS[k % 5], ("North", "Gate")[: k % 3],
            (9.0 * (k // A_ROW), 2.5 * (k % A_ROW), 0.1, 2.5, 5.0),
        )
        for k, each in enumerate(drawn.stalls)
    )  # fmt: skip
    out = (LeftOut("f" * 36, moment(at(9.0, 1)), NO_TIME),)
    return replace(
        drawn, stalls=stalls, is_there=np.array(there), taken_probability=np.array(chances, np.float32), left_out=out,
        clock=ZoneInfo("Europe/Amsterdam"), clock_name="Europe/Amsterdam",
    )  # fmt: skip


@pytest.mark.parametrize("by", ["hour", "row", "zone", "kind"])
def test_the_figures_of_a_drawn_week(by: Partition) -> None:
    found = figures(week(), by)
    shown = found.model_dump(mode="json")
    check_values(HERE / f"{by}.json", shown if by == "hour" else {"parts": shown["parts"]})
    check_text(HERE / f"{by}.txt", figures_text(found) + "\n")
    check_text(HERE / f"{by}.csv", figures_csv(found))


def test_a_question_about_a_drawn_week() -> None:
    found = asked_use(week(), asked_of("mon-wed", "10-12,15", ["A"], (), ["normal", "disabled"]))
    check_values(HERE / "asked.json", found.model_dump(mode="json", exclude={"cells"}))
    check_text(HERE / "asked.txt", asked_text(found) + "\n")
    check_text(HERE / "asked.csv", asked_csv(found))


def test_one_hour_of_a_drawn_week() -> None:
    found = asked_use(week(), asked_of("wed", "15"))
    assert found.hours == 1
    assert found.accumulation.value == pytest.approx((found.occupancy.value or 0.0) * STALLS)
    check_text(HERE / "hour_of_a_day.txt", asked_text(found) + "\n")


def test_the_hours_of_a_drawn_week_as_a_feed() -> None:
    check_text(HERE / "aggregates.csv", cds_aggregates(week()))


def test_changes_between_two_surveys_of_a_drawn_week() -> None:
    found = [changes_between(week(), *pair).model_dump(mode="json") for pair in ((0, 1), (4, 14), (14, 4))]
    check_values(HERE / "changes.json", found)


def test_arrivals_of_a_drawn_week_pair_by_pair() -> None:
    moves = Moves.of(week(), [*everything(week()), *groups_of(week(), "row")])
    gap = longest_gap(moves)
    ends = [np.round(np.nan_to_num(each, nan=-1.0), 4).tolist() for each in (least(moves), most(moves, gap))]
    check_values(HERE / "arrivals.json", {"longest_gap": round(gap or -1.0, 4), "least": ends[0], "most": ends[1]})
