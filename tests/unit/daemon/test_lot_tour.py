"""The tour over a lot that is surveyed again, planned beside the flight from what the store knows."""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest

from hawk.daemon.known_lot import KnownLotFollower
from hawk.daemon.lot_tour import Surroundings, TourKeeper
from hawk.ddc.fence.geometry import polygon_fence, to_map
from hawk.lots.saving import save
from hawk.lots.store import LotStore
from hawk.model.known_lot import LotsAhead
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import Fence, HeightParameters
from hawk.model.poses import GlobalPose, Ring
from tests.unit.algo.synthetic import CAMERA
from tests.unit.lots.surveys import DATUM, survey

RING: Ring = ((-150.0, -150.0), (150.0, -150.0), (150.0, 150.0), (-150.0, 150.0))
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
    said: list[LotsAhead] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.store = LotStore(self.path)
        self.tours = TourKeeper(
            Surroundings(
                asked=lambda: self.asked,
                here=lambda: self.here,
                camera=lambda: self.camera,
                heights=lambda: HeightParameters(15.0, 35.0, 60.0),
                fence=lambda _datum, _place: self.fence,
                state=lambda: self.state,
                publish=self.said.append,
            )
        )
        self.follower = KnownLotFollower(
            self.store, lambda: self.datum, lambda: "another", lambda *_: None, tours=self.tours
        )

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


async def test_the_flight_over_the_asked_lot_is_planned_before_the_start_and_its_length_said(drone: Drone) -> None:
    drone.asked = await drone.store_survey()
    await drone.follower.look()
    tour = drone.tours.current
    assert tour is not None
    assert tour.lot == drone.asked
    assert drone.said[-1].tour_m == round(tour.distance_m, 1) > 0.0
    await drone.follower.look()
    assert drone.tours.current is tour


async def test_a_drone_elsewhere_gets_another_tour_unless_it_flies_it(drone: Drone) -> None:
    drone.asked = await drone.store_survey()
    drone.datum = DATUM
    await drone.follower.look()
    before = drone.tours.current
    drone.here, drone.state = GlobalPose(DATUM.latitude + 5e-4, DATUM.longitude, 0.0), StateName.AUTONOMOUS_EXPLORE
    await drone.follower.look()
    assert drone.tours.current is before
    drone.state = StateName.HOVER
    await drone.follower.look()
    after = drone.tours.current
    assert after is not None
    assert after is not before
    assert after.points[0].north == pytest.approx(to_map(DATUM, drone.here.latitude, drone.here.longitude).north)


async def test_without_a_camera_or_a_place_no_tour_is_planned(drone: Drone) -> None:
    drone.asked, drone.camera = await drone.store_survey(), None
    await drone.follower.look()
    assert drone.tours.current is None
    drone.camera, drone.datum, drone.here = CAMERA, DATUM, None
    await drone.follower.look()
    assert drone.tours.current is None


async def test_a_tour_ends_when_the_lot_is_no_longer_asked_for(drone: Drone) -> None:
    drone.asked = await drone.store_survey()
    await drone.follower.look()
    drone.asked = ""
    await drone.follower.look()
    assert drone.tours.current is None
    assert drone.said[-1].tour_m is None


async def test_a_store_that_cannot_be_read_is_said_and_the_tour_stays(drone: Drone) -> None:
    drone.asked = await drone.store_survey()
    await drone.follower.look()
    tour = drone.tours.current
    drone.tours.fail("lots.db: is damaged")
    assert drone.said[-1].problem == "lots.db: is damaged"
    assert drone.tours.current is tour
    assert replace(drone.said[-1], problem="") == drone.said[0]
