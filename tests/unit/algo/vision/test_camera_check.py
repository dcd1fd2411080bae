from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.algo.frame import FrameInput
from hawk.algo.vision.camera_check import CameraCheck, Evidence, Pair, View
from hawk.algo.vision.odometry import Motion, expected_motion, find_features, measured_motion
from hawk.algo.vision.rectify import scaled_camera
from hawk.model.operation import Health, StateName
from hawk.model.plans import HeightParameters
from hawk.model.poses import MapPose
from hawk.sim.camera.camera import default_intrinsics, turned_camera
from hawk.worlds.camera import WorldCamera
from hawk.worlds.generate import WorldOptions, generate_world
from hawk.worlds.moment import Condition
from hawk.worlds.world import World
from tests.drawn_worlds import drawn_world
from tests.examples import nightly

CAMERA = scaled_camera(default_intrinsics(), 960, 540)
"""The check makes pictures of 320 pixels; drawing them costs most of these tests."""
Picture = NDArray[np.uint8]
grain = np.random.default_rng(8).integers(0, 255, (540, 960, 3), np.uint8)


CAMERAS: dict[int, WorldCamera] = {}
"""The camera over a world, by the world's identity: its first picture costs a quarter of a second."""


@pytest.fixture(scope="module")
def world() -> World:
    return drawn_world(3)


@cache
def world_in(condition: Condition) -> World:
    return generate_world(11, WorldOptions(condition=condition, metres_per_pixel=0.1))  # the check sees 15 cm


def straight(steps: int, *, speed: float = 4.0, heading: float = 0.7, yaw: float = 0.2) -> list[MapPose]:
    """A flight over the lot, five pictures a second; the drone wobbles as it does in wind."""
    rng = np.random.default_rng(5)
    poses = []
    for k in range(steps):
        flown = k * 0.2 * speed
        roll, pitch, off = rng.normal(0.0, 0.04, 3)
        poses.append(MapPose(flown * math.cos(heading), flown * math.sin(heading), 35.0, roll, pitch, yaw + off))
    return poses


def corner(steps: int) -> list[MapPose]:
    """A flight with a bend, so that the picture moves in two directions; the drone keeps its heading."""
    first = straight(steps // 2, heading=0.0, yaw=0.0)
    turn = first[-1]
    second = straight(steps - steps // 2, heading=math.pi / 2, yaw=0.0)
    return first + [replace(pose, north=turn.north + pose.north, east=turn.east + pose.east) for pose in second]


class Flight:
    """Frames of a camera over a drawn world, with the faults that a test asks for."""

    def __init__(
        self, world: World, *, turn: float = 0.0, change: Callable[[Picture], Picture] = lambda it: it
    ) -> None:
        if id(world) not in CAMERAS:
            CAMERAS[id(world)] = WorldCamera(world, CAMERA)
        self._camera = CAMERAS[id(world)]
        self._middle = np.mean([stall.corners.mean(0) for stall in world.stalls], 0)
        self._turn, self._change = turn, change
        self._rng = np.random.default_rng(1)
        self.model = CAMERA
        self.state = StateName.AUTONOMOUS_EXPLORE

    def frames(self, poses: list[MapPose], *, same: bool = False) -> Iterator[tuple[FrameInput, Picture]]:
        seen: Picture | None = None
        for k, pose in enumerate(poses):
            if seen is None or not same:
                seen = self._change(self._drawn(pose))
            jpeg = b"same" if same else f"picture {k}".encode()
            yield (
                FrameInput(k, k * 0.2, jpeg, self.model, pose, 4.0, self.state, None, HeightParameters(), None, None),
                seen,
            )

    def check(self, poses: list[MapPose], *, same: bool = False) -> tuple[CameraCheck, list[Health]]:
        check = CameraCheck()
        return check, [check.look(frame, picture) for frame, picture in self.frames(poses, same=same)]

    def _drawn(self, pose: MapPose) -> Picture:
        x, y = self._middle[0] + pose.east - 20, self._middle[1] - pose.north + 20
        attitude = turned_camera(pose.roll, pose.pitch, pose.yaw, self._turn)
        return self._camera.render(float(x), float(y), pose.height, *attitude, rng=self._rng)


# -- one pair ----------------------------------------------------------------------------------------------------------


@pytest.mark.nightly
@pytest.mark.parametrize("turn_deg", [0.0, 90.0, 40.0, *nightly(180.0, -90.0)])
def test_a_turned_camera_turns_the_measured_shift_against_the_expected_one(world: World, turn_deg: float) -> None:
    poses = [MapPose(0.0, 0.0, 35.0, 0.05, -0.1, 0.3), MapPose(3.0, 4.0, 36.0, -0.08, 0.06, 0.4)]
    flight = Flight(world, turn=math.radians(turn_deg))
    before, now = (find_features(picture, CAMERA) for _, picture in flight.frames(poses))
    expected, measured = expected_motion(CAMERA, *poses), measured_motion(before, now)
    assert expected is not None
    assert measured is not None
    off = math.degrees(cmath.phase(measured.shift / expected.shift))
    assert math.remainder(off + turn_deg, 360) == pytest.approx(0.0, abs=6.0)
    assert abs(measured.shift) == pytest.approx(abs(expected.shift), rel=0.15)
    assert measured.turn == pytest.approx(expected.turn, abs=0.06)


def test_an_oblique_camera_with_a_lens_is_expected_where_it_sees() -> None:
    """The expectation at the optical axis: straight flight, seen from a camera tilted forward."""
    tilted = replace(CAMERA, mount_pitch=math.radians(20))
    motion = expected_motion(tilted, MapPose(0, 0, 30.0, 0, 0, 0), MapPose(3.0, 0, 30.0, 0, 0, 0))
    assert motion is not None
    ahead = 30.0 * math.tan(math.radians(20))
    assert math.atan2(motion.shift.imag, 1) == pytest.approx(math.radians(20) - math.atan2(ahead - 3.0, 30.0), abs=1e-9)
    assert motion.shift.real == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("pitch_deg", [89.0, 120.0])
def test_a_camera_that_looks_above_the_horizon_has_no_expectation(pitch_deg: float) -> None:
    camera = replace(CAMERA, mount_pitch=math.radians(pitch_deg))
    assert expected_motion(camera, MapPose(0, 0, 30, 0, 0, 0), MapPose(3, 0, 30, 0, 0, 0)) is None


def test_a_picture_without_any_feature_has_no_motion() -> None:
    blank = find_features(np.full((540, 960, 3), 90, np.uint8), CAMERA)
    assert measured_motion(blank, blank) is None


# -- the evidence ------------------------------------------------------------------------------------------------------

directions = st.floats(-math.pi, math.pi)
noise = st.floats(-0.12, 0.12)


@st.composite
def moves(draw: st.DrawFn) -> list[Motion]:
    """Eight movements: about half of them turn."""
    return [
        Motion(cmath.rect(draw(st.floats(0.1, 0.4)), draw(directions)), draw(st.sampled_from([0.0, 0.2, -0.2, 0.15])))
        for _ in range(8)
    ]


def evidence(expected: list[Motion], measured: Callable[[Motion], Motion]) -> Evidence:
    found = Evidence()
    for motion in expected:
        found = found.with_pair(Pair(motion, measured(motion)))
    return found


@pytest.mark.slow
@given(moves(), directions, noise)
def test_a_turn_is_measured_whatever_the_flight(expected: list[Motion], angle: float, wrong: float) -> None:
    found = evidence(expected, lambda e: Motion(e.shift * cmath.exp(-1j * (angle + wrong)), e.turn * 0.9)).finding()
    if abs(angle) < math.radians(15):
        assert found.view in (View.RIGHT, View.UNKNOWN)
    elif abs(angle) > math.radians(35):
        assert found.view is View.TURNED
        assert abs(math.remainder(found.angle - angle, math.tau)) < 0.13


@pytest.mark.slow
@given(moves(), directions)
def test_a_mirrored_picture_is_never_right(expected: list[Motion], axis: float) -> None:
    found = evidence(expected, lambda e: Motion(e.shift.conjugate() * cmath.exp(1j * axis), -e.turn)).finding()
    assert found.view is not View.RIGHT


def test_a_mirrored_picture_shows_in_two_directions_without_any_turn() -> None:
    expected = [Motion(0.2 + 0j, 0.0), Motion(0.2j, 0.0)] * 2
    assert evidence(expected, lambda e: Motion(-e.shift.conjugate(), 0.0)).finding().view is View.MIRRORED


def test_a_mirrored_picture_shows_in_three_turns_on_the_spot() -> None:
    found = Evidence()
    for count in range(1, 4):
        found = found.with_pair(Pair(Motion(0j, 0.25), Motion(0j, -0.25)))
        assert (found.finding().view is View.MIRRORED) == (count == 3)


def test_along_one_line_a_right_camera_is_not_proven_and_no_fault() -> None:
    """A mirrored picture moves in the same direction along its own axis."""
    expected = [Motion(0.2 + 0j, 0.0)] * 6
    assert evidence(expected, lambda e: e).finding().view is View.UNKNOWN
    assert evidence(expected, lambda e: Motion(-e.shift, 0.0)).finding().view is View.TURNED


@given(st.lists(st.tuples(directions, directions), min_size=8, max_size=8))
def test_movements_that_agree_on_nothing_say_nothing(directions: list[tuple[float, float]]) -> None:
    """Whatever the pictures show, a verdict needs an agreement; no single wrong pair turns a right camera."""
    pairs = [Pair(Motion(cmath.rect(0.2, e), 0.2), Motion(cmath.rect(0.2, e), 0.2)) for e, _ in directions[:7]]
    wrong = Pair(Motion(cmath.rect(0.2, directions[7][0]), 0.2), Motion(cmath.rect(0.2, directions[7][1]), -0.2))
    found = Evidence()
    for pair in (*pairs, wrong):
        found = found.with_pair(pair)
    assert found.finding().view in (View.RIGHT, View.UNKNOWN)


# -- the check over drawn worlds ---------------------------------------------------------------------------------------


@pytest.mark.nightly
def test_a_camera_that_sits_right_is_healthy(world: World) -> None:
    check, healths = Flight(world).check(corner(40))
    assert set(healths) == {Health()}
    assert check.finding.view is View.RIGHT
    assert abs(math.degrees(check.finding.angle)) < 5


@pytest.mark.slow
@pytest.mark.fault(
    "the camera sits turned (40°, 90°, upside down)",
    "camera unhealthy after four comparisons, within 18 m of flight; the message names camera.mount_yaw_deg "
    "and the value that fits",
)
@pytest.mark.parametrize(("turn_deg", "setting"), [(-90, -90), (40, 40), *nightly((90, 90), (180, 180))])
def test_a_turned_camera_is_named_with_its_setting_and_the_setting_heals_it(
    world: World, turn_deg: int, setting: int
) -> None:
    flight = Flight(world, turn=math.radians(turn_deg))
    _, healths = flight.check(straight(30))
    bad = [k for k, health in enumerate(healths) if not health.is_healthy]
    assert bad[0] <= 22  # 4 m/s, five pictures a second: within 18 m of flight
    assert bad == list(range(bad[0], 30))
    assert f"turned by about {turn_deg}°" in healths[-1].reason
    assert f"camera.mount_yaw_deg to {setting} (it is 0)" in healths[-1].reason
    flight.model = replace(CAMERA, mount_yaw=math.radians(setting))
    assert set(flight.check(straight(30))[1]) == {Health()}


@pytest.mark.nightly
def test_the_setting_is_reckoned_from_the_one_in_force(world: World) -> None:
    flight = Flight(world, turn=0.0)
    flight.model = replace(CAMERA, mount_yaw=math.radians(90))
    assert "camera.mount_yaw_deg to 0 (it is 90)" in flight.check(straight(30))[1][-1].reason


@pytest.mark.slow
@pytest.mark.fault(
    "the picture is mirrored",
    "camera unhealthy after three turns or as soon as the drone has flown in two directions",
)
def test_a_mirrored_picture_is_unhealthy_and_stays_so_along_a_line(world: World) -> None:
    flight = Flight(world, change=lambda picture: np.asarray(cv2.flip(picture, 1), np.uint8))
    bent = corner(40)
    along = [replace(bent[-1], east=bent[-1].east + 0.8 * k) for k in range(1, 15)]
    _, healths = flight.check(bent + along)
    assert "mirrored" in healths[-1].reason
    first = [health.is_healthy for health in healths].index(False)
    assert not any(health.is_healthy for health in healths[first:])


@pytest.mark.slow
@pytest.mark.fault(
    "the camera sends the same picture with new time stamps",
    "camera unhealthy once the drone moved by 1 m or turned by 15° (0.3 s to 1.3 s of flight); Explore and "
    "Autonomous Move end in Hover; the pictures are not mapped",
)
def test_the_same_picture_while_the_drone_moves_a_metre_is_a_frozen_camera(world: World) -> None:
    _, healths = Flight(world).check(straight(10), same=True)
    assert [health.is_healthy for health in healths[:3]] == [True, True, False]  # 0.8 m, 1.6 m
    assert "stands still" in healths[2].reason


def test_the_same_picture_while_the_drone_turns_is_a_frozen_camera(world: World) -> None:
    poses = [MapPose(0, 0, 35.0, 0, 0, math.radians(8 * k)) for k in range(4)]
    assert [health.is_healthy for health in Flight(world).check(poses, same=True)[1]] == [True, True, False, False]


@pytest.mark.slow
@pytest.mark.fault(
    "the picture stands still under a running clock",
    "camera unhealthy after three comparisons, 1.3 s to 3.2 s of flight",
)
def test_a_frozen_picture_with_a_running_clock_in_it_is_found_by_its_motion(world: World) -> None:
    frozen: list[Picture] = []
    count = iter(range(1000))

    def clock(picture: Picture) -> Picture:
        frozen.append(picture)
        text = f"12:00:{next(count):02d}"
        return np.asarray(cv2.putText(frozen[0].copy(), text, (15, 30), 0, 1, (255, 255, 255), 2), np.uint8)

    _, healths = Flight(world, change=clock).check(straight(20))
    assert "stands still" in healths[-1].reason


def test_a_picture_that_stood_while_the_drone_turned_is_healthy_as_soon_as_it_moves() -> None:
    still = [Pair(Motion(0j, 0.3), Motion(0j, 0.0))] * 3
    found = Evidence()
    for pair in still:
        found = found.with_pair(pair)
    assert found.finding().view is View.FROZEN
    assert found.with_pair(Pair(Motion(0.2 + 0j, 0.0), Motion(0.2 + 0j, 0.0))).finding().view is View.UNKNOWN


@pytest.mark.slow
@pytest.mark.fault(
    "GNSS walks and the camera holds the drone: the reported position moves, the picture stands",
    "the camera is not taken for a frozen one",
)
def test_a_camera_that_holds_the_drone_in_spite_of_its_position_is_not_taken_for_a_frozen_one(world: World) -> None:
    """The reported position walks away, and the camera keeps the drone where it is."""
    walking, check, judged = straight(40, speed=2.0), CameraCheck(), CameraCheck()
    for k, (frame, picture) in enumerate(Flight(world).frames([walking[0]] * len(walking))):
        reported = replace(frame, pose=walking[k])
        assert check.look(replace(reported, map_problem="the position is doubted"), picture).is_healthy
        known = judged.look(reported, picture)
    assert not known.is_healthy, "while nobody doubts the position, the camera is at fault"


@pytest.mark.nightly
def test_a_frozen_camera_is_no_fault_on_the_ground_and_a_turned_one_is(world: World) -> None:
    for turn, change in ((0.0, lambda picture: np.zeros_like(picture) + grain), (math.pi, lambda picture: picture)):
        flight = Flight(world, turn=turn, change=change)
        check, healths = flight.check(straight(20))
        assert not healths[-1].is_healthy
        frame, picture = next(flight.frames(straight(21)[20:]))
        landed = check.look(replace(frame, state=StateName.IDLE, captured=5.0), picture)
        assert landed.is_healthy == (turn == 0.0)


@pytest.mark.nightly
def test_a_camera_that_is_turned_on_the_ground_is_judged_by_the_next_flight_alone(world: World) -> None:
    check = CameraCheck()
    for frame, picture in Flight(world).frames(corner(30)):
        check.look(frame, picture)
    assert check.evidence.moves
    check.look(replace(frame, state=StateName.IDLE), picture)
    assert check.evidence == Evidence()


@pytest.mark.slow
def test_a_picture_that_moves_again_is_healthy_again(world: World) -> None:
    flight, check = Flight(world), CameraCheck()
    for frame, picture in flight.frames(straight(10), same=True):
        health = check.look(frame, picture)
    assert not health.is_healthy
    frame, picture = next(flight.frames(straight(11)[10:]))
    assert check.look(replace(frame, captured=2.0), picture).is_healthy


@pytest.mark.parametrize("state", [StateName.IDLE, StateName.CONFIGURE, StateName.ARM])
def test_on_the_ground_the_same_picture_is_reported_and_no_fault(world: World, state: StateName) -> None:
    flight = Flight(world)
    flight.state = state
    poses = [MapPose(0.05 * k, 0.0, 0.1, 0, 0, 0) for k in range(40)]  # GNSS drifts
    _, healths = flight.check(poses, same=True)
    assert all(health.is_healthy for health in healths)
    assert healths[-1].reason == "the same picture for 8 s"


@pytest.mark.nightly
def test_a_drone_that_hangs_still_has_a_healthy_camera(world: World) -> None:
    """GNSS drifts by a metre every five seconds under a drone that holds."""
    poses = [replace(straight(1)[0], north=0.04 * k) for k in range(40)]
    check, healths = Flight(world).check(poses)
    assert set(healths) == {Health()}
    assert check.evidence == Evidence()


@pytest.mark.nightly
def test_a_jump_of_the_position_is_no_motion_of_the_drone(world: World) -> None:
    """Global and local position jump together by 12 m: the picture goes on as it did."""
    check = CameraCheck()
    flight, poses = Flight(world), corner(60)
    for k, (frame, picture) in enumerate(flight.frames(poses)):
        pose = poses[k]
        jumped = replace(pose, north=pose.north + 12.0 * (k // 10 % 2))
        assert check.look(replace(frame, pose=jumped), picture).is_healthy
    assert len(check.evidence.moves) >= 4


@pytest.mark.slow
def test_low_and_without_a_pose_nothing_is_compared(world: World) -> None:
    check = CameraCheck()
    for frame, picture in Flight(world, turn=math.pi).frames(straight(12)):
        assert frame.pose is not None
        low = replace(frame, pose=None if frame.sequence % 2 else replace(frame.pose, height=5.9))
        assert check.look(low, picture).is_healthy
    assert check.evidence == Evidence()


@pytest.mark.nightly
def test_another_camera_begins_a_new_check(world: World) -> None:
    check = CameraCheck()
    for frame, picture in Flight(world, turn=math.pi).frames(straight(30)):
        health = check.look(frame, picture)
    assert not health.is_healthy
    assert check.look(replace(frame, camera=replace(CAMERA, fx=900.0)), picture).is_healthy


HARDEST = (Condition.NIGHT, Condition.SNOW)
MARKS = {condition: () if condition in HARDEST else pytest.mark.nightly for condition in Condition}


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("condition", "height"),
    [
        pytest.param(condition, height, marks=MARKS[condition])
        for condition, height in zip(Condition, [35, 35, 60, 35, 15, 60, 15], strict=True)
    ],
)
def test_no_time_of_day_and_no_weather_makes_a_right_camera_wrong(condition: Condition, height: int) -> None:
    world = world_in(condition)
    poses = [replace(pose, height=height) for pose in corner(40)]
    check, healths = Flight(world).check(poses)
    assert set(healths) == {Health()}
    assert abs(math.degrees(check.finding.angle)) < 8


@pytest.mark.slow
@pytest.mark.parametrize("condition", [pytest.param(condition, marks=MARKS[condition]) for condition in Condition])
def test_a_camera_upside_down_is_found_at_any_time_and_in_any_weather(condition: Condition) -> None:
    world = world_in(condition)
    _, healths = Flight(world, turn=math.pi).check(straight(30))
    assert "turned by about 180°" in healths[-1].reason
