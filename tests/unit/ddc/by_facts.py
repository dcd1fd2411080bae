"""A single state by facts alone: makes it, changes its facts, and reads its acts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

from hawk.ddc.acts import (
    Acts,
    Ask,
    Log,
    ReadParameter,
    SendTarget,
)
from hawk.ddc.facts import Answer, Facts
from hawk.ddc.motion import Goal
from hawk.ddc.orders import (
    MoveOrder,
    ToCommunicationLost,
    ToExplore,
    ToHover,
    ToLand,
    ToManual,
    ToMove,
    ToReturn,
    ToTakeoff,
    Transition,
)
from hawk.ddc.parameters.reader import ParameterReader
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import State
from hawk.ddc.states.factory import make_state
from hawk.model.plans import HeightParameters, Route
from hawk.model.poses import MapPoint
from hawk.model.vehicle import CopterMode
from tests.unit.ddc.written_facts import SETTINGS, flying, on_ground, pose

HEIGHTS = HeightParameters(15, 35, 60)
MOVE = MoveOrder(MapPoint(40.0, 0.0), 30.0, 0.0, False, 0)
STRAIGHT = Route((MapPoint(0.0, 0.0), MapPoint(40.0, 0.0)), (0.0, 0.0))
LOT_MOVE = replace(MOVE, autonomous=True, number=3, route=STRAIGHT)
IN_THE_AIR: tuple[Transition, ...] = (
    ToTakeoff(),
    ToHover(),
    ToExplore(),
    ToMove(MOVE),
    ToReturn(),
    ToLand(),
    ToCommunicationLost(),
    ToManual(),
)


def made(transition: Transition, now: float = 0.0, settings: DdcSettings = SETTINGS) -> State:
    return make_state(transition, flying(now), settings)[0]


def standing(now: float, armed: bool = False, mode: int = CopterMode.GUIDED) -> Facts:
    facts = on_ground(flying(now, mode))
    return replace(facts, vehicle=replace(facts.vehicle, armed=armed))


def answered(facts: Facts, *answers: tuple[str, float, str], words: str = "") -> Facts:
    """Write answers down: name, time of the request, status."""
    given = tuple(Answer(name, at, status, words) for name, at, status in answers)  # type: ignore[arg-type]
    return replace(facts, answers=given)


def at(facts: Facts, north: float = 0.0, east: float = 0.0, height: float = 30.0) -> Facts:
    return replace(facts, position=replace(facts.position, pose=pose(facts.now, north, east, height)))


def without_pose(facts: Facts) -> Facts:
    return replace(facts, position=replace(facts.position, age=0.6))


def without_operator(facts: Facts) -> Facts:
    return replace(facts, operator=replace(facts.operator, is_present=False))


def requests(acts: Acts) -> list[object]:
    return [act.request for act in acts if isinstance(act, Ask)]


def targets(acts: Acts) -> list[Goal]:
    return [act.goal for act in acts if isinstance(act, SendTarget)]


def texts(acts: Acts) -> list[str]:
    return [act.text for act in acts if isinstance(act, Log)]


def read_all(reader: ParameterReader, facts: Facts, values: Mapping[str, float | None], fails: str = "") -> None:
    """Answer whatever the reader asks, until it asks no more; what has no value fails, and so does ``fails``."""
    acts = reader.tick(facts)
    while asked := reads(acts):
        answers = []
        for name in asked:
            value = None if name == fails else values.get(name)
            status: Literal["done", "failed"] = "failed" if value is None else "done"
            answers.append(Answer(f"read {name}", facts.now, status, "", value))
        acts = reader.tick(replace(facts, answers=tuple(answers)))


def reads(acts: Acts) -> list[str]:
    """Return the parameters that are asked for."""
    return [request.parameter for request in requests(acts) if isinstance(request, ReadParameter)]
