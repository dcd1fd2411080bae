"""A plan that a person corrects by the lot's picture: what is removed and added, and where."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.again.corrected import box_of, correct, fitted
from benchmarks.again.visits import Watch
from benchmarks.lots.archive import stored_ids
from benchmarks.lots.looks import StillEye
from benchmarks.lots.visits import DrawnLot
from hawk.algo.vision.network import StallNetwork
from hawk.daemon.lot_keeper import find_stalls
from hawk.lots.ingest import save
from hawk.lots.plan.queries import all_stalls
from hawk.lots.registration.frames import Move
from hawk.lots.storage.database import Database

PLACES = np.array([(0.0, 0.0), (30.0, 2.0), (-7.0, 21.0), (11.0, 40.0)])


@given(st.floats(-200, 200), st.floats(-200, 200), st.floats(-1.5, 1.5))
def test_a_rigid_move_is_found_again(north: float, east: float, turn: float) -> None:
    move = Move(north, east, turn)
    found = fitted(PLACES, move.of(PLACES))
    assert (found.north, found.east, found.turn) == pytest.approx((north, east, turn), abs=1e-6)


@given(st.floats(0.0, math.pi - 1e-3), st.floats(2.0, 3.0), st.floats(4.5, 6.0))
def test_a_box_is_read_from_its_corners(angle: float, width: float, length: float) -> None:
    """North is up the picture, so that (x, y) is (east, -north) from its corner."""
    along = np.array([math.sin(angle), -math.cos(angle)]) * length / 2
    aside = np.array([math.cos(angle), math.sin(angle)]) * width / 2
    middle = np.array([50.0, 20.0])
    corners = np.array([middle + along - aside, middle + along + aside, middle - along + aside, middle - along - aside])
    north, east, found, wide, long = box_of(corners, (40.0, 25.0))
    assert (north, east) == pytest.approx((5.0, 10.0))
    assert math.sin(found - angle) == pytest.approx(0.0, abs=1e-6)
    assert (wide, long) == pytest.approx((width, length))


@pytest.mark.slow
def test_the_corrected_plan_has_every_true_stall_at_its_place(tmp_path: Path) -> None:
    lot = DrawnLot(4)
    visit = lot.visits()[0]
    world = lot.world(visit)
    look = StillEye(StallNetwork.load(None)).look(world, visit, None)
    survey = replace(
        look.survey, stalls=tuple(replace(stall, looked=float(stall.id)) for stall in look.survey.stalls[5:])
    )
    store = Database(tmp_path / "lots.db", {"synchronous": 0})
    with store.writing() as connection:
        saved = save(connection, survey, find_stalls)
        assert saved.lot is not None
        ids = stored_ids(connection, saved, look)
        whole = [stall.id for stall, yes in zip(world.stalls, Watch(world).counted, strict=True) if yes]
        mended = correct(connection, saved.lot, world, ids, whole)
        stalls = all_stalls(connection, saved.lot)
    store.close()
    assert mended >= 4, "five finds were left out, of which a false one or two may be"
    assert all(stall.is_confirmed for stall in stalls)
    true = {stall.id: box_of(stall.corners, world.start()) for stall in world.stalls}
    places = np.array([(each.north, each.east) for each in stalls])
    shown = np.array([true[number][:2] for number in whole])
    offset = Move(turn=visit.compass).of(shown)
    shift = np.median([places[np.argmin(np.hypot(*(places - place).T))] - place for place in offset], axis=0)
    away = [np.hypot(*(places - place - shift).T).min() for place in offset]
    assert max(away) < 1.5
