"""Plans as DXF: closed polylines of the model space, with the text that stands in each as its label.

Blocks are taken apart. Lines and hatches are no stalls: who drew them joins them to closed polylines.
"""

from __future__ import annotations

import math
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np
import shapely

from hawk.lots.plan_files.facts import tidy_label
from hawk.lots.plan_files.values import Asked, Drawing, Drawn, Floats, Notes
from hawk.lots.values import LotInputError
from hawk.runtime.late import load

if TYPE_CHECKING:
    from ezdxf.document import Drawing as Document

FORMAT: Final = "DXF"
_BROKEN: Final = (
    OSError,
    ArithmeticError,
    AttributeError,
    LookupError,
    TypeError,
    ValueError,
    AssertionError,
    StopIteration,
)
"""Errors by which ezdxf ends at a file that is damaged, beside its own."""
BINARY: Final = b"AutoCAD Binary DXF\r\n\x1a\x00"
UNITS: Final = {"m": 1.0, "cm": 0.01, "mm": 0.001, "dm": 0.1, "ft": 0.3048, "in": 0.0254}
"""Units of a drawing -> metres."""
_INSUNITS: Final = {1: "in", 2: "ft", 4: "mm", 5: "cm", 6: "m", 14: "dm"}
"""Values of the header's $INSUNITS that plans have (AutoCAD's DXF reference) -> units."""
_MISSING: Final = (
    'DXF is read with ezdxf, which is not installed here: pip install "hawk-drone[plans]", or save it as GeoJSON'
)
_MOST_ENTITIES: Final = 500_000
"""Entities with those of blocks: one block that holds others, in rows and columns, makes any number of a small file."""
_DEEPEST: Final = 8
"""Blocks within blocks."""
_CLOSED: Final = 1e-6
"""Share of a polyline's size by which its ends may differ where it is closed without saying so."""
_TEXTS: Final = ("TEXT", "MTEXT", "ATTRIB")
_SAGITTA: Final = 0.05
"""Units by which the corners of an arc may lie beside it."""


def read(data: bytes, asked: Asked, notes: Notes) -> Drawing:
    """Return the outlines of a file. Raises LotInputError for one that is none, is cut, or says no units."""
    document = _document(data, notes)
    metres = _metres(document, asked.units)
    outlines: list[tuple[str, str, Floats]] = []
    texts: list[tuple[str, tuple[float, float]]] = []
    hidden = _hidden(document)
    gone: Counter[str] = Counter()
    for number, entity in enumerate(_entities(document.modelspace(), 0)):
        if number >= _MOST_ENTITIES:
            words = f"has more than {_MOST_ENTITIES} entities, with those of its blocks: delete other layers"
            raise LotInputError("file", words)
        kind = entity.dxftype()
        if entity.dxf.get("layer", "0").lower() in hidden or entity.dxf.get("invisible", 0):
            gone[str(entity.dxf.get("layer", "0"))] += kind in ("LWPOLYLINE", "POLYLINE")
        elif kind in ("LWPOLYLINE", "POLYLINE"):
            _add_outline(entity, outlines, notes)
        elif kind in _TEXTS:
            texts.append(_text(entity))
    for layer, count in sorted(gone.items()):
        if count:
            notes.add(f"layer {layer}", f"{count} polylines on it are frozen or off: thaw it, if they are stalls")
    counts = Counter(layer for layer, _, _ in outlines)
    if asked.layer:
        if asked.layer not in counts:
            words = f"has no closed polyline; those with some: {', '.join(sorted(counts)[:20]) or 'none'}"
            raise LotInputError("layer", words)
        outlines = [each for each in outlines if each[0] == asked.layer]
    labels = _labels([ring for _, _, ring in outlines], texts)
    drawn = [
        Drawn(name, ring, tidy_label(labels.get(k, ""), name, notes)) for k, (_, name, ring) in enumerate(outlines)
    ]
    return Drawing(FORMAT, tuple(drawn), metres=metres, layers=tuple(sorted(counts.items())))


def _document(data: bytes, notes: Notes) -> Document:
    try:
        ezdxf = load("ezdxf", "recover", "filemanagement", "lldxf.const")
    except ImportError:
        raise LotInputError("file", _MISSING) from None
    if not data.startswith(BINARY) and b"EOF" not in data[-200:]:
        raise LotInputError("file", "is cut: a DXF ends with EOF. Save it again, and copy all of it")
    with tempfile.TemporaryDirectory(prefix="hawk-plan-") as folder:
        path = Path(folder) / "plan.dxf"
        path.write_bytes(data)
        try:
            return cast("Document", ezdxf.filemanagement.readfile(path))
        except (ezdxf.lldxf.const.DXFError, *_BROKEN):
            pass  # many programs write what is no strict DXF; the reader that repairs takes twice the time
        try:
            document, auditor = ezdxf.recover.readfile(path)
            notes.add("file", "was repaired while it was read: compare the preview with the drawing")
        except (ezdxf.lldxf.const.DXFError, *_BROKEN) as error:
            words = f"cannot be read as DXF ({error}): save it again as DXF 2000 or later"
            raise LotInputError("file", words) from None
    if auditor.has_errors and len(document.modelspace()) == 0:
        raise LotInputError("file", "is damaged, and its model space is empty: save it again as DXF 2000 or later")
    return cast("Document", document)


def _hidden(document: Document) -> frozenset[str]:
    """Return the layers, in small letters, that a drawing freezes or switches off: nobody sees what is on them."""
    return frozenset(layer.dxf.name.lower() for layer in document.layers if layer.is_frozen() or layer.is_off())


def _metres(document: Document, units: str) -> float:
    """Return the metres of a unit: that which is asked for, else the header's. Raises LotInputError."""
    if units:
        if units not in UNITS:
            raise LotInputError("units", f"must be one of {', '.join(UNITS)}")
        return UNITS[units]
    number = int(document.header.get("$INSUNITS", 0))
    named = _INSUNITS.get(number)
    if named is None:
        said = "says none" if number == 0 else f"says {number}"
        raise LotInputError("units", f"of the drawing are not known ($INSUNITS {said}): write {', '.join(UNITS)}")
    return UNITS[named]


def _entities(holder: Any, depth: int) -> Iterator[Any]:
    """Yield the entities of a space or block; those of blocks that it inserts in their place, and their attributes."""
    for entity in holder:
        if entity.dxftype() != "INSERT":
            yield entity
            continue
        yield from entity.attribs
        if depth >= _DEEPEST:
            raise LotInputError(
                "file", f"has blocks within blocks, more than {_DEEPEST} deep: explode them, save it again"
            )
        parts = entity.multi_insert() if entity.mcount > 1 else (entity,)
        for part in parts:
            yield from _entities(part.virtual_entities(), depth + 1)


def _add_outline(entity: Any, outlines: list[tuple[str, str, Floats]], notes: Notes) -> None:
    """Add the outline of a closed polyline. Open ones are lines, and no matter of this."""
    name = f"{entity.dxftype()} {entity.dxf.handle or 'of a block'} on {entity.dxf.layer}"
    if entity.dxftype() == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline):
        return
    try:
        ring = _corners(entity)
    except (ValueError, TypeError, ZeroDivisionError, OverflowError):
        notes.add(name, "vertices: cannot be read: draw it again")
        return
    if len(ring) < 3:
        return
    if not np.isfinite(ring).all():
        notes.add(name, "vertices: must be finite numbers")
        return
    size = float(np.ptp(ring, axis=0).max())
    if entity.is_closed or math.dist(ring[0], ring[-1]) <= _CLOSED * size:
        outlines.append((str(entity.dxf.layer), name, ring))


def _corners(entity: Any) -> Floats:
    """Return the corners of a polyline (N, 2) in the world's coordinates; arcs as chains of corners."""
    if entity.has_arc:
        places = list(load("ezdxf.path").make_path(entity).flattening(_SAGITTA))
    elif entity.dxftype() == "LWPOLYLINE":
        places = list(entity.vertices_in_wcs())
    else:
        places = list(entity.points_in_wcs())
    return np.array([(place.x, place.y) for place in places], np.float64).reshape(-1, 2)


def _text(entity: Any) -> tuple[str, tuple[float, float]]:
    """Return the text of an entity and the place of it."""
    text = entity.plain_text() if entity.dxftype() != "MTEXT" else entity.plain_text().replace("\n", " ")
    place = entity.dxf.insert
    if entity.dxftype() != "MTEXT" and entity.dxf.get("halign", 0) + entity.dxf.get("valign", 0) > 0:
        place = entity.dxf.get("align_point", place)
    if entity.dxftype() != "MTEXT":
        place = entity.ocs().to_wcs(place)
    return text, (float(place.x), float(place.y))


def _labels(rings: list[Floats], texts: list[tuple[str, tuple[float, float]]]) -> dict[int, str]:
    """Return the text that stands in each outline, by its number; the one nearest to its middle of several."""
    placed = [(text, place) for text, place in texts if text.strip() and all(map(math.isfinite, place))]
    if not rings or not placed:
        return {}
    polygons = shapely.polygons([shapely.linearrings(ring) for ring in rings])
    points = shapely.points([place for _, place in placed])
    number, inside = shapely.STRtree(polygons).query(points, predicate="intersects")
    away = shapely.distance(shapely.centroid(polygons[inside]), points[number])
    found: dict[int, str] = {}
    for at in np.argsort(away, kind="stable").tolist():
        found.setdefault(int(inside[at]), placed[int(number[at])][0])
    return found
