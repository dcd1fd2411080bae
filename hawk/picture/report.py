"""Report of a survey by pictures: counts with their interval, ground that was seen, what was left out."""

from __future__ import annotations

import math
from typing import Any

from hawk.exports.text_files import about_survey
from hawk.model.lot_map import HELD_SHARE, free_variance, interval_of
from hawk.picture.values import PictureSurvey


def free_range(mapped: PictureSurvey, unseen: float = 0.0) -> tuple[int, int] | None:
    """Return the least and the greatest number of free stalls on the ground that was seen; None where it is not known.

    It is not known of a survey without stalls either: how many were missed is in no stall's probability.

    As after a flight (`hawk.model.lot_map.free_interval`): of stalls that err each for itself. ``unseen``: stalls that
    are expected on ground that was not seen, each of which may be free or not.
    """
    stalls = mapped.survey.stalls
    if not stalls or any(stall.score is None for stall in stalls):
        return None
    variance = sum(
        free_variance(stall.score or 0.0, stall.taken_probability)
        for stall in stalls
        if stall.taken_probability is not None
    )
    least, most = interval_of(mapped.survey.count("free"), variance, unseen)
    return least, min(most, len(stalls) + math.ceil(unseen))


def report(mapped: PictureSurvey, program: str) -> dict[str, Any]:
    """Return the report as values of JSON. ``program``: name of the program with its version."""
    bounds = free_range(mapped)
    return {
        "program": program,
        **about_survey(mapped.survey),
        "free_range": None if bounds is None else list(bounds),
        "free_range_holds_in": None if bounds is None else HELD_SHARE,
        "area_seen_m2": round(mapped.area_m2, 1),
        "crs": mapped.crs or "EPSG:4326",
        "notes": list(mapped.notes),
        **({} if mapped.checked is None else {"checked": mapped.checked}),
        "left_out": [{"name": each.name, "reason": each.reason} for each in mapped.left_out],
    }


def text(mapped: PictureSurvey) -> str:
    """Return the report in lines for a person."""
    survey, bounds = mapped.survey, free_range(mapped)
    within = "" if bounds is None else f" ({bounds[0]} to {bounds[1]} in nine of ten surveys)"
    lines = [
        f"{survey.lot}: {len(survey.stalls)} stalls on {mapped.area_m2 / 1e4:.2f} ha that were seen",
        f"  free {survey.count('free')}{within}, taken {survey.count('taken')}, unclear {survey.count('unknown')}",
    ]
    return "\n".join([*lines, *closing_lines(mapped)])


def closing_lines(mapped: PictureSurvey) -> list[str]:
    """Return the lines behind the counts: what a person must know, and what was left out."""
    lines = [f"  {note}" for note in mapped.notes]
    if not mapped.survey.time_is_sure:
        lines.append(
            "  Its time is not sure, so that no statistics and no feed use it: give it by --taken "
            "2026-05-04T10:30+02:00."
        )
    if mapped.left_out:
        lines.append(f"  left out: {len(mapped.left_out)}")
        lines += [f"    {each.name}: {each.reason}" for each in mapped.left_out]
    return lines
