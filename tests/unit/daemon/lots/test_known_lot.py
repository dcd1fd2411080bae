from __future__ import annotations

import asyncio
import contextlib
from pathlib import Path

import pytest

from hawk.daemon.lots.known_lot import KnownLotFollower
from hawk.lots.ingest import save
from hawk.lots.plan import edits
from hawk.lots.store import LotStore
from hawk.model.poses import GlobalPose
from tests.unit.comm.waiting import until
from tests.unit.lots import whole
from tests.unit.lots.sections.test_flown_sections import make_lot
from tests.unit.lots.surveys import BEGAN, DATUM, survey

LOOK_S = 0.01


class Drone:
    def __init__(self, path: Path) -> None:
        self.datum: GlobalPose | None = None
        self.messages: list[tuple[str, str, str]] = []
        self.store = LotStore(path)
        self.survey = "000009-another"
        self.follower = KnownLotFollower(self.store, lambda: self.datum, lambda: self.survey, self.add, LOOK_S)

    def add(self, level: str, text: str, details: str) -> None:
        self.messages.append((level, text, details))

    async def store_survey(self) -> str:
        saved = await self.store.write(lambda c: save(c, survey(), None))
        assert saved.lot is not None
        return saved.lot

    async def confirm_all(self, lot: str) -> None:
        opened = await self.store.write(lambda c: edits.open_edit(c, lot, {"who": "Ann"}, BEGAN))
        asked = {"edit": opened.edit, "operation": {"do": "confirm", "all": True}}
        await self.store.write(lambda c: edits.do(c, lot, asked, BEGAN))


@pytest.fixture
async def drone(tmp_path: Path):  # type: ignore[no-untyped-def]
    made = Drone(tmp_path / "lots.db")
    yield made
    await made.store.close()


async def test_before_the_drone_was_armed_no_lot_is_known(drone: Drone) -> None:
    await drone.store_survey()
    await drone.follower.look()
    assert drone.follower.current == ()


@pytest.mark.slow
async def test_the_lot_at_which_the_drone_was_armed_is_known_and_named(drone: Drone) -> None:
    lot = await drone.store_survey()
    drone.datum = DATUM
    await drone.follower.look()
    (known,) = drone.follower.current
    assert known.id == lot
    assert len(known.stalls) == 40
    assert [text for _, text, _ in drone.messages] == ["This is Lot 1: its plan is known."]
    assert drone.messages[0][2] == "0 of 40 stalls are confirmed."


async def test_a_plan_that_did_not_change_stays_the_same_object(drone: Drone) -> None:
    await drone.store_survey()
    drone.datum = DATUM
    await drone.follower.look()
    before = drone.follower.current
    await drone.follower.look()
    assert drone.follower.current is before
    assert len(drone.messages) == 1


@pytest.mark.slow
async def test_a_survey_that_goes_on_is_no_witness_of_itself_but_for_what_a_person_confirmed(drone: Drone) -> None:
    lot = await drone.store_survey()
    drone.datum, drone.survey = DATUM, survey().name
    await drone.follower.look()
    before = drone.follower.current
    await drone.confirm_all(lot)
    await drone.follower.look()
    (after,) = drone.follower.current
    assert before == ()
    assert len(after.stalls) == 40


@pytest.mark.slow
async def test_a_correction_in_flight_is_known_soon(drone: Drone) -> None:
    lot = await drone.store_survey()
    drone.datum = DATUM
    task = asyncio.create_task(drone.follower.run())
    await until(lambda: bool(drone.follower.current))
    await drone.confirm_all(lot)
    await until(lambda: bool(drone.follower.current) and drone.follower.current[0].stalls[0].is_confirmed)
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task


async def test_a_lot_farther_off_is_not_this_one(drone: Drone) -> None:
    await drone.store_survey()
    drone.datum = GlobalPose(DATUM.latitude + 0.002, DATUM.longitude, 0.0)
    await drone.follower.look()
    assert drone.follower.current == ()
    assert drone.messages == []


async def test_a_store_that_nobody_has_opened_is_not_opened_in_flight(drone: Drone) -> None:
    drone.datum = DATUM
    await drone.follower.look()
    assert not drone.store.is_open
    assert drone.follower.current == ()


@pytest.mark.slow
async def test_a_store_that_cannot_be_read_leaves_the_plan_as_it_was(drone: Drone) -> None:
    await drone.store_survey()
    drone.datum = DATUM
    await drone.follower.look()
    before = drone.follower.current
    drone.store.path.write_bytes(b"no database")
    await drone.follower.look()
    assert drone.follower.current is before


@pytest.mark.slow
async def test_the_plan_lies_where_the_receiver_places_it(drone: Drone) -> None:
    await drone.store_survey()
    drone.datum = GlobalPose(DATUM.latitude + 10 / 111_200, DATUM.longitude, 0.0)
    await drone.follower.look()
    (plan,) = drone.follower.current
    shown = await drone.store.read(lambda c: whole.stalls(c, plan.id))
    off = [known.north - stall["north"] for known, stall in zip(plan.stalls, shown, strict=True)]
    assert off == pytest.approx([-10.0] * 40, abs=0.05)


async def test_it_looks_at_once_when_it_is_woken(tmp_path: Path) -> None:
    drone = Drone(tmp_path / "lots.db")
    patient = KnownLotFollower(drone.store, lambda: drone.datum, lambda: drone.survey, drone.add, look_s=3600.0)
    running = asyncio.create_task(patient.run())
    await drone.store_survey()
    drone.datum = DATUM
    patient.wake()
    await until(lambda: bool(patient.current))
    running.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await running
    await drone.store.close()


async def test_private_ground_is_known_of_a_lot_without_stalls_too_and_at_once_when_it_is_drawn(drone: Drone) -> None:
    """It steers nothing: it is no offer."""
    lot = await drone.store.write(make_lot)
    drone.datum = DATUM
    await drone.follower.look()
    assert (drone.follower.lots, drone.follower.current, drone.follower.private) == ((lot,), (), ())
    opened = await drone.store.write(lambda c: edits.open_edit(c, lot, {"who": "Ann"}, BEGAN))
    asked = {"do": "forbid", "outline": [[-9, 2], [-9, 9], [-2, 9]], "private": True}
    await drone.store.write(lambda c: edits.do(c, lot, {"edit": opened.edit, "operation": asked}, BEGAN))
    await drone.follower.look()
    (ring,) = drone.follower.private
    assert min(north for north, _ in ring) == pytest.approx(-14.0, abs=3.0)
    drone.datum = GlobalPose(DATUM.latitude + 0.1, DATUM.longitude, 0.0)
    await drone.follower.look()
    assert (drone.follower.lots, drone.follower.private) == ((), ())
