from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.algo.mapper.delta import MapMeta, tile_key, tile_name
from hawk.algo.mapper.grid import EvidenceTile
from hawk.algo.mapper.table import STALL_DTYPE, from_bytes, to_bytes
from hawk.model.lot_map import Cell


def tile(seed: int = 0) -> EvidenceTile:
    rng = np.random.default_rng(seed)
    result = EvidenceTile()
    layers = result.layers
    layers.lot[:] = rng.uniform(-4, 4, layers.lot.shape)
    layers.looks[:] = rng.uniform(0, 60, layers.lot.shape)
    layers.core[:] = rng.random(layers.lot.shape)
    layers.car[:] = rng.random(layers.lot.shape)
    layers.well[:] = rng.integers(0, 2, layers.lot.shape)
    layers.shown[:] = rng.integers(0, 3, layers.lot.shape)
    result.summarise()
    return result


def test_a_tile_comes_back_nearly_as_it_was() -> None:
    before = tile()
    after = EvidenceTile(before.to_bytes())
    for name, tolerance in (("lot", 0.05), ("looks", 0.2), ("core", 0.003), ("car", 0.003), ("well", 0), ("shown", 0)):
        difference = getattr(before.layers, name).astype(float) - getattr(after.layers, name).astype(float)
        assert np.abs(difference).max() <= tolerance, name
    assert after.lot_cells == np.count_nonzero(before.layers.shown == Cell.LOT)


@given(st.binary(max_size=200))
def test_what_is_no_tile_is_an_error_that_says_so(data: bytes) -> None:
    with pytest.raises(ValueError, match="not an evidence tile"):
        EvidenceTile(data)


def test_a_torn_tile_is_an_error() -> None:
    data = tile().to_bytes()
    with pytest.raises(ValueError, match="not an evidence tile"):
        EvidenceTile(data[: len(data) // 2])


@given(st.integers(-1000, 1000), st.integers(-1000, 1000))
def test_names_of_tiles_come_back(row: int, column: int) -> None:
    assert tile_key(tile_name("grid", (row, column))) == (row, column)


def test_meta_comes_back() -> None:
    meta = MapMeta("survey-1", 77, 12, (0.5, -0.25, 0.01))
    assert MapMeta.from_bytes(meta.to_bytes()) == meta
    assert MapMeta.from_bytes(b'["survey-1", 77, 12, 0.5, -0.25, 0.01, 1.0]') == meta, "of an older journal"


@pytest.mark.parametrize("data", [b"", b"{}", b"[1]", b'["a", 1, 2, 0, 0, NaN, 1]', b'["a", 1, 2, "x", 0, 0, 1]'])
def test_meta_that_cannot_be_read_says_so(data: bytes) -> None:
    with pytest.raises(ValueError, match="meta"):
        MapMeta.from_bytes(data)


def test_a_stall_comes_back_exactly() -> None:
    row = np.ones(1, STALL_DTYPE)
    row["north"], row["id"], row["confirmed"] = 1 / 3, 42, True
    assert (from_bytes(to_bytes(row[0])) == row).all()


@pytest.mark.parametrize("data", [b"", b"{}", b"[]", b'{"id": 1}', b"\xff\xfe"])
def test_what_is_no_stall_is_an_error(data: bytes) -> None:
    with pytest.raises(ValueError, match=r"stall|JSON|Expecting"):
        from_bytes(data)


def test_a_stall_with_a_number_that_is_not_finite_is_refused() -> None:
    row = np.ones(1, STALL_DTYPE)
    row["taken"] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        from_bytes(to_bytes(row[0]))
