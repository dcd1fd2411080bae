"""Route Requests: the path of an Autonomous Move without flying it; and the planner's verdict in words."""

from __future__ import annotations

from dataclasses import dataclass

from hawk.comm.protocol.commands import RouteAnswer, RouteRequest
from hawk.comm.protocol.heartbeat import ClientId, Point
from hawk.ddc.acts import Acts, AskPlace, Reply
from hawk.ddc.facts import Facts
from hawk.ddc.readings.topic_interface import VERDICT_AGE_S
from hawk.ddc.rules.judge import place_of, place_refusal
from hawk.model.plans import DesiredPose, Inbound, Verdict
from hawk.model.poses import MapPoint
from hawk.model.sentences import say

WAITING_LIMIT = 8
"""Clients whose questions wait at a time."""
NOT_JUDGED = say("X, Y: whether the place is inside the lot could not be found within a second.")
_REASONS = {
    Inbound.OUTSIDE: say("X, Y: the place is outside the lot: choose one inside, or Compulsive Move."),
    Inbound.UNKNOWN: say("X, Y: nobody has seen that place yet: explore first, or Compulsive Move."),
}


def verdict_refusal(verdict: Verdict) -> str:
    """Return the reason why an Autonomous Move to the place of a verdict is refused; empty when it has a route."""
    if verdict.inbound is not Inbound.INSIDE:
        return _REASONS[verdict.inbound]
    if len(verdict.route.points) >= 2:
        return ""
    return say(
        "X, Y: {refused}: choose another place, or Compulsive Move.",
        refused=verdict.route.refused or say("no route there is known"),
    )


@dataclass(frozen=True, slots=True)
class _Question:
    client: ClientId
    request: RouteRequest
    number: int = 0
    asked: float = 0.0


class RouteRequests:
    """Asks the planner about one place after another, in the order in which clients asked.

    A client's newer question replaces its older one, whose answer says so.
    """

    def __init__(self) -> None:
        self._waiting: dict[ClientId, _Question] = {}
        self._open: _Question | None = None
        self._number = 0

    def ask(self, client: ClientId, request: RouteRequest) -> Acts:
        """Accept a question; the answer goes to the client within a second of its turn."""
        acts: Acts = ()
        older = self._waiting.pop(client, None)
        if older is not None:
            acts = _refuse(older, say("You asked for another route since."))
        question = _Question(client, request)
        if len(self._waiting) >= WAITING_LIMIT:
            return acts + _refuse(question, say("Too many ask for routes: ask again in a moment."))
        self._waiting[client] = question
        return acts

    def tick(self, facts: Facts) -> Acts:
        """Look for the answer, and ask the next question."""
        acts = () if self._open is None else self._look(self._open, facts)
        while self._open is None and self._waiting:
            client = next(iter(self._waiting))
            acts += self._put(self._waiting.pop(client), facts)
        return acts

    def _put(self, question: _Question, facts: Facts) -> Acts:
        place = place_of(question.request, facts)
        if place is None:
            return _refuse(question, say("The position is not known well enough: wait for it."))
        refused = place_refusal(facts, place)
        if refused is not None:
            return _refuse(question, refused.reason)
        self._number += 1
        self._open = _Question(question.client, question.request, self._number, facts.now)
        return (AskPlace(DesiredPose(self._number, place.north, place.east)),)

    def _look(self, question: _Question, facts: Facts) -> Acts:
        verdict = facts.sight.asked
        if verdict is None or verdict.number != question.number:
            if facts.now - question.asked <= VERDICT_AGE_S:
                return ()
            self._open = None
            return AskPlace(None), *_refuse(question, NOT_JUDGED)
        self._open = None
        refused = verdict_refusal(verdict)
        return AskPlace(None), *(_refuse(question, refused) if refused else _answer(question, verdict))


def _answer(question: _Question, verdict: Verdict) -> Acts:
    points = [_point(place) for place in verdict.route.points]
    length = round(verdict.route.length_m, 1)
    answer = RouteAnswer(id=question.request.id, points=points, length=length, refused=None)
    return (Reply(question.client, answer),)


def _refuse(question: _Question, reason: str) -> Acts:
    answer = RouteAnswer(id=question.request.id, points=[], length=None, refused=reason)
    return (Reply(question.client, answer),)


def _point(place: MapPoint) -> Point:
    return Point(north=round(place.north, 2), east=round(place.east, 2))
