"""Pictures of strangers: no request goes out, no bytes of other files become pixels, nothing small takes gigabytes."""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterator
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np
import pytest

from hawk.formats.gdal import UnsafeError, open_picture
from hawk.picture.orthophoto.source import open_orthophoto
from hawk.picture.values import PictureError
from tests.unit.picture.orthophoto.drawn import write

PLACED = "<SRS>EPSG:28992</SRS><GeoTransform>100000,.1,0,450000,0,-.1</GeoTransform>"
WMS = (
    '<GDAL_WMS><Service name="TMS"><ServerUrl>http://{at}/${{z}}/${{x}}/${{y}}.png</ServerUrl></Service><DataWindow>'
    "<UpperLeftX>100000</UpperLeftX><UpperLeftY>450000</UpperLeftY><LowerRightX>100040</LowerRightX><LowerRightY>449960"
    "</LowerRightY><TileLevel>1</TileLevel><YOrigin>top</YOrigin></DataWindow><Projection>EPSG:28992</Projection>"
    "<BlockSizeX>256</BlockSizeX><BlockSizeY>256</BlockSizeY><BandsCount>3</BandsCount></GDAL_WMS>"
)


@pytest.fixture
def server() -> Iterator[socket.socket]:
    """Listen, and fail where somebody has asked."""
    with socket.create_server(("127.0.0.1", 0)) as opened:
        opened.setblocking(False)
        yield opened
        with pytest.raises(BlockingIOError):
            opened.accept()


def vrt(source: str, *, subclass: str = "", relative: int = 1, more: str = "") -> str:
    named = f'<SourceFilename relativeToVRT="{relative}">{source}</SourceFilename>'
    held = (
        named if subclass == "VRTRawRasterBand" else f"<SimpleSource>{named}<SourceBand>1</SourceBand></SimpleSource>"
    )
    kind = f' subClass="{subclass}"' if subclass else ""
    bands = "".join(f'<VRTRasterBand dataType="Byte" band="{k}"{kind}>{more}{held}</VRTRasterBand>' for k in (1, 2, 3))
    return f'<VRTDataset rasterXSize="40" rasterYSize="40">{PLACED}{bands}</VRTDataset>'


NESTED = escape(vrt("/vsicurl/http://{at}/a.tif"))
HOSTILE = {
    "wms": (WMS, "XML by which GDAL asks a server"),
    "curl": (vrt("/vsicurl/http://{at}/a.tif"), "names /vsicurl/.*, no file of this computer"),
    "stream": (vrt("/vsicurl_streaming/http://{at}/a.tif"), "no file of this computer"),
    "url": (vrt("http://{at}/a.tif"), "no file of this computer"),
    "zip": (vrt("/vsizip/vsicurl/http://{at}/a.zip/a.tif"), "no file of this computer"),
    "nested": (vrt(NESTED), "no file of this computer"),
    "service": (vrt("wms.xml"), "names wms.xml, which is XML by which GDAL asks a server"),
    "inner": (vrt("inner.vrt"), "no file of this computer"),
    "raw": (vrt("/etc/passwd", subclass="VRTRawRasterBand", relative=0), "reads bytes of any file as pixels"),
    "bytes": (vrt("/etc/passwd", relative=0), "names passwd, which is of no kind that is known"),
    "program": (
        vrt("a.tif", subclass="VRTDerivedRasterBand", more="<PixelFunctionLanguage>Python</PixelFunctionLanguage>"),
        "computes its pixels by a program",
    ),
}


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.parametrize("suffix", [".tif", ".vrt"])
def test_no_request_goes_out_and_no_other_file_becomes_pixels(
    tmp_path: Path, server: socket.socket, name: str, suffix: str
) -> None:
    at = f"127.0.0.1:{server.getsockname()[1]}"
    write(tmp_path / "a.tif", np.full((3, 40, 40), 90, np.uint8))
    (tmp_path / "wms.xml").write_text(WMS.format(at=at))
    (tmp_path / "inner.vrt").write_text(HOSTILE["curl"][0].format(at=at))
    path = tmp_path / f"photo{suffix}"
    path.write_text(HOSTILE[name][0].format(at=at) if "{at}" in HOSTILE[name][0] else HOSTILE[name][0])
    with pytest.raises(PictureError, match=rf"photo\{suffix}: .*{HOSTILE[name][1]}"):
        open_orthophoto(path)


def test_files_beside_a_picture_ask_nobody(tmp_path: Path, server: socket.socket) -> None:
    at = f"127.0.0.1:{server.getsockname()[1]}"
    path = write(tmp_path / "a.tif", np.full((3, 640, 640), 90, np.uint8))
    (tmp_path / "a.tif.aux.xml").write_text(
        f'<PAMDataset><Metadata domain="OVERVIEWS"><MDI key="OVERVIEW_FILE">/vsicurl/http://{at}/o.tif</MDI>'
        "</Metadata></PAMDataset>"
    )
    source = open_orthophoto(path)
    assert source.read((0, 0, 40, 40)).valid.all()
    source.ground()


def test_a_vrt_of_local_pictures_is_read(tmp_path: Path) -> None:
    write(tmp_path / "a.tif", np.full((3, 40, 40), 90, np.uint8))
    (tmp_path / "city.vrt").write_text(vrt("a.tif"))
    (tmp_path / "outer.tif").write_text(vrt("city.vrt"))
    with open_picture(tmp_path / "outer.tif") as opened:
        assert opened.read()[0, 0, 0] == 90
    (tmp_path / "loop.vrt").write_text(vrt("loop.vrt"))
    with pytest.raises((UnsafeError, Exception)):
        open_picture(tmp_path / "loop.vrt").read()


def tiff(width: int, height: int, **parts: int) -> bytes:
    """Return a GeoTIFF of three bands without any pixel: ``tile`` or ``rows`` is the size of its parts."""
    short, word, real = 3, 4, 12
    directory = [
        (256, word, (width,)), (257, word, (height,)), (258, short, (8, 8, 8)), (259, short, (8,)), (262, short, (2,)),
        (277, short, (3,)), (33550, real, (0.1, 0.1, 0.0)), (33922, real, (0.0, 0.0, 0.0, 1e5, 4.5e5, 0.0)),
        (34735, short, (1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 28992)),
    ]  # fmt: skip
    if "tile" in parts:
        count = -(-width // parts["tile"]) * -(-height // parts["tile"])
        directory += [(322, short, (parts["tile"],)), (323, short, (parts["tile"],))]
        directory += [(324, word, (0,) * count), (325, word, (0,) * count)]
    else:
        directory += [(273, word, (8,)), (278, word, (parts["rows"],)), (279, word, (8,))]
    at = 8 + 2 + 12 * len(directory) + 4
    entries, blob = struct.pack("<H", len(directory)), b""
    for tag, kind, values in sorted(directory):
        data = struct.pack(f"<{len(values)}{ {short: 'H', word: 'I', real: 'd'}[kind] }", *values)
        if len(data) > 4:
            data, blob = struct.pack("<I", at + len(blob)), blob + data
        entries += struct.pack("<HHI", tag, kind, len(values)) + data.ljust(4, b"\0")
    return b"II*\0" + struct.pack("<I", 8) + entries + bytes(4) + blob


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (tiff(32_000, 32_000, tile=32_000), r"is stored in parts of 3,072 MB, .*-co TILED=YES"),
        (tiff(1_000_000, 1_000_000, tile=8192), r"has 1,000,000 by 1,000,000 pixels in 0\.\d\d MB: nearly"),
        (tiff(2_000_000_000, 16, rows=1), r"is stored in parts of|has 2,000,000,000 by 16 pixels|cannot be read"),
    ],
)  # fmt: skip
def test_a_small_file_that_would_take_gigabytes_or_days_is_refused(tmp_path: Path, data: bytes, words: str) -> None:
    path = tmp_path / "small.tif"
    path.write_bytes(data)
    assert len(data) < 200_000
    with pytest.raises(PictureError, match=words):
        open_orthophoto(path)
