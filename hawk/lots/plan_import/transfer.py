"""Takes a previewed plan: as one operation of the open edit of a lot, or as the first layout of a new lot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
import shapely
from sqlalchemy import Connection, select

from hawk.lots import change_log
from hawk.lots.answers import Begun
from hawk.lots.change_log import Change
from hawk.lots.ingest import lot_places
from hawk.lots.operations import layout_row, stall_row
from hawk.lots.plan import edits, geometry
from hawk.lots.plan.answers import Edited
from hawk.lots.plan.checks import MOST_OVERLAP
from hawk.lots.plan.edits import checked
from hawk.lots.plan.queries import all_stalls, sections_of
from hawk.lots.plan.steps import next_key, section_values
from hawk.lots.plan.values import SHAPE, Draft, LayoutSection, PlanStall, shapes_of
from hawk.lots.plan.versions import revision_of
from hawk.lots.plan_import.previews import Preview
from hawk.lots.registration.georeference import about, on_earth, ring_on_earth
from hawk.lots.registration.lot_match import SAME_SHARE, Candidate, which_lot
from hawk.lots.registration.survey_place import ABOUT_M
from hawk.lots.storage.outlines import outline_json
from hawk.lots.storage.rows import Row
from hawk.lots.storage.schema import LOT, SECTION, STALL
from hawk.lots.values import LotInputError, LotStoreError, check_fields, checked_name, new_id
from hawk.model.plans import Outline

KIND: Final = "import"
"""Name of the operation among the steps of an edit, and kind of the change that makes a lot."""


def take(connection: Connection, preview: Preview, asked: Mapping[str, Any], now: float) -> Edited:
    """Take a plan within the open ``edit``; return the stalls that changed, as `edits.do` does.

    ``uncertain``: true where it is to be taken although its place is not certain. Raises LotInputError, NotFoundError
    and LotStoreError; nothing is written then.
    """
    assert preview.lot is not None  # noqa: S101 - a preview of a new lot is made by `begin`
    edit = edits.held(connection, preview.lot, asked, now, ("edit", "uncertain"))
    _check(preview, asked)
    if revision_of(connection, preview.lot) != preview.revision:
        raise LotStoreError("import: the plan was changed since the preview: send the file again")
    return edits.done(connection, edit, KIND, preview.matched.draft, now)


def _check(preview: Preview, asked: Mapping[str, Any]) -> None:
    is_uncertain = asked.get("uncertain", False)
    if not isinstance(is_uncertain, bool):
        raise LotInputError("uncertain", "must be true or false")
    if preview.placement.doubt and not is_uncertain:
        words = f"must be true: it is not certain where the plan lies ({preview.placement.doubt}); look at the preview"
        raise LotInputError("uncertain", words)
    clashes = preview.matched.clashes
    if clashes:
        more = f", and {len(clashes) - 1} more" if len(clashes) > 1 else ""
        raise LotInputError("rename", f"is needed: {clashes[0].name}: {clashes[0].reason}{more}")


def new_ground(connection: Connection, preview: Preview) -> Outline:
    """Return the ground of a new lot. Raises LotInputError for that of another lot, which is named.

    Lots may adjoin, and one may lie within the arms of another: no part of the plan of one lies on a part of the other
    one's. A lot without any part is judged by its outline.
    """
    draft, datum = preview.matched.draft, preview.placement.datum
    outline = _outline(draft, datum)
    beside = [each for each in which_lot(outline, lot_places(connection)).candidates if each.overlap > 0]
    parts = _parts(draft.added, draft.begun_sections)
    there = next((each.lot for each in beside if _is_on(connection, each, parts, datum)), None)
    if there is not None:
        name = connection.execute(select(LOT.c.name).where(LOT.c.id == there)).scalar_one()
        raise LotInputError("lot", f"{name} is there already on the ground of this plan: import it into that lot")
    return outline


def _parts(stalls: Sequence[PlanStall], sections: Sequence[LayoutSection]) -> list[shapely.Polygon]:
    return [*geometry.polygons(shapes_of(stalls)), *(shapely.Polygon(each.outline) for each in sections)]


def _is_on(
    connection: Connection, beside: Candidate, parts: Sequence[shapely.Polygon], datum: tuple[float, float]
) -> bool:  # fmt: skip
    """Return whether a part of a plan about a datum lies on one of a lot's by more than two stalls may overlap."""
    others = np.array(_parts(all_stalls(connection, beside.lot), sections_of(connection, beside.lot)))
    if not len(others):
        return beside.overlap >= SAME_SHARE
    row = connection.execute(select(LOT.c.latitude, LOT.c.longitude).where(LOT.c.id == beside.lot)).one()
    mine = shapely.transform(parts, lambda places: about((row[0], row[1]), on_earth(datum, places))[:, :2])
    one, other = shapely.STRtree(others).query(mine, predicate="intersects")
    shared = shapely.area(shapely.intersection(mine[one], others[other]))
    return bool((shared > MOST_OVERLAP * np.minimum(shapely.area(mine[one]), shapely.area(others[other]))).any())


def begin(connection: Connection, preview: Preview, asked: Mapping[str, Any], who: str, now: float) -> Begun:
    """Make a lot called ``name`` of a plan, its first layout; return the change, which is undone once.

    Raises LotInputError for a plan on the ground of another lot.
    """
    check_fields(asked, ("name",))
    name = checked_name(asked.get("name"))
    _check(preview, asked)
    draft = preview.matched.draft
    outline = new_ground(connection, preview)
    lot = new_id()
    stalls = checked(connection, lot, draft, ()).added
    latitude, longitude = preview.placement.datum
    place = {"latitude": latitude, "longitude": longitude, "datum_is_pinned": True, "outline": outline_json(outline)}
    rows = [
        Row(LOT.name, (lot,), {"id": lot, "name": name, **place, "merged_into": None, "made": now}),
        layout_row(lot, 1, f"imported from {preview.file}", who, now),
    ]
    rows += [
        stall_row(
            key, lot, stall.label, {name: getattr(stall, name) for name in SHAPE}, stall=stall.id, kind=stall.kind,
            is_confirmed=stall.is_confirmed, is_named=stall.is_named,
        )
        for key, stall in enumerate(stalls, next_key(connection, STALL))
    ]  # fmt: skip
    rows += [
        Row(SECTION.name, (key,), section_values(key, lot, section, 1, None))
        for key, section in enumerate(draft.begun_sections, next_key(connection, SECTION))
    ]
    done = change_log.write(connection, Change(KIND, lot, tuple(rows)), who, now)
    return Begun(**dict(done), stalls=len(stalls), sections=len(draft.begun_sections))


def _outline(draft: Draft, datum: tuple[float, float]) -> Outline:
    """Return the ground about the stalls and sections of a plan, WGS-84."""
    corners = [corner for section in draft.begun_sections for corner in section.outline]
    places = [*shapes_of(draft.added)[:, :2].tolist(), *corners]
    ring = np.array(shapely.MultiPoint(places).convex_hull.buffer(ABOUT_M, quad_segs=4).exterior.coords[:-1])
    return Outline((ring_on_earth(datum, ring),))
