"""Import of an owner's plan by the API: the file is the body, the choices are parameters."""

from __future__ import annotations

from typing import Annotated, Literal

from aiohttp import web
from pydantic import Field

from hawk.web import plan_files
from hawk.web.lot_answers import FOR_OPERATORS, as_text, opened
from hawk.web.refusals import check_operator
from hawk.web.v1.answering import answered
from hawk.web.v1.asked import Query
from hawk.web.v1.changing import changed

_LONGEST = 200
_Text = Annotated[str, Field(max_length=_LONGEST)]
Switch = Literal["0", "1"]


class ImportChoices(Query):
    """Choices about a file with a plan, for the definition: `hawk.lots.plan_import.choices` reads and checks them."""

    name: Annotated[_Text | None, Field(description="name of the file, as it is shown")] = None
    layer: Annotated[_Text | None, Field(description="layer of the drawing that has the stalls")] = None
    units: Annotated[_Text | None, Field(description="unit of the drawing's lengths")] = None
    label: Annotated[_Text | None, Field(description="property with the labels")] = None
    crs: Annotated[_Text | None, Field(description="system of coordinates, as EPSG:25832")] = None
    pin: Annotated[
        list[str] | None,
        Field(
            description="point of the drawing and its place on Earth: x,y,latitude,longitude; again for a second one",
            json_schema_extra={"x-again": True},
        ),
    ] = None
    replace: Annotated[Switch | None, Field(description="1: stalls that the file has not end")] = None
    rename: Annotated[Switch | None, Field(description="1: labels that other stalls had get another number")] = None


@answered
async def preview(request: web.Request) -> web.StreamResponse:
    """The preview of an import; nothing is written."""
    check_operator(request, FOR_OPERATORS)
    return changed(as_text(await plan_files.previewed(await opened(request), request)))
