"""The library's example in docs/how-to/count-from-photos.md."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import rasterio
from rasterio.transform import from_origin

import hawk.picture
from hawk.sim.photos import PhotoOptions, write_photos
from hawk.worlds.world import World

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "count-from-photos.md"


def _ground() -> World:
    image = np.random.default_rng(1).integers(60, 120, (300, 400, 3)).astype(np.uint8)
    lot = np.array([(5, 5), (35, 5), (35, 25), (5, 25)], np.float64)
    return World(name="plain", metres_per_pixel=0.1, ground=image, lots=(lot,))


@pytest.mark.slow
def test_the_example_of_the_documentation_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_photos(_ground(), PhotoOptions(height=60.0, width=600, overlap=(0.1, 0.1)), tmp_path / "my-flight")
    with rasterio.open(
        tmp_path / "orthophoto.tif", "w", driver="GTiff", width=200, height=200, count=3, dtype="uint8",
        crs="EPSG:28992", transform=from_origin(155_000, 463_000, 0.1, 0.1),
    ) as file:  # fmt: skip
        file.write(np.full((3, 200, 200), 100, np.uint8))
    monkeypatch.chdir(tmp_path)
    (example,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    exec(compile(example, str(PAGE), "exec"), {})  # noqa: S102 - our own page
    assert "0 of 0 stalls are free" in capsys.readouterr().out


def test_every_name_that_the_library_offers_is_there() -> None:
    for name in hawk.picture.__all__:
        assert getattr(hawk.picture, name).__name__ == name
    with pytest.raises(AttributeError, match="nothing"):
        hawk.picture.nothing  # noqa: B018
