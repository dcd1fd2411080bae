"""Files are read in a process of their own, whose bounds end it alone."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from hawk.lots.plan_files import child
from hawk.lots.plan_files.values import Asked
from hawk.lots.values import LotInputError
from tests.unit.lots.plan_files.files import feature, geojson, numbered, plan


@pytest.mark.slow
async def test_a_plan_comes_back_as_it_is_read_here() -> None:
    data = geojson([*numbered(3, parking_space="staff"), feature([5.0, 52.0], "Point")])
    found = child.unpacked(await child.read_apart(data, Asked(label="label")))
    assert found == plan(data, label="label")


@pytest.mark.slow
async def test_a_refusal_comes_back_with_its_field() -> None:
    with pytest.raises(LotInputError, match="is a DWG") as refused:
        await child.read_apart(b"AC1032", Asked())
    assert refused.value.field == "file"


@pytest.mark.slow
async def test_a_file_that_takes_too_long_or_too_much_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(LotInputError, match=r"takes more than 0 s to read: leave other layers out"):
        await child.read_apart(geojson(numbered(1)), Asked(), longest_s=0.01)
    monkeypatch.setattr(child, "MODULE", "hawk.lots.no_such_module")
    with pytest.raises(LotInputError, match="takes more memory or time than a plan does"):
        await child.read_apart(geojson(numbered(1)), Asked())


LESS_MEMORY = """
import sys
from hawk.lots.plan_files import __main__ as child
child.MEMORY_BYTES = 200_000_000
sys.exit(child.main("{}"))
"""


@pytest.mark.slow
def test_a_file_that_takes_more_memory_than_the_bound_ends_its_process() -> None:
    bomb = b'{"features": [' + b"[]," * 5_000_000 + b"[]]}"
    ended = subprocess.run(
        [sys.executable, "-c", LESS_MEMORY], input=bomb, capture_output=True, timeout=60, check=False
    )
    assert ended.returncode == child.REFUSED
    assert json.loads(ended.stdout) == {"field": "file", "reason": child.TOO_MUCH}


BROKEN = """
import sys
from hawk.lots.plan_files import __main__ as child
def read_plan(data, asked):
    raise KeyError("layer")
child.read_plan = read_plan
sys.exit(child.main("{}"))
"""


@pytest.mark.slow
def test_a_file_that_a_package_fails_at_is_refused_with_the_remedy() -> None:
    ended = subprocess.run([sys.executable, "-c", BROKEN], input=b"x", capture_output=True, timeout=60, check=False)
    assert ended.returncode == child.REFUSED
    assert json.loads(ended.stdout)["reason"] == "cannot be read (KeyError): export it again, or in another form"
