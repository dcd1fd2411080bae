"""More to see: the true place, what another station changed, what is said, a second daemon."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from proving.faults.fault import Moment, Sight


def stayed(metres: float) -> Sight:
    """The true drone is at most so far from where it was when the fault began, seen from above."""

    def test(moment: Moment) -> bool:
        here, there = moment.truth["position"], moment.before["position"]
        return math.dist((here["x"], here["y"]), (there["x"], there["y"])) <= metres

    return Sight(f"within {metres:g} m of its true place", test)


def truly_between(lowest: float, highest: float) -> Sight:
    """The true height, metres."""
    return Sight(
        f"truly {lowest:g} to {highest:g} m high", lambda m: lowest <= m.truth["position"]["height"] <= highest
    )


def parameter(name: str, value: float) -> Sight:
    """The autopilot's parameter has this value."""
    return Sight(f"{name} {value:g}", lambda m: m.truth["parameters"].get(name) == value)


FENCE_IS_OURS: Final = Sight("the fence as before", lambda m: bool(m.truth["fence_mark"] == m.before["fence_mark"]))
NO_RALLY: Final = Sight("no rally point", lambda m: not m.truth["rally_points"])


def _said(moment: Moment) -> Iterator[str]:
    """Yield everything that the operator can read."""
    for entry in moment.log:
        yield f"{entry.text} {entry.details}"
    beat = moment.beat
    if beat is not None:
        yield str(beat.detail)
        for item in beat.health:
            if not item.healthy:
                yield f"{item.name} {item.reason}"
        for check in beat.checks:
            if not check.passed:
                yield f"{check.name} {check.value} {check.consequence} {check.remedy}"


def warned(*words: str) -> Sight:
    """A message, the state's detail, an unhealthy part or a failed check has one of these words."""
    shown = " or ".join(f"“{word}”" for word in words)
    return Sight(f"reported: {shown}", lambda m: any(word in line for line in _said(m) for word in words))


CLEAN: Final = Sight("no control characters shown", lambda m: not any(map(_has_control, _said(m))))


def _has_control(text: str) -> bool:
    return any(not character.isprintable() for character in text)


def second_ended(status: int, text: str = "") -> Sight:
    """A second daemon ended with this status; its output has the text."""
    return Sight(
        f"the second ends with status {status}" + (f", “{text}”" if text else ""),
        lambda m: m.second is not None and m.second[0] == status and text in m.second[1],
    )


def second_says(*texts: str) -> Sight:
    """A second daemon says one of these; it may run or have ended."""
    shown = " or ".join(f"“{text}”" for text in texts)
    return Sight(
        f"the second says {shown}", lambda m: m.second is not None and any(text in m.second[1] for text in texts)
    )
