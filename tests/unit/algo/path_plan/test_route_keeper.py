from __future__ import annotations

import numpy as np
import shapely

from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.algo.path_plan.lot_route import NO_LOT_THERE, NO_ROUTE, RouteKeeper
from hawk.model.plans import DesiredPose, Route
from hawk.model.poses import MapPoint
from tests.unit.algo.path_plan.lots import DrawnLot, fence_of, line_of, place_in

GOAL = place_in(5, 55)


class Rig:
    def __init__(self) -> None:
        self.lot = DrawnLot(np.ones((40, 60), np.bool_))
        self.keeper = RouteKeeper(10.0)
        self.guard = FenceGuard(None)

    def at(self, row: float, column: float, number: int = 1) -> Route:
        return self.keeper.route(self.lot, self.guard, place_in(row, column), DesiredPose(number, *GOAL))


def test_while_nothing_changes_it_is_the_very_route() -> None:
    rig = Rig()
    first = rig.at(5, 2)
    assert first.points == (MapPoint(*place_in(5, 2)), MapPoint(*GOAL))
    assert all(rig.at(5 + 0.5 * (i % 2), 2 + i) is first for i in range(50))


def test_ground_that_turns_out_not_to_be_lot_is_flown_around() -> None:
    rig = Rig()
    first = rig.at(5, 2)
    rig.at(5, 10)
    rig.lot.lot[0:20, 30] = False
    second = rig.at(5, 10)
    assert second != first
    assert second.points[0] == MapPoint(*place_in(5, 10))
    assert shapely.covers(rig.lot.area(), line_of(second.points))


def test_what_lies_behind_the_drone_is_nothing_to_it() -> None:
    rig = Rig()
    first = rig.at(5, 2)
    rig.at(5, 30)
    rig.lot.lot[:, 20] = False
    assert rig.at(5, 31) is first


def test_a_route_that_is_cut_off_is_refused_and_found_again_when_it_opens() -> None:
    rig = Rig()
    rig.at(5, 2)
    rig.lot.lot[:, 30] = False
    assert rig.at(5, 10) == Route(refused=NO_ROUTE)
    rig.lot.lot[35, 30] = True
    assert rig.at(5, 10).refused == ""


def test_a_place_that_is_lot_no_longer_is_refused() -> None:
    rig = Rig()
    rig.at(5, 2)
    rig.lot.lot[:12, 48:] = False
    assert rig.at(5, 10) == Route(refused=NO_LOT_THERE)


def test_a_drone_that_was_blown_off_gets_a_route_from_where_it_is() -> None:
    rig = Rig()
    first = rig.at(5, 2)
    assert rig.at(9, 20) is first
    assert rig.at(11, 20).points[0] == MapPoint(*place_in(11, 20))


def test_a_fence_drawn_closer_counts_at_once() -> None:
    rig = Rig()
    rig.at(20, 2)
    rig.guard = FenceGuard(fence_of(-5, -5, 45, 40))
    assert rig.at(20, 2) == Route(refused=NO_LOT_THERE)


def test_another_number_is_another_question() -> None:
    rig = Rig()
    rig.at(5, 2)
    assert rig.at(5, 10, number=2).points[0] == MapPoint(*place_in(5, 10))


def test_a_new_search_costs_the_rest_of_the_route() -> None:
    rig = Rig()
    rig.lot = DrawnLot(np.ones((600, 600), np.bool_))
    rig.at(5, 2)
    rig.lot.asked = 0
    rig.at(5, 3)
    far = rig.lot.asked
    rig.lot.asked = 0
    rig.at(5, 45)
    assert rig.lot.asked < far < 2500
