from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks import __main__ as command
from benchmarks.chain_flight import __main__ as chain
from benchmarks.chain_flight import campaign, flight, measure
from benchmarks.chain_flight.flight import Errors, Flown, Glance
from benchmarks.chain_flight.measure import Judgement, Pool, Result
from benchmarks.figures import Figure
from hawk.algo.frame import FrameOutput
from hawk.algo.vision.detection import Detection, FrameGround, GroundImage
from hawk.ddc.motion import Goal
from hawk.model.lot_map import Counts, OccupancyMap, StallState
from hawk.model.operation import Health
from hawk.model.plans import ExploreStatus, PathPlan
from hawk.model.poses import MapPose
from hawk.survey import accuracy
from hawk.worlds.world import TrueStall, World

BOX = np.array([[0, 0], [2.6, 0], [2.6, 5.2], [0, 5.2]], float)


def row(count: int, x: float = 0.0, y: float = 0.0) -> NDArray[np.float64]:
    return np.array([BOX + np.array([x + 2.6 * k, y]) for k in range(count)])


def judged(found: int, true: int, *, free: int, taken: float = 0.1, shift: float = 0.0) -> Judgement:
    """The first stalls of a row of free ones are found; ``free`` of them are called free."""
    states = np.array([StallState.FREE] * free + [StallState.TAKEN] * (found - free), object)
    truth = accuracy.LabelledPlace(row(true), np.array([StallState.FREE] * true, object))
    return Judgement.of(row(found, shift), np.full(found, taken), states, truth)


def result(name: str, fused: Judgement, single: Judgement) -> Result:
    health = Health()
    output = FrameOutput(1, 0.0, True, b"", OccupancyMap(), PathPlan(), (), health, health, health)
    flown = Flown(output, 200.0, 50.0, np.array([40.0, 60.0]), np.array([5.0, 7.0]), True)
    report = {
        "lot_iou": 0.9, "position_error_p95_m": 0.2, "true_stalls": fused.tally.true,
        "lot_seen": 0.8, "stalls_seen": 1.0 if name == "a" else 0.5, "stall_recall_seen": 0.9 if name == "a" else 0.6,
    }  # fmt: skip
    return Result(name, flown, report, fused, Pool((single, single)), (19, 20), 160.0)


def by_key(results: list[Result]) -> dict[str, Figure]:
    return {figure.key: figure for figure in measure.figures(results)}


def test_counts_of_all_flights_are_added_up_and_stand_beside_single_frames() -> None:
    found = by_key(
        [
            result("a", judged(20, 20, free=20), judged(15, 20, free=15)),
            result("b", judged(18, 20, free=18, shift=0.4), judged(10, 20, free=5)),
        ]
    )
    assert found["chain_stall_f1"].value == pytest.approx(2 * 38 / (38 + 40))
    assert found["chain_single_stall_f1"].value == pytest.approx(2 * 50 / (50 + 80))
    assert found["chain_stall_f1"].reference is not None
    assert found["chain_stall_f1"].reference.value == found["chain_single_stall_f1"].value
    assert found["chain_stall_f1_min"].value == pytest.approx(2 * 18 / 38)
    assert found["chain_free_count_error"].value == pytest.approx(-2 / 40)
    assert found["chain_free_count_error"].passed is False
    assert found["chain_free_counts_right"].value == 2
    assert found["chain_position_error_p95_m"].value == pytest.approx(0.4)
    assert found["chain_ece"].value == pytest.approx(0.1)
    assert found["chain_recall_kept"].value == 1.0
    assert found["chain_recall_seen"].value == pytest.approx(0.95)
    assert found["chain_lot_seen"].value == pytest.approx(0.8)
    assert found["chain_stalls_in_view"].value == pytest.approx(30 / 40)
    assert found["chain_recall_in_view"].value == pytest.approx((18 + 6) / 30)
    assert found["chain_distance_over_model"].value == pytest.approx(400 / 320)
    assert found["chain_precision_star"].value == 1.0
    assert found["chain_recall_whole"].value == pytest.approx(38 / 40)
    assert found["chain_finished"].passed


def test_the_map_is_held_against_single_frames_with_every_stall_counted_once() -> None:
    one = result("a", judged(18, 20, free=18), judged(20, 20, free=20))
    found = by_key([replace(one, once=0.9), replace(one, once=0.91)])
    assert found["chain_recall_kept"].value == 0.5
    assert not found["chain_recall_kept"].passed
    assert "every stall once 0.910" in measure.line(replace(one, once=0.91))


def test_a_stall_that_many_frames_show_counts_once() -> None:
    """The first stall is in two pictures and found in both; the second is in one and not found."""
    corners = row(2, 5.0, 5.0)
    stalls = tuple(TrueStall(k, c, taken=False) for k, c in enumerate(corners))
    frames = measure.SingleFrames(World("w", 0.1, np.zeros((200, 200, 3), np.uint8), stalls=stalls, start_m=(0.0, 0.0)))
    assert frames.recall_once is None
    seen = (Detection(-7.6, 6.3, 0.0, 2.6, 5.2, 0.9, 0.1, 1.0),)
    for columns in (80, 110):
        size = (150, columns)
        image = GroundImage(
            np.zeros((*size, 3), np.uint8), np.array([[0.0, -0.1, 0.0], [0.1, 0.0, 0.0]]), np.ones(size, np.bool_)
        )
        pose = MapPose(0.0, 0.0, 35.0, 0.0, 0.0, 0.0)
        frames.watch(Glance(FrameGround(seen, image, image, image, image, image, pose, 0.0), (0.0, 0.0)))
    assert frames.recall_once == pytest.approx(0.5)
    assert Pool(tuple(frames.judgements)).tally.recall == pytest.approx(2 / 3)


def test_a_stall_was_looked_at_once_it_was_wholly_in_the_good_part_of_a_picture() -> None:
    """Four stalls beside each other in a picture of 20 m: the first lies in its rim, the world's edge cuts the last."""
    corners = row(4, 5.0, 7.0)
    stalls = tuple(TrueStall(k, c, taken=False) for k, c in enumerate(corners))
    frames = measure.SingleFrames(World("w", 0.1, np.zeros((200, 154, 3), np.uint8), stalls=stalls, start_m=(0.0, 0.0)))
    assert frames.looked_at == (0, 3)
    for left, count in ((4.0, 2), (20.0, 2), (3.0, 3)):
        to_map = np.array([[0.0, -0.1, 0.0], [0.1, 0.0, left]])
        image = GroundImage(np.zeros((200, 200, 3), np.uint8), to_map, np.ones((200, 200), np.bool_))
        pose = MapPose(0.0, 0.0, 35.0, 0.0, 0.0, 0.0)
        frames.watch(Glance(FrameGround((), image, image, image, image, image, pose, 0.0), (0.0, 0.0)))
        assert frames.looked_at == (count, 3)


def test_the_share_of_stalls_looked_at_stands_pooled_and_for_the_least_flight() -> None:
    one = result("a", judged(20, 20, free=20), judged(20, 20, free=20))
    found = by_key([replace(one, looked_at=(99, 100)), replace(one, looked_at=(9, 10)), one])
    assert found["chain_stalls_seen"].value == pytest.approx(108 / 110)
    assert (found["chain_stalls_seen"].passed, found["chain_stalls_seen_min"].passed) == (True, False)
    assert found["chain_stalls_seen_min"].value == pytest.approx(0.9)
    assert by_key([one])["chain_stalls_seen_min"].value is None


def test_a_count_is_right_within_5_percent_or_2_stalls() -> None:
    one = judged(20, 20, free=20)
    assert result("a", judged(18, 20, free=18), one).free_is_right
    assert not result("a", judged(17, 20, free=17), one).free_is_right
    assert result("a", judged(97, 100, free=95), one).free_is_right
    assert not result("a", judged(97, 100, free=94), one).free_is_right


@pytest.mark.parametrize(
    ("columns", "labels", "count"),
    [(400, 10, 6), (150, 10, 3), (131, 3, 3)],
    ids=["whole world", "its picture cuts the fourth", "nobody labelled what lies beyond its picture"],
)
def test_a_single_frame_is_judged_at_its_true_place_by_what_lies_wholly_in_it(
    columns: int, labels: int, count: int
) -> None:
    corners = row(labels, 5.0, 20.0)
    stalls = tuple(TrueStall(k, c, taken=k == 0) for k, c in enumerate(corners))
    world = World("w", 0.1, np.zeros((400, columns, 3), np.uint8), stalls=stalls, start_m=(0.0, 0.0))
    off = (1.5, -0.8)
    size = (200, 200)  # 20 m: the last four stalls are cut or outside
    to_map = np.array([[0.0, -0.1, -10.0 + off[0]], [0.1, 0.0, 2.0 + off[1]]])
    image = GroundImage(np.zeros((*size, 3), np.uint8), to_map, np.ones(size, np.bool_))
    seen = tuple(
        Detection(-22.6 + off[0], 6.3 + 2.6 * k + off[1], 0.0, 2.6, 5.2, 0.9, 0.9 if k == 0 else 0.1, 1.0)
        for k in range(6)
    )
    pose = MapPose(off[0], off[1], 35.0, 0.0, 0.0, 0.0)
    frames = measure.SingleFrames(world)
    frames.watch(Glance(FrameGround(seen, image, image, image, image, image, pose, 0.0), off))
    (one,) = frames.judgements
    assert (one.tally.matched, one.tally.found, one.tally.true) == (count, count, count)
    assert one.tally.state_accuracy == 1.0
    assert one.errors.max() < 1e-6


def test_errors_of_compass_and_height_change_the_reported_pose_and_the_goal() -> None:
    errors = Errors(height=1.2, compass=0.1)
    reported = errors.reported(MapPose(3.0, 4.0, 35.0, 0.01, 0.02, 0.5))
    assert (reported.north, reported.east, reported.roll, reported.pitch) == (3.0, 4.0, 0.01, 0.02)
    assert (reported.height, reported.yaw) == pytest.approx((42.0, 0.6))
    led = errors.led(Goal(1.0, 2.0, 42.0, 0.6))
    assert led is not None
    assert (led.north, led.east, led.height, led.yaw) == pytest.approx((1.0, 2.0, 35.0, 0.5))
    assert errors.led(None) is None


@pytest.mark.flight
@pytest.mark.nightly
def test_a_flight_of_a_few_frames(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(flight, "TIMEOUT_S", 2.0)
    monkeypatch.setattr(flight, "PIXELS", (640, 360))
    out = tmp_path / "chain.json"
    assert chain.main(["--seeds", "1", "--json", str(out), "--out", str(tmp_path / "maps")]) == 0
    figures = json.loads(out.read_text())
    assert figures["chain_flights"] == 1
    assert figures["chain_finished"] == 0
    assert figures["chain_precision"] > 0.8
    assert 0 < figures["chain_distance_over_model"] < 1
    assert 0 < figures["chain_single_recall"] < 1
    assert (tmp_path / "maps" / "seed-1.png").exists()


def test_no_world_is_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert chain.main(["--lots", str(tmp_path)]) == 1
    assert "no world to fly over" in capsys.readouterr().err


def test_the_section_is_part_of_all_benchmarks(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked = []

    def measured(seeds: list[int]) -> list[Figure]:
        asked.append(seeds)
        return [Figure("chain_flights", "flights", float(len(seeds)))]

    monkeypatch.setattr(campaign, "measure", measured)
    assert command.main(["--only", "chain", "--chain", "3-4", "--json", str(tmp_path / "out.json")]) == 0
    assert asked == [[3, 4]]


def test_errors_are_those_of_the_simulator_and_can_be_none() -> None:
    assert Errors() == Errors(gnss_m=1.0, height=1.0, compass=0.0)


def test_the_interval_is_that_of_the_published_counts() -> None:
    one = result("a", judged(20, 20, free=20), judged(15, 20, free=15))
    assert one.free_range is None, "nothing was seen"
    assert not one.free_in_range
    held, missed = (
        replace(
            one,
            flown=replace(
                one.flown,
                output=replace(
                    one.flown.output,
                    occupancy_map=OccupancyMap(counts=Counts(count, 0, 0, free_variance=1.0)),
                    path_plan=PathPlan(explore=ExploreStatus(done=True, seen=1.0)),
                ),
            ),
        )
        for count in (18, 16)
    )
    assert (held.free_range, held.free_in_range) == ((15, 21), True)
    assert (missed.free_range, missed.free_in_range) == ((13, 19), False)
    found = by_key([held, missed])
    assert (found["chain_free_in_range"].value, found["chain_free_in_range"].passed) == (0.5, False)
    assert found["chain_free_range_width"].value == 6
