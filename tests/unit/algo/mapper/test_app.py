from __future__ import annotations

import copy
import math
import zlib
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from hawk.algo.frame import AlgoError
from hawk.algo.mapper.app import MapperApp
from hawk.algo.mapper.core import MapperSettings
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.model.lot_map import TILE_CELLS, Cell, OccupancyMap, Stall, StallState, variance_of
from hawk.model.plans import Inbound
from hawk.model.poses import MapPose
from hawk.model.tile_picture import decode_picture
from tests.unit.algo.synthetic import SyntheticVision, Truth, frame_at, pose_at, rows_lot


class Rig:
    """Mapper and a vision that sees a known lot."""

    def __init__(self, truth: Truth | None = None, settings: MapperSettings | None = None, **faults: object) -> None:
        self.truth = truth or rows_lot(turn=0.3)
        self.vision = SyntheticVision(self.truth, **faults)  # type: ignore[arg-type]
        self.interface = AlgorithmTopicInterface()
        self.mapper = MapperApp(settings, map_id="survey")
        self.vision.init(FrameCamera(self.interface), self.interface)
        self.mapper.init(self.vision, self.interface)
        self.sequence = 0

    def frame(self, pose: MapPose | None) -> None:
        self.sequence += 1
        self.interface.begin(frame_at(pose, self.sequence))
        self.vision.process()
        self.mapper.process()
        self.mapper.publish()

    def fly(self, easts: Iterable[float], north: float = 0.0) -> None:
        for east in easts:
            self.frame(pose_at(north, float(east), math.pi / 2))

    @property
    def map(self) -> OccupancyMap:
        return self.interface.occupancy_map_pub.value

    def unmatched(self, stalls: Iterable[Stall]) -> int:
        """Stalls that are not within 0.5 m of a true one of the right state."""
        wrong = 0
        for stall in stalls:
            distance = np.hypot(self.truth.stalls[:, 0] - stall.north, self.truth.stalls[:, 1] - stall.east)
            taken = self.truth.taken[np.argmin(distance)]
            wrong += distance.min() > 0.5 or stall.state is not (StallState.TAKEN if taken else StallState.FREE)
        return wrong


PASS = np.arange(-30, 31, 1.0)


@pytest.fixture(scope="module")
def flown() -> Rig:
    rig = Rig(noise_m=0.15, miss=0.15, state_error=0.1, rng=np.random.default_rng(1), with_picture=True)
    rig.fly(PASS)
    rig.fly([30.0] * 12)
    return rig


@pytest.fixture(scope="module")
def flown_20() -> Rig:
    rig = Rig()
    rig.fly(PASS[:20])
    return rig


@pytest.fixture(scope="module")
def flown_pass(flown_20: Rig) -> Rig:
    rig = copy.deepcopy(flown_20)
    rig.fly(PASS[20:])
    return rig


@pytest.fixture
def after_20(flown_20: Rig) -> Rig:
    """A rig of the test's own after twenty frames."""
    return copy.deepcopy(flown_20)


@pytest.fixture
def after_pass(flown_pass: Rig) -> Rig:
    """A rig of the test's own after a whole pass."""
    return copy.deepcopy(flown_pass)


@pytest.mark.nightly
def test_every_stall_is_found_once_and_in_its_state(flown: Rig) -> None:
    assert flown.map.counts.total == len(flown.truth.stalls)
    assert flown.unmatched(flown.map.stalls.values()) == 0
    assert flown.map.counts.taken == int(flown.truth.taken.sum())


@pytest.mark.slow
def test_the_spread_of_the_count_is_that_of_the_published_stalls_through_a_flight() -> None:
    rig = Rig(miss=0.2, state_error=0.2, false_alarms=[(5.0, 30.0)])
    for east in PASS[::2]:
        rig.fly([east])
        assert rig.map.counts.free_variance == pytest.approx(variance_of(rig.map.stalls.values()), abs=1e-4)
    assert rig.map.counts.free_variance > 0


@pytest.mark.slow
def test_the_map_shows_lot_and_stalls_where_they_are(flown: Rig) -> None:
    cells = np.concatenate([np.frombuffer(zlib.decompress(t.data), np.uint8) for t in flown.map.tiles.values()])
    free = int((~flown.truth.taken).sum()) * 2.6 * 5.2
    assert np.count_nonzero(cells == Cell.FREE) * 0.01 == pytest.approx(free, rel=0.06)
    assert flown.map.lot_area_m2 > 1500
    assert all(len(zlib.decompress(t.data)) == TILE_CELLS**2 for t in flown.map.tiles.values())


@pytest.mark.slow
def test_the_mosaic_is_there(flown: Rig) -> None:
    assert set(flown.map.mosaic) >= {(0, 0), (0, -1), (-1, 0), (-1, -1)}


def pictured_m2(found: OccupancyMap) -> float:
    return sum(np.count_nonzero(decode_picture(tile.data)[1]) for tile in found.mosaic.values()) * 0.01


@pytest.mark.slow
def test_a_turn_on_the_spot_and_its_frames_in_a_hurry_get_into_the_picture() -> None:
    rig = Rig(with_picture=True)
    turn = np.linspace(0, math.pi / 2, 9)
    for yaw in turn:
        rig.frame(pose_at(0.0, 0.0, float(yaw)))
    for _ in range(60):
        rig.frame(pose_at(0.0, 0.0, math.pi / 2))
    width, height = 49.0 - 1.2, 27.6 - 1.2
    assert pictured_m2(rig.map) > 1.3 * width * height, "pictures of every heading"
    shown = {key: tile.version for key, tile in rig.map.mosaic.items()}
    for _ in range(10):
        rig.frame(pose_at(0.0, 0.0, math.pi / 2))
    assert {key: tile.version for key, tile in rig.map.mosaic.items()} == shown


def test_places_are_inside_outside_or_unknown(flown: Rig) -> None:
    assert flown.mapper.inbound(0.0, 0.0) is Inbound.INSIDE
    assert flown.mapper.inbound(-1.0, 41.0) is Inbound.OUTSIDE
    assert flown.mapper.inbound(300.0, 0.0) is Inbound.UNKNOWN
    assert flown.mapper.inbound(math.nan, 0.0) is Inbound.UNKNOWN


def test_the_index_is_immutable_and_published_ones_do_not_change(flown: Rig) -> None:
    before = flown.map
    stalls = dict(before.stalls)
    flown.fly([29.0, 28.0])
    assert dict(before.stalls) == stalls
    with pytest.raises(TypeError):
        before.stalls[1] = next(iter(stalls.values()))  # type: ignore[index]


@pytest.mark.nightly
def test_versions_do_not_rise_while_nothing_changes() -> None:
    rig = Rig()
    rig.fly([0.0] * 40)
    tiles = {key: tile.version for key, tile in rig.map.tiles.items()}
    rig.fly([0.0] * 10)
    assert {key: tile.version for key, tile in rig.map.tiles.items()} == tiles


@pytest.mark.slow
def test_a_changed_stall_carries_the_version_of_the_map_that_first_shows_it() -> None:
    rig = Rig()
    seen: dict[int, Stall] = {}
    for east in PASS[:30]:
        rig.fly([east])
        for i, stall in rig.map.stalls.items():
            if seen.get(i) != stall:
                assert stall.version == rig.map.version
        seen = dict(rig.map.stalls)


@pytest.mark.nightly
def test_false_alarms_of_single_frames_do_not_count() -> None:
    rig = Rig(false_alarms=[])
    for i, east in enumerate(PASS):
        rig.vision.false_alarms = [(20.0 + i, 15.0)] if i % 10 == 0 else []
        rig.fly([east])
    assert rig.unmatched(rig.map.stalls.values()) == 0


@pytest.mark.nightly
def test_a_pose_that_drifts_by_more_than_half_a_pitch_does_not_double_stalls(after_pass: Rig) -> None:
    rig = after_pass
    for i, east in enumerate(PASS[::-1]):
        rig.vision.pose_error = (min(i * 0.04, 1.0), min(i * 0.06, 1.5))
        rig.fly([east])
    assert rig.map.counts.total == len(rig.truth.stalls)


@pytest.mark.slow
def test_without_a_pose_the_map_stays_and_is_healthy(after_20: Rig) -> None:
    rig = after_20
    before = rig.map.stalls
    rig.frame(None)
    assert rig.map.stalls == before
    assert rig.mapper.get_health().is_healthy


def test_what_vision_saw_in_an_older_frame_is_not_fused_twice() -> None:
    rig = Rig()
    rig.fly([0.0])
    version = rig.map.version
    rig.interface.begin(frame_at(pose_at(0, 5), 99))
    rig.mapper.process()
    assert rig.mapper.get_occupancy_map().version == version


@pytest.mark.slow
def test_a_picture_that_does_not_fit_is_an_error_and_changes_nothing(after_20: Rig) -> None:
    rig = after_20
    before = rig.map
    rig.interface.begin(frame_at(pose_at(0, 0), 99))
    rig.vision.process()
    ground = rig.vision.seen.ground
    assert ground is not None
    bad = replace(ground.lot, to_map=np.full((2, 3), math.nan))
    rig.vision.seen = replace(rig.vision.seen, ground=replace(ground, lot=bad))
    with pytest.raises(AlgoError, match="lot picture does not fit"):
        rig.mapper.process()
    assert not rig.mapper.get_health().is_healthy
    assert rig.mapper.get_occupancy_map() is before
    rig.fly([1.0])
    assert rig.mapper.get_health().is_healthy


def test_a_pose_that_is_not_finite_is_an_error() -> None:
    rig = Rig()
    rig.fly([0.0])
    assert rig.vision.seen.ground is not None
    frame = frame_at(replace(pose_at(0, 0), height=math.inf), 1)
    rig.interface.begin(frame)
    with pytest.raises(AlgoError, match="not finite"):
        rig.mapper.process()


def test_not_initialised_is_said() -> None:
    with pytest.raises(AlgoError, match="not initialised"):
        MapperApp().process()
    assert not MapperApp().get_health().is_healthy


@pytest.mark.flight
def test_a_map_restored_from_its_deltas_goes_on_with_the_same_ids() -> None:
    """A killed process leaves only the journal's content of its last frame."""
    rig, parts, version = Rig(with_picture=True), [], 0
    for east in PASS[:40]:
        rig.fly([east])
        delta = rig.mapper.changes_since(version)
        parts.append(delta.parts)
        version = delta.version
    killed = rig.map
    again = Rig()
    assert again.mapper.restore(parts) == []
    restored = again.mapper.get_occupancy_map()
    assert restored.map_id == "survey"
    assert set(restored.stalls) == set(killed.stalls)
    assert replace(restored.counts, free_variance=0.0) == replace(killed.counts, free_variance=0.0)
    assert restored.counts.free_variance == pytest.approx(killed.counts.free_variance, rel=0.2)
    assert set(restored.tiles) == set(killed.tiles)
    assert set(restored.mosaic) == set(killed.mosaic)
    again.sequence = 1000
    again.fly(PASS[40:])
    assert again.map.counts.total == len(rig.truth.stalls)
    assert set(killed.stalls) <= set(again.map.stalls)
    assert again.map.version > killed.version


@pytest.mark.slow
def test_a_delta_holds_only_what_changed(after_pass: Rig) -> None:
    rig = after_pass
    version = rig.mapper.changes_since(0).version
    assert set(rig.mapper.changes_since(version).parts) == {"meta"}
    rig.fly([30.0])
    changed = rig.mapper.changes_since(version).parts
    assert 0 < sum(name.startswith("grid/") for name in changed) < len(rig.map.tiles)


@pytest.mark.slow
def test_a_stall_that_went_is_gone_after_a_restore() -> None:
    rig = Rig()
    rig.fly([0.0] * 10)
    first = rig.mapper.changes_since(0)
    doomed = min(rig.map.stalls.values(), key=lambda s: math.hypot(s.north, s.east)).id
    keep = np.array([i for i, s in enumerate(rig.truth.stalls) if not _is_at(s, rig.map.stalls[doomed])])
    rig.vision.truth = Truth(rig.truth.lot, rig.truth.stalls[keep], rig.truth.taken[keep])
    rig.fly(np.tile([0.0, 5.0], 30))
    assert doomed not in rig.map.stalls
    again = Rig()
    again.mapper.restore([first.parts, rig.mapper.changes_since(first.version).parts])
    assert set(again.mapper.get_occupancy_map().stalls) == set(rig.map.stalls)


def test_parts_that_cannot_be_read_are_named_and_the_rest_is_kept(after_20: Rig) -> None:
    rig = after_20
    parts = dict(rig.mapper.changes_since(0).parts)
    stalls = [name for name in parts if name.startswith("stall/")]
    parts |= {"grid/0,0": b"torn", "grid/x": b"", "nonsense": b"1", stalls[0]: b"{"}
    again = Rig()
    problems = again.mapper.restore([parts])
    assert sorted(problem.partition(":")[0] for problem in problems) == sorted(
        ["grid/0,0", "grid/x", "nonsense", stalls[0]]
    )
    assert len(again.mapper.get_occupancy_map().stalls) == len(stalls) - 1


def _is_at(row: np.ndarray, stall: Stall) -> bool:
    return bool(math.hypot(row[0] - stall.north, row[1] - stall.east) < 0.5)


@pytest.mark.fault("local and global position jump together by 25 m (EKF reset after a GPS glitch) while the map grows")
def test_a_frame_whose_position_jumped_is_not_mapped_and_the_next_good_one_is(flown_20: Rig) -> None:
    rig = copy.deepcopy(flown_20)
    before = rig.map
    jumped = replace(frame_at(pose_at(25.0, -10.0, math.pi / 2), 900), map_problem="the position jumped by 25 m")
    rig.interface.begin(jumped)
    rig.vision.process()
    rig.mapper.process()
    rig.mapper.publish()
    assert rig.interface.mapper_app_health_pub.value.reason == "the position jumped by 25 m"
    assert (rig.map.version, rig.map.stalls) == (before.version, before.stalls)
    rig.frame(pose_at(0.0, -10.0, math.pi / 2))
    assert rig.mapper.get_health().is_healthy
    assert rig.map.version == before.version + 1
