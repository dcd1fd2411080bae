from __future__ import annotations

from hawk.model.lot_map import Counts, OccupancyMap, Stall, StallState
from hawk.picture.cars import LEAST, suggest_lone_cars

FREE, TAKEN, SUGGESTED = StallState.FREE, StallState.TAKEN, StallState.SUGGESTED


def _map(*rows: tuple[float, str]) -> OccupancyMap:
    """Return rows of stalls at places to the east, a letter each: f free, t taken."""
    stalls: dict[int, Stall] = {}
    for north, (east, letters) in enumerate(rows):
        for k, letter in enumerate(letters):
            number = len(stalls) + 1
            state = FREE if letter == "f" else TAKEN
            stalls[number] = Stall(
                number,
                40.0 * north,
                east + 2.6 * k,
                0.0,
                2.6,
                5.2,
                0.1 if state is FREE else 0.9,
                state,
                0.95,
                3,
                0.0,
                1,
            )
    states = [stall.state for stall in stalls.values()]
    return OccupancyMap(stalls=stalls, counts=Counts(states.count(FREE), states.count(TAKEN), 0, 1.0, 0))


def _states(found: OccupancyMap) -> list[StallState]:
    return [stall.state for _, stall in sorted(found.stalls.items())]


def test_a_few_cars_alone_are_suggestions() -> None:
    found = suggest_lone_cars(_map((0.0, "t" * (LEAST - 1))))
    assert _states(found) == [SUGGESTED] * (LEAST - 1)
    assert (found.counts.taken, found.counts.suggested, found.counts.free_variance) == (0, LEAST - 1, 0.0)


def test_a_row_of_cars_is_a_row_of_stalls() -> None:
    given = _map((0.0, "t" * LEAST))
    assert suggest_lone_cars(given) is given


def test_cars_beside_a_free_stall_stand_on_stalls() -> None:
    given = _map((0.0, "tft"))
    assert suggest_lone_cars(given) is given


def test_a_free_place_at_the_end_of_a_few_cars_is_what_any_cars_suggest() -> None:
    found = suggest_lone_cars(_map((0.0, "tttf")))
    assert _states(found) == [SUGGESTED] * 4
    assert (found.counts.free, found.counts.taken, found.counts.suggested) == (0, 0, 4)


def test_two_free_stalls_are_marked_ones() -> None:
    given = _map((0.0, "ttff"))
    assert suggest_lone_cars(given) is given


def test_each_group_is_judged_alone() -> None:
    found = suggest_lone_cars(_map((0.0, "ttfftt"), (0.0, "tt")))
    assert _states(found) == [TAKEN, TAKEN, FREE, FREE, TAKEN, TAKEN, SUGGESTED, SUGGESTED]
    assert found.counts.taken == 4


def test_an_empty_map_stays() -> None:
    empty = OccupancyMap()
    assert suggest_lone_cars(empty) is empty
