from __future__ import annotations

import random
import zlib
from dataclasses import replace
from unittest import mock

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.comm.protocol.heartbeat import MapUpdate
from hawk.lots.plan.operations import LONGEST_LABEL
from hawk.model.lot_map import TILE_CELLS, EncodedTile, OccupancyMap, Stall, StallState, TileKey
from hawk.model.poses import MapPoint
from hawk.model.shards import Sharded
from hawk.survey.client import ClientMap
from hawk.web import map_view
from hawk.web.map_view import BUDGET_BYTES, MapView

HERE = MapPoint(0.0, 0.0)


def tile(fill: int, version: int) -> EncodedTile:
    return EncodedTile(version, zlib.compress(bytes([fill % 5]) * TILE_CELLS**2, 1))


def heavy_tile(seed: int, version: int = 1) -> EncodedTile:
    cells = np.random.default_rng(seed).integers(0, 5, TILE_CELLS**2, np.uint8)
    return EncodedTile(version, zlib.compress(cells.tobytes(), 1))


def stall(number: int, version: int = 1, north: float = 1.0, state: StallState = StallState.FREE) -> Stall:
    return Stall(number, north, 2.0, 0.5, 2.6, 5.4, 0.25, state, 0.9, 3, 12.0, version)


def over_the_wire(update: MapUpdate) -> MapUpdate:
    text = update.to_json()
    assert len(text) <= BUDGET_BYTES
    return MapUpdate.model_validate_json(text)


class Model:
    """The server's map, changed step by step."""

    def __init__(self) -> None:
        self.now = OccupancyMap(map_id="m0")
        self._version = 0

    def change(self, action: str, number: int, fill: int) -> None:
        self._version += 1
        tiles, mosaic, stalls = dict(self.now.tiles), dict(self.now.mosaic), dict(self.now.stalls)
        key = (number // 5 - 2, number % 5 - 2)
        if action == "tile":
            tiles[key] = tile(fill, self._version)
        elif action == "heavy":
            tiles[key] = heavy_tile(fill, self._version)
        elif action == "mosaic":
            mosaic[key] = EncodedTile(self._version, b"jpeg")
        elif action == "stall":
            stalls[number] = stall(number, self._version, float(fill))
        elif action == "many":
            stalls |= {n: stall(n, self._version, float(n)) for n in range(1000, 1400)}
        elif action == "gone":
            stalls = {n: s for n, s in stalls.items() if n % 7 != number % 7}
        elif action == "another map":
            tiles, mosaic, stalls = {}, {}, {}
        map_id = f"m{self._version}" if action == "another map" else self.now.map_id
        self.now = OccupancyMap(tiles, mosaic, stalls, version=self._version, map_id=map_id)


STEPS = st.lists(
    st.tuples(
        st.sampled_from(
            ["tile", "tile", "heavy", "mosaic", "stall", "stall", "many", "gone", "another map", "nothing"]
        ),
        st.integers(0, 24),
        st.integers(0, 50),
        st.booleans(),
    ),
    max_size=30,
)


def assert_same(client: ClientMap, server: OccupancyMap) -> None:
    assert client.map_id == server.map_id
    assert client.stalls == server.stalls
    assert client.mosaic == {key: tile.version for key, tile in server.mosaic.items()}
    assert client.tiles.keys() == server.tiles.keys()
    for key, encoded in server.tiles.items():
        assert client.tiles[key].tobytes() == zlib.decompress(encoded.data)


@pytest.mark.slow
@settings(max_examples=60)
@given(steps=STEPS, resync_at=st.integers(0, 60))
def test_whatever_changes_and_however_slow_the_client_ends_with_the_servers_map(
    steps: list[tuple[str, int, int, bool]], resync_at: int
) -> None:
    server, view, client = Model(), MapView(), ClientMap()
    for index, (action, number, fill, reads) in enumerate(steps):
        server.change(action, number, fill)
        if index == resync_at:
            view.forget()
            client.clear()
        if reads:  # a client that does not read is not built a heartbeat
            client.apply(over_the_wire(view.update(server.now, HERE)))
    for _ in range(100):
        update = view.update(server.now, HERE)
        client.apply(over_the_wire(update))
        if update.backlog == 0:
            break
    assert_same(client, server.now)
    quiet = view.update(server.now, HERE)
    assert (quiet.tiles, quiet.stalls, quiet.mosaic, quiet.backlog) == ([], [], [], 0)


def test_nearest_tiles_come_first_and_the_backlog_is_counted() -> None:
    tiles: dict[TileKey, EncodedTile] = {(0, column): heavy_tile(column) for column in range(10)}
    view = MapView()
    first = view.update(OccupancyMap(tiles), MapPoint(-12.8, 4 * 25.6 + 12.8))
    columns = [update.column for update in first.tiles]
    assert columns[0] == 4
    assert [abs(column - 4) for column in columns] == sorted(abs(column - 4) for column in columns)
    assert 0 < len(columns) < 10
    assert first.backlog == 10 - len(columns)


def test_a_lot_of_stalls_leaves_room_for_tiles_and_the_reverse() -> None:
    stalls = {number: stall(number) for number in range(2000)}
    tiles: dict[TileKey, EncodedTile] = {(0, column): heavy_tile(column) for column in range(50)}
    update = MapView().update(OccupancyMap(tiles, {}, stalls), HERE)
    assert len(update.tiles) >= 1
    assert len(update.stalls) >= 90


def test_only_what_changed_is_sent() -> None:
    before = OccupancyMap({(0, 0): tile(1, 1), (0, 1): tile(1, 1)}, {}, {1: stall(1), 2: stall(2)})
    view = MapView()
    view.update(before, HERE)
    after = replace(before, tiles={**before.tiles, (0, 1): tile(2, 2)}, stalls={1: stall(1), 2: stall(2, 5)})
    update = view.update(after, HERE)
    assert [(t.row, t.column, t.version) for t in update.tiles] == [(0, 1, 2)]
    assert [s.id for s in update.stalls] == [2]


def test_a_stall_that_is_gone_is_said_to_be() -> None:
    view = MapView()
    view.update(OccupancyMap(stalls={1: stall(1), 2: stall(2)}), HERE)
    (update,) = view.update(OccupancyMap(stalls={2: stall(2)}), HERE).stalls
    assert (update.id, update.removed) == (1, True)


def test_another_map_is_sent_from_its_beginning() -> None:
    view, client = MapView(), ClientMap()
    client.apply(view.update(OccupancyMap({(0, 0): tile(1, 9)}, {}, {7: stall(7, 9)}, map_id="a"), HERE))
    client.apply(view.update(OccupancyMap({(5, 5): tile(2, 1)}, {}, {8: stall(8)}, map_id="b"), HERE))
    assert set(client.tiles) == {(5, 5)}
    assert set(client.stalls) == {8}


def test_a_tile_beyond_the_budget_is_sent_alone_rather_than_never() -> None:
    view = MapView(budget_bytes=4096)
    shown = set()
    current = OccupancyMap({(0, 0): heavy_tile(1), (0, 1): heavy_tile(2)})
    for _ in range(2):
        update = view.update(current, HERE)
        assert len(update.tiles) == 1
        shown.add(update.tiles[0].column)
    assert shown == {0, 1}


def test_the_longest_stall_fits_what_is_counted_for_it() -> None:
    rng = random.Random(1)
    stalls = {}
    for _ in range(200):
        number = rng.randrange(10**9, 10**10)
        stalls[number] = Stall(
            number, -rng.random() * 1e4, -rng.random() * 1e4, rng.random() * 3, rng.random() * 9, rng.random() * 9,
            rng.random(), StallState.UNKNOWN, rng.random(), 10**7, rng.random() * 1e7, 10**9,
            label="\xd6" * LONGEST_LABEL,
        )  # fmt: skip
    over_the_wire(MapView().update(OccupancyMap(stalls=stalls), HERE))


@pytest.mark.parametrize("drone", [None, MapPoint(3.0, 4.0)])
def test_without_a_place_of_the_drone_the_map_goes_out_all_the_same(drone: MapPoint | None) -> None:
    assert len(MapView().update(OccupancyMap({(0, 0): tile(1, 1)}), drone).tiles) == 1


@pytest.mark.nightly
@settings(max_examples=25)
@given(steps=STEPS)
def test_a_large_map_is_taken_in_by_and_by(steps: list[tuple[str, int, int, bool]]) -> None:
    server, view, client = Model(), MapView(), ClientMap()
    shared = OccupancyMap(Sharded(_block), Sharded(_block), Sharded(lambda number: number // 8), map_id="m0")
    with mock.patch.object(map_view, "INTAKE", 40):
        for action, number, fill, reads in steps:
            server.change(action, number, fill)
            shared = as_shared(server.now, shared)
            if reads:
                client.apply(over_the_wire(view.update(shared, HERE)))
        for _ in range(300):
            update = view.update(shared, HERE)
            client.apply(over_the_wire(update))
            if update.backlog == 0:
                break
    assert_same(client, server.now)


def _block(key: TileKey) -> TileKey:
    return key[0] // 2, key[1] // 2


def as_shared(now: OccupancyMap, before: OccupancyMap) -> OccupancyMap:
    """Return the map with mappings that share with the one before what did not change."""
    layers = {}
    for name in ("tiles", "mosaic", "stalls"):
        old, new = getattr(before, name), getattr(now, name)
        news = {key: value for key, value in new.items() if old.get(key) != value}
        layers[name] = old.changed(news, [key for key in old if key not in new])
    return replace(now, **layers)
