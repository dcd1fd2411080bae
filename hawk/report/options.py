"""Choices about a report, and the kinds of its files. Nothing here loads a library."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, get_args

if TYPE_CHECKING:  # it loads numpy: not for the command line
    from hawk.stats.use_query import Asked

Language = Literal["en", "fr"]
LANGUAGES: Final[tuple[Language, ...]] = get_args(Language)
Paper = Literal["a4", "letter"]
PAPERS: Final[tuple[Paper, ...]] = get_args(Paper)
Kind = Literal["html", "pdf", "xlsx"]
CONTENT_TYPES: Final[Mapping[Kind, str]] = {
    "html": "text/html; charset=utf-8",
    "pdf": "application/pdf",
    "xlsx": "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
}
"""Kinds of files with the type of their content."""
EXTRA: Final = "report"
"""Extra of the package that writes PDF."""
MOST_LOTS: Final = 50
"""Lots of one report."""


@dataclass(frozen=True, slots=True)
class Form:
    """Language and paper of a document."""

    language: Language = "en"
    paper: Paper = "a4"


@dataclass(frozen=True, slots=True)
class Wanted:
    """Content of a report: a lot, a question about it, a period as `hawk.stats.period.period_of_lot` takes it.

    ``has_ground``: the picture shows the ground, too; a link shows no picture that was taken.
    """

    lot: str
    asked: Asked
    begin: str | None = None
    end: str | None = None
    time_zone: str | None = None
    has_ground: bool = True
