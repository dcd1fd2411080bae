"""The parts that keep lots: their store, the saving of surveys, and the plan that a flight knows."""

from __future__ import annotations

import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from hawk.comm.autopilot.autopilot import MavsdkAutopilot
from hawk.comm.cameras.drone_camera import DroneCamera
from hawk.config.sections import Config, FenceSettings
from hawk.daemon.lots.day_flights import DayDrone, DayPlanner, drone_of
from hawk.daemon.lots.flown_sections import SectionCounter
from hawk.daemon.lots.keeper import LotKeeper, find_stalls
from hawk.daemon.lots.known_lot import KnownLotFollower
from hawk.daemon.lots.schedule import Schedule, Timetable
from hawk.daemon.lots.tour import Surroundings, TourKeeper
from hawk.ddc.battery.survey import Battery
from hawk.ddc.fence.geometry import FenceError
from hawk.ddc.operations_manager import OperationsManager
from hawk.ddc.readings.topic_interface import DdcInputs, DdcTopicInterface
from hawk.lots.store import LotStore, lots_file
from hawk.lots.survey.landing import LandingFacts
from hawk.model.lot_map import OccupancyMap
from hawk.model.operation import Level, StateName
from hawk.model.plans import Fence
from hawk.model.poses import GlobalPose
from hawk.store.recordings import Recordings
from hawk.webhooks.documents import DocumentSender
from hawk.webhooks.sender import WebhookSender


@dataclass(frozen=True, slots=True)
class LotParts:
    """They share the store; none calls another."""

    store: LotStore
    keeper: LotKeeper
    known: KnownLotFollower
    tours: TourKeeper
    sections: SectionCounter
    webhooks: WebhookSender
    documents: DocumentSender
    timetable: Timetable
    schedule: Schedule
    days: DayPlanner

    @classmethod
    def create(
        cls,
        config: Config,
        landed: Callable[[], LandingFacts | None],
        datum: Callable[[], GlobalPose | None],
        survey: Callable[[], str],
        add_message: Callable[[Level, str, str], object],
        around: Surroundings,
        occupancy: Callable[[], OccupancyMap | None],
        recordings: Recordings,
        *,
        is_restored: bool,
        full_battery: Callable[[float], Battery],
    ) -> Self:
        """Make them; arguments as those of `LotKeeper`, `KnownLotFollower`, `TourKeeper` and `SectionCounter`.

        ``recordings``: those on this disk. ``full_battery``: a full battery at a time, UTC, Unix seconds.
        """
        store = LotStore(lots_file(config.store.directory, config.store.lots), find_stalls)
        tours = TourKeeper(around)
        timetable = Timetable(config.schedule, has_desk=config.collect.url is not None)

        def is_due(lot: str, name: str, last: float | None) -> bool:
            return timetable.is_due(lot, name, last, time.time())

        known = KnownLotFollower(store, datum, survey, add_message, tours=tours, due=is_due)
        sections = SectionCounter(store, lambda: known.lots, datum, occupancy)
        keeper = LotKeeper(store, landed, add_message, is_restored=is_restored, stored=known.wake)
        webhooks = WebhookSender(store, config.webhooks, time.time, lambda: keeper.is_armed, add_message)
        documents = DocumentSender(
            store, config.collect, time.time, lambda: keeper.is_armed, add_message, take_due=timetable.take,
            recordings=recordings,
        )  # fmt: skip
        schedule = Schedule(store, timetable, time.time, lambda: keeper.is_armed, add_message)
        days = DayPlanner(store, config, timetable, day_drone(config, around, full_battery))
        return cls(store, keeper, known, tours, sections, webhooks, documents, timetable, schedule, days)

    def loops(self) -> tuple[tuple[str, Callable[[], Awaitable[None]]], ...]:
        """Return what runs until the end, by its name."""
        keeping = (("lot-keeper", self.keeper.run), ("known-lot", self.known.run), ("sections", self.sections.run))
        sending = (("webhooks", self.webhooks.run), ("collect", self.documents.run))
        return (*keeping, *sending, ("schedule", self.schedule.run))

    async def close(self) -> None:
        """End the store and the planning of tours."""
        self.tours.close()
        self.days.close()
        await self.store.close()


def day_drone(config: Config, around: Surroundings, full_battery: Callable[[float], Battery]) -> Callable[[], DayDrone]:
    """Return the function that returns the drone of a day's rounds as it is now."""
    described = drone_of(config)

    def drone() -> DayDrone:
        camera = around.camera() or described.camera
        battery, flies = full_battery(time.time()), around.is_flying()
        return DayDrone(camera, around.heights(), battery, around.here(), is_flying=flies, fence=around.fence)

    return drone


def surroundings(
    autopilot: MavsdkAutopilot, camera: DroneCamera, inputs: DdcInputs, topics: DdcTopicInterface,
    manager: OperationsManager, settings: FenceSettings,
) -> Surroundings:  # fmt: skip
    """Return what the flight over lots that are surveyed again depends on."""

    def here() -> GlobalPose | None:
        pose = topics.get_pose()
        return None if pose is None else pose.global_

    def fence(datum: GlobalPose, place: GlobalPose) -> Fence | None:
        if autopilot.datum is not None and topics.fence_pub.value is not None:
            return topics.fence_pub.value
        try:
            return manager.fences.plan.around(datum, place, settings)
        except FenceError:
            return None

    return Surroundings(
        asked=lambda: () if (outline := manager.outlines.outline) is None else outline.lots,
        here=here,
        camera=lambda: camera.model,
        heights=topics.get_heights,
        fence=fence,
        state=lambda: topics.curr_state_pub.value or StateName.IDLE,
        publish=inputs.lots.publish,
        is_flying=topics.may_fly,
        taken=lambda: topics.taken_plan_pub.value or "",
    )


def program_name(model: Path | None) -> str:
    """Return version and network of a survey. There is a map by then: the algorithms' libraries are loaded."""
    from hawk.daemon import algorithms

    return algorithms.program_name(model)
