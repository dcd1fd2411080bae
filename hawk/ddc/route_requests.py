"""Telling an operator the way that an Autonomous Move would take, without flying it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hawk.comm.messages import Point, RouteAnswer, RouteRequest
from hawk.comm.status import ClientId
from hawk.ddc.inquiry import NOT_TOLD, place_refusal
from hawk.ddc.topic_interface import VERDICT_AGE_S
from hawk.model import DesiredPose, MapPoint, Route

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

WAITING_LIMIT = 8
"""Clients whose questions wait at a time."""


@dataclass(frozen=True, slots=True)
class _Question:
    client: ClientId
    request: RouteRequest


class RouteRequests:
    """Asks the planner about one place after another, in the order in which clients asked.

    A client's newer question takes the place of its older one, whose answer says so.
    """

    def __init__(self, context: OperationsManager) -> None:
        self._context = context
        self._waiting: dict[ClientId, _Question] = {}
        self._open: tuple[_Question, int, float] | None = None
        self._number = 0

    def ask(self, client: ClientId, request: RouteRequest) -> None:
        """Take up a question; the answer goes to the client within a second of its turn."""
        older = self._waiting.pop(client, None)
        if older is not None:
            self._refuse(older, "You asked for another way since.")
        if len(self._waiting) >= WAITING_LIMIT:
            self._refuse(_Question(client, request), "Too many ask for ways: ask again in a moment.")
            return
        self._waiting[client] = _Question(client, request)

    def tick(self) -> None:
        """Look for the answer, and put the next question."""
        if self._open is not None:
            self._look(*self._open)
        while self._open is None and self._waiting:
            client = next(iter(self._waiting))
            self._put(self._waiting.pop(client))

    def _put(self, question: _Question) -> None:
        place = self._context.commands.place_of(question.request)
        refusal = None if place is None else self._context.judge.place_refusal(place)
        if place is None or refusal is not None:
            self._refuse(question, refusal.reason if refusal else "The position is not known well enough: wait for it.")
            return
        self._number += 1
        self._open = (question, self._number, self._context.now)
        self._context.topics.asked_place_pub.publish(DesiredPose(self._number, place.north, place.east))

    def _look(self, question: _Question, number: int, asked: float) -> None:
        verdict = self._context.topics.get_asked_verdict(number)
        if verdict is not None:
            self._close()
            refused = place_refusal(verdict)
            if refused:
                self._refuse(question, refused)
            else:
                self._answer(question, verdict.route)
        elif self._context.now - asked > VERDICT_AGE_S:
            self._close()
            self._refuse(question, NOT_TOLD)

    def _close(self) -> None:
        self._open = None
        self._context.topics.asked_place_pub.publish(None)

    def _answer(self, question: _Question, route: Route) -> None:
        points = [_point(place) for place in route.points]
        answer = RouteAnswer(id=question.request.id, points=points, length_m=round(route.length_m, 1), refused=None)
        self._context.socket.reply(question.client, answer)

    def _refuse(self, question: _Question, reason: str) -> None:
        answer = RouteAnswer(id=question.request.id, points=[], length_m=None, refused=reason)
        self._context.socket.reply(question.client, answer)


def _point(place: MapPoint) -> Point:
    return Point(north=round(place.north, 2), east=round(place.east, 2))
