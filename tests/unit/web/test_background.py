"""The picture of the ground under the map: from a folder of tiles, and from nowhere else."""

from __future__ import annotations

from pathlib import Path

import pytest
from aiohttp import web

from hawk.web.background import LARGEST_TILE_BYTES, add_routes, read_tile, zooms_in
from tests.unit.web.rig import Rig, browser


async def get(rig: Rig, path: str) -> tuple[int, bytes, str]:
    server = rig.server or await rig.start()
    async with browser() as session, session.get(server.make_url(path)) as response:
        return response.status, await response.read(), response.content_type


@pytest.fixture
def tiles(tmp_path: Path) -> Path:
    folder = tmp_path / "tiles"
    for name in ("18/139/90.png", "17/69/45.jpg"):
        (folder / name).parent.mkdir(parents=True)
        (folder / name).write_bytes(name.encode())
    (folder / "readme").mkdir()
    (folder / "99").mkdir()
    (folder / "16").write_text("no folder")
    (tmp_path / "secret.png").write_text("secret")
    return folder


async def test_a_tile_is_served_as_what_it_is(rig: Rig, tiles: Path) -> None:
    rig.web = rig.web.model_copy(update={"background_tiles": tiles})
    assert await get(rig, "/api/background/18/139/90") == (200, b"18/139/90.png", "image/png")
    assert await get(rig, "/api/background/17/69/45") == (200, b"17/69/45.jpg", "image/jpeg")
    status, body, _ = await get(rig, "/api/background.json")
    assert (status, body) == (200, b'{"Zooms": [17, 18]}')


async def test_ground_beside_the_tiles_is_no_error(rig: Rig, tiles: Path) -> None:
    rig.web = rig.web.model_copy(update={"background_tiles": tiles})
    assert (await get(rig, "/api/background/18/139/91"))[:2] == (204, b"")


RESOURCE = """<?xml version="1.0" encoding="utf-8"?>
<TileMap version="1.0.0" tilemapservice="http://tms.osgeo.org/1.0.0"><SRS>EPSG:3857</SRS>
<TileFormat width="256" height="256" mime-type="image/png" extension="png"/>
<TileSets profile="{}"><TileSet href="17" units-per-pixel="1.19" order="17"/></TileSets></TileMap>"""


@pytest.mark.fault("a folder of TMS tiles", "served at their places; one that only seems to be TMS is named")
@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("tilemapresource.xml", RESOURCE.format("mercator")),
        ("tilemapresource.xml", RESOURCE.format("global-mercator")),
        ("metadata.json", '{"name": "lot", "scheme": "tms"}'),
    ],
)
async def test_tiles_of_a_tms_folder_lie_where_they_are(rig: Rig, tiles: Path, name: str, text: str) -> None:
    (tiles / name).write_text(text)
    rig.web = rig.web.model_copy(update={"background_tiles": tiles})
    assert await get(rig, f"/api/background/18/139/{2**18 - 1 - 90}") == (200, b"18/139/90.png", "image/png")
    assert await get(rig, f"/api/background/17/69/{2**17 - 1 - 45}") == (200, b"17/69/45.jpg", "image/jpeg")
    assert (await get(rig, "/api/background/18/139/90"))[0] == 204


@pytest.mark.parametrize("text", ['{"scheme": "xyz"}', "{", "[]", "{}", '{"scheme": 3}'])
async def test_metadata_that_does_not_say_tms_changes_nothing(rig: Rig, tiles: Path, text: str) -> None:
    (tiles / "metadata.json").write_text(text)
    rig.web = rig.web.model_copy(update={"background_tiles": tiles})
    assert (await get(rig, "/api/background/18/139/90"))[0] == 200


@pytest.mark.fault("a folder of TMS tiles")
async def test_a_folder_that_seems_to_be_tms_is_named_once(
    rig: Rig, tiles: Path, caplog: pytest.LogCaptureFixture
) -> None:
    rig.web = rig.web.model_copy(update={"background_tiles": tiles})
    assert (await get(rig, "/api/background/18/139/91"))[0] == 204
    for _ in range(2):
        status, body, _ = await get(rig, f"/api/background/18/139/{2**18 - 1 - 90}")
        assert status == 404
        assert b"numbered from the south (TMS): write metadata.json" in body
    said = [record.getMessage() for record in caplog.records if record.name == "hawk.web.background"]
    assert len(said) == 1
    assert "gdal2tiles --xyz" in said[0]


async def test_tiles_that_are_not_in_web_mercator_are_reported_at_the_start(
    rig: Rig, tiles: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tiles / "tilemapresource.xml").write_text(RESOURCE.format("geodetic"))
    rig.web = rig.web.model_copy(update={"background_tiles": tiles})
    status, body, _ = await get(rig, "/api/background/18/139/90")
    assert (status, b"not in Web Mercator (geodetic)" in body) == (404, True)
    assert any("not in Web Mercator" in record.getMessage() for record in caplog.records)


async def test_without_the_setting_there_is_none(rig: Rig) -> None:
    assert (await get(rig, "/api/background.json"))[1] == b'{"Zooms": []}'
    assert (await get(rig, "/api/background/18/139/90"))[0] == 404


@pytest.mark.parametrize(("name", "words"), [("tiles", ""), ("gone", "web.background_tiles: {} has no tiles")])
async def test_a_folder_without_tiles_is_reported_at_the_start(
    rig: Rig, tiles: Path, caplog: pytest.LogCaptureFixture, name: str, words: str
) -> None:
    rig.web = rig.web.model_copy(update={"background_tiles": tiles.with_name(name)})
    await rig.start()
    said = [record.getMessage() for record in caplog.records if record.name == "hawk.web.background"]
    assert len(said) == bool(words)
    assert all(text.startswith(words.format(tiles.with_name(name))) for text in said)


@pytest.mark.parametrize(
    "path",
    ["18/../../secret", "18/..%2F..%2Fsecret/90", "-1/139/90", "18/139/90.png", "18/139/999999999"],
)
async def test_nothing_but_a_tile_is_served(rig: Rig, tiles: Path, path: str) -> None:
    rig.web = rig.web.model_copy(update={"background_tiles": tiles})
    status, body, _ = await get(rig, f"/api/background/{path}")
    assert status == 404
    assert body != b"secret"


def test_a_folder_that_is_not_there_has_no_zooms(tmp_path: Path) -> None:
    assert zooms_in(tmp_path / "gone") == []
    assert read_tile(tmp_path / "gone", 1, 2, 3) is None


def test_what_is_too_large_for_a_tile_is_none(tiles: Path) -> None:
    path = tiles / "18" / "139" / "90.png"
    path.write_bytes(b"0" * LARGEST_TILE_BYTES)
    assert read_tile(tiles, 18, 139, 90) is not None
    path.write_bytes(b"0" * (LARGEST_TILE_BYTES + 1))
    assert read_tile(tiles, 18, 139, 90) is None


def test_the_routes_take_numbers_only() -> None:
    app = web.Application()
    add_routes(app)
    assert [r.resource.canonical for r in app.router.routes() if r.resource and r.method == "GET"] == [
        "/api/background.json",
        "/api/background/{zoom}/{x}/{y}",
    ]
