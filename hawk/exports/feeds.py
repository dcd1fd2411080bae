"""A survey in the words of receivers: NGSI-LD (FIWARE smart data models), CDS 1.0 curb spaces, and ParkAPI.

A state is that of a look at a moment. Where the look is older than the receiver lets it be valid, it is unknown.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime
from itertools import groupby
from typing import Any, Final
from urllib.parse import quote

import shapely
from pydantic_core import to_json
from sqlalchemy import Connection

from hawk.exports.formats import FEEDS, VALID_S, Span, Wanted
from hawk.exports.records import NEWEST, read_survey, survey_of
from hawk.exports.section_files import geometry_of
from hawk.exports.shapes import lot_shape, stall_shape
from hawk.exports.values import UNSEEN, ExportRecord, Observation, SeenSection
from hawk.lots.labels import parts_of
from hawk.lots.plan.sections import PLACES_M
from hawk.lots.survey.moments import has_been
from hawk.lots.values import LotInputError, utc
from hawk.stats.panel import read_panel
from hawk.stats.period import period_of_lot
from hawk.stats.section_use import read_sections

_NGSI_STATES: Final = {"free": "free", "taken": "occupied"}
_NGSI_CONTEXT: Final = (
    "https://raw.githubusercontent.com/smart-data-models/dataModel.Parking/master/context.jsonld",
    "https://uri.etsi.org/ngsi-ld/v1/ngsi-ld-core-context.jsonld",
)
_PARKAPI_STATES: Final = {"free": "AVAILABLE", "taken": "TAKEN"}
_PARKAPI_AUDIENCE: Final = {
    "disabled": "DISABLED", "charging": "CHARGING", "parent": "FAMILY", "delivery": "DELIVERY", "private": "PRIVATE",
    "staff": "PRIVATE", "bus": "BUS", "hgv": "TRUCK", "taxi": "TAXI",
}  # fmt: skip
"""OSM's value of a stall's kind -> ParkAPI's ParkingAudience; its motorcycles are a purpose of their own."""
_PARKAPI_CAPACITY: Final = {
    "disabled": "disabled", "charging": "charging", "parent": "family", "hgv": "truck", "bus": "bus",
}  # fmt: skip
CDS_VERSION: Final = "1.0.0"
_CDS_ANGLES: Final = {"parallel": "parallel", "across": "perpendicular"}


def feed_text(connection: Connection, name: str, wanted: Wanted, now: float) -> str:
    """Return a feed as text; ``now``: Unix seconds. Raises NotFoundError, LotInputError."""
    feed = FEEDS[name]
    _check(name, wanted)
    if feed.span is Span.PERIOD:
        period = period_of_lot(connection, wanted.lot, wanted.begin, wanted.end, wanted.time_zone)
        return str(feed.make(read_panel(connection, wanted.lot, period), read_sections(connection, wanted.lot, period)))
    survey = read_survey(connection, survey_of(connection, wanted.lot, wanted.survey or NEWEST))
    return to_json(feed.make(valid_at(survey, now, VALID_S if wanted.valid_s is None else wanted.valid_s))).decode()


def _check(name: str, wanted: Wanted) -> None:
    """Refuse what the feed does not use."""
    of_span: Mapping[Span, Mapping[str, object]] = {
        Span.SURVEY: {"survey": wanted.survey, "valid_s": wanted.valid_s},
        Span.PERIOD: {"from": wanted.begin, "to": wanted.end, "time_zone": wanted.time_zone},
    }
    (other,) = set(Span) - {FEEDS[name].span}
    for field, value in of_span[other].items():
        if value is not None:
            raise LotInputError(field, f"is not used by {name}, a feed over a {FEEDS[name].span}: leave it out")


def valid_at(survey: ExportRecord, now: float, valid_s: float) -> ExportRecord:
    """Return the survey without the states whose looks are older than ``valid_s`` at ``now``, or later (Unix seconds).

    A survey whose time is not sure has no state, and no look: it may be of any day.
    """
    if not survey.time_is_sure:
        stalls = tuple(replace(stall, state=UNSEEN, taken_probability=None, looked_at=None) for stall in survey.stalls)
        sections = tuple(_valid_room(each, math.inf, valid_s) for each in survey.sections)
        return replace(survey, ended=min(survey.ended, now), stalls=stalls, sections=sections)
    stalls = tuple(_valid(stall, now, valid_s) for stall in survey.stalls)
    return replace(survey, stalls=stalls, sections=tuple(_valid_room(each, now, valid_s) for each in survey.sections))


def _valid_room(seen: SeenSection, now: float, valid_s: float) -> SeenSection:
    """Return a section without the room in it where its look is too old."""
    at = seen.look.observed.timestamp()
    if now - at <= valid_s and has_been(at, now):
        return seen
    return replace(seen, look=seen.look.model_copy(update={"room": None}))


def _valid(stall: Observation, now: float, valid_s: float) -> Observation:
    is_valid = stall.looked_at is not None and now - stall.looked_at <= valid_s and has_been(stall.looked_at, now)
    return stall if is_valid else replace(stall, state=UNSEEN, taken_probability=None)


def ngsi_entities(survey: ExportRecord) -> list[dict[str, Any]]:
    """Return OffStreetParking, a ParkingGroup a row, and a ParkingSpot a stall, as key-values (NGSI-LD 1.6).

    Spots refer to their group and site, groups to their site; in the other direction the models allow one value only.
    """
    site = f"urn:ngsi-ld:OffStreetParking:{survey.lot_id}"
    rows = _rows(survey)
    groups = {name: f"urn:ngsi-ld:ParkingGroup:{survey.lot_id}:{quote(name, safe='')}" for name in rows}
    row_of = {stall.id: name for name, stalls in rows.items() for stall in stalls}
    spots = [_ngsi_spot(stall, site, groups.get(row_of.get(stall.id, ""))) for stall in survey.stalls]
    return [
        _ngsi_site(survey, site),
        *(_ngsi_group(groups[name], name, stalls, site) for name, stalls in rows.items()),
        *spots,
    ]


def _rows(survey: ExportRecord) -> dict[str, list[Observation]]:
    """Return the stalls by the names of their rows; those whose label has no row are in none."""
    lettered = [(parts[0], stall) for stall in survey.stalls if (parts := parts_of(stall.label)) is not None]
    ordered = sorted(lettered, key=lambda each: (len(each[0]), each[0]))
    return {name: [stall for _, stall in each] for name, each in groupby(ordered, key=lambda each: each[0])}


def _ngsi_site(survey: ExportRecord, site: str) -> dict[str, Any]:
    shape = lot_shape(survey.outline)
    if shape.is_empty:
        shape = shapely.MultiPoint([stall.place[::-1] for stall in survey.stalls])
    return {
        "@context": list(_NGSI_CONTEXT),
        "id": site,
        "type": "OffStreetParking",
        "name": survey.lot,
        "location": shapely.geometry.mapping(shape),
        "category": ["parkingLot", "ground"],
        "layout": ["openSpace"],
        "occupancyDetectionType": ["singleSpaceDetection"],
        "totalSpotNumber": len(survey.stalls),
        **_ngsi_counts(survey.stalls),
        **({"occupancyModified": utc(survey.ended)} if survey.time_is_sure else {}),
        **({"observationDateTime": utc(survey.ended)} if survey.time_is_sure else {}),
        "source": survey.software,
    }


def _ngsi_counts(stalls: tuple[Observation, ...] | list[Observation]) -> dict[str, int]:
    """Return the counts where every state is known: a part of a lot is not its free spots."""
    states = [stall.state for stall in stalls]
    if UNSEEN in states or not states:
        return {}
    return {"availableSpotNumber": states.count("free"), "occupiedSpotNumber": states.count("taken")}


def _ngsi_group(group: str, name: str, stalls: list[Observation], site: str) -> dict[str, Any]:
    shape = shapely.MultiPoint([stall.place[::-1] for stall in stalls]).convex_hull
    known = _ngsi_counts(stalls)
    known.pop("occupiedSpotNumber", None)  # the model of a group has none
    return {
        "@context": list(_NGSI_CONTEXT),
        "id": group,
        "type": "ParkingGroup",
        "name": name,
        "location": shapely.geometry.mapping(shape),
        "refParkingSite": site,
        "category": ["adjacentSpaces", "offStreet"],
        "totalSpotNumber": len(stalls),
        **known,
        "occupancyDetectionType": ["singleSpaceDetection"],
    }


def _ngsi_spot(stall: Observation, site: str, group: str | None) -> dict[str, Any]:
    return {
        "@context": list(_NGSI_CONTEXT),
        "id": f"urn:ngsi-ld:ParkingSpot:{stall.id}",
        "type": "ParkingSpot",
        "name": stall.label,
        "location": shapely.geometry.mapping(stall_shape(stall)),
        "status": _NGSI_STATES.get(stall.state, "unknown"),
        "category": ["offStreet"],
        "width": round(stall.width, 2),
        "length": round(stall.length, 2),
        "refParkingSite": site,
        **({} if group is None else {"refParkingGroup": group}),
        **({} if stall.looked_at is None else {"timeInstant": utc(stall.looked_at)}),
    }


def cds_spaces(survey: ExportRecord) -> dict[str, Any]:
    """Return the stalls as CDS curb spaces of one curb zone, the lot; times are milliseconds of Unix."""
    ended = round(survey.ended * 1000)
    spaces = [_cds_space(number, stall, survey.lot_id, ended) for number, stall in enumerate(survey.stalls, 1)]
    return _cds(survey, {"spaces": spaces})


def _cds_space(number: int, stall: Observation, zone: str, ended: int) -> dict[str, Any]:
    looked = {} if stall.looked_at is None else {"availability_time": round(stall.looked_at * 1000)}
    known = {"available": stall.state == "free", **looked} if stall.state != UNSEEN else {}
    return {
        "curb_space_id": stall.id,
        "geometry": shapely.geometry.mapping(stall_shape(stall)),
        "name": stall.label,
        "published_date": ended,
        "last_updated_date": ended,
        "curb_zone_id": zone,
        "space_number": number,
        "length": round(stall.length * 100),
        "width": round(stall.width * 100),
        **known,
    }


def cds_zones(survey: ExportRecord) -> dict[str, Any]:
    """Return the sections that a survey looked at as CDS curb zones; times are milliseconds of Unix, lengths cm.

    A zone has no policy: hawk knows none. Its available spaces are those that the gaps have room for.
    """
    ended = round(survey.ended * 1000)
    return _cds(survey, {"zones": [_cds_zone(each, ended) for each in survey.sections]})


def _cds(survey: ExportRecord, data: Mapping[str, Any]) -> dict[str, Any]:
    """Return an answer of CDS about a survey."""
    return {
        "version": CDS_VERSION,
        "time_zone": survey.time_zone,
        "last_updated": round(survey.ended * 1000),
        "currency": "USD",
        "author": survey.software,
        "data": data,
    }


def _cds_zone(seen: SeenSection, ended: int) -> dict[str, Any]:
    section, look = seen.section, seen.look
    place, at = PLACES_M.get(section.kind), round(look.observed.timestamp() * 1000)
    is_known = place is not None and look.room is not None
    available = {"available_space_lengths": [round((place or 0) * 100)] * (look.room or 0), "availability_time": at}
    return {
        "curb_zone_id": section.id,
        "geometry": geometry_of(seen),
        "curb_policy_ids": [],
        "published_date": ended,
        "last_updated_date": ended,
        "start_date": at,
        "name": section.name,
        "length": round(section.length_m * 100),
        **({} if section.capacity is None else {"num_spaces": section.capacity}),
        **({} if section.kind == "" else {"parking_angle": _CDS_ANGLES[section.kind]}),
        **(available if is_known else {}),
    }


def parkapi(survey: ExportRecord) -> dict[str, Any]:
    """Return the lot as a parking site and the stalls as parking spots of ParkAPI (its model is DATEX II Parking's)."""
    spots = [_parkapi_spot(stall, survey) for stall in survey.stalls]
    return {"parking_sites": [_parkapi_site(survey)], "parking_spots": spots}


def _parkapi_site(survey: ExportRecord) -> dict[str, Any]:
    places = shapely.MultiPoint([stall.place[::-1] for stall in survey.stalls]) if survey.stalls else None
    middle = shapely.Point(survey.origin[::-1]) if places is None else places.centroid
    kinds = {name: [s for s in survey.stalls if s.kind == kind] for kind, name in _PARKAPI_CAPACITY.items()}
    shape = lot_shape(survey.outline)
    free = _ngsi_counts(survey.stalls).get("availableSpotNumber")
    return {
        "uid": survey.lot_id,
        "name": survey.lot,
        "type": "OFF_STREET_PARKING_GROUND",
        "purpose": "CAR",
        "lat": round(middle.y, 8),
        "lon": round(middle.x, 8),
        "geojson": None if shape.is_empty else shapely.geometry.mapping(shape),
        "capacity": len(survey.stalls),
        **{f"capacity_{name}": len(stalls) for name, stalls in kinds.items() if stalls},
        "static_data_updated_at": _offset(survey.ended),
        **(_realtime(survey, free) if survey.time_is_sure else {"has_realtime_data": False}),
    }


def _realtime(survey: ExportRecord, free: int | None) -> dict[str, Any]:
    return {
        "has_realtime_data": True,
        "realtime_data_updated_at": _offset(survey.ended),
        "realtime_opening_status": "UNKNOWN",
        "realtime_capacity": len(survey.stalls),
        **({} if free is None else {"realtime_free_capacity": free}),
    }


def _parkapi_spot(stall: Observation, survey: ExportRecord) -> dict[str, Any]:
    audience = _PARKAPI_AUDIENCE.get(stall.kind)
    return {
        "uid": stall.id,
        "name": stall.label or None,
        "type": "OFF_STREET_PARKING_GROUND",
        "purpose": "MOTORCYCLE" if stall.kind == "motorcycle" else "CAR",
        "lat": round(stall.place[0], 8),
        "lon": round(stall.place[1], 8),
        "geojson": shapely.geometry.mapping(stall_shape(stall)),
        "restricted_to": [] if audience is None else [{"type": audience}],
        "static_data_updated_at": _offset(survey.ended),
        **(_realtime_spot(stall, survey) if survey.time_is_sure else {"has_realtime_data": False}),
    }


def _realtime_spot(stall: Observation, survey: ExportRecord) -> dict[str, Any]:
    return {
        "has_realtime_data": True,
        "realtime_data_updated_at": _offset(survey.ended if stall.looked_at is None else stall.looked_at),
        "realtime_status": _PARKAPI_STATES.get(stall.state, "UNKNOWN"),
    }


def _offset(seconds: float) -> str:
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="seconds")
