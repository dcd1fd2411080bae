"""Route Requests by facts alone: numbers, order, times and what is answered."""

from __future__ import annotations

from dataclasses import replace

from hawk.comm.protocol.commands import RouteAnswer, RouteRequest
from hawk.comm.protocol.heartbeat import Point
from hawk.ddc.acts import Acts, AskPlace, Reply
from hawk.ddc.facts import Facts
from hawk.ddc.readings.topic_interface import VERDICT_AGE_S
from hawk.ddc.rules.command_desk import NOT_JUDGED, WAITING_LIMIT, RouteRequests
from hawk.model.plans import DesiredPose, Inbound, Route, Verdict
from hawk.model.poses import MapPoint
from tests.unit.ddc.written_facts import flying

ROUTE = Route((MapPoint(0.0, 0.0), MapPoint(3.3333, 4.4444)), (0.0, 0.0))


def request(number: int) -> RouteRequest:
    return RouteRequest(id=number, x=10 * number, y=5, frame="Map")


def judged(facts: Facts, number: int, inbound: Inbound = Inbound.INSIDE, route: Route = ROUTE) -> Facts:
    return replace(facts, sight=replace(facts.sight, asked=Verdict(number, inbound, route)))


def places(acts: Acts) -> list[DesiredPose | None]:
    return [act.pose for act in acts if isinstance(act, AskPlace)]


def answers(acts: Acts) -> list[tuple[str, RouteAnswer]]:
    return [
        (act.client, act.message) for act in acts if isinstance(act, Reply) and isinstance(act.message, RouteAnswer)
    ]


def test_questions_are_numbered_one_after_the_other_and_answered_in_centimetres() -> None:
    routes = RouteRequests()
    assert routes.ask("ana", request(1)) == ()
    assert routes.ask("bo", request(2)) == ()
    assert places(routes.tick(flying(1.0))) == [DesiredPose(1, 10.0, 5.0)]
    acts = routes.tick(judged(flying(1.1), 1))
    ((client, answer),) = answers(acts)
    assert (client, answer.id, answer.refused) == ("ana", 1, None)
    assert answer.points == [Point(north=0.0, east=0.0), Point(north=3.33, east=4.44)]
    assert answer.length == 5.6, "5.5555 m"
    assert places(acts) == [None, DesiredPose(2, 20.0, 5.0)]


def test_a_question_waits_a_second_for_its_verdict_whatever_the_clock_says() -> None:
    routes = RouteRequests()
    routes.ask("ana", request(1))
    routes.tick(flying(5000.0))
    assert routes.tick(flying(5000.0 + VERDICT_AGE_S)) == ()
    assert routes.tick(judged(flying(5000.0 + VERDICT_AGE_S), 2)) == (), "that is the verdict of another question"
    ((client, answer),) = answers(routes.tick(flying(5000.0 + VERDICT_AGE_S + 0.1)))
    assert (client, answer.refused, answer.length) == ("ana", NOT_JUDGED, None)
    assert routes.tick(flying(5010.0)) == ()


def test_a_newer_question_of_a_client_replaces_its_older_one_and_few_wait() -> None:
    routes = RouteRequests()
    for number in range(WAITING_LIMIT):
        assert routes.ask(f"client {number}", request(number)) == ()
    ((client, answer),) = answers(routes.ask("late", request(9)))
    assert (client, answer.id) == ("late", 9)
    assert answer.refused is not None
    ((client, older),) = answers(routes.ask("client 3", request(8)))
    assert (client, older.id) == ("client 3", 3)
