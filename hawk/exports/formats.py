"""Formats of an export: kinds of the files of a survey, by the ends of their names, and feeds, by name.

A feed is a lot in the words of a receiver: one row, over a survey or over a period. Makers are loaded when a feed is
made: the command line and the server know the names without them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pkgutil import resolve_name
from typing import Any, Final

PICTURE: Final = ".png"
RASTER: Final = ".tif"
"""Mosaic and occupancy as Cloud Optimised GeoTIFF, with a STAC item: several files."""
ARCHIVE: Final = ".zip"
"""The files of `RASTER` in one."""
DATABASE: Final = ".gpkg"
"""It may hold many surveys."""
SECTIONS_TABLE: Final = ".sections.csv"
SECTIONS_MAP: Final = ".sections.geojson"
CONTENT_TYPES: Final[Mapping[str, str]] = {
    ".csv": "text/csv; charset=utf-8",
    ".geojson": "application/geo+json",
    DATABASE: "application/geopackage+sqlite3",
    ".kmz": "application/vnd.google-earth.kmz",
    PICTURE: "image/png",
    SECTIONS_TABLE: "text/csv; charset=utf-8",
    SECTIONS_MAP: "application/geo+json",
    ARCHIVE: "application/zip",
}
"""Kinds that are one file each, with the type of their content."""
WRITTEN: Final = (*(each for each in CONTENT_TYPES if each != ARCHIVE), RASTER)
"""Kinds that the command writes."""


def kind_of(name: str) -> str:
    """Return the kind of a file by its name; "sections.csv" is a table of sections as "NAME.sections.csv" is."""
    kinds = [each for each in (*CONTENT_TYPES, RASTER) if f".{name.lower()}".endswith(each)]
    return max(kinds, key=len, default="")


VALID_S: Final = 3600.0
"""Age of a look up to which its state is given, seconds, where a receiver names no other."""


class Span(StrEnum):
    """Ground of a feed in time."""

    SURVEY = "survey"
    """A survey: the maker takes an `ExportRecord`, whose old states are unknown, and returns JSON values."""
    PERIOD = "period"
    """A period: the maker takes a `Panel` and a `SectionPanel` of the period's surveys, and returns text."""


@dataclass(frozen=True, slots=True)
class Feed:
    """A receiver's format. ``maker``: module and function that make it."""

    title: str
    content_type: str
    span: Span
    maker: str

    def make(self, *given: Any) -> Any:
        """Return the feed of what its span says."""
        return resolve_name(self.maker)(*given)


FEEDS: Final[Mapping[str, Feed]] = {
    "ngsi-ld": Feed(
        "NGSI-LD, the smart data models of parking", "application/ld+json", Span.SURVEY,
        "hawk.exports.feeds:ngsi_entities",
    ),
    "cds": Feed(
        "CDS 1.0 curb spaces", "application/vnd.cds+json;version=1.0", Span.SURVEY, "hawk.exports.feeds:cds_spaces"
    ),
    "cds-zones": Feed(
        "CDS 1.0 curb zones: the sections of a lot", "application/vnd.cds+json;version=1.0", Span.SURVEY,
        "hawk.exports.feeds:cds_zones",
    ),
    "parkapi": Feed("ParkAPI", "application/json", Span.SURVEY, "hawk.exports.feeds:parkapi"),
    "cds-aggregates": Feed(
        "CDS 1.0 aggregates: occupancy hour by hour, -1 where nobody flew", "application/vnd.cds+csv;version=1.0",
        Span.PERIOD, "hawk.stats.aggregates:cds_aggregates",
    ),
}  # fmt: skip
"""Feeds by name."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """Ground and time of a feed.

    ``survey``: id of the survey, or its beginning; None: the last one that is registered. ``valid_s``: seconds up to
    which a state is given, None for `VALID_S`. ``begin``, ``end``, ``time_zone``: a period as
    `hawk.stats.period.period_of_lot` takes it.
    """

    lot: str
    survey: str | None = None
    valid_s: float | None = None
    begin: str | None = None
    end: str | None = None
    time_zone: str | None = None
