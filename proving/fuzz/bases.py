"""Sound files of each kind that strangers send, and hostile ones, small enough to be read some thousand times."""

from __future__ import annotations

import functools
import io
import json
import math
import sqlite3
import warnings
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from proving.fuzz.damage import Base
from tests.unit.lots.plan_files.files import closed, degrees, dxf, feature, geojson, geopackage, osm, outline, row


def areas(folder: Path) -> Iterator[Base]:
    """Yield outlines of lots and areas."""
    import shapely

    square = [[5.0, 52.0], [5.002, 52.0], [5.002, 52.002], [5.0, 52.002], [5.0, 52.0]]
    hole = [[5.0005, 52.0005], [5.001, 52.0005], [5.001, 52.001], [5.0005, 52.0005]]
    yield Base(".geojson", geojson([feature([square, hole], exclusion=False, ceiling_m=40)]))
    yield Base(".geojsonl", b"\n".join(json.dumps(feature([square])).encode() for _ in range(2)))
    ring = " ".join(f"{x},{y},0" for x, y in square)
    kml = (
        "<?xml version='1.0'?><kml><Document><Placemark><name>A</name><Polygon><outerBoundaryIs><LinearRing>"
        f"<coordinates>{ring}</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark></Document></kml>"
    ).encode()
    yield Base(".kml", kml)
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("doc.kml", kml)
    yield Base(".kmz", made.getvalue())
    yield Base(".gpkg", geopackage(folder, [(shapely.Polygon(square, [hole]), "parking")], column="amenity"))
    yield Base(".osm", osm(outline(1, row(1)[0], amenity="parking")))


def fences(folder: Path) -> Iterator[Base]:
    """Yield areas as the page takes them."""
    yield from (each for each in areas(folder) if each.suffix not in (".gpkg", ".osm"))


def plans(folder: Path) -> Iterator[Base]:
    """Yield plans of stalls and sections."""
    import shapely

    rings = row(4)
    yield Base(".geojson", geojson([feature([degrees(ring)], label=f"P{k}") for k, ring in enumerate(rings)]))
    yield Base(".gpkg", geopackage(folder, [(shapely.Polygon(degrees(ring)), "1") for ring in rings]))
    yield Base(".osm", osm(*(outline(k, ring, amenity="parking_space", ref=str(k)) for k, ring in enumerate(rings))))
    kerb = degrees([(20.0, 0.0), (20.0, 44.0)])
    said = {"name": "Kerb", "side": "both", "width": 2.2, "kind": "parallel", "note": "permit"}
    area = feature([degrees(rings[0])], name="Yard", capacity=30, length=12.5, section_id="e", capacity_given=True)
    yield Base(".geojson", geojson([feature(kerb, "LineString", **said), area]))
    tags = {"parking__left": "lane", "parking__lane__right": "diagonal", "width": "9", "name": "Elm"}
    yield Base(".osm", osm(outline(1, [*rings[0], rings[0][0]], **tags), outline(2, rings[1], amenity="parking")))

    def draw(_: Any, space: Any) -> None:
        for k, ring in enumerate(rings):
            space.add_lwpolyline(closed(ring), close=True, dxfattribs={"layer": "STALLS"})
            space.add_text(f"{k}", height=0.3, dxfattribs={"insert": closed(ring)[0]})

    yield Base(".dxf", dxf(draw))
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("plan.geojson", geojson([feature([degrees(rings[0])])]))
    yield Base(".zip", made.getvalue())


def pictures(folder: Path) -> Iterator[Base]:
    """Yield pictures with a place on Earth, in the forms that GDAL reads."""
    from hawk.formats import gdal

    gdal.prepare()
    import rasterio
    from rasterio.transform import from_origin

    ground = np.random.default_rng(1).integers(0, 255, (3, 96, 96), np.uint8)
    place = {"crs": "EPSG:28992", "transform": from_origin(155_000, 463_000, 0.1, 0.1)}
    for name, options in (
        ("strips", {"compress": "lzw"}), ("tiles", {"tiled": True, "blockxsize": 32, "blockysize": 32}),
        ("jpeg", {"compress": "jpeg", "photometric": "ycbcr"}), ("deflate", {"compress": "deflate"}),
    ):  # fmt: skip
        path = folder / f"{name}.tif"
        with rasterio.open(
            path, "w", driver="GTiff", width=96, height=96, count=3, dtype="uint8", **place, **options
        ) as file:
            file.write(ground)
        yield Base(".tif", path.read_bytes())
    bands = "".join(
        f'<VRTRasterBand dataType="Byte" band="{k}"><SimpleSource><SourceFilename relativeToVRT="1">a.tif'
        f"</SourceFilename><SourceBand>{k}</SourceBand></SimpleSource></VRTRasterBand>"
        for k in (1, 2, 3)
    )
    head = "<SRS>EPSG:28992</SRS><GeoTransform>155000,.1,0,463000,0,-.1</GeoTransform>"
    yield Base(".vrt", f'<VRTDataset rasterXSize="96" rasterYSize="96">{head}{bands}</VRTDataset>'.encode())
    (folder / "a.tif").write_bytes((folder / "tiles.tif").read_bytes())
    for suffix in (".png", ".jpg", ".jp2"):
        image = np.moveaxis(ground, 0, -1)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            done, data = cv2.imencode(suffix, image) if suffix != ".jp2" else (False, None)
        if done and data is not None:
            yield Base(suffix, data.tobytes())


def photographs(folder: Path) -> Iterator[Base]:
    """Yield photographs of drones."""
    from tests.unit.picture.photographs.photos import DJI, exif, photo, xmp

    for model in ("FC330", "FC6310"):
        yield Base(".jpg", photo(folder / f"{model}.jpg", exif(model=model), xmp(DJI)).read_bytes())


def flown(folder: Path) -> Iterator[Base]:
    """Yield the beginning of a recording, with its first pictures from the air."""
    from tests.reference.kept import unpack

    yield Base(".mcap", unpack("survey", folder).read_bytes()[:1_200_000])
    yield from packed(folder)


def decided(folder: Path) -> Iterator[Base]:
    """Yield the beginning of a recording, with decisions."""
    from tests.reference.kept import unpack

    yield Base(".mcap", unpack("battery-swap-before", folder).read_bytes()[:120_000])
    yield from packed(folder)


def packed(_: Path) -> Iterator[Base]:
    """Yield recordings whose chunks another program packed."""
    from tests.unit.store.test_mcap_records import PACKED
    from tests.unit.store.test_mcap_records import packed as made

    for kind in PACKED:
        yield Base(".mcap", made([b'{"facts": {}}'] * 50, kind, 500))


def films(folder: Path) -> Iterator[Base]:
    """Yield short films."""
    for suffix, code in ((".mp4", "mp4v"), (".avi", "MJPG")):
        path = folder / f"film{suffix}"
        written = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*code), 10.0, (64, 48))
        for k in range(12):
            written.write(np.full((48, 64, 3), 20 * k, np.uint8))
        written.release()
        yield Base(suffix, path.read_bytes())


def captions(_: Path) -> Iterator[Base]:
    """Yield captions of films."""
    lines = [
        f"{k}\n00:00:0{k // 10},{k % 10}00 --> 00:00:0{(k + 1) // 10},{(k + 1) % 10}00\n<font>FrameCnt: {k}\n"
        f"2026-05-04 10:30:0{k // 10}.{k % 10}00\n[focal_len: 24.00] [latitude: {52 + k * 1e-6:.6f}] "
        "[longitude: 5.1] [rel_alt: 30.0 abs_alt: 40.0] [gb_yaw: 1.0 gb_pitch: -90.0 gb_roll: 0.0]</font>\n"
        for k in range(12)
    ]
    yield Base(".srt", "\n".join(lines).encode())


def logs(folder: Path) -> Iterator[Base]:
    """Yield logs of a ground station and of an autopilot."""
    from tests.unit.picture.film.films import Flight, straight, write_bin, write_tlog

    flight = Flight(straight, 4.0)
    yield Base(".tlog", write_tlog(folder / "a.tlog", flight).read_bytes())
    yield Base(".bin", write_bin(folder / "a.bin", flight, 0.0, 4.0).read_bytes())


def tables(_: Path) -> Iterator[Base]:
    """Yield settings, tables of lenses and calibrations."""
    yield Base(".toml", b"[web]\nport = 0\n")
    yield Base(".toml", b'[[lens]]\nmodel = "X"\nsensor_width_mm = 6.2\nsensor_pixels = [4000, 3000]\nsource = "a"\n')
    matrix = "{{rows: {}, cols: {}, data: [{}]}}"
    camera = matrix.format(3, 3, "500.0, 0.0, 320.0, 0.0, 500.0, 240.0, 0.0, 0.0, 1.0")
    lens = matrix.format(1, 5, "0.1, 0.0, 0.0, 0.0, 0.0")
    head = "image_width: 640\nimage_height: 480\ndistortion_model: plumb_bob\n"
    yield Base(".yaml", f"{head}camera_matrix: {camera}\ndistortion_coefficients: {lens}\n".encode())


def projects(folder: Path) -> Iterator[Base]:
    """Yield the poses of a WebODM project, and write its photograph."""
    from tests.unit.picture.photographs.photos import DJI, exif, photo, xmp

    photo(folder / "given.jpg", exif(), xmp(DJI))
    shots = [
        {
            "type": "Feature",
            "properties": {
                "filename": "given.jpg", "width": 40, "height": 30, "focal": 0.8, "camera": "c",
                "translation": [k * 5.0, 0.0, 40.0], "rotation": [math.pi, 0.0, 0.0],
            },
            "geometry": {"type": "Point", "coordinates": [5.0 + k * 1e-4, 52.0, 40.0]},
        }
        for k in range(3)
    ]  # fmt: skip
    yield Base(".geojson", json.dumps({"type": "FeatureCollection", "features": shots}).encode())


def stores(folder: Path) -> Iterator[Base]:
    """Yield a store of lots."""
    from hawk.lots.storage.database import make

    path = folder / "lots.sqlite"
    make(path)
    with sqlite3.connect(path) as opened:
        opened.execute("PRAGMA journal_mode = DELETE")
    opened.close()
    yield Base(".sqlite", path.read_bytes())


def hostile(port: int) -> Iterator[Base]:
    """Yield files that ask a server, read other files, or would become far more than they are."""
    at = f"http://127.0.0.1:{port}/x"
    wms = (
        f'<GDAL_WMS><Service name="TMS"><ServerUrl>{at}</ServerUrl></Service><DataWindow><UpperLeftX>0</UpperLeftX>'
        "<UpperLeftY>9</UpperLeftY><LowerRightX>9</LowerRightX><LowerRightY>0</LowerRightY></DataWindow></GDAL_WMS>"
    )
    for suffix in (".tif", ".vrt", ".jpg", ".gpkg", ".mp4"):
        yield Base(suffix, wms.encode())
    for name in (at, f"/vsicurl/{at}.tif", f"/vsizip/vsicurl/{at}.zip/a.tif", f"WMS:{at}", "/etc/passwd"):
        for kind in ("", ' subClass="VRTRawRasterBand"'):
            source = f'<SourceFilename relativeToVRT="0">{name}</SourceFilename>'
            inner = source if kind else f"<SimpleSource>{source}<SourceBand>1</SourceBand></SimpleSource>"
            band = f'<VRTRasterBand dataType="Byte" band="1"{kind}>{inner}</VRTRasterBand>'
            head = "<SRS>EPSG:28992</SRS><GeoTransform>155000,.1,0,463000,0,-.1</GeoTransform>"
            yield Base(".tif", f'<VRTDataset rasterXSize="64" rasterYSize="64">{head}{band}</VRTDataset>'.encode())
    yield Base(".mp4", f"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\n{at}.ts\n#EXT-X-ENDLIST\n".encode())
    yield Base(".avi", f"ffconcat version 1.0\nfile {at}.mp4\n".encode())
    yield Base(".mp4", f"<?xml version='1.0'?><MPD><BaseURL>{at}</BaseURL></MPD>".encode())
    yield Base(".kml", f"<kml><NetworkLink><Link><href>{at}</href></Link></NetworkLink></kml>".encode())
    yield _zip_bomb()
    from tests.unit.formats.test_gdal import tiff

    for data in (
        tiff(32_000, 32_000, tile=32_000),
        tiff(400_000, 400_000, tile=8192),
        tiff(60_000, 60_000, rows=60_000),
    ):
        yield Base(".tif", data)
    yield from _packed_bombs()
    jpeg = b"\xff\xd8\xff\xc0\x00\x11\x08\xff\xff\xff\xff\x03\x01\x11\x00\x02\x11\x00\x03\x11\x00"
    yield Base(".jpg", jpeg + b"\xff\xda\x00\x0c\x03\x01\x00\x02\x00\x03\x00\x00\x3f\x00" + bytes(50) + b"\xff\xd9")


@functools.cache
def _zip_bomb() -> Base:
    bomb = io.BytesIO()
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("doc.kml", bytes(100_000_000))
    return Base(".kmz", bomb.getvalue())


@functools.cache
def _packed_bombs() -> tuple[Base, ...]:
    from tests.unit.store.test_mcap_records import PACKED
    from tests.unit.store.test_mcap_records import packed as made

    return tuple(Base(".mcap", made([bytes(90_000_000)], kind)) for kind in PACKED[:2])
