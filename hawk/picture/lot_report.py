"""Report of a survey of several lots: a count with its interval and its doubts for each, and the sum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from hawk.model.lot_map import HELD_SHARE
from hawk.picture.report import closing_lines, free_range, report
from hawk.picture.values import LotFacts, LotSurvey, PictureSurvey, list_names

Range = tuple[int, int]
_ALONE: Final = "as if every stall erred for itself"
_TOGETHER: Final = "as if all lots erred alike"
_LISTED: Final = 40
"""Lots that a person reads on a terminal; the table has all."""
_LEAST_SURE: Final = 20


@dataclass(frozen=True, slots=True)
class LotCount:
    """A row of the table of lots, without the pictures.

    ``bounds``: least and most free stalls, those among them that are expected on ground that was not seen; None where
    they are not known. ``picture``: name of its file, "" without one. ``stored``: how the store has it.
    """

    survey: LotSurvey
    bounds: Range | None
    picture: str = ""
    stored: str = ""

    @classmethod
    def of(cls, survey: LotSurvey, picture: str = "", stored: str = "") -> LotCount:
        """Count a lot."""
        return cls(survey, free_range(survey.mapped, unseen_stalls(survey)), picture, stored)

    @property
    def facts(self) -> LotFacts:
        """Facts of the lot."""
        return self.survey.facts

    def values(self) -> dict[str, Any]:
        """Return the count by the columns of the table of lots; None: not known."""
        record, mapped = self.survey.mapped.survey, self.survey.mapped
        least, most = self.bounds or (None, None)
        return {
            "lot_id": self.facts.id,
            "lot_name": self.facts.name,
            "stalls": len(record.stalls),
            "free": record.count("free"),
            "taken": record.count("taken"),
            "unknown": record.count("unknown"),
            "free_least": least,
            "free_most": most,
            **self._vehicles(),
            "area_seen_m2": round(mapped.area_m2, 1),
            "unseen_share": round(self.survey.unseen_share, 3),
            "unsure": None if self.survey.unsure is None else round(self.survey.unsure, 3),
            "doubts": list(self.survey.doubts),
            "tags": dict(self.facts.tags),
            "latitude": record.origin[0],
            "longitude": record.origin[1],
            "survey_id": record.survey,
            "picture": self.picture,
            "stored": self.stored,
        }

    def _vehicles(self) -> dict[str, float | int | None]:
        """Return the vehicles in the outline, and their share of the places that its file says."""
        parked, least, most = self.survey.vehicles or (None, None, None)
        places = self.facts.capacity
        return {
            "vehicles": parked,
            "vehicles_least": least,
            "vehicles_most": most,
            "capacity": places,
            "occupancy": None if parked is None or places is None else round(parked / places, 4),
        }


def unseen_stalls(survey: LotSurvey) -> float:
    """Return how many stalls are expected on the ground of a lot that was not seen: as many by area as where it was."""
    seen = 1 - survey.unseen_share
    return len(survey.mapped.survey.stalls) * (1 / seen - 1) if seen > 0 else 0.0


def sum_ranges(whole: PictureSurvey, counts: Sequence[LotCount]) -> tuple[Range | None, Range | None]:
    """Return least and most free stalls of all lots: by stalls that err each for itself, and by lots that err together.

    How the errs of lots go together is not measured: the truth lies between the two. The second one adds the least of
    all lots, and the most of all.
    """
    known = [each.bounds for each in counts if each.bounds is not None]
    if not known:
        return None, None
    together = sum(least for least, _ in known), sum(most for _, most in known)
    return free_range(whole, sum(unseen_stalls(each.survey) for each in counts)), together


def least_sure(counts: Sequence[LotCount]) -> list[LotCount]:
    """Return the lots with stalls of which the network is least sure, the least one first."""
    unsure = [each for each in counts if each.survey.unsure is not None]
    return sorted(unsure, key=lambda each: (-(each.survey.unsure or 0.0), each.facts.id))


def lots_report(whole: PictureSurvey, counts: Sequence[LotCount], program: str) -> dict[str, Any]:
    """Return the report as values of JSON. ``program``: name of the program with its version."""
    alone, together = sum_ranges(whole, counts)
    return {
        **report(whole, program),
        "free_range": None if alone is None else list(alone),
        "free_range_holds_in": None if alone is None else HELD_SHARE,
        "free_range_is": _ALONE,
        "free_range_together": None if together is None else list(together),
        "free_range_together_is": _TOGETHER,
        "lots_without_free_range": sum(each.bounds is None for each in counts),
        "lots": [each.values() for each in counts],
        "least_sure": [each.facts.id for each in least_sure(counts)[:_LEAST_SURE]],
    }


def lots_text(whole: PictureSurvey, counts: Sequence[LotCount]) -> str:
    """Return the report in lines for a person."""
    survey = whole.survey
    alone, together = sum_ranges(whole, counts)
    within = ""
    if alone is not None and together is not None:
        within = f" ({alone[0]} to {alone[1]} {_ALONE}, {together[0]} to {together[1]} {_TOGETHER})"
    lines = [
        f"{survey.lot}: {len(counts)} lots, {len(survey.stalls)} stalls on {whole.area_m2 / 1e4:.2f} ha that were seen",
        f"  free {survey.count('free')}{within}, taken {survey.count('taken')}, unclear {survey.count('unknown')}",
    ]
    lines += [f"  {_line(each)}" for each in counts[:_LISTED]]
    if len(counts) > _LISTED:
        lines.append(f"  and {len(counts) - _LISTED} more: see lots.csv")
    if unsure := least_sure(counts):
        lines.append(f"  least sure: {list_names([each.facts.name for each in unsure])}")
    return "\n".join([*lines, *closing_lines(whole)])


def _line(count: LotCount) -> str:
    record = count.survey.mapped.survey
    within = "" if count.bounds is None else f" ({count.bounds[0]} to {count.bounds[1]})"
    doubts = "".join(f" {doubt}" for doubt in count.survey.doubts)
    said = f"{count.facts.name}: {len(record.stalls)} stalls, free {record.count('free')}{within}"
    return f"{said}, taken {record.count('taken')}, unclear {record.count('unknown')}{_parked(count)}.{doubts}"


def _parked(count: LotCount) -> str:
    """Return the vehicles of a lot whose places are given, or that has no stalls."""
    places = count.facts.capacity
    if count.survey.vehicles is None or (places is None and count.survey.mapped.survey.stalls):
        return ""
    parked, least, most = count.survey.vehicles
    return f", {parked} vehicles ({least} to {most}){'' if places is None else f' for {places} places'}"
