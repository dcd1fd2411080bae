from __future__ import annotations

import copy
import math
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from hawk.algo.frame import AlgoError, FrameInput, FrameOutput
from hawk.algo.manager import TURNED_S, AlgorithmManagerApp
from hawk.algo.mapper.app import MapperApp
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.algo.vision.camera_check import CameraCheck
from hawk.algo.vision.detection import FrameGround, VisionResult
from hawk.algo.vision.odometry import Odometry
from hawk.formats.image import NoImage
from hawk.model.lot_map import CELL_M, TILE_CELLS, TILE_M, Cell
from hawk.model.operation import Health
from hawk.model.pictures import GroundStep
from hawk.model.plans import DesiredPose, Inbound
from hawk.model.poses import GlobalPose
from hawk.model.tile_picture import decode_picture
from hawk.results.survey_map import SurveyMap
from tests.examples import nightly
from tests.unit.algo.synthetic import SyntheticVision, box_fence, frame_at, pose_at, rows_lot

TRUTH = rows_lot()


class Rig:
    def __init__(self, odometry: Odometry | None = None, **faults: Any) -> None:
        self.vision = SyntheticVision(TRUTH, rng=np.random.default_rng(3), **faults)
        self.interface = AlgorithmTopicInterface()
        self.check = CameraCheck()
        self.manager = AlgorithmManagerApp(timer=lambda: 0.0, camera_check=self.check, odometry=odometry)
        self.mapper, self.path_plan = MapperApp(map_id="m"), PathPlanApp()
        self.manager.init(self.interface, self.vision, self.mapper, self.path_plan, FrameCamera(self.interface))

    def run(self, frame: FrameInput) -> FrameOutput:
        return self.manager.run(frame)


def flight(count: int) -> list[FrameInput]:
    fence = box_fence(TRUTH.lot, 15.0)
    desired = DesiredPose(7, 0.0, 0.0)
    return [
        frame_at(pose_at(0.0, -20.0 + i, 1.57), i + 1, fence=fence, desired=desired, jpeg=b"%d" % i)
        for i in range(count)
    ]


@pytest.fixture(scope="module")
def flown() -> Rig:
    rig = Rig()
    for frame in flight(20):
        rig.run(frame)
    return rig


@pytest.fixture
def rig(flown: Rig) -> Rig:
    """A rig of the test's own after twenty frames."""
    return copy.deepcopy(flown)


@pytest.mark.nightly
def test_results_of_all_three_come_out(rig: Rig) -> None:
    output = [rig.run(frame) for frame in flight(30)[20:]][-1]
    assert output.sequence == 30
    assert output.park_lot_detected
    assert output.occupancy_map.counts.total > 20
    assert output.path_plan.target is not None
    assert output.path_plan.verdict is not None
    assert output.path_plan.verdict.number == 7
    assert output.path_plan.verdict.inbound is Inbound.INSIDE
    assert output.annotated_jpeg.startswith(b"\xff\xd8")
    assert len(output.footprint) == 4
    assert [name for name, _ in output.timings] == [
        "vision",
        "camera",
        "odometry",
        "mapper",
        "path plan",
        "stall size",
        "annotate",
        "all",
    ]
    healths = {output.camera_health, output.vision_health, output.mapper_health, output.path_plan_health}
    assert healths == {Health()}


@pytest.mark.slow
@pytest.mark.nightly
def test_the_same_inputs_twice_give_equal_outputs() -> None:
    """The condition of replaying a recorded flight."""
    faults: dict[str, Any] = {"noise_m": 0.2, "miss": 0.1, "state_error": 0.1, "with_picture": True}
    first, second = Rig(**faults), Rig(**faults)
    for frame in flight(40):
        assert first.run(frame) == second.run(frame)


@pytest.mark.slow
def test_both_halves_of_a_frame_give_the_map_of_the_whole(rig: Rig) -> None:
    """A recording is processed so: the next picture is seen while this one is mapped."""
    whole = copy.deepcopy(rig)
    frame = flight(21)[-1]
    expected = whole.run(frame).occupancy_map
    rig.manager.go_on(frame, rig.manager.look(frame))
    assert rig.mapper.get_occupancy_map() == expected


@pytest.mark.slow
def test_what_failed_in_the_first_half_is_raised_at_the_end_of_the_second(rig: Rig) -> None:
    rig.vision.fault = AlgoError("no ground")
    frame = flight(21)[-1]
    looked = rig.manager.look(frame)
    assert looked.failures == ("vision: no ground",)
    with pytest.raises(AlgoError, match="vision: no ground"):
        rig.manager.go_on(frame, looked)


class Turning:
    """The camera's motion, as far as it turned beyond the heading; ``turns``: degrees by the number of the frame."""

    def __init__(self, turns: dict[int, float]) -> None:
        self.turns = turns

    def look(self, frame: FrameInput, image: object) -> GroundStep | None:
        turn = self.turns.get(frame.sequence)
        if turn is None:
            return None
        here = (0.0, 0.0)
        return GroundStep(frame.captured - 0.4, frame.captured, here, here, 0.0, math.radians(turn), 30.0)


def left_out(turns: dict[int, float], monkeypatch: pytest.MonkeyPatch) -> list[FrameInput]:
    """Fly, and return the frames that were not mapped."""
    rig, frames = Rig(cast("Odometry", Turning(turns))), flight(40)
    mapped, fuse = [], rig.mapper._core.fuse

    def noted(ground: FrameGround) -> None:
        mapped.append(ground.captured)
        fuse(ground)

    monkeypatch.setattr(rig.mapper._core, "fuse", noted)
    for frame in frames:
        assert rig.run(frame).mapper_health.is_healthy
    return [frame for frame in frames if frame.captured not in mapped]


@pytest.mark.slow
@pytest.mark.parametrize("turn", [-60.0, 15.1, *nightly(60.0)])
def test_a_picture_that_turned_beyond_its_heading_is_not_mapped_nor_are_those_just_after_it(
    turn: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    frames = left_out({3: 0.0, 5: turn, 6: 0.0}, monkeypatch)
    assert frames[0].sequence == 5
    began = frames[0].captured
    assert frames == [frame for frame in flight(40) if 0.0 <= frame.captured - began < TURNED_S]


@pytest.mark.nightly
def test_a_turn_of_a_late_picture_is_mapped(monkeypatch: pytest.MonkeyPatch) -> None:
    assert left_out({3: 6.0, 4: -14.9}, monkeypatch) == []


@pytest.mark.slow
@pytest.mark.parametrize("fault", [NoImage("torn"), AlgoError("no ground"), RuntimeError("bug")])
def test_a_fault_of_vision_is_reported_and_mapper_and_planner_go_on(rig: Rig, fault: Exception) -> None:
    before = rig.mapper.get_occupancy_map()
    rig.vision.fault = fault
    output = rig.run(replace(flight(21)[-1]))
    assert not output.vision_health.is_healthy
    assert str(fault) in output.vision_health.reason
    assert not output.park_lot_detected
    assert output.mapper_health.is_healthy
    assert output.path_plan_health.is_healthy
    assert output.occupancy_map.stalls == before.stalls
    assert output.path_plan.target is not None


def test_a_fault_of_the_mapper_is_reported_and_the_planner_goes_on(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rig.mapper, "fuse", _broken)
    output = rig.run(flight(21)[-1])
    assert output.vision_health.is_healthy
    assert output.mapper_health.reason == "unexpected ZeroDivisionError: division by zero"
    assert output.path_plan_health.is_healthy
    assert output.annotated_jpeg


def test_a_fault_of_the_planner_leaves_no_target_standing(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rig.path_plan, "_planned", _broken)
    output = rig.run(flight(21)[-1])
    assert output.path_plan.target is None
    assert output.path_plan.verdict is None
    assert not output.path_plan_health.is_healthy
    assert output.mapper_health.is_healthy


def test_process_raises_naming_each_that_failed_after_all_ran(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = Rig(fault=AlgoError("blind"))
    monkeypatch.setattr(rig.path_plan, "_planned", _broken)
    rig.interface.begin(flight(1)[0])
    with pytest.raises(AlgoError, match=r"vision: blind; path plan: unexpected ZeroDivisionError"):
        rig.manager.process()
    assert rig.interface.mapper_app_health_pub.value.is_healthy


@pytest.mark.parametrize("part", ["vision", "mapper", "path plan"])
def test_process_raises_when_one_app_alone_fails(rig: Rig, part: str, monkeypatch: pytest.MonkeyPatch) -> None:
    steps = {"vision": (rig.vision, "see"), "mapper": (rig.mapper, "fuse"), "path plan": (rig.path_plan, "_planned")}
    monkeypatch.setattr(*steps[part], _broken)
    rig.interface.begin(flight(21)[-1])
    with pytest.raises(AlgoError, match=rf"^{part}: unexpected ZeroDivisionError: division by zero$"):
        rig.manager.process()
    healths = {
        "mapper": rig.interface.mapper_app_health_pub.value,
        "path plan": rig.interface.path_plan_app_health_pub.value,
    }
    assert [name for name, health in healths.items() if not health.is_healthy] == [part][part == "vision" :]


@pytest.mark.slow
def test_the_pictures_of_a_frozen_camera_are_not_mapped(rig: Rig) -> None:
    before = rig.mapper.get_occupancy_map()
    frames = [replace(frame, jpeg=b"frozen") for frame in flight(30)[20:]]
    assert all(rig.run(frame).camera_health.is_healthy for frame in frames[:2])
    version = rig.mapper.get_occupancy_map().version
    assert version == before.version + 2
    outputs = [rig.run(frame) for frame in frames[2:]]
    assert all("stands still" in output.camera_health.reason for output in outputs)
    assert rig.mapper.get_occupancy_map().version == version
    assert all(output.vision_health.is_healthy and output.annotated_jpeg for output in outputs)


@pytest.mark.fault("the check of the camera fails", "camera unhealthy with that frame")
def test_a_check_of_the_camera_that_fails_is_no_healthy_camera(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rig.check, "look", _broken)
    output = rig.run(flight(21)[-1])
    assert output.camera_health.reason == "unexpected ZeroDivisionError: division by zero"
    assert output.mapper_health.is_healthy
    assert output.path_plan.target is not None


def test_health_comes_back_with_the_next_good_frame() -> None:
    rig = Rig(fault=NoImage("torn"))
    frames = flight(2)
    assert not rig.run(frames[0]).vision_health.is_healthy
    rig.vision.fault = None
    assert rig.run(frames[1]).vision_health.is_healthy


def test_without_a_pose_there_is_a_picture_and_no_map() -> None:
    output = Rig().run(frame_at(None))
    assert output.annotated_jpeg
    assert output.footprint == ()
    assert output.occupancy_map.counts.total == 0
    assert output.path_plan.target is None


def test_a_picture_that_cannot_be_drawn_on_costs_only_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = Rig()
    monkeypatch.setattr(rig.vision, "see", lambda _: VisionResult(image=np.zeros((0, 0, 3), np.uint8)))
    output = rig.run(flight(1)[0])
    assert output.annotated_jpeg == b""
    assert output.mapper_health.is_healthy


def _broken(*_: object) -> None:
    raise ZeroDivisionError("division by zero")


def test_private_ground_is_in_no_picture_and_on_no_map_while_the_witnesses_see_the_whole_picture() -> None:
    garden = ((-13.0, -30.0), (-13.0, 30.0), (-3.0, 30.0), (-3.0, -30.0))
    rig, plain = Rig(with_picture=True), Rig(with_picture=True)
    witnessed: list[int] = []
    look = rig.check.look

    def watched(frame: FrameInput, image: Any) -> Health:
        witnessed.append(int(np.count_nonzero(image == 0)))
        return look(frame, image)

    rig.check.look = watched  # type: ignore[method-assign]
    for frame in flight(20):
        output = rig.run(replace(frame, private=(garden,)))
        whole = plain.run(frame)
    rig.mapper.finish()
    assert witnessed == [0] * 20
    assert output.recorded_jpeg
    assert whole.recorded_jpeg is None
    kept = [stall for stall in output.occupancy_map.stalls.values() if -12.0 < stall.north < -4.0]
    assert (kept, len(whole.occupancy_map.stalls) > len(output.occupancy_map.stalls) > 5) == ([], True)
    seen = 0
    for (row, column), tile in rig.mapper.get_occupancy_map().mosaic.items():
        mask = decode_picture(tile.data)[1]
        north = -row * TILE_M - (np.arange(TILE_CELLS) + 0.5) * CELL_M
        east = column * TILE_M + (np.arange(TILE_CELLS) + 0.5) * CELL_M
        hidden = ((north > -12.8) & (north < -3.2))[:, None] & (np.abs(east) < 29.8)
        assert not mask[hidden].any(), (row, column)
        seen += int(np.count_nonzero(mask))
    assert seen > 10_000
    cells = SurveyMap.of(GlobalPose(52.0, 5.0, 0.0), rig.mapper.get_occupancy_map()).cells()
    ((column, row),) = np.floor(cells.to_pixels(np.array([(-8.0, -10.0)]))).astype(int)
    assert cells.values[row, column] == Cell.NON_LOT, "no flight waits for it"
