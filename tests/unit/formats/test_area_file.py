from __future__ import annotations

import contextlib
import io
import json
import zipfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.ddc.fence.geojson import FenceFile, read_fence, read_survey_outline
from hawk.ddc.fence.geometry import FenceError
from hawk.formats.area_file import LARGEST_BYTES, AreaError, read_areas

RING = ((43.26, -79.92), (43.26, -79.91), (43.27, -79.91), (43.27, -79.92))
HOLE = ((43.262, -79.918), (43.262, -79.916), (43.264, -79.916))
CRS84 = {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}


def positions(ring: Any = RING, *more: float, last: Any = None) -> list[list[float]]:
    closing = ring[0] if last is None else last
    return [[longitude, latitude, *more] for latitude, longitude in (*ring, closing)]


def polygon(*rings: list[list[float]]) -> dict[str, Any]:
    return {"type": "Polygon", "coordinates": list(rings or [positions()])}


def feature(geometry: Any, **properties: Any) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def collection(*features: Any, **more: Any) -> dict[str, Any]:
    return {"type": "FeatureCollection", **more, "features": list(features)}


POINT = feature({"type": "Point", "coordinates": [-79.9, 43.2]}, name="home")
LINE = feature({"type": "LineString", "coordinates": positions()[:2]})
ALMOST = (RING[0][0] + 1e-10, RING[0][1] - 1e-10)


def fence_of(tmp_path: Path, data: bytes | str | dict[str, Any], name: str = "f.geojson") -> FenceFile:
    path = tmp_path / name
    if isinstance(data, dict):
        data = json.dumps(data)
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return read_fence(path)


@pytest.mark.fault(
    "a fence as QGIS writes it: MultiPolygon of one part, byte order mark, a point beside, a ring closed to "
    "1e-10, `Polygon Z`, a `crs` of WGS-84",
    "taken",
)
@pytest.mark.parametrize(
    "content",
    [
        polygon(),
        feature({"type": "MultiPolygon", "coordinates": [[positions()]]}),
        collection(feature({"type": "MultiPolygon", "coordinates": [[positions()]]}), name="fence", crs=CRS84),
        collection(POINT, feature(polygon()), LINE),
        collection(feature(polygon(positions(last=ALMOST)))),
        collection(feature(polygon(positions(RING, 102.5)))),
        collection(feature({"type": "Polygon Z", "coordinates": [positions(RING, 0.0)]})),
        collection(feature({"type": "MultiPolygonZ", "coordinates": [[positions(RING, 0.0)]]})),
        feature({"type": "GeometryCollection", "geometries": [POINT["geometry"], polygon()]}),
        {"type": "GeometryCollection", "geometries": [{"type": "GeometryCollection", "geometries": [polygon()]}]},
        collection(feature(None), feature(polygon())),
        polygon(positions((*RING[:2], RING[1], *RING[2:]))),
        polygon(positions()[:-1]),
        {**polygon(), "crs": {"type": "name", "properties": {"name": "EPSG:4326"}}},
        {**polygon(), "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::4326"}}},
    ],
    ids=[
        "polygon",
        "a MultiPolygon of one part",
        "as QGIS writes it",
        "a point and a line beside it",
        "closed to 1e-10",
        "with heights",
        "Polygon Z",
        "MultiPolygonZ",
        "a collection of geometries",
        "a collection in one",
        "a feature without a shape",
        "a corner twice",
        "not closed",
        "of GDAL's old system",
        "of an old name",
    ],
)
def test_what_has_one_clear_meaning_is_a_fence(tmp_path: Path, content: dict[str, Any]) -> None:
    assert fence_of(tmp_path, content) == FenceFile(RING, (), None)


@pytest.mark.fault(
    "a fence as QGIS writes it: MultiPolygon of one part, byte order mark, a point beside, a ring closed to "
    "1e-10, `Polygon Z`, a `crs` of WGS-84"
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_a_byte_order_mark_is_no_fault(tmp_path: Path, encoding: str) -> None:
    text = json.dumps(collection(feature(polygon(), name="Parkplatz Süd")), ensure_ascii=False)
    assert fence_of(tmp_path, text.encode(encoding)).ring == RING
    assert fence_of(tmp_path, kml(placemark(kml_polygon())).encode(encoding)).ring == RING


@pytest.mark.parametrize("said", [True, 1, "true", "Yes", " TRUE "])
def test_zones_are_holes_and_polygons_that_are_exclusions(tmp_path: Path, said: object) -> None:
    content = collection(
        feature(polygon(positions(), positions(HOLE)), ceiling_m="60"), feature(polygon(), Exclusion=said)
    )
    assert fence_of(tmp_path, content) == FenceFile(RING, (HOLE, RING), 60.0)


@pytest.mark.fault(
    "several polygons, another coordinate system, metres for degrees, an archive or XML made to harm",
    "refused with what to do",
)
@pytest.mark.parametrize(
    ("content", "words"),
    [
        (collection(feature(polygon()), feature(polygon())), r"exactly one Polygon.*features\[0\].*features\[1\]"),
        (feature({"type": "MultiPolygon", "coordinates": [[positions()], [positions(HOLE)]]}), "exactly one Polygon"),
        (collection(POINT, LINE), "exactly one Polygon.*it holds LineString, Point"),
        (collection(), "exactly one Polygon"),
        (polygon([[590000.0, 4790000.0], [590100.0, 4790000.0], [590100.0, 4790100.0]]), "not degrees.*EPSG:4326"),
        (
            collection(feature(polygon()), crs={"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32617"}}),
            r"crs: is urn:ogc:def:crs:EPSG::32617; save it in WGS-84",
        ),
        ({**polygon(), "crs": {"type": "link", "properties": {"href": "x"}}}, "crs: is not named"),
        (collection(feature(polygon(), ceiling_m="high")), "ceiling_m: must be metres"),
        (collection("x"), r"features\[0\]: must be a Feature, not a text"),
        (polygon([[float("nan"), 1.0]]), "must be"),
    ],
)
def test_what_has_none_is_refused_with_how_to_save_it(tmp_path: Path, content: dict[str, Any], words: str) -> None:
    with pytest.raises(FenceError, match=words):
        fence_of(tmp_path, content)


def kml_polygon(ring: Any = RING, inner: Any = ()) -> str:
    def boundary(name: str, corners: Any) -> str:
        text = "\n          ".join(f"{longitude},{latitude},0" for latitude, longitude in (*corners, corners[0]))
        return f"<{name}><LinearRing><coordinates>\n{text} \n</coordinates></LinearRing></{name}>"

    holes = "".join(boundary("innerBoundaryIs", hole) for hole in inner)
    return f"<Polygon><tessellate>1</tessellate>{boundary('outerBoundaryIs', ring)}{holes}</Polygon>"


def placemark(content: str, data: str = "") -> str:
    return f"<Placemark><name>Lot</name><styleUrl>#s</styleUrl>{data}{content}</Placemark>"


def kml(*placemarks: str, namespace: str = "http://www.opengis.net/kml/2.2") -> str:
    style = "<Style id='s'><PolyStyle><color>7f00ff00</color></PolyStyle></Style>"
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<kml xmlns="{namespace}" '
        f'xmlns:gx="http://www.google.com/kml/ext/2.2"><Document><name>lot.kml</name>{style}'
        f"<Folder>{''.join(placemarks)}</Folder></Document></kml>\n"
    )


KML_POINT = "<Placemark><Point><coordinates>-79.9,43.2,0</coordinates></Point></Placemark>"
ZONE_DATA = '<ExtendedData><Data name="exclusion"><value>true</value></Data></ExtendedData>'
CEILING_DATA = '<ExtendedData><SchemaData><SimpleData name="ceiling_m">55</SimpleData></SchemaData></ExtendedData>'


@pytest.mark.fault("KML or KMZ of Google Earth", "taken, holes and zones too")
@pytest.mark.parametrize("namespace", ["http://www.opengis.net/kml/2.2", "http://earth.google.com/kml/2.1"])
def test_google_earth_s_kml_is_a_fence(tmp_path: Path, namespace: str) -> None:
    text = kml(KML_POINT, placemark(kml_polygon(RING, [HOLE]), CEILING_DATA), namespace=namespace)
    assert fence_of(tmp_path, text, "lot.kml") == FenceFile(RING, (HOLE,), 55.0)
    several = f"<MultiGeometry>{kml_polygon()}</MultiGeometry>"
    zoned = kml(placemark(several), placemark(kml_polygon(HOLE), ZONE_DATA), namespace=namespace)
    assert fence_of(tmp_path, zoned, "lot.kml") == FenceFile(RING, (HOLE,), None)


def packed(text: str, name: str = "doc.kml") -> bytes:
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("files/icon.png", b"x")
        archive.writestr(name, text)
    return data.getvalue()


@pytest.mark.fault("KML or KMZ of Google Earth")
def test_kmz_is_unpacked(tmp_path: Path) -> None:
    assert fence_of(tmp_path, packed(kml(placemark(kml_polygon()))), "lot.kmz").ring == RING


def bomb() -> bytes:
    return packed("<kml>" + " " * (LARGEST_BYTES + 1) + "</kml>")


@pytest.mark.fault("several polygons, another coordinate system, metres for degrees, an archive or XML made to harm")
@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b'<!DOCTYPE k [<!ENTITY a "x">]><kml><name>&a;</name></kml>', "DOCTYPE"),
        (b'<!DOCTYPE k SYSTEM "file:///etc/passwd"><kml/>', "DOCTYPE"),
        (b"<kml><Document>", "cannot be read as KML"),
        (b"<gpx/>", "XML of another kind .gpx."),
        (kml(placemark(kml_polygon()).replace(",43.26,", ";43.26;")).encode(), "longitude,latitude,height"),
        (kml(placemark("<Polygon/>")).encode(), "holds no ring"),
        (packed("x", "readme.txt"), "without a KML"),
        (b"PK\x03\x04 broken", "cannot be unpacked"),
        (b"\xff\xfe\x00", "cannot be read"),
        (b"\x89PNG\r\n", "cannot be read"),
        (b"{" + b" " * LARGEST_BYTES, "too large"),
        (b"[" * 100_000, "cannot be read"),
    ],
)
def test_what_is_no_file_of_areas_says_so(data: bytes, words: str) -> None:
    with pytest.raises(AreaError, match=words):
        read_areas(data)


def test_an_archive_that_unpacks_to_more_than_is_read_is_refused() -> None:
    with pytest.raises(AreaError, match="too large"):
        read_areas(bomb())


def test_an_outline_is_read_the_same(tmp_path: Path) -> None:
    path = tmp_path / "lot.kml"
    path.write_text(kml(KML_POINT, placemark(kml_polygon(RING, [HOLE]))), encoding="utf-8-sig")
    outline = read_survey_outline(path)
    assert (outline.polygons, outline.holes) == ((RING,), (HOLE,))


@given(st.binary(max_size=300) | st.text(max_size=100).map(str.encode))
def test_any_bytes_give_areas_or_words(data: bytes) -> None:
    for start in (b"", b"PK\x03\x04", b"<kml>", b'{"type": "Polygon", "coordinates": '):
        with contextlib.suppress(AreaError):
            read_areas(start + data)


json_values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.sampled_from(["Polygon", "MultiPolygon", "Feature", "name"]),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.sampled_from(["type", "coordinates", "geometry", "features", "geometries", "crs"]), inner)
    ),
    max_leaves=12,
)


@pytest.mark.slow
@given(json_values)
def test_any_json_gives_areas_or_words(content: Any) -> None:
    with contextlib.suppress(AreaError):
        read_areas(json.dumps(content).encode())
