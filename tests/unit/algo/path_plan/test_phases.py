from __future__ import annotations

from dataclasses import replace

import numpy as np

from hawk.algo.ground import Floats, Place, Window
from hawk.algo.path_plan.explore import Explorer
from hawk.algo.path_plan.field import InformationField
from hawk.algo.path_plan.footprint import Footprint
from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.algo.path_plan.overview import ExploreScene, GroundPart, Overview, near_tiles, with_margin
from hawk.algo.path_plan.phases import BorderPath, GivenUp, LookAround, SecondLooks, Turns
from hawk.algo.path_plan.settings import PathPlanSettings

SETTINGS = PathPlanSettings()
EXTENT: Floats = np.array([[-40.0, -40.0], [40.0, 40.0]])


def scene(
    place: Place = (0.0, 0.0),
    *,
    well: float = 0.0,
    unclear: dict[int, Place] | None = None,
    spun: float = 20.0,
    is_small: bool = False,
) -> ExploreScene:
    """All ground is known lot, and the share ``well`` of it was seen well; the drone may be everywhere."""
    overview = Overview()
    tiles = near_tiles(overview.whole(EXTENT), place)
    window: Window = with_margin(tiles)
    ones, free = np.ones(window.shape, np.float32), np.ones(window.shape, np.uint8)
    field = InformationField(window, ones * 0, free, free, ones, ones * np.float32(well), ones)
    part = GroundPart(tiles, field)
    overview.take(part, ones)
    scouting = field if is_small else None
    foot = Footprint(40.0, 24.0, 19.0, spun)
    return ExploreScene(part, None, overview, place, 0.0, 0.0, foot, FenceGuard(None), unclear or {}, scouting)


def test_a_turn_is_made_once_a_place_where_the_exploration_begins_and_its_tour_ends() -> None:
    turns = Turns(SETTINGS)
    first = turns.present(scene(), ())
    assert first is not None
    assert turns.present(scene((1.0, 0.0)), ()) is first
    turns.end()
    assert turns.present(scene(), ()) is None
    assert turns.present(scene((50.0, 0.0)), ((51.0, 0.0), (90.0, 0.0))) is None
    last = turns.present(scene((50.0, 0.0)), ((51.0, 0.0),))
    assert last is not None
    assert last.place == (51.0, 0.0)


def test_a_picture_that_turning_does_not_widen_is_not_turned() -> None:
    assert Turns(SETTINGS).present(scene(spun=0.0), ()) is None


def test_looking_around_ends_when_it_shows_lot_or_costs_too_much_or_the_lot_has_grown() -> None:
    around = LookAround(SETTINGS)
    assert not around.may_begin(scene())
    assert around.may_begin(scene(is_small=True))
    around.begin((0.0, 0.0), 10.0)
    assert not around.is_over(scene((50.0, 0.0), is_small=True), 10.0)
    assert around.is_over(scene((50.0, 0.0), is_small=True), 11.0 + SETTINGS.least_gain_m2)
    assert around.is_over(scene((50.0, 0.0)), 10.0)
    assert around.may_begin(scene(is_small=True))
    assert around.is_over(scene((50.0, SETTINGS.scout_path_m), is_small=True), 10.0)
    assert not around.may_begin(scene(is_small=True))


def test_looking_around_that_has_come_to_its_end_is_not_begun_again() -> None:
    around = LookAround(SETTINGS)
    around.finish()
    assert not around.may_begin(scene(is_small=True))


def test_unclear_stalls_are_flown_to_once_the_nearest_first() -> None:
    looks = SecondLooks(SETTINGS)
    stalls: dict[int, Place] = {1: (60.0, 0.0), 2: (20.0, 0.0), 3: (24.0, 0.0)}
    assert looks.route(scene(unclear=stalls)) == ((20.0, 0.0),)
    assert looks.route(scene((15.0, 0.0), unclear=stalls)) == ()
    assert looks.route(scene((15.0, 0.0), unclear=stalls)) == ((24.0, 0.0),)
    assert looks.route(scene((24.0, 0.0), unclear=stalls)) == ()
    assert looks.route(scene((24.0, 0.0), unclear=stalls)) == ((60.0, 0.0),)
    assert looks.route(scene((24.0, 0.0), unclear={})) == ()
    assert looks.route(scene((24.0, 0.0), unclear=stalls)) == ()


def test_a_place_that_shows_nothing_new_is_given_up_after_some_plans() -> None:
    given_up = GivenUp(SETTINGS)
    assert not any(given_up.learns_nothing(scene(well=0.5)) for _ in range(SETTINGS.idle_plans + 1))
    assert given_up.learns_nothing(scene(well=0.5))
    assert not given_up.learns_nothing(scene(well=0.6))


def test_a_path_that_shows_nothing_new_is_given_up_after_some_metres() -> None:
    given_up = GivenUp(SETTINGS)
    steps = round(SETTINGS.idle_path_m / 10.0)
    assert not any(given_up.learns_nothing(scene((10.0 * step, 0.0))) for step in range(steps + 1))
    assert given_up.learns_nothing(scene((10.0 * (steps + 1), 0.0)))


def test_ground_about_a_place_that_was_given_up_is_wanted_no_more_and_no_waypoint() -> None:
    given_up, before = GivenUp(SETTINGS), scene(is_small=True)
    assert given_up.without(before) is before
    given_up.add((0.0, 0.0))
    once = given_up.without(before)
    assert not once.are_allowed(np.array([[0.0, 0.0]]))[0]
    assert once.scouting is not None
    assert once.scouting.lot.sum() == once.field.lot.sum() < before.field.lot.sum()
    given_up.add((0.0, 0.0))
    assert given_up.without(before).field.lot.sum() < once.field.lot.sum()


def test_the_path_for_looking_beyond_the_border_is_a_share_of_what_was_flown_until_lot_was_found() -> None:
    path, known = BorderPath(SETTINGS), scene((-300.0, 0.0))
    longest = SETTINGS.beyond_path_m
    assert path.is_left(known, is_beyond=False)
    assert path.is_left(replace(known, place=(0.0, 0.0)), is_beyond=False), "path for the lot itself does not count"
    assert path.is_left(replace(known, place=(longest - 1.0, 0.0)), is_beyond=True)
    assert not path.is_left(replace(known, place=(longest + 1.0, 0.0)), is_beyond=True)
    more = scene((longest + 1.0, 0.0))
    tiles = more.overview.whole(2 * EXTENT)
    window = with_margin(tiles)
    ones, free = np.ones(window.shape, np.float32), np.ones(window.shape, np.uint8)
    more.overview.take(GroundPart(tiles, InformationField(window, ones * 0, free, free, ones, ones, ones)), ones)
    assert more.overview.lot_m2 > known.overview.lot_m2
    assert path.is_left(more, is_beyond=True), "lot that is found gives it back"
    longer = longest + SETTINGS.beyond_path_share * (300.0 + longest + 1.0)
    assert path.is_left(replace(more, place=(longest + longer, 0.0)), is_beyond=True)
    assert not path.is_left(replace(more, place=(longest + longer + 2.0, 0.0)), is_beyond=True)


def test_lot_that_looks_beyond_the_border_found_is_seen_before_they_go_on() -> None:
    """All known lot was seen; half of it is new; it was seen as well."""
    explorer, beyond = Explorer(SETTINGS), []
    for well in (1.0, 1.0, 0.5, 1.0):
        explorer.plan(scene(well=well))
        beyond.append(explorer.looks_beyond)
    assert beyond == [True, True, False, True]
