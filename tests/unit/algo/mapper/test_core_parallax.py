"""Objects above the ground move against it; no other error of a flight is mistaken for that."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.mapper import stalls as stalls_module
from hawk.algo.mapper.core import MapCore, MapperSettings
from hawk.algo.mapper.register import Slip
from hawk.algo.mapper.table import STALL_DTYPE, from_bytes, to_bytes
from hawk.algo.vision.detection import FrameGround
from tests.examples import nightly
from tests.unit.algo.synthetic import SyntheticVision, Truth, pose_at, rows_lot, stretched

HEIGHT_M = 35.0
ROOF_EAST_M = 6.0

Floats = NDArray[np.float64]


def on_roof(stalls: Floats) -> NDArray[np.bool_]:
    return np.asarray((stalls[:, 0] > 9) & (stalls[:, 1] > ROOF_EAST_M))


def look(
    truth: Truth, raised_m: float, east: float, time: float, reported_m: float, rng: np.random.Generator
) -> FrameGround:
    """Some of the lot's stalls stand ``raised_m`` higher than the others."""
    pose = pose_at(4.0, east, math.pi / 2, reported_m)
    raised = stretched(truth, (pose.north, pose.east), HEIGHT_M / (HEIGHT_M - raised_m))
    stalls = np.where(on_roof(truth.stalls)[:, None], raised.stalls, truth.stalls)
    vision = SyntheticVision(Truth(truth.lot, stalls, truth.taken), rng=rng, noise_m=0.12, true_height=HEIGHT_M)
    return vision.look(pose, time)


def fly(raised_m: float, reported_m: float = HEIGHT_M) -> tuple[int, int, MapCore]:
    """Fly over a lot; return how many stalls count on the ground and on the roof."""
    truth, rng, core = rows_lot(), np.random.default_rng(1), MapCore(MapperSettings(), "m")
    for number, east in enumerate(np.arange(-24, 40, 0.8)):
        core.fuse(look(truth, raised_m, float(east), number * 0.2, reported_m, rng))
    core.encode(None)
    places = np.array([(s.north, s.east) for s in core.index.stalls.values()])
    roof = (places[:, 0] > 7) & (places[:, 1] > ROOF_EAST_M - 1)
    return int((~roof).sum()), int(roof.sum()), core


ALL = len(rows_lot().stalls)
RAISED = int(on_roof(rows_lot().stalls).sum())


@pytest.fixture(scope="module")
def level() -> tuple[int, int, MapCore]:
    """A flight over stalls that all lie on the ground; no test changes its map."""
    return fly(0.0)


@pytest.mark.nightly
@pytest.mark.parametrize("height", [5.0, *nightly(8.0)])
def test_stalls_on_a_roof_do_not_count(height: float) -> None:
    ground, roof, _ = fly(height)
    assert ground == pytest.approx(ALL - RAISED, abs=1)
    assert roof <= 1


@pytest.mark.nightly
def test_without_the_rule_for_raised_stalls_they_would_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stalls_module, "RAISED", 9.0)
    assert fly(5.0)[1] >= RAISED / 2


@pytest.mark.nightly
def test_stalls_on_the_ground_all_count(level: tuple[int, int, MapCore]) -> None:
    ground, roof, core = level
    assert ground + roof == ALL
    assert not core.tracker.rows["raised"].any()
    assert np.abs(core.tracker.rows["lean"]).max() < 0.1


@pytest.mark.flight
@pytest.mark.parametrize("factor", [0.85, 1.15])
def test_a_wrong_height_raises_no_stall(factor: float) -> None:
    *_, core = fly(0.0, HEIGHT_M * factor)
    assert len(core.index.stalls) > ALL / 2
    assert not core.tracker.rows["raised"].any()


def test_the_lean_is_the_height_by_what_the_drone_is_above_it() -> None:
    slip, ground = Slip(), np.array([(6.0 * j, 2.6 * k, 0.0) for j in range(3) for k in range(8)])
    for east in (5.0, 8.2):
        places = ground.copy()
        places[-4:, :2] = (8, east) + (ground[-4:, :2] - (8, east)) * 35 / (35 - 6)
        slip.move(places, (8.0, east), east / 4)
    assert slip.leans[-4:] == pytest.approx([6 / 29] * 4)
    assert slip.leans[:-4] == pytest.approx([0.0] * 20, abs=1e-9)


def test_one_look_is_not_enough_for_a_little_lean_but_for_a_large_one() -> None:
    rows = np.zeros(3, STALL_DTYPE)
    stalls_module.note_leans(rows, np.array([0.12, 0.3, np.nan]))
    assert rows["raised"].tolist() == [False, True, False]
    for _ in range(19):
        stalls_module.note_leans(rows, np.array([0.13, 0.0, np.nan]))
    assert rows["raised"].tolist() == [True, False, False]
    assert rows["lean_looks"].tolist() == [20, 20, 0]


@pytest.mark.flight
def test_a_journal_from_before_is_read(level: tuple[int, int, MapCore]) -> None:
    row = level[2].tracker.rows[0]
    kept = {k: v for k, v in json.loads(to_bytes(row)).items() if not k.startswith("lean") and k != "raised"}
    old = from_bytes(json.dumps(kept).encode())[0]
    assert old["north"] == row["north"]
    assert old["lean_looks"] == 0
    with pytest.raises(ValueError, match="not a stall"):
        from_bytes(json.dumps({k: v for k, v in kept.items() if k != "north"}).encode())
