"""Vehicles of a survey by the ground that they stand on. No answer shows one of them."""

from __future__ import annotations

from collections import Counter
from typing import Final

from sqlalchemy import Connection

from hawk.lots.answers import VehicleCounts
from hawk.lots.plan.queries import all_stalls, private_zones, sections_of
from hawk.lots.plan.values import shapes_of
from hawk.lots.queries import lot_row, survey_row
from hawk.lots.registration.georeference import ground_about
from hawk.lots.registration.survey_place import datum_of
from hawk.lots.storage.outlines import outline_of
from hawk.lots.storage.tables import unpack_vehicles
from hawk.lots.survey.section_looks import move_of_survey, moved_shapes
from hawk.lots.survey.vehicle_places import Grounds, Place, may_be_seen, places_of

_FIELDS: Final = {
    Place.STALL: "on_stalls",
    Place.SECTION: "in_sections",
    Place.BESIDE: "beside",
    Place.ELSEWHERE: "elsewhere",
}


def vehicle_counts(connection: Connection, survey_id: str) -> VehicleCounts:
    """Return how many vehicles of a survey stand where, by the present plan. Raises NotFoundError, LotStoreError."""
    row = survey_row(connection, survey_id).values
    assert row is not None  # noqa: S101 - it is there
    vehicles = unpack_vehicles(row["vehicles"])
    if vehicles is None:
        return VehicleCounts(survey=survey_id, vehicles=None)
    move = None if row["lot"] is None else move_of_survey(connection, row)
    if move is None:
        return VehicleCounts(survey=survey_id, vehicles=len(vehicles))
    lot = str(row["lot"])
    ground = ground_about(datum_of(connection, lot), outline_of(lot_row(connection, lot)["outline"]))
    sections = {each.id: each.outline for each in sections_of(connection, lot)}
    grounds = Grounds(shapes_of(all_stalls(connection, lot)), sections, ground)
    shapes = moved_shapes(shapes_of(vehicles), move)
    shapes = shapes[may_be_seen(shapes, private_zones(connection, lot))]
    found = Counter(each.place for each in places_of(shapes, grounds))
    return VehicleCounts(
        survey=survey_id, vehicles=len(shapes), **{name: found[place] for place, name in _FIELDS.items()}
    )
