from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from hawk.algo.vision.odometry import expected_motion
from hawk.algo.vision.rectify import ground_homography, intrinsics
from hawk.calibrate.flight import Flown
from hawk.calibrate.flight_command import LARGEST_SPREADS, Advice, advise, table
from hawk.calibrate.in_flight import Estimate, NoEstimateError, estimate
from hawk.calibrate.pairs import Matches, carried, motions, mounted
from hawk.config.sections import CameraSettings
from hawk.model.poses import MapPose
from tests.unit.calibrate.flights import CAMERA, Errors, all_pairs, lanes, reported, seen

FLOWN = Flown(0.08)


def estimated(errors: Errors, *, seed: int = 0, compass: float = 0.0) -> Estimate:
    """An estimate from a minute and a half; the compass is off by ``compass`` degrees."""
    true = lanes(90, seed=seed)
    by_autopilot = reported(true, seed=seed, drift=0.03, lean=math.radians(0.1))
    by_autopilot.poses[:, 5] += math.radians(compass)
    return estimate(by_autopilot, seen(all_pairs(by_autopilot), true, errors, seed=seed), CAMERA)


def test_points_are_carried_as_the_daemon_projects_them() -> None:
    camera = replace(CAMERA, mount_roll=0.1, mount_pitch=-0.2, mount_yaw=0.7)
    before, now = MapPose(3, -2, 30, 0.05, -0.1, 0.4), MapPose(6, 1, 33, -0.08, 0.02, 0.9)
    ray = np.array([0.2, -0.1])
    pixel = intrinsics(camera) @ (*ray, 1.0)
    ground = np.linalg.solve(ground_homography(camera, before), pixel)
    expected = np.linalg.solve(intrinsics(camera), ground_homography(camera, now) @ (ground / ground[2]))
    rows = [np.array([[p.north, p.east, p.height, p.roll, p.pitch, p.yaw]]) for p in (before, now)]
    mount = mounted(np.array([0.1, -0.2, 0.7]))
    assert carried(ray[None, None], rows[0], rows[1], mount)[0, 0] == pytest.approx(
        expected[:2] / expected[2], abs=1e-9
    )
    shift, turn = motions(rows[0], rows[1], mount)
    motion = expected_motion(camera, before, now)
    assert motion is not None
    assert shift[0] == pytest.approx(motion.shift, abs=1e-9)
    assert turn[0] == pytest.approx(motion.turn, abs=1e-6)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("errors", "seed", "compass"),
    [
        (Errors(late=0.12, roll=1.0, pitch=-1.5, yaw=4.0), 1, 0.0),
        (Errors(late=-0.3, roll=-2.0, pitch=3.0, yaw=-93.0), 2, 0.0),
        (Errors(late=0.02, yaw=178.0), 3, 2.0),
    ],
)
def test_latency_within_10_ms_and_yaw_within_0_3_degrees(errors: Errors, seed: int, compass: float) -> None:
    found = estimated(errors, seed=seed, compass=compass)
    assert found.values[0] == pytest.approx(errors.late, abs=0.010)
    off = np.degrees(np.array(found.values[1:]) - errors.mount)
    off[2] = math.remainder(off[2], 360)
    assert np.abs(off[:2]).max() < 0.2
    assert abs(off[2]) < 0.3
    assert (np.abs([found.values[0] - errors.late, *np.radians(off)]) < 4 * np.array(found.spreads)).all()


@pytest.mark.nightly
def test_a_flight_without_turns_and_leans_does_not_know_the_latency() -> None:
    """Each picture shifted by the same distance: a straight flight at one speed."""
    true = lanes(60, wobble=0.0, turns=False, speed=4.0)
    straight = replace(true, poses=true.poses.copy())
    straight.poses[:, :2] = np.column_stack([4.0 * true.times, 0 * true.times])
    straight.poses[:, 2], straight.poses[:, 3:] = 25.0, 0.0
    found = estimate(straight, seen(all_pairs(straight), straight, Errors(late=0.1)), CAMERA)
    latency, roll, _, yaw = advise(found, FLOWN, CameraSettings())
    assert found.one_heading == pytest.approx(1.0)
    assert "turns, starts and stops" in latency.problem
    assert roll.problem
    assert not latency.is_offered
    assert "starts and stops" in yaw.problem  # the compass may be wrong


@pytest.mark.nightly
def test_a_flight_that_only_turns_does_not_know_the_yaw() -> None:
    true = lanes(60, seed=4)
    true.poses[:, [0, 1, 3, 4]] = 0.0
    found = estimate(true, seen(all_pairs(true), true, Errors(late=0.1)), CAMERA)
    latency, *_, yaw = advise(found, FLOWN, CameraSettings())
    assert latency.value == pytest.approx(-0.02, abs=0.01)
    assert "lanes of 20 m" in yaw.problem


@pytest.mark.slow
def test_too_few_pairs_are_refused_with_the_flight_that_is_needed() -> None:
    true = lanes(30)
    pairs = all_pairs(true)[:19]
    with pytest.raises(NoEstimateError, match=r"only 19 pairs .* 20 are needed: fly for at least a minute"):
        estimate(true, seen(pairs, true, Errors()), CAMERA)


@pytest.mark.slow
def test_pairs_of_a_few_seconds_are_refused() -> None:
    true = lanes(40)
    matches = [m for m in seen(all_pairs(true), true, Errors()) if m.pair.before.captured < 15]
    with pytest.raises(NoEstimateError, match="within 20 s: fly for at least a minute"):
        estimate(true, matches, CAMERA)


@pytest.mark.slow
@pytest.mark.parametrize("late", [1.2, -1.2])
def test_a_latency_that_is_off_by_more_than_a_second_is_found(late: float) -> None:
    true = lanes(60, seed=1)
    found = estimate(true, seen(all_pairs(true), true, Errors(late=late)), CAMERA)
    assert found.values[0] == pytest.approx(late, abs=0.010)


@pytest.mark.slow
def test_pictures_of_another_time_are_refused() -> None:
    true = lanes(60, seed=1)
    matches = [m for m in seen(all_pairs(true), true, Errors(late=2.5)) if len(m.first) >= 10]
    with pytest.raises(NoEstimateError, match=r"do not fit the poses of this flight: set camera\.latency_s"):
        estimate(true, matches, CAMERA)


@pytest.mark.slow
def test_a_mirrored_camera_is_refused() -> None:
    true = lanes(60, seed=2)
    flip = np.array([-1.0, 1.0])
    mirrored = [replace(m, first=m.first * flip, second=m.second * flip) for m in seen(all_pairs(true), true, Errors())]
    with pytest.raises(NoEstimateError, match="a mirrored or frozen picture does not fit"):
        estimate(true, mirrored, CAMERA)


@pytest.mark.nightly
def test_pairs_that_show_something_else_do_not_matter() -> None:
    """A fifth of the pairs is a wrong match."""
    true = lanes(60, seed=5)
    found = seen(all_pairs(true), true, Errors(late=0.05, yaw=3.0))
    rng = np.random.default_rng(1)
    wrong = [
        Matches(m.pair, m.first, m.second + rng.normal(0, 0.1, 2)) if k % 5 == 0 else m for k, m in enumerate(found)
    ]
    result = estimate(true, wrong, CAMERA)
    assert result.values[0] == pytest.approx(0.05, abs=0.010)
    assert math.degrees(result.values[3]) == pytest.approx(3.0, abs=0.3)


# -- advice ------------------------------------------------------------------------------------------------------------


ANGLE = math.radians(0.05)


def result(late: float = 0.0, yaw: float = 0.0, spread: float = 0.001, one_heading: float = 0.5) -> Estimate:
    return Estimate((late, 0.0, 0.0, math.radians(yaw)), (spread, ANGLE, ANGLE, ANGLE), 100, one_heading)


def test_pictures_that_are_taken_later_than_stamped_have_a_shorter_latency() -> None:
    latency = advise(result(late=0.03), FLOWN, CameraSettings(latency_s=0.08))[0]
    assert latency == Advice("latency_s", 0.05, 0.001, 0.08)
    assert latency.is_offered
    assert latency.line == "latency_s = 0.05"


def test_the_flight_s_latency_counts_not_the_present_one() -> None:
    latency = advise(result(late=0.03), FLOWN, CameraSettings(latency_s=0.05))[0]
    assert latency.value == pytest.approx(0.05)
    assert not latency.is_offered


def test_a_setting_within_two_spreads_is_not_offered() -> None:
    near, far = (advise(result(yaw=yaw), FLOWN, CameraSettings())[3] for yaw in (0.09, 0.11))
    assert not near.is_offered
    assert far.is_offered


def test_a_spread_above_the_limit_is_not_offered() -> None:
    latency = advise(result(late=0.05, spread=LARGEST_SPREADS["latency_s"] * 1.01), FLOWN, CameraSettings())[0]
    assert not latency.is_offered
    assert "latency_s" in table([latency])[0]
    assert "not known: its spread is above 0.005" in table([latency])[0]


def test_a_latency_below_zero_is_no_setting() -> None:
    latency = advise(result(late=0.2), FLOWN, CameraSettings())[0]
    assert "lies outside 0 to 5" in latency.problem


@pytest.mark.parametrize(("one_heading", "known"), [(0.71, True), (0.8, False)])
def test_roll_and_pitch_need_more_than_one_heading(one_heading: float, known: bool) -> None:
    latency, roll, pitch, yaw = advise(result(one_heading=one_heading), FLOWN, CameraSettings())
    assert not latency.problem
    assert not yaw.problem
    for each in (roll, pitch):
        assert ("the nose pointed to one side" not in each.problem) is known


def test_a_latency_is_not_offered_where_the_kernel_stamps_the_pictures() -> None:
    latency, *_, yaw = advise(result(late=0.03, yaw=2.0), Flown(0.08, has_kernel_stamps=True), CameraSettings())
    assert latency.problem == "not used: the kernel stamps the pictures, -0.030 s off by this flight"
    assert yaw.is_offered


def test_a_gimbal_has_a_latency_but_no_mount() -> None:
    latency, *angles = advise(result(late=0.03, yaw=2.0), Flown(0.08, has_gimbal=True), CameraSettings())
    assert latency.is_offered
    assert all("hangs on a gimbal" in each.problem for each in angles)
