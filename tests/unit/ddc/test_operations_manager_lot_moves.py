"""Autonomous Move over known lot: refusals, the flown route, and changes of the map."""

from __future__ import annotations

import pytest

from hawk.comm.protocol.commands import Ack, AutonomousMove, Hold, RouteAnswer, RouteRequest
from hawk.model.operation import StateName, UserError
from hawk.model.plans import Inbound, Route
from hawk.model.poses import MapPoint
from tests.unit.ddc.fakes import Rig

S = StateName


def path(*points: tuple[float, float], turns: tuple[float, ...] | None = None) -> Route:
    return Route(tuple(MapPoint(*p) for p in points), turns or (0.0,) * len(points))


AROUND = path((0, 0), (30, 0), (30, 40), turns=(0.0, 8.0, 0.0))


async def move(rig: Rig, x: float, y: float) -> Ack:
    assert rig.manager.handle("ana", AutonomousMove(x=x, y=y, frame="Map")) is None
    while not rig.socket.replies:
        await rig.tick()
    answer = rig.socket.replies.pop()[1]
    assert isinstance(answer, Ack)
    return answer


@pytest.mark.nightly
async def test_it_flies_around_what_is_not_lot_without_a_stop(flying: Rig) -> None:
    flying.sight.route = AROUND
    assert (await move(flying, 30, 40)).accepted
    places, ticks = [], 0
    while flying.state is S.AUTONOMOUS_MOVE:
        await flying.tick()
        places.append((flying.autopilot.north, flying.autopilot.east))
        ticks += 1
    flying.expect(S.HOVER)
    assert "There. Holding." in flying.log
    beside = [(n, e) for n, e in places if not (abs(e) < 1.1 or abs(n - 30) < 1.1 or (n > 21 and e < 9))]
    assert not beside
    assert max(n for n, _ in places) > 26
    assert ticks * 0.05 < AROUND.length_m / 4.0 + 6.0


@pytest.mark.nightly
async def test_each_target_is_on_the_route(flying: Rig) -> None:
    flying.sight.route = path((0, 0), (30, 0), (30, 40))
    await move(flying, 30, 40)
    first = len(flying.autopilot.targets)
    await flying.until(S.HOVER)
    places = [(t.north, t.east) for t in flying.autopilot.targets[first:] if t.state is S.AUTONOMOUS_MOVE]
    assert len(places) > 100
    assert all(abs(e) < 0.5 or abs(n - 30) < 1.6 for n, e in places)


async def test_without_a_route_it_is_refused_with_user_error_1(flying: Rig) -> None:
    flying.sight.route = Route(refused="no path over known lot leads there")
    answer = await move(flying, 30, 40)
    assert not answer.accepted
    assert "no path over known lot leads there" in answer.reason
    assert flying.manager.outcomes.user_error is UserError.DESIRED_LOCATION_OUT_OF_BOUNDS
    flying.expect(S.HOVER)
    assert flying.topics.des_pose_pub.value is None


async def test_a_planner_that_says_inside_but_gives_no_route_is_not_believed(flying: Rig) -> None:
    flying.sight.route = Route()
    assert not (await move(flying, 30, 40)).accepted
    flying.expect(S.HOVER)


@pytest.mark.parametrize("corner", [(500.0, 0.0), (float("nan"), 0.0)])
async def test_a_route_that_leaves_the_fence_is_refused_whatever_the_planner_says(
    flying: Rig, corner: tuple[float, float]
) -> None:
    flying.sight.route = path((0, 0), corner, (30, 40))
    answer = await move(flying, 30, 40)
    assert not answer.accepted
    assert "fence" in answer.reason
    flying.expect(S.HOVER)


async def test_a_route_that_begins_beyond_the_fence_from_here_is_refused(flying: Rig) -> None:
    flying.autopilot.north = 100.0
    await flying.tick()
    flying.sight.route = path((0, 0), (-190, 0), (30, 40))
    assert not (await move(flying, 30, 40)).accepted


async def test_a_route_that_is_cut_off_in_flight_holds_and_says_why(flying: Rig) -> None:
    flying.sight.route = AROUND
    await move(flying, 30, 40)
    await flying.run(3)
    flying.sight.route = Route(refused="no path over known lot leads there")
    await flying.tick(2)
    flying.expect(S.HOVER)
    assert flying.manager.outcomes.user_error is UserError.DESIRED_LOCATION_OUT_OF_BOUNDS
    assert any("no path over known lot leads there" in text for text in flying.log)
    before = (flying.autopilot.north, flying.autopilot.east)
    await flying.run(5)
    assert abs(flying.autopilot.north - before[0]) < 12
    assert flying.topics.des_pose_pub.value is None


@pytest.mark.nightly
async def test_a_new_route_is_flown_from_where_the_drone_is_and_reported(flying: Rig) -> None:
    flying.sight.route = AROUND
    await move(flying, 30, 40)
    await flying.run(3)
    north = flying.autopilot.north
    assert 3 < north < 20
    flying.sight.route = path((north, 0), (north, 40), (30, 40))
    await flying.run(4)
    assert abs(flying.autopilot.north - north) < 2.0
    assert flying.autopilot.east > 5
    assert any("Another route" in text for text in flying.log)
    await flying.until(S.HOVER)
    assert "There. Holding." in flying.log


@pytest.mark.slow
async def test_a_refused_new_target_reports_nothing_of_a_changed_map(flying: Rig) -> None:
    await move(flying, 60, 0)
    await flying.run(2)
    flying.sight.inbound = Inbound.OUTSIDE
    assert not (await move(flying, -30, 0)).accepted
    flying.sight.inbound = Inbound.INSIDE
    await flying.run(2)
    flying.expect(S.AUTONOMOUS_MOVE)
    assert not any("Another route" in text for text in flying.log)


async def test_the_status_has_the_distance_that_is_left(flying: Rig) -> None:
    status = flying.manager.status
    assert status.value is not None
    assert not status.value.travel.route
    flying.sight.route = AROUND
    await move(flying, 30, 40)
    await flying.run(2)
    route = tuple(MapPoint(point.north, point.east) for point in status.value.travel.route)
    assert route[0].distance(MapPoint(flying.autopilot.north, flying.autopilot.east)) < 2.0
    assert route[1:] == AROUND.points[1:]
    flying.order(Hold())
    await flying.run(0.4)
    assert status.value.travel.route == ()


# -- the route asked for before ---------------------------------------------------------------------------------------


async def ask(rig: Rig, request: RouteRequest, client: str = "ana") -> RouteAnswer:
    assert rig.manager.handle(client, request) is None
    for _ in range(40):
        if rig.socket.replies:
            break
        await rig.tick()
    to, answer = rig.socket.replies.pop(0)
    assert to == client
    assert isinstance(answer, RouteAnswer)
    return answer


async def test_the_route_is_reported_and_nothing_is_flown(flying: Rig) -> None:
    flying.sight.route = AROUND
    answer = await ask(flying, RouteRequest(id=7, x=30, y=40, frame="Map"))
    assert answer.id == 7
    assert [(p.north, p.east) for p in answer.points] == [(0, 0), (30, 0), (30, 40)]
    assert (answer.length, answer.refused) == (70.0, None)
    flying.expect(S.HOVER)
    assert flying.topics.des_pose_pub.value is None
    await flying.run(1)
    assert flying.topics.asked_place_pub.value is None
    flying.expect(S.HOVER)


async def test_who_only_watches_may_ask(flying: Rig) -> None:
    answer = await ask(flying, RouteRequest(x=5, y=5), client="eve")
    assert answer.refused is None
    assert (answer.points[1].north, answer.points[1].east) == (5, 5)


@pytest.mark.parametrize(
    ("inbound", "words"),
    [(Inbound.OUTSIDE, "outside the lot"), (Inbound.UNKNOWN, "nobody has seen"), (None, "could not be found")],
)
async def test_the_reason_of_no_route_is_reported_without_a_user_error(
    flying: Rig, inbound: Inbound | None, words: str
) -> None:
    flying.sight.inbound = inbound
    answer = await ask(flying, RouteRequest(x=5, y=5))
    assert answer.refused is not None
    assert words in answer.refused
    assert (answer.points, answer.length) == ([], None)
    assert flying.manager.outcomes.user_error is UserError.NONE


async def test_a_place_outside_the_fence_is_reported_at_once(flying: Rig) -> None:
    answer = await ask(flying, RouteRequest(x=900, y=0))
    assert answer.refused is not None
    assert "fence" in answer.refused


@pytest.mark.nightly
async def test_it_is_reported_while_another_place_is_flown_to(flying: Rig) -> None:
    await move(flying, 60, 0)
    flying.socket.replies.clear()
    answer = await ask(flying, RouteRequest(x=-20, y=10, frame="Map"))
    assert answer.refused is None
    flying.expect(S.AUTONOMOUS_MOVE)
    await flying.until(S.HOVER)
    assert "There. Holding." in flying.log


async def test_many_may_ask_and_each_gets_an_answer(flying: Rig) -> None:
    for n in range(12):
        flying.manager.handle(f"client {n % 6}", RouteRequest(id=n, x=n, y=1, frame="Map"))
    await flying.run(3)
    answers = {a.id: a for _, a in flying.socket.replies if isinstance(a, RouteAnswer)}
    assert set(answers) == set(range(12))
    assert all(answers[n].refused is None for n in range(6, 12))
    assert all(answers[n].refused == "You asked for another route since." for n in range(6))


async def test_a_crowd_is_refused_politely(flying: Rig) -> None:
    for n in range(12):
        flying.manager.handle(f"client {n}", RouteRequest(id=n, x=n, y=1, frame="Map"))
    await flying.run(3)
    refused = [a for _, a in flying.socket.replies if isinstance(a, RouteAnswer) and a.refused is not None]
    assert len(flying.socket.replies) == 12
    assert len(refused) == 4


async def test_on_the_ground_it_is_refused(rig: Rig) -> None:
    await rig.run(1.5)
    answer = await ask(rig, RouteRequest(x=5, y=5))
    assert answer.refused is not None
