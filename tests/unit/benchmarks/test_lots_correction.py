"""A plan that a person corrects by the lot's picture: what is removed and added, and where."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.chain_flight.views import Views
from benchmarks.lots.archive import store_look, stored_ids
from benchmarks.lots.correction import correct, edited, fitted, shapes_of
from benchmarks.lots.looks import StillEye
from benchmarks.lots.visits import DrawnLot
from hawk.algo.vision.network import StallNetwork
from hawk.lots.plan.queries import all_stalls
from hawk.lots.registration.frames import Move
from hawk.lots.storage.database import Database
from hawk.worlds.world import TrueStall, World

PLACES = np.array([(0.0, 0.0), (30.0, 2.0), (-7.0, 21.0), (11.0, 40.0)])


@given(st.floats(-200, 200), st.floats(-200, 200), st.floats(-1.5, 1.5))
def test_a_rigid_move_is_found_again(north: float, east: float, turn: float) -> None:
    move = Move(north, east, turn)
    found = fitted(PLACES, move.of(PLACES))
    assert (found.north, found.east, found.turn) == pytest.approx((north, east, turn), abs=1e-6)


@given(st.floats(0.0, math.pi - 1e-3), st.floats(2.0, 3.0), st.floats(4.5, 6.0))
def test_a_shape_is_read_from_its_corners(angle: float, width: float, length: float) -> None:
    """North is up the picture, so that (x, y) is (east, -north) from its corner."""
    along = np.array([math.sin(angle), -math.cos(angle)]) * length / 2
    aside = np.array([math.cos(angle), math.sin(angle)]) * width / 2
    middle = np.array([50.0, 20.0])
    corners = np.array([middle + along - aside, middle + along + aside, middle - along + aside, middle - along - aside])
    world = World(
        "w", 0.1, np.zeros((8, 8, 3), np.uint8), stalls=(TrueStall(7, corners, taken=False),), start_m=(40.0, 25.0)
    )
    north, east, found, wide, long = shapes_of(world)[7]
    assert (north, east) == pytest.approx((5.0, 10.0))
    assert math.sin(found - angle) == pytest.approx(0.0, abs=1e-6)
    assert (wide, long) == pytest.approx((width, length))


@pytest.mark.slow
@pytest.mark.nightly
def test_the_corrected_plan_has_every_true_stall_at_its_place(tmp_path: Path) -> None:
    lot = DrawnLot(4)
    visit = lot.visits()[0]
    world = lot.world(visit)
    look = StillEye(StallNetwork.load(None)).look(world, visit)
    look = replace(look, survey=replace(look.survey, stalls=look.survey.stalls[5:]))
    store = Database(tmp_path / "lots.db", {"synchronous": 0})
    saved = store_look(store, look)
    assert saved.lot is not None
    whole = [stall.id for stall, yes in zip(world.stalls, Views(world).counted, strict=True) if yes]
    with store.writing() as connection:
        true = {stored: number for number, stored in stored_ids(connection, saved.survey, look).items()}
        with edited(connection, saved.lot) as do:
            mended = correct(connection, saved.lot, do, world, true, whole)
        stalls = all_stalls(connection, saved.lot)
    store.close()
    assert mended.removed + mended.added >= 4, "five finds were left out, of which a false one or two may be"
    assert mended.true.keys() == {stall.id for stall in stalls}
    assert set(whole) <= set(mended.true.values())
    shapes = shapes_of(world)
    places = np.array([(each.north, each.east) for each in stalls])
    shown = np.array([shapes[number][:2] for number in whole])
    offset = Move(turn=visit.compass).of(shown)
    shift = np.median([places[np.argmin(np.hypot(*(places - place).T))] - place for place in offset], axis=0)
    away = [np.hypot(*(places - place - shift).T).min() for place in offset]
    assert max(away) < 1.5
