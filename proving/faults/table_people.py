"""Faults that people make: a lot that is changed while it is flown over, a page that nobody sees."""

from __future__ import annotations

from typing import Final, Literal

from hawk.comm.protocol.commands import Hold
from hawk.model.operation import StateName
from proving.faults.fault import (
    DOWN,
    UP,
    Answer,
    Bring,
    ChangeLot,
    Fault,
    Hide,
    KnowLot,
    Moment,
    Order,
    See,
    Sight,
    Subject,
    TakePlan,
    When,
    absent,
    both,
    either,
    refused,
    reported,
    state,
)

_HOVER, _EXPLORE, _RETURN, _LOST = (
    StateName.HOVER,
    StateName.AUTONOMOUS_EXPLORE,
    StateName.RETURN_TO_LAUNCH,
    StateName.COMMUNICATION_LOST,
)
_FLOWN_M: Final = 10.0
"""No place of the tour as it began lies so far north of its start; the new row lies 28 m north."""


def _tour(test: float) -> Sight:
    """The planned flight over the lot is longer than that, metres."""

    def found(moment: Moment) -> bool:
        distance = None if moment.beat is None else moment.beat.again_distance
        return distance is not None and distance > test

    return Sight(f"a tour of more than {test:g} m", found)


_OFFERED: Final = Sight("a changed plan is offered", lambda m: m.beat is not None and m.beat.plan_offer is not None)
_WENT_THERE: Final = Sight(
    "flies to what was changed", lambda m: m.beat is not None and (m.beat.north or 0.0) > _FLOWN_M
)
_BEGIN: Final = (KnowLot(), See(_tour(1.0), 60.0), Bring(When.EXPLORING))

_CHANGED: Final = Answer(
    Subject.PEOPLE,
    "somebody without control changes plan, pin or outline of the lot that is surveyed again",
    "flies on as it began; the change is offered within {a changed plan is offered*}",
    "**Fly it** or **Leave it**",
)
_HIDDEN: Final = Answer(
    Subject.PEOPLE,
    "the page of the operator is hidden while it explores, as in a pocket",
    "holds after {CommunicationLost}, then returns home; shown again before, it holds",
    "look at the page; **Explore** goes on",
)


def _changed(what: Literal["plan", "pin", "outline"]) -> Fault:
    """Return the fault of a lot that somebody without control changes in its tour."""
    return Fault(
        f"somebody without control changes the {what} of the lot in a tour",
        When.GROUND,
        (
            *_BEGIN,
            ChangeLot(what),
            See(both(reported("was changed, signed"), _OFFERED), 10.0),
            TakePlan(stranger=True),
            See(refused("control"), 2.0),
            See(both(UP, absent(_WENT_THERE)), 12.0, lasts=True),
        ),
        ends_flight=True,
        answer=_CHANGED,
    )


PEOPLE: Final = (
    _changed("plan"),
    _changed("pin"),
    _changed("outline"),
    Fault(
        "the page of the operator is hidden while it explores",
        When.EXPLORING,
        (
            Hide(),
            See(state(_LOST), 40.0),
            See(reported("is hidden"), 42.0),
            See(state(_RETURN), 60.0),
            Hide(hidden=False),
            Order(Hold()),
            See(either(state(_HOVER), DOWN), 5.0),
        ),
        ends_flight=True,
        answer=_HIDDEN,
    ),
    Fault(
        "a hidden page is shown again before the return",
        When.EXPLORING,
        (
            Hide(),
            See(state(_LOST), 40.0),
            Hide(hidden=False),
            See(state(_HOVER), 3.0),
            See(both(UP, absent(state(_EXPLORE))), 5.0, lasts=True),
        ),
        answer=_HIDDEN,
    ),
)
