from __future__ import annotations

import base64
import zlib

import numpy as np
import pytest

from hawk.comm.protocol.heartbeat import MapUpdate, MosaicVersion, StallUpdate, TileUpdate
from hawk.model.lot_map import TILE_CELLS, Cell, StallState
from hawk.model.poses import GlobalPose
from hawk.survey.client import BadMapError, ClientMap


def pack(raw: bytes) -> str:
    return base64.b64encode(zlib.compress(raw)).decode()


def update(
    data: str | None = None, stalls: list[StallUpdate] | None = None, map_id: str = "m", backlog: int = 0
) -> MapUpdate:
    tiles = [] if data is None else [TileUpdate(row=-1, column=2, version=1, data=data)]
    mosaic = [MosaicVersion(row=-1, column=2, version=4)]
    return MapUpdate(map_id=map_id, tiles=tiles, stalls=stalls or [], mosaic=mosaic, backlog=backlog)


def stall(number: int, state: str = "free") -> StallUpdate:
    return StallUpdate(
        id=number, version=1, north=1.0, east=2.0, angle=0.5, width=2.5, length=5.0,
        state=state, taken=0.2, seen=3, last_seen=9.0, score=0.8,  # type: ignore[arg-type]
    )  # fmt: skip


LOT = bytes([Cell.LOT]) * TILE_CELLS**2


def test_updates_become_the_map_of_a_survey() -> None:
    held = ClientMap()
    held.apply(update(pack(LOT), [stall(1), stall(2, "taken"), stall(3, "unknown")], backlog=5))
    assert held.backlog == 5
    survey = held.survey_map(GlobalPose(43.0, -79.0, 0.0), {(-1, 2): b"jpeg"})
    assert (survey.counts.free, survey.counts.taken, survey.counts.unknown) == (1, 1, 1)
    assert survey.stalls[2].state is StallState.TAKEN
    assert np.all(survey.tiles[-1, 2] == Cell.LOT)
    assert survey.mosaic == {(-1, 2): b"jpeg"}
    assert held.mosaic == {(-1, 2): 4}


def test_a_stall_of_a_known_lot_has_the_label_of_its_plan() -> None:
    held = ClientMap()
    held.apply(update(stalls=[stall(1).model_copy(update={"label": "B 12"}), stall(2)]))
    assert [held.stalls[number].label for number in (1, 2)] == ["B 12", ""]


def test_what_is_removed_goes_and_removing_twice_is_no_error() -> None:
    held = ClientMap()
    held.apply(update(stalls=[stall(1), stall(2)]))
    gone = StallUpdate(id=1, version=2, removed=True)
    held.apply(update(stalls=[gone]))
    held.apply(update(stalls=[gone]))
    assert set(held.stalls) == {2}


def test_another_map_replaces_all() -> None:
    held = ClientMap()
    held.apply(update(pack(LOT), [stall(1)]))
    held.apply(update(map_id="other"))
    assert (held.tiles, held.stalls) == ({}, {})


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ("not base64!", "unpacked"),
        (base64.b64encode(b"not zlib").decode(), "unpacked"),
        (pack(LOT[:-1]), "65535 cells"),
        (pack(LOT + b"\x00"), "65537 cells"),
        (pack(bytes(10**7)), "65537 cells"),
        (pack(LOT[:-1] + b"\x09"), "class 9"),
    ],
)
def test_a_tile_that_cannot_be_one_is_refused(data: str, said: str) -> None:
    with pytest.raises(BadMapError, match=said):
        ClientMap().apply(update(data))


def test_a_stall_without_its_place_is_refused() -> None:
    with pytest.raises(BadMapError, match="stall 7"):
        ClientMap().apply(update(stalls=[StallUpdate(id=7, version=1, state="free", north=1.0)]))
