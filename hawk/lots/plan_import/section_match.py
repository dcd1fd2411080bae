"""Changes that a placed plan makes to the sections of a lot: those that stay and are said otherwise, begin, and end.

A section of the file is one of the lot by its id, by its ground, or by its name where both touch. It keeps the id, and
that which the file does not say of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import shapely
from shapely.geometry.base import BaseGeometry

from hawk.lots.plan.sections import capacity_of
from hawk.lots.plan.values import LayoutSection
from hawk.lots.plan_files.values import FileSection, LeftOut
from hawk.lots.registration.survey_place import ABOUT_M
from hawk.lots.values import free_name
from hawk.model.poses import Ring

SAME_SHARE: Final = 0.5
"""Ground that two sections share, of the ground of both, from which they are one."""
_ALIKE_M: Final = 0.01
"""Metres by which a section of the file may lie beside that of the lot and is where that one is: files round."""


@dataclass(frozen=True, slots=True)
class MatchedSections:
    """The change of sections. One that changes ends, and one with the same id begins, as `Draft` has it.

    ``same``: number of those that the plan has as the file does; ``clashes`` and ``renamed`` as of stalls.
    """

    begun: tuple[LayoutSection, ...]
    ended: tuple[LayoutSection, ...]
    same: int
    clashes: tuple[LeftOut, ...]
    renamed: tuple[tuple[str, str], ...]


def matched_sections(
    given: Sequence[FileSection],
    rings: Sequence[Ring],
    present: Sequence[LayoutSection],
    new_id: Callable[[], str],
    *,
    is_replaced: bool,
    is_renamed: bool,
) -> MatchedSections:
    """Return the change. ``rings``: of the file's sections, in the lot's frame, north and east.

    ``is_replaced``: sections amid those of the file end where the file has them not; ``is_renamed``: a number follows a
    name that another section has.
    """
    readable = [each for each in present if each.outline]
    grounds = [shapely.Polygon(ring) for ring in rings]
    there = [shapely.Polygon(each.outline) for each in readable]
    same = _same(given, grounds, readable, there)
    gone = _gone(grounds, readable, there, {*same.values()}) if is_replaced and given else []
    taken = {readable[k].id for k in same.values()} | {each.id for each in gone}
    used = {each.name for each in present if each.id not in taken}
    names, clashes, renamed = _names(given, [readable[same[i]].name if i in same else "" for i in range(len(given))],
                                     used, is_renamed=is_renamed)  # fmt: skip
    begun, ended, alike = [], list(gone), 0
    for i, each in enumerate(given):
        old = readable[same[i]] if i in same else None
        new = _said(each, rings[i], names[i], old, "" if old else new_id())
        if old == new:
            alike += 1
            continue
        begun.append(new)
        ended += [] if old is None else [old]
    return MatchedSections(tuple(begun), tuple(ended), alike, tuple(clashes), tuple(renamed))


def _same(
    given: Sequence[FileSection], grounds: Sequence[BaseGeometry], present: Sequence[LayoutSection],
    there: Sequence[BaseGeometry],
) -> dict[int, int]:  # fmt: skip
    """Return which section of the lot each one of the file is, each at most once: the best pairs first."""
    pairs: list[tuple[int, float, int, int]] = []
    near = shapely.STRtree(there)
    ids = {each.id: k for k, each in enumerate(present)}
    for i, (each, ground) in enumerate(zip(given, grounds, strict=True)):
        if each.facts.id in ids:
            pairs.append((0, 0.0, i, ids[each.facts.id]))
        for k in near.query(ground, predicate="intersects").tolist():
            shared = ground.intersection(there[k]).area / ground.union(there[k]).area
            is_namesake = each.facts.title == present[k].name
            if shared >= SAME_SHARE or is_namesake:
                pairs.append((1 if shared >= SAME_SHARE else 2, -shared - is_namesake, i, k))
    same: dict[int, int] = {}
    for _, _, i, k in sorted(pairs):
        if i not in same and k not in same.values():
            same[i] = k
    return same


def _gone(
    grounds: Sequence[BaseGeometry], present: Sequence[LayoutSection], there: Sequence[BaseGeometry], kept: set[int]
) -> list[LayoutSection]:
    """Return the sections of the lot that the file has not, amid those that it has."""
    around = shapely.union_all(list(grounds)).convex_hull.buffer(ABOUT_M)
    return [
        each
        for k, (each, ground) in enumerate(zip(present, there, strict=True))
        if k not in kept and around.contains(ground.centroid)
    ]


def _names(
    given: Sequence[FileSection], former: Sequence[str], used: set[str], *, is_renamed: bool
) -> tuple[list[str], list[LeftOut], list[tuple[str, str]]]:
    """Return the names of the file's sections, those that other sections have, and the pairs that were renamed.

    ``former``: the name of the lot's section that each one is, "" of new ones; ``used``: names of others that stay.
    """
    known, first_of = {*used}, dict[str, str]()
    for each, name in zip(given, former, strict=True):
        first_of.setdefault(each.facts.title or name, each.name)
    names, clashes, renamed = [], list[LeftOut](), list[tuple[str, str]]()
    known |= first_of.keys()
    for each, name in zip(given, former, strict=True):
        wanted = each.facts.title or name or free_name("Section", known)
        if wanted in used or first_of.get(wanted, each.name) != each.name:
            if is_renamed:
                renamed.append((wanted, free_name(wanted, known)))
                wanted = renamed[-1][1]
            else:
                whose = "another section of this lot" if wanted in used else first_of[wanted]
                words = f"name {wanted}: {whose} has it too; write another one, or import with rename"
                clashes.append(LeftOut(each.name, words))
        known.add(wanted)
        names.append(wanted)
    return names, clashes, renamed


def _said(given: FileSection, ring: Ring, name: str, old: LayoutSection | None, section: str) -> LayoutSection:
    """Return a section as the file says it; what it does not say is as of the lot's ``old`` one."""
    facts = given.facts
    is_there = old is not None and _is_there(ring, old.outline)
    outline = old.outline if old is not None and is_there else ring
    length = old.length_m if old is not None and is_there and facts.metres is None else given.length_m
    kind = facts.kind if facts.kind is not None else old.kind if old is not None else ""
    note = facts.note if facts.note is not None else old.note if old is not None else ""
    capacity, is_given = facts.capacity, facts.is_capacity_given and facts.capacity is not None
    if capacity is None and old is not None and (old.is_capacity_given or (is_there and kind == old.kind)):
        capacity, is_given = old.capacity, old.is_capacity_given
    elif capacity is None:
        capacity = capacity_of(kind, length, facts.place_m)
    new = LayoutSection(section, name, outline, kind, length, capacity, is_given, note)
    return new if old is None else replace(new, id=old.id, key=old.key)


def _is_there(ring: Ring, other: Ring) -> bool:
    """Return whether two rings are one, by the farthest that any place of one is from the other."""
    away: float = shapely.hausdorff_distance(shapely.LinearRing(ring), shapely.LinearRing(other))
    return away < _ALIKE_M
