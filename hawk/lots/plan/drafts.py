"""Operations on a plan as pure functions: the stalls that are meant -> the draft of a change.

A draft may still overlap other stalls, stand where none may be, or use another stall's label: `hawk.lots.plan.checks`
and `hawk.lots.plan.label_claims`.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hawk.lots.labels import parts_of
from hawk.lots.plan import geometry, sections
from hawk.lots.plan.operations import (
    LENGTHS_M,
    MOST_STALLS,
    WIDTHS_M,
    AddRow,
    AddStall,
    Allow,
    ChangeSection,
    Confirm,
    DrawSection,
    DrawZone,
    EraseZone,
    Forbid,
    Move,
    Operation,
    Remove,
    RemoveSection,
    Rename,
    Renumber,
    Reverse,
    SetKind,
    Shift,
    Split,
    Swap,
    Turn,
    Widen,
)
from hawk.lots.plan.values import NO_STALLS, PRIVATE, Draft, Floats, LayoutSection, LayoutStall, PlanZone, shapes_of
from hawk.lots.values import LotInputError
from hawk.model.sentences import say, words_of
from hawk.results.label_parts import LabelParts, in_order, numbered, reading_order


@dataclass(frozen=True, slots=True)
class Context:
    """The facts that drafts need besides the stalls: ``width`` and ``length`` are the lot's usual ones, metres.

    ``zones``: the areas without stalls; ``named``: zones with a name; ``sections``: all there are.
    ``new_id`` returns a UUID that is new.
    """

    width: float
    length: float
    zones: Sequence[PlanZone]
    new_id: Callable[[], str]
    named: Sequence[PlanZone] = ()
    sections: Sequence[LayoutSection] = ()


def drafted(asked: Operation, stalls: Sequence[LayoutStall], context: Context) -> Draft:
    """Return the draft of an operation.

    ``stalls`` are those that it selects; those whose middle is in the box around the outline for `Forbid`. Raises
    LotInputError.
    """
    try:
        return _drafted(asked, stalls, context)
    except geometry.ShapeError as error:
        raise LotInputError(error.field, words_of(error)) from None


def _drafted(asked: Operation, stalls: Sequence[LayoutStall], context: Context) -> Draft:
    match asked:
        case AddStall():
            shape = geometry.normal(np.array([[asked.north, asked.east, asked.angle, asked.width, asked.length]]))
            (stall,) = _new(shape, asked.kind, context)
            named = replace(stall, label=asked.label or "", is_named=asked.label is not None)
            return Draft(added=(named,), field="north")
        case AddRow():
            return Draft(added=_new(_row(asked, context), asked.kind, context), field="front")
        case Remove():
            return Draft(ended=tuple(stalls))
        case Move() | Turn() | Widen():
            return Draft(changed=_reshaped(stalls, _shapes(asked, shapes_of(stalls))))
        case SetKind():
            return Draft(changed=_changed([(stall, replace(stall, kind=asked.kind)) for stall in stalls]))
        case Confirm():
            return Draft(
                changed=_changed([(stall, replace(stall, is_confirmed=True, is_named=True)) for stall in stalls])
            )
        case Renumber() | Rename() | Reverse() | Shift() | Swap():
            return _relabelled(asked, stalls)
        case Split():
            return _split(stalls[0], asked.parts, context)
        case Forbid():
            return _forbidden(asked, stalls, context)
        case Allow():
            return Draft(allowed=(_zone(asked.zone, context.zones),))
        case DrawZone():
            return _drawn(asked, context)
        case EraseZone():
            return Draft(erased=(_zone(asked.zone, context.named),))
        case DrawSection():
            return sections.drawn(asked, context.sections, context.new_id)
        case ChangeSection():
            return sections.changed(asked, context.sections)
        case RemoveSection():
            return sections.removed(asked, context.sections)


def _new(shapes: Floats, kind: str, context: Context) -> tuple[LayoutStall, ...]:
    """Return new stalls, which a person has seen where they are."""
    blank = LayoutStall("", "", 0.0, 0.0, 0.0, 0.0, 0.0, kind, is_confirmed=True, is_named=False)
    return tuple(replace(blank.at(shape), id=context.new_id()) for shape in _rounded(shapes))


def _row(asked: AddRow, context: Context) -> Floats:
    start, end = asked.front
    length = geometry.front_length(start, end)
    usual = context.length if asked.parallel else context.width / math.cos(asked.lean)
    count = asked.count or max(1, round(length / (asked.pitch or usual)))
    if count * (1 + asked.double) > MOST_STALLS:
        raise LotInputError(
            "count",
            say(
                "makes {count} stalls: write one for {most} or fewer",
                count=count * (1 + asked.double),
                most=MOST_STALLS,
            ),
        )
    shapes = geometry.row_shapes(geometry.Row(start, end, asked.far, count, asked.lean, asked.double))
    width, long = shapes[0, 3:].tolist()
    if not WIDTHS_M[0] <= width <= WIDTHS_M[1]:
        raise LotInputError(
            "count",
            say(
                "makes stalls {width:.2f} m wide: write one for {least:g} to {most:g} m",
                width=width,
                least=WIDTHS_M[0],
                most=WIDTHS_M[1],
            ),
        )
    if long > LENGTHS_M[1]:
        raise LotInputError(
            "far",
            say(
                "makes stalls {length:.2f} m long: place it for {least:g} to {most:g} m, or as two rows",
                length=long,
                least=LENGTHS_M[0],
                most=LENGTHS_M[1],
            ),
        )
    return shapes


def _shapes(asked: Move | Turn | Widen, shapes: Floats) -> Floats:
    """Return the shapes (N, 5) after a change of their place or size."""
    match asked:
        case Move():
            moved: Floats = shapes + np.array([asked.north, asked.east, 0.0, 0.0, 0.0])
            return moved
        case Turn():
            return geometry.turned(shapes, asked.by, about_each=asked.about == "each")
        case Widen():
            found = shapes.copy()
            for column, size in ((3, asked.width), (4, asked.length)):
                if size is not None:
                    found[:, column] = size
            if (found[:, 3] > found[:, 4]).any():
                field = "length" if asked.width is None else "width"
                raise LotInputError(field, say("makes a stall wider than long: turn it by 90° and exchange both"))
            return found


def _reshaped(stalls: Sequence[LayoutStall], shapes: Floats) -> tuple[tuple[LayoutStall, LayoutStall], ...]:
    return _changed([(stall, stall.at(shape)) for stall, shape in zip(stalls, _rounded(shapes), strict=True)])


def _rounded(shapes: Floats) -> list[list[float]]:
    found: list[list[float]] = np.round(shapes, 6).tolist()
    return found


def _changed(pairs: Sequence[tuple[LayoutStall, LayoutStall]]) -> tuple[tuple[LayoutStall, LayoutStall], ...]:
    """Return the pairs of which something changes."""
    return tuple((old, new) for old, new in pairs if old != new)


def _relabelled(asked: Renumber | Rename | Reverse | Shift | Swap, stalls: Sequence[LayoutStall]) -> Draft:
    """Return the draft of other labels, which are a person's."""
    rows: frozenset[str] = frozenset()
    match asked:
        case Renumber():
            stalls, labels = _renumbered(asked, stalls)
            field = "labels" if asked.labels else "letter"
            rows = frozenset({asked.letter} if asked.row is not None and asked.letter is not None else ())
        case Rename():
            labels = [_numbers(stall, "to").in_row(asked.to) for stall in stalls]
            field, rows = "to", frozenset({asked.to} if asked.row is not None else ())
        case Reverse():
            labels, field = _reversed([stall.label for stall in stalls]), "stalls"
        case Shift():
            labels, field = [_shifted(stall, asked.by) for stall in stalls], "by"
        case Swap():
            (one, other), field = asked.rows, "rows"
            to = {one: other, other: one}
            labels = [_numbers(stall, field).in_row(to[(parts_of(stall.label) or ("", 0))[0]]) for stall in stalls]
    pairs = zip(stalls, labels, strict=True)
    changed = _changed([(stall, replace(stall, label=label, is_named=True)) for stall, label in pairs])
    return Draft(changed=changed, field=field, rows=rows)


def _renumbered(asked: Renumber, stalls: Sequence[LayoutStall]) -> tuple[Sequence[LayoutStall], Sequence[str]]:
    """Return the stalls in the order of their new labels, and these."""
    if asked.labels is not None:
        if len(asked.labels) != len(stalls):
            raise LotInputError(
                "labels",
                say(
                    "are {labels} for {stalls} stalls: write one for each", labels=len(asked.labels), stalls=len(stalls)
                ),
            )
        return stalls, asked.labels
    ordered = stalls if asked.stalls is not None else in_order(stalls)
    return ordered, [f"{asked.letter} {number}" for number in range(asked.first, asked.first + len(stalls))]


def _numbers(stall: LayoutStall, field: str) -> LabelParts:
    parts = numbered(stall.label)
    if parts is None:
        raise LotInputError(
            field, say("finds no number in {label}: give that stall a label by renumber first", label=stall.label)
        )
    return parts


def _shifted(stall: LayoutStall, by: int) -> str:
    parts = _numbers(stall, "by")
    if parts.number + by < 0:
        raise LotInputError(
            "by",
            say(
                "makes {label} number {number}: write {least} or more",
                label=stall.label,
                number=parts.number + by,
                least=-parts.number,
            ),
        )
    return parts.with_number(parts.number + by)


def _reversed(labels: Sequence[str]) -> list[str]:
    """Return the labels of each row in the other order."""
    rows: dict[str, list[str]] = defaultdict(list)
    for label in sorted(labels, key=reading_order):
        rows[reading_order(label)[1] if numbered(label) else ""].append(label)
    other = {one: another for row in rows.values() for one, another in zip(row, reversed(row), strict=True)}
    return [other[label] for label in labels]


def _split(stall: LayoutStall, count: int, context: Context) -> Draft:
    shapes = geometry.parts(shapes_of([stall])[0], count)
    width = float(shapes[0, 3])
    if width < WIDTHS_M[0]:
        raise LotInputError(
            "parts", say("are {width:.2f} m wide: write fewer, for {least:g} m or more", width=width, least=WIDTHS_M[0])
        )
    (first,) = _reshaped([stall], shapes[:1])
    new = _new(shapes[1:], stall.kind, context)
    return Draft(changed=(first,), added=new, field="parts")


def _zone(named: str, zones: Sequence[PlanZone]) -> PlanZone:
    zone = next((each for each in zones if each.id == named), None)
    if zone is None:
        raise LotInputError("zone", say("must be of this plan: read the plan again"))
    return zone


def _ring(asked: Forbid | DrawZone) -> tuple[tuple[float, float], ...]:
    return tuple(geometry.checked_ring([(round(north, 6), round(east, 6)) for north, east in asked.outline]))


def _drawn(asked: DrawZone, context: Context) -> Draft:
    if any(zone.name == asked.name for zone in context.named):
        raise LotInputError(
            "name", say("{name} is another zone's: write another one, or erase that zone first", name=asked.name)
        )
    return Draft(drawn=(PlanZone(context.new_id(), asked.name, _ring(asked), asked.kind),), field="outline")


def _forbidden(asked: Forbid, stalls: Sequence[LayoutStall], context: Context) -> Draft:
    outline = _ring(asked)
    name = " ".join(asked.name.split())
    if not name.isprintable():
        raise LotInputError("name", say("holds characters that cannot be shown: write it without"))
    inside = geometry.within(outline, shapes_of(stalls)[:, :2])
    ended = tuple(stall for stall, lies in zip(stalls, inside, strict=True) if lies)
    zone = PlanZone(context.new_id(), name, outline, PRIVATE if asked.private else NO_STALLS)
    return Draft(ended=ended, forbidden=(zone,), field="outline")
