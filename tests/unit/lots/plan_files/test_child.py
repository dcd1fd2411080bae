"""Files are read in a process of their own, whose bounds end it alone."""

from __future__ import annotations

import pytest

from hawk.formats.box import Limits
from hawk.lots.plan_files import child
from hawk.lots.plan_files.values import Asked
from hawk.lots.values import LotInputError
from tests.unit.lots.plan_files.files import feature, geojson, numbered, plan


@pytest.mark.nightly
async def test_a_plan_comes_back_as_it_is_read_here() -> None:
    data = geojson([*numbered(3, parking_space="staff"), feature([5.0, 52.0], "Point")])
    found = child.unpacked(await child.read_apart(data, Asked(label="label")))
    assert found == plan(data, label="label")


@pytest.mark.nightly
async def test_a_refusal_comes_back_with_its_field() -> None:
    with pytest.raises(LotInputError, match="is a DWG") as refused:
        await child.read_apart(b"AC1032", Asked())
    assert refused.value.field == "file"


@pytest.mark.slow
async def test_a_file_that_takes_too_long_or_too_much_is_refused() -> None:
    with pytest.raises(LotInputError, match=r"takes more than 0 s to read: leave other layers out"):
        await child.read_apart(geojson(numbered(1)), Asked(), Limits(longest_s=0.01))
    bomb = b'{"features": [' + b"[]," * 5_000_000 + b"[]]}"
    with pytest.raises(LotInputError, match="takes more memory or time than such a file does"):
        await child.read_apart(bomb, Asked(), Limits(200_000_000))
