"""The real web server over a made-up drone, for looking at the page: ``python packaging/fake_drone.py SCENE``.

Scenes: ground, failed, ready, explore, still, watch, manual, lost, landed. The drone answers commands roughly as a real
one would; it is for the eye and for tests of the page's layout, nothing else is measured with it.
"""

from __future__ import annotations

import argparse
import asyncio
import dataclasses
import math
import zlib
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from fake_film import record
from fake_lot import COLOURS, DATUM, FIELD_M, draw_ground, make_stalls, ring, store_with, to_pixel
from numpy.typing import NDArray

from hawk.comm.clock import Clock
from hawk.comm.protocol.authority import authority_refusal
from hawk.comm.protocol.command_table import COMMAND_TABLE, sender_of
from hawk.comm.protocol.commands import (
    Ack,
    AutonomousMove,
    ClearOutline,
    Command,
    CompulsiveMove,
    Configure,
    Kill,
    KillRequest,
    KillToken,
    Outgoing,
    RouteAnswer,
    RouteRequest,
    SetOutline,
)
from hawk.comm.protocol.heartbeat import (
    CheckItem,
    CommandOption,
    DroneStatus,
    HealthItem,
    LogEntry,
    OperationStatus,
    OutlineSetup,
    PartsStatus,
    PerceptionStatus,
    Point,
    PoseStatus,
    SiteStatus,
    StatusStamp,
    TravelStatus,
    VehicleStatus,
)
from hawk.comm.topic import Topic
from hawk.config.reference import reference_text, settings
from hawk.config.sections import Config, OperatorSettings, StoreSettings, WebSettings
from hawk.model.lot_map import Counts, EncodedTile, OccupancyMap, StallState, TileKey, free_interval
from hawk.model.operation import StateName
from hawk.model.pictures import AnnotatedFrame
from hawk.model.plans import ExploreStatus
from hawk.model.poses import MapPoint
from hawk.model.tile_picture import encode_picture
from hawk.runtime.performance import LagSummary
from hawk.store.recordings import Recordings
from hawk.web.app import WebServer
from hawk.web.services import OperatorSide, WebServices

NO_OUTLINE = OutlineSetup(source="none", polygons=[], holes=[], area=0.0)


class FakeDrone:
    """Moves, sees and answers."""

    def __init__(self, scene: str, clock: Clock, side: OperatorSide, count: int | None = None) -> None:
        rng = np.random.default_rng(4)
        self.clock, self.side, self.scene = clock, side, scene
        self.stalls = make_stalls(rng, count)
        self.ground, self.classes = draw_ground(self.stalls, rng)
        self.seen = np.zeros(self.classes.shape, np.bool_)
        self.north, self.east, self.yaw, self.height = -38.0, -12.0, 0.4, 0.0
        self.state = StateName.IDLE
        self.armed = False
        self.failed = scene in ("ground", "failed")
        self.heights = (15.0, 35.0, 60.0)
        self.target: MapPoint | None = None
        self.route: list[MapPoint] = []
        self.trail: list[MapPoint] = []
        self.log: list[LogEntry] = []
        self.versions: dict[TileKey, int] = {}
        self.tiles: dict[TileKey, EncodedTile] = {}
        self.mosaic: dict[TileKey, EncodedTile] = {}
        self.outline = NO_OUTLINE
        self.explored, self.done, self.path_length, self.sequence, self.started = 0.0, False, 0.0, 0, clock()
        self.stage()
        if count is not None:
            self.see_all()

    def stage(self) -> None:
        """Bring the drone to where the scene begins."""
        self.say("info", "Autopilot found.", "ArduCopter V4.6.1 (fake)")
        if self.scene in ("ground", "failed", "ready"):
            return
        self.armed, self.height, self.state = True, 35.0, StateName.AUTONOMOUS_EXPLORE
        for text in ("Armed by you. 9 checks passed.", "Took off.", "At 35 m. Holding.", "Lot found. Exploring."):
            self.say("ok", text)
        self.say("warning", "5 stalls unclear: half under a tree. Will look again.")
        legs = ((-38, -12), (-30, 18), (-8, 26), (14, 20), (26, 4))
        for here, there in pairwise(legs):
            for share in np.linspace(0, 1, 8):
                self.go(here[0] + (there[0] - here[0]) * share, here[1] + (there[1] - here[1]) * share)
        self.yaw = -0.9
        self.route = [MapPoint(34, -14), MapPoint(18, -34), MapPoint(-6, -36), MapPoint(-24, -22)]
        self.say("info", "Next: the rows to the north, 14 m away.")
        states = {"manual": StateName.MANUAL, "lost": StateName.COMMUNICATION_LOST, "landed": StateName.IDLE}
        self.state = states.get(self.scene, self.state)

    def say(self, level: str, text: str, details: str = "") -> None:
        """Add a line to the messages."""
        now = datetime.now(UTC).isoformat()
        self.log.append(LogEntry(number=len(self.log) + 1, time=now, level=level, text=text, details=details))  # type: ignore[arg-type]

    def go(self, north: float, east: float) -> None:
        """Be at a place and see what lies below."""
        self.path_length += math.hypot(north - self.north, east - self.east)
        self.north, self.east = north, east
        self.trail.append(MapPoint(north, east))
        outline = np.array([to_pixel(p.north, p.east) for p in self.footprint()], np.int32)
        before = self.seen.copy()
        fresh = self.seen.view(np.uint8)
        cv2.fillPoly(fresh, [outline], 1)
        for row, column in self.changed_tiles(before):
            self.encode(row, column)
        for each in self.stalls:
            x, y = to_pixel(each.stall.north, each.stall.east)
            if self.seen[y, x] and not each.shown:
                each.shown = True
                each.stall = dataclasses.replace(each.stall, last_seen=self.clock())
        self.explored = sum(each.shown for each in self.stalls) / len(self.stalls)

    def see_all(self) -> None:
        """Know the whole lot at once."""
        self.seen[:] = True
        for row in range(-5, 5):
            for column in range(-5, 5):
                self.encode(row, column)
        for each in self.stalls:
            each.shown = True
        self.explored, self.done = 1.0, True

    def changed_tiles(self, before: NDArray[np.bool_]) -> list[TileKey]:
        """Return the tiles in which more was seen."""
        rows, columns = np.nonzero((before != self.seen)[::16, ::16])
        return sorted({(int(r) * 16 // 256 - 5, int(c) * 16 // 256 - 5) for r, c in zip(rows, columns, strict=True)})

    def encode(self, row: int, column: int) -> None:
        """Publish one tile as it is seen."""
        top, left = (row + 5) * 256, (column + 5) * 256
        cut = np.s_[top : top + 256, left : left + 256]
        seen = self.seen[cut]
        version = self.versions[row, column] = self.versions.get((row, column), 0) + 1
        classes = np.where(seen, self.classes[cut], 0).astype(np.uint8)
        self.tiles[row, column] = EncodedTile(version, zlib.compress(classes.tobytes(), 1))
        data = encode_picture(self.ground[cut], np.where(seen, 255, 0).astype(np.uint8))
        self.mosaic[row, column] = EncodedTile(version, data)

    def footprint(self) -> list[MapPoint]:
        """Return the four corners of what the camera sees."""
        scale = max(self.height, 3) / 35
        found = []
        for a, b in ((1, -1), (1, 1), (-1, 1), (-1, -1)):
            up, right = a * FIELD_M[1] / 2 * scale, b * FIELD_M[0] / 2 * scale
            north = self.north + up * math.cos(self.yaw) - right * math.sin(self.yaw)
            found.append(MapPoint(north, self.east + up * math.sin(self.yaw) + right * math.cos(self.yaw)))
        return found

    def handle_now(self, client: str, command: Command) -> Outgoing:
        """Act on Hold and Kill."""
        if isinstance(command, KillRequest):
            return KillToken(id=command.id, token="t" * 24, valid_for=10.0)
        if isinstance(command, Kill):
            self.state, self.armed, self.height = StateName.IDLE, False, 0.0
            self.say("error", "Motors cut by you.")
            return Ack(id=command.id, accepted=True)
        return self.answer(client, command)

    def answer(self, client: str, command: Command) -> Outgoing:
        """Take or refuse a command; a route is a straight line."""
        if isinstance(command, RouteRequest):
            there = Point(north=command.x, east=command.y)
            metres = math.dist((self.north, self.east), (command.x, command.y))
            return RouteAnswer(id=command.id, points=[there], length=metres, refused=None)
        kind, desk = command.type, self.side.desk
        homing = self.state in (StateName.RETURN_TO_LAUNCH, StateName.LAND)
        has_control, control = desk.has_control(client), desk.tenure()
        reason = authority_refusal(sender_of(kind), has_control=has_control, control=control, homing=homing)
        reason = reason or self.reason(kind)
        if not reason:
            self.act(kind, command)
        return Ack(id=command.id, accepted=not reason, reason=reason)

    def reason(self, kind: str) -> str:
        """Return why a command is refused."""
        if kind == "Arm" and self.failed and self.state is StateName.IDLE:
            return "Ground-station failsafe: off."
        return COMMAND_TABLE[kind].states[self.state]

    def act(self, kind: str, command: Command) -> None:
        """Do what a command says."""
        moves = {
            "Takeoff": StateName.TAKEOFF,
            "Autonomous Explore": StateName.AUTONOMOUS_EXPLORE,
            "Hold": StateName.HOVER,
            "Return To Launch": StateName.RETURN_TO_LAUNCH,
            "Land": StateName.LAND,
            "Autonomous Move": StateName.AUTONOMOUS_MOVE,
            "Compulsive Move": StateName.COMPULSIVE_MOVE,
            "Arm": StateName.ARM,
            "Resume": StateName.HOVER,
            "Disarm": StateName.IDLE,
        }
        self.failed = self.failed and kind != "Set Failsafes"
        self.state = moves.get(kind, self.state)
        self.armed = self.state is not StateName.IDLE
        if isinstance(command, Configure):
            self.heights = (command.min, command.des, command.max)
        self.target = MapPoint(-38, -12) if kind == "Return To Launch" else None
        if isinstance(command, AutonomousMove | CompulsiveMove):
            self.target = MapPoint(command.x, command.y)
        if isinstance(command, SetOutline):
            polygons, holes = command.polygons, command.holes
            self.outline = OutlineSetup(source="set", polygons=polygons, holes=holes, area=5000.0)
        elif isinstance(command, ClearOutline):
            self.outline = NO_OUTLINE
        self.say("ok", f"{kind}.")

    def tick(self, seconds: float) -> None:
        """Fly on."""
        for client, command in self.side.socket.receive():
            self.side.socket.reply(client, self.answer(client, command))
        if self.state is StateName.TAKEOFF:
            self.height = min(self.heights[1], self.height + 6 * seconds)
            self.state = StateName.HOVER if self.height >= self.heights[1] else self.state
        if self.state is StateName.LAND:
            self.height = max(0.0, self.height - 8 * seconds)
            if self.height == 0:
                self.state, self.armed = StateName.IDLE, False
        stop = self.route[0] if self.state is StateName.AUTONOMOUS_EXPLORE and self.route else self.target
        if stop is not None and self.height > 5 and self.scene != "still":
            self.approach(stop, 4 * seconds)
        if self.scene == "landed" and self.clock() - self.started > 12 and self.armed:
            self.armed, self.height = False, 0.0

    def approach(self, stop: MapPoint, metres: float) -> None:
        """Fly so far towards a place."""
        north, east = stop.north - self.north, stop.east - self.east
        distance_m = math.hypot(north, east)
        if distance_m < 1:
            self.arrive()
            return
        self.yaw = math.atan2(east, north)
        self.go(self.north + north / distance_m * metres, self.east + east / distance_m * metres)

    def arrive(self) -> None:
        """Choose what comes next at a place."""
        if self.route and self.state is StateName.AUTONOMOUS_EXPLORE:
            self.route.pop(0)
            if not self.route:
                self.done, self.state = True, StateName.HOVER
                self.say("ok", "Explored: the lot found is seen whole, 5168 m². Other ground was not looked at.")
            return
        self.state = StateName.LAND if self.state is StateName.RETURN_TO_LAUNCH else StateName.HOVER
        self.target = None

    def map(self) -> OccupancyMap:
        """Return the map so far."""
        shown = [each.stall for each in self.stalls if each.shown]
        return OccupancyMap(
            tiles=dict(self.tiles),
            mosaic=dict(self.mosaic),
            stalls={stall.id: stall for stall in shown},
            counts=self.counts(),
            lot_area_m2=5168.0,
            version=len(shown),
            map_id="fake",
        )

    def counts(self) -> Counts:
        """Return the stalls by state."""
        states = [each.stall.state for each in self.stalls if each.shown]
        return Counts(*(states.count(state) for state in (StallState.FREE, StallState.TAKEN, StallState.UNKNOWN)))

    def status(self) -> DroneStatus:
        """Return the drone's message."""
        self.sequence += 1
        counts, grounded = self.counts(), self.state in (StateName.IDLE, StateName.ARM)
        corners = ((62, -60), (62, 64), (-20, 64), (-62, 30), (-62, -30), (-30, -60))
        fence = tuple(Point(north=north, east=east) for north, east in corners)
        known = counts.total > 0
        return DroneStatus(
            stamp=StatusStamp(sequence=self.sequence, time=self.clock(), utc=datetime.now(UTC).isoformat()),
            operation=OperationStatus(
                state=self.state,
                detail="" if grounded else "At its place.",
                options=tuple(
                    CommandOption(command=each, possible=not self.reason(each), reason=self.reason(each))
                    for each, row in COMMAND_TABLE.items()
                    if row.states
                ),
                checks=tuple(self.checks()) if self.state is StateName.IDLE else (),
                return_in=24.0 if self.state is StateName.COMMUNICATION_LOST else None,
            ),
            vehicle=VehicleStatus(
                ardupilot_state="GUIDED", armed=self.armed, connected=True,
                landed="ON_GROUND" if self.height < 0.3 else "IN_AIR", link_age=0.1, battery_percentage=89.0,
                battery_age=0.4, voltage=16.2, battery_time_left=790.0, time_home=61.0, satellites=16,
                survey_time_left=140.0 if self.state is StateName.AUTONOMOUS_EXPLORE else None,
                battery_needed_home=24.0, battery_needed_survey=31.0, battery_left=34.0, survey_basis="planner",
                survey_share=1.0,
            ),
            pose=PoseStatus(
                relative_altitude=self.height, latitude=DATUM.latitude, longitude=DATUM.longitude,
                local_position_x=self.north + 38, local_position_y=self.east + 12,
                north=self.north, east=self.east, yaw=self.yaw, roll=0.0, pitch=0.0,
                speed=0.0 if grounded else 3.9, climb=0.0, pose_age=0.02,
            ),
            site=SiteStatus(
                home=Point(north=-38, east=-12), fence=fence, ceiling=120.0, heights=self.heights,
                datum=(DATUM.latitude, DATUM.longitude),
            ),
            travel=TravelStatus(
                target=None if self.target is None else Point.of(self.target),
                route=tuple(map(Point.of, self.route)) if self.state is StateName.AUTONOMOUS_EXPLORE else (),
                flight_time=312.0, distance_flown=self.path_length,
            ),
            perception=PerceptionStatus(
                footprint=() if grounded else tuple(map(Point.of, self.footprint())),
                explored=self.explored if known else None, explore_done=self.done,
                remaining=None if self.done else 480 * (1 - self.explored), lot_area=5168.0, free=counts.free,
                taken=counts.taken, unknown=counts.unknown,
                free_range=free_interval(counts, ExploreStatus(self.done, self.explored)) if known else None,
                vision_rate=8.1, camera_age=0.1,
            ),
            parts=PartsStatus(health=tuple(self.health())),
            log=tuple(self.log), trail=tuple(self.trail), outline_setup=self.outline,
        )  # fmt: skip

    def health(self) -> list[HealthItem]:
        """Return the health of each part."""
        names = (
            "link",
            "position",
            "ground",
            "vision",
            "mapper",
            "planner",
            "camera",
            "recording",
            "requests",
            "tasks",
            "loop",
            "home",
        )
        return [HealthItem(name=name, healthy=True, reason="") for name in names]

    def checks(self) -> list[CheckItem]:
        """Return the checks before flight."""
        passed = {
            "GPS": "16 satellites, ±0.9 m", "Battery": "98 %, 16.6 V", "Compass": "2° from GPS heading",
            "Camera": "15 pictures/s, 0.2 s old", "Fence": "150 × 146 m, home inside", "Home": "at the drone",
            "Battery failsafe": "returns home at 25 %", "Remote control": "connected", "Recording": "room for 9 h",
        }  # fmt: skip
        items = [CheckItem(name=name, passed=True, value=value) for name, value in passed.items()]
        return [self.failsafe_check(), *items]

    def failsafe_check(self) -> CheckItem:
        """Return the check that a scene may fail."""
        if not self.failed:
            return CheckItem(name="Ground-station failsafe", passed=True, value="returns home")
        return CheckItem(
            name="Ground-station failsafe",
            passed=False,
            value="off",
            consequence="If this computer stops in flight, the drone stays in the air until the battery is empty.",
            remedy="Sets FS_GCS_ENABLE to 1: return home.",
            remedy_command="Set Failsafes",
        )

    def picture(self) -> bytes:
        """Return what the camera sees, annotated."""
        corners = np.array([to_pixel(p.north, p.east) for p in self.footprint()], np.float32)
        onto = np.array([(0, 0), (960, 0), (960, 540), (0, 540)], np.float32)
        warp = cv2.getPerspectiveTransform(corners, onto)
        picture = cv2.warpPerspective(self.ground, warp, (960, 540), borderMode=cv2.BORDER_REFLECT)
        for each in self.stalls:
            outline = cv2.perspectiveTransform(ring(each.stall).astype(np.float32)[None], warp)[0].astype(np.int32)
            cv2.polylines(picture, [outline], True, COLOURS[each.stall.state], 2, cv2.LINE_AA)
        return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 75])[1].tobytes()


async def main() -> None:
    """Serve one scene until interrupted."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("scene", nargs="?", default="explore")
    parser.add_argument("--port", type=int, default=3999)
    parser.add_argument("--stalls", type=int, help="a field of N stalls, all of them known from the beginning")
    parser.add_argument(
        "--lots", type=Path, metavar="FILE", help="a store of lots: made with this one where there is none"
    )
    parser.add_argument(
        "--surveys",
        type=int,
        default=1,
        help="surveys of a store that is made; of several the newest is recorded",
    )
    parser.add_argument("--real", action="store_true", help="do not say SIMULATION")
    options = parser.parse_args()
    clock = Clock()
    side = OperatorSide.create(clock, OperatorSettings())
    drone = FakeDrone(options.scene, clock, side, options.stalls)
    side.socket.attach(drone.handle_now)
    status: Topic[DroneStatus] = Topic("status", clock)
    occupancy: Topic[OccupancyMap] = Topic("map", clock)
    video: Topic[AnnotatedFrame] = Topic("video", clock)
    services = WebServices(
        clock=clock, web=WebSettings(port=options.port), operator=OperatorSettings(), side=side, status=status,
        occupancy_map=occupancy, video=video, version="0.1.0", simulation=not options.real, camera_fov_deg=70.0,
        travel_speed_m_s=4.0,
        loop_lag=lambda: LagSummary(0, 0, 0, 0), settings=settings(Config(), reference_text()),
        lots=None if options.lots is None else store_with(options.lots, drone.stalls, options.surveys),
        recordings=None if options.lots is None else Recordings(StoreSettings(directory=options.lots.parent)),
    )  # fmt: skip
    if options.lots is not None and options.surveys > 1:
        record(options.lots.parent / "recordings", drone.stalls)
    server = WebServer(services)
    await server.start()
    print(server.page_url, flush=True)
    while True:
        drone.tick(0.2)
        occupancy.publish(drone.map())
        status.publish(drone.status())
        video.publish(AnnotatedFrame(drone.sequence, clock() - 0.15, drone.picture()))
        await asyncio.sleep(0.2)


if __name__ == "__main__":
    asyncio.run(main())
