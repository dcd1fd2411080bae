"""Source of a survey: a flight with hawk, or pictures that others took, with what limits their survey."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Final, Self

if TYPE_CHECKING:
    from sqlalchemy import RowMapping


class SurveyKind(StrEnum):
    """Kind of a survey."""

    FLOWN = "flown"
    """hawk flew it."""
    PICTURE = "picture"
    """It was made of pictures."""


class SourceKind(StrEnum):
    """Kind of the pictures of a survey."""

    PHOTOGRAPHS = "photographs"
    ORTHOPHOTO = "orthophoto"
    FILM = "film"


class Limit(StrEnum):
    """Limit of a survey by pictures, which its reader must know."""

    BY_GPS = "by_gps"
    """Pictures that were not adjusted with their neighbours lie where their files say."""
    STRETCHED = "stretched"
    """The places of its pictures say too little of the turn and the scale of the whole map."""
    COARSE = "coarse"
    """A pixel covers more ground than stalls are found well by."""
    PARTLY = "partly"
    """A part of the lot was not seen."""


LIMIT_WORDS: Final[Mapping[Limit, str]] = {
    Limit.BY_GPS: "Pictures that share too little with the others lie where their files say: stalls may be metres off.",
    Limit.STRETCHED: (
        "The pictures' GPS leaves the whole map turned or stretched: at the ends of a lot of 100 m stalls may be a "
        "stall's width off, or more."
    ),
    Limit.COARSE: "A pixel covers more than 12 cm of the ground: fewer stalls are found.",
    Limit.PARTLY: "A part of the lot was not seen: its stalls are not counted.",
}


@dataclass(frozen=True, slots=True)
class PictureSource:
    """Pictures that a survey was made of. ``name``: that of their folder or file."""

    kind: SourceKind
    name: str
    limits: tuple[Limit, ...] = ()

    @property
    def words(self) -> str:
        """The kind with the name, as ``photographs my-flight``."""
        return f"{self.kind.value} {self.name}".strip()

    @property
    def warning(self) -> str:
        """The limits as sentences, "" without any."""
        return " ".join(LIMIT_WORDS[limit] for limit in self.limits)

    @classmethod
    def read(cls, row: Mapping[str, Any] | RowMapping) -> Self | None:
        """Return that of a row of the table of surveys; None for a flown one."""
        if row["kind"] != SurveyKind.PICTURE:
            return None
        limits = tuple(Limit(each) for each in json.loads(row["limits"]))
        return cls(SourceKind(row["source"]), str(row["source_name"]), limits)


def source_columns(pictures: PictureSource | None) -> dict[str, str]:
    """Return the columns of the table of surveys that say where a survey is from; None: it was flown."""
    if pictures is None:
        return {"kind": SurveyKind.FLOWN.value, "source": "", "source_name": "", "limits": _json(())}
    return {
        "kind": SurveyKind.PICTURE.value,
        "source": pictures.kind.value,
        "source_name": pictures.name,
        "limits": _json(pictures.limits),
    }


def source_json(row: Mapping[str, Any] | RowMapping) -> dict[str, Any]:
    """Return the same columns of a row as JSON values, for programs."""
    limits = row["limits"]
    return {
        "kind": row["kind"], "source": row["source"], "source_name": row["source_name"],
        "limits": json.loads(limits) if limits != _NO_LIMITS else [],
    }  # fmt: skip


_NO_LIMITS: Final = "[]"
"""Text of a survey without limits, as most are: a list of a thousand needs no parser for it."""


def _json(limits: Sequence[Limit]) -> str:
    return json.dumps([limit.value for limit in limits])


SOURCE_COLUMNS: Final = tuple(source_columns(None))
"""Names of those columns."""
