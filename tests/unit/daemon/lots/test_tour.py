"""The tour over a lot that is surveyed again, planned beside the flight from what the store knows."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import cast

import pytest

from hawk.comm.autopilot.autopilot import MavsdkAutopilot
from hawk.comm.cameras.drone_camera import DroneCamera
from hawk.comm.protocol.commands import Land
from hawk.config.sections import FenceSettings
from hawk.daemon.lots.known_lot import KnownLotFollower
from hawk.daemon.lots.parts import surroundings
from hawk.daemon.lots.tour import Surroundings, TourKeeper
from hawk.ddc.fence.geometry import polygon_fence, to_map
from hawk.lots import commands
from hawk.lots.ingest import save
from hawk.lots.plan import edits
from hawk.lots.store import LotStore
from hawk.model.known_lot import KnownLot, LotsAhead, LotTour, PlanOffer
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import Fence, HeightParameters, RoundLot
from hawk.model.poses import GlobalPose, Ring
from tests.unit.algo.synthetic import CAMERA
from tests.unit.ddc.fakes import Rig
from tests.unit.lots.sections.test_flown_sections import KERB, make_lot
from tests.unit.lots.surveys import BEGAN, DATUM, box, survey

RING: Ring = ((-150.0, -150.0), (150.0, -150.0), (150.0, 150.0), (-150.0, 150.0))
FAR = replace(DATUM, latitude=DATUM.latitude + 1e-2)
FENCE = polygon_fence(RING, 5.0, 60.0, 3.0)


@dataclass
class Drone:
    path: Path
    asked: str = ""
    here: GlobalPose | None = DATUM
    datum: GlobalPose | None = None
    camera: CameraModel | None = CAMERA
    fence: Fence | None = FENCE
    state: StateName = StateName.IDLE
    flies: bool = False
    taken: str = ""
    more: tuple[RoundLot, ...] = ()
    minutes: int = 0
    said: list[LotsAhead] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.store = LotStore(self.path)
        self.tours = TourKeeper(
            Surroundings(
                asked=lambda: self.round_lots,
                here=lambda: self.here,
                camera=lambda: self.camera,
                heights=lambda: HeightParameters(15.0, 35.0, 60.0),
                fence=lambda _datum, _place: self.fence,
                state=lambda: self.state,
                publish=self.said.append,
                is_flying=lambda: self.flies,
                taken=lambda: self.taken,
            )
        )
        self.follower = KnownLotFollower(
            self.store,
            lambda: self.datum,
            lambda: "another",
            lambda _level, text, _details: self.messages.append(text),
            tours=self.tours,
        )

    @property
    def round_lots(self) -> tuple[RoundLot, ...]:
        """`asked` is one lot, "" none; ``more`` are others of the same round."""
        return (*((RoundLot(self.asked, "Lot 1"),) if self.asked else ()), *self.more)

    @property
    def plan(self) -> KnownLot:
        """The plan of the one lot that is flown."""
        (known,) = self.follower.current
        return known

    @property
    def tour(self) -> LotTour:
        """The tour over the one lot that is surveyed again."""
        (tour,) = self.tours.current
        return tour

    async def store_survey(self) -> str:
        saved = await self.store.write(lambda c: save(c, survey(), None))
        assert saved.lot is not None
        return saved.lot


@pytest.fixture
async def drone(tmp_path: Path) -> AsyncIterator[Drone]:
    made = Drone(tmp_path / "lots.db")
    yield made
    made.tours.close()
    await made.store.close()


async def test_the_lots_about_the_drone_are_known_before_it_is_armed(drone: Drone) -> None:
    lot = await drone.store_survey()
    await drone.follower.look()
    (ahead,) = drone.said[-1].lots
    assert (ahead.id, ahead.name, ahead.stalls) == (lot, "Lot 1", 40)
    assert ahead.away_m < 100.0
    assert len(ahead.outline.polygons) > 0
    assert drone.said[-1].tour_m is None


async def test_a_lot_that_is_far_away_has_its_distance_and_no_outline(drone: Drone) -> None:
    await drone.store_survey()
    drone.here = GlobalPose(DATUM.latitude + 0.01, DATUM.longitude, 0.0)
    await drone.follower.look()
    (ahead,) = drone.said[-1].lots
    assert ahead.away_m > 900.0
    assert ahead.outline.polygons == ()


@pytest.mark.nightly
async def test_the_flight_over_the_asked_lot_is_planned_before_the_start_and_its_length_said(drone: Drone) -> None:
    drone.asked = await drone.store_survey()
    await drone.follower.look()
    tour = drone.tour
    assert tour.lot == drone.asked
    assert drone.said[-1].tour_m == round(tour.distance_m, 1) > 0.0
    await drone.follower.look()
    assert drone.tour is tour


@pytest.mark.nightly
async def test_a_lot_of_sections_alone_has_a_tour_and_is_known_when_it_is_surveyed_again_alone(drone: Drone) -> None:
    lot = await drone.store.write(make_lot)
    opened = await drone.store.write(lambda c: edits.open_edit(c, lot, {"who": "Ann"}, BEGAN))
    asked = {"edit": opened.edit, "operation": {"do": "draw_section", "name": "Elm Street", **KERB}}
    await drone.store.write(lambda c: edits.do(c, lot, asked, BEGAN))
    drone.datum = DATUM
    await drone.follower.look()
    assert drone.follower.current == ()
    drone.asked = lot
    await drone.follower.look()
    assert (drone.plan.stalls, len(drone.plan.section_places) > 0) == ((), True)
    assert drone.said[-1].tour_m == round(drone.tour.distance_m, 1) > 0.0
    assert drone.messages == []


@pytest.mark.nightly
async def test_a_drone_elsewhere_gets_another_tour_unless_it_flies_it(drone: Drone) -> None:
    drone.asked = await drone.store_survey()
    drone.datum = DATUM
    await drone.follower.look()
    before = drone.tour
    drone.here, drone.state = GlobalPose(DATUM.latitude + 5e-4, DATUM.longitude, 0.0), StateName.AUTONOMOUS_EXPLORE
    await drone.follower.look()
    assert drone.tour is before
    drone.state = StateName.HOVER
    await drone.follower.look()
    after = drone.tour
    assert after is not before
    assert after.points[0].north == pytest.approx(to_map(DATUM, drone.here.latitude, drone.here.longitude).north)


@pytest.mark.slow
async def test_without_a_camera_or_a_place_no_tour_is_planned(drone: Drone) -> None:
    drone.asked, drone.camera = await drone.store_survey(), None
    await drone.follower.look()
    assert drone.tours.current == ()
    drone.camera, drone.datum, drone.here = CAMERA, DATUM, None
    await drone.follower.look()
    assert drone.tours.current == ()


@pytest.mark.nightly
async def test_a_tour_ends_when_the_lot_is_no_longer_asked_for(drone: Drone) -> None:
    drone.asked = await drone.store_survey()
    await drone.follower.look()
    drone.asked = ""
    await drone.follower.look()
    assert drone.tours.current == ()
    assert drone.said[-1].tour_m is None


@pytest.mark.slow
async def test_a_store_that_cannot_be_read_is_said_and_the_tour_stays(drone: Drone) -> None:
    drone.asked = await drone.store_survey()
    await drone.follower.look()
    tours = drone.tours.current
    drone.tours.fail("lots.db: is damaged")
    assert drone.said[-1].problem == "lots.db: is damaged"
    assert drone.tours.current is tours
    assert replace(drone.said[-1], problem="") == drone.said[0]


# -- in flight --------------------------------------------------------------------------------------------------------


async def in_flight(drone: Drone) -> tuple[KnownLot, LotTour]:
    """Fly Survey again; return the plan and tour that the flight began with."""
    drone.asked, drone.datum = await drone.store_survey(), DATUM
    await drone.follower.look()
    drone.flies, drone.state = True, StateName.AUTONOMOUS_EXPLORE
    await drone.follower.look()
    return drone.plan, drone.tour


def offered(drone: Drone) -> PlanOffer | None:
    return drone.said[-1].offer


async def second_lot(drone: Drone, place: GlobalPose = FAR) -> str:
    """Store another lot; the usual place is 1.1 km north of the first one."""
    found = survey("000002-20260505T103000Z")
    outline, seen = box(-30, -3, 30, 40, place), box(-40, -15, 60, 60, place)
    there = replace(found, datum=place, outline=outline, seen_ground=seen, beside=())
    saved = await drone.store.write(lambda c: save(c, there, None))
    assert saved.lot is not None
    return saved.lot


async def add_row(drone: Drone, who: str = "Operator 2") -> None:
    """Draw a row 60 m beside the lot, as a client without control does over HTTP."""
    row = {"do": "add_row", "front": [[90.0, -20.0], [90.0, 5.0]], "far": [95.0, 0.0], "count": 10}
    await edited(drone, row, who)


async def edited(drone: Drone, operation: dict[str, object], who: str) -> None:
    lot = drone.asked
    opened = await drone.store.write(lambda c: edits.open_edit(c, lot, {"who": who, "take_over": True}, BEGAN))
    asked = {"edit": opened.edit, "operation": operation}
    drone.minutes += 1
    await drone.store.write(lambda c: edits.do(c, lot, asked, BEGAN + 60.0 * drone.minutes))


async def pinned(drone: Drone) -> None:
    points = [{"from": [DATUM.latitude, DATUM.longitude], "to": [DATUM.latitude + 2e-4, DATUM.longitude]}]
    await drone.store.write(lambda c: commands.pin(c, drone.asked, {"points": points}, "operator", BEGAN + 2.0))


async def split(drone: Drone) -> None:
    half = [
        [DATUM.latitude + a * 1e-3, DATUM.longitude + b * 1e-3] for a, b in ((-9, -9), (9, -9), (9, 0.1), (-9, 0.1))
    ]
    asked = {"outline": half, "name": "Half"}
    await drone.store.write(lambda c: commands.split(c, drone.asked, asked, "operator", BEGAN + 2.0))


async def ended(drone: Drone) -> None:
    await edited(drone, {"do": "remove", "all": True}, "Operator 2")


async def merged(drone: Drone) -> None:
    other = await second_lot(drone)
    await drone.store.write(lambda c: commands.merge(c, other, drone.asked, "operator", BEGAN + 2.0))


CHANGES = [add_row, pinned, split, ended, merged]


@pytest.mark.slow
@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
async def test_who_changes_the_store_in_flight_steers_nothing(
    drone: Drone, change: Callable[[Drone], Awaitable[None]]
) -> None:
    known, tour = await in_flight(drone)
    await change(drone)
    for _ in range(2):
        await drone.follower.look()
        assert drone.plan is known
        assert drone.tour is tour
    assert drone.said[-1].tour_m == round(tour.distance_m, 1)
    assert len([text for text in drone.messages if "changed" in text]) == 1


@pytest.mark.nightly
async def test_a_changed_plan_is_offered_with_its_author_and_flown_when_it_was_taken(drone: Drone) -> None:
    known, tour = await in_flight(drone)
    assert offered(drone) is None
    await add_row(drone)
    await drone.follower.look()
    offer = offered(drone)
    assert offer is not None
    assert replace(offer, id="") == PlanOffer("", "Lot 1", "Operator 2", 50, 40)
    assert drone.messages[-1] == "The plan of Lot 1 was changed, signed as Operator 2."
    drone.taken = "another one"
    await drone.follower.look()
    assert drone.plan is known
    drone.taken = offer.id
    await drone.follower.look()
    assert len(drone.plan.stalls) == 50
    assert drone.tour.distance_m > tour.distance_m + 40.0
    assert offered(drone) is None


@pytest.mark.slow
async def test_what_was_looked_at_is_flown_and_a_later_change_is_offered_next(drone: Drone) -> None:
    await in_flight(drone)
    await add_row(drone)
    await drone.follower.look()
    offer = offered(drone)
    assert offer is not None
    await edited(drone, {"do": "remove", "row": "A"}, "Ann")
    drone.taken = offer.id
    await drone.follower.look()
    assert len(drone.plan.stalls) == 50
    later = offered(drone)
    assert later is not None
    assert (later.by, later.before) == ("Ann", 50)
    assert later.stalls < 50


@pytest.mark.slow
async def test_a_change_that_was_taken_back_and_new_labels_ask_nothing(drone: Drone) -> None:
    known, _ = await in_flight(drone)
    await add_row(drone)
    await drone.follower.look()
    opened = await drone.store.write(lambda c: edits.open_edit(c, drone.asked, {"who": "Operator 2"}, BEGAN))
    await drone.store.write(lambda c: edits.undo(c, drone.asked, {"edit": opened.edit}, BEGAN))
    await drone.follower.look()
    assert offered(drone) is None
    assert drone.plan is known


@pytest.mark.nightly
async def test_after_the_flight_the_newest_plan_is_there(drone: Drone) -> None:
    await in_flight(drone)
    await add_row(drone)
    await drone.follower.look()
    drone.flies, drone.state = False, StateName.IDLE
    await drone.follower.look()
    assert len(drone.plan.stalls) == 50
    assert offered(drone) is None


@pytest.mark.nightly
async def test_another_lot_that_who_has_control_chooses_in_flight_is_flown_as_it_is(drone: Drone) -> None:
    known, _ = await in_flight(drone)
    drone.asked = other = await second_lot(drone)
    await drone.follower.look()
    assert drone.plan.id == other != known.id
    assert offered(drone) is None


@pytest.mark.slow
async def test_a_lot_that_is_made_under_a_drone_in_flight_waits_for_who_has_control(drone: Drone) -> None:
    await drone.store.open()
    drone.datum, drone.flies = DATUM, True
    await drone.follower.look()
    await drone.store_survey()
    await drone.follower.look()
    assert drone.follower.current == ()
    offer = offered(drone)
    assert offer is not None
    assert (offer.before, offer.stalls) == (0, 40)
    drone.taken = offer.id
    await drone.follower.look()
    assert len(drone.plan.stalls) == 40


@pytest.mark.nightly
async def test_a_changed_plan_is_offered_also_where_the_outline_or_the_asked_lot_changes(drone: Drone) -> None:
    """Clear Outline, Set Outline and Survey Again in flight take no plan that somebody else changed."""
    known, tour = await in_flight(drone)
    lot = drone.asked
    await add_row(drone)
    await drone.follower.look()
    drone.asked = ""  # Clear Outline, or Set Outline
    for _ in range(2):
        await drone.follower.look()
        assert drone.plan is known
        assert offered(drone) is not None
    drone.asked = lot  # Survey Again
    for _ in range(2):
        await drone.follower.look()
        assert drone.plan is known
    again, offer = drone.tour, offered(drone)
    assert again.distance_m == pytest.approx(tour.distance_m)
    assert offer is not None
    drone.taken = offer.id
    await drone.follower.look()
    assert len(drone.plan.stalls) == 50


# -- a round ----------------------------------------------------------------------------------------------------------


async def round_of_two(drone: Drone) -> tuple[str, str]:
    """Ask for a round over the first lot and one 120 m north of it; the second one comes first."""
    near = replace(DATUM, latitude=DATUM.latitude + 150.0 / 111_200)
    drone.fence = polygon_fence(tuple((2 * north, east) for north, east in RING), 5.0, 60.0, 3.0)
    one, two = await drone.store_survey(), await second_lot(drone, near)
    drone.asked, drone.more = one, (RoundLot(two, "Lot 2", is_first=True),)
    drone.datum = DATUM
    await drone.follower.look()
    return one, two


@pytest.mark.nightly
async def test_a_round_is_planned_over_all_its_lots_and_its_length_is_their_sum(drone: Drone) -> None:
    one, two = await round_of_two(drone)
    assert [lot.id for lot in drone.follower.current] == [one, two]
    assert [tour.lot for tour in drone.tours.current] == [two, one]
    assert drone.said[-1].tour_m == round(sum(tour.distance_m for tour in drone.tours.current), 1)
    assert [text for text in drone.messages if "is known" in text] == [
        "This is Lot 1: its plan is known.",
        "This is Lot 2: its plan is known.",
    ]


@pytest.mark.nightly
async def test_while_it_explores_the_tours_stay_and_after_a_swap_lots_that_are_over_are_left_out(drone: Drone) -> None:
    one, two = await round_of_two(drone)
    drone.state, drone.flies = StateName.AUTONOMOUS_EXPLORE, True
    flown = drone.tours.current
    drone.more = (replace(drone.more[0], is_over=True),)
    await drone.follower.look()
    assert drone.tours.current is flown
    drone.state, drone.flies = StateName.IDLE, False
    await drone.follower.look()
    assert [tour.lot for tour in drone.tours.current] == [one]
    assert [lot.id for lot in drone.follower.current] == [one, two], "its stalls stay on the map"


@pytest.mark.nightly
async def test_a_changed_plan_of_one_lot_of_a_round_is_offered_and_the_others_stay(drone: Drone) -> None:
    await round_of_two(drone)
    before = drone.follower.current
    drone.state, drone.flies = StateName.AUTONOMOUS_EXPLORE, True
    await drone.follower.look()
    await add_row(drone)
    await drone.follower.look()
    assert drone.follower.current is before
    offer = offered(drone)
    assert offer is not None
    assert (offer.lot, offer.before, offer.stalls) == ("Lot 1", 40, 50)
    drone.taken = offer.id
    await drone.follower.look()
    assert [len(lot.stalls) for lot in drone.follower.current] == [50, 40]
    assert drone.follower.current[1] is before[1]


@pytest.mark.slow
async def test_a_round_without_one_of_its_lots_is_not_planned(drone: Drone) -> None:
    await drone.store_survey()
    await drone.follower.look()
    lot = drone.said[-1].lots[0].id
    drone.asked, drone.more = lot, (RoundLot("gone", "Gone"),)
    await drone.follower.look()
    assert drone.tours.current == ()
    assert drone.said[-1].tour_m is None


@pytest.mark.slow
async def test_one_late_disarmed_thaws_no_plan(tmp_path: Path) -> None:
    flying = Rig(tmp_path)
    await flying.enter(StateName.HOVER)
    around = surroundings(
        cast(MavsdkAutopilot, flying.autopilot), cast(DroneCamera, None), flying.inputs, flying.topics,
        flying.manager, FenceSettings(),
    )  # fmt: skip
    assert around.is_flying()
    said = flying.topics.get_state()
    flying.topics.vehicle.state.publish(replace(said, armed=False))
    assert around.is_flying()
    await flying.tick()
    assert around.is_flying()
    flying.order(Land())
    await flying.until(StateName.IDLE)
    assert not around.is_flying()
    await flying.close()
