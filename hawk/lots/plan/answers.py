"""Answers about plans and their edits, as `hawk.lots.answers` has those about lots."""

from __future__ import annotations

from hawk.lots.answers import Count, Degrees, Edit, Shown, Utc
from hawk.lots.plan.values import Id, PlanSection, PlanStall, PlanZone


class PlanZones(Shown):
    """Areas of a plan: `zones` are those without stalls, `named_zones` those that statistics count; `sections`."""

    zones: list[PlanZone]
    named_zones: list[PlanZone]
    sections: list[PlanSection]


class PlanChanges(PlanZones):
    """Stalls of a plan, and the ids of those that are `gone`: no part of the plan any more."""

    stalls: list[PlanStall]
    gone: list[Id]


class Plan(PlanChanges):
    """A lot's plan: all of it where `whole`, else the stalls that changed after a revision, and the ids of those that
    are `gone`. `layout`: the version that was asked for, which has neither a `revision` nor an `edit`; null for the
    present plan. `datum`: origin of the lot's frame, north up. A file with all of it is imported as an owner's plan.
    """

    lot: Id
    datum: Degrees
    layout: int | None
    revision: Count | None
    edit: Edit | None
    whole: bool


class StepCounts(Shown):
    """Operations of an edit that can be undone, and done again."""

    undo: Count
    redo: Count


class Opened(StepCounts):
    """An open edit. `undo`, `redo`: operations that can be undone, done again."""

    edit: Id
    lot: Id
    who: str
    since: Utc
    layout: int
    revision: Count


class Edited(PlanChanges, StepCounts):
    """Changes by an operation. `gone`: stalls that are no part of the plan any more. Zones and sections
    are all there are.
    """

    edit: Id
    revision: Count


class Stepped(Edited):
    """Changes by an undo or a redo; `operation` names what was undone or done again."""

    operation: str


class Closed(Shown):
    """A closed edit: `seq` undoes all of it, `layout` is its version; both null where nothing is changed."""

    lot: Id
    edit: Id
    seq: int | None
    layout: int | None
