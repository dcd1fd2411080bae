"""Rasters of servers: allowed hosts alone are asked, and no address is printed with its secrets."""

from __future__ import annotations

import socket
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.formats import gdal, remote_raster
from hawk.formats.remote_raster import AllowedHost, RemoteError, RemoteRaster, door
from hawk.picture.orthophoto.source import open_orthophoto
from hawk.picture.values import PictureError
from tests.raster_server import RasterServer, raster_server
from tests.unit.formats.test_gdal import vrt
from tests.unit.picture.orthophoto.drawn import write


@pytest.fixture
def content(tmp_path: Path) -> bytes:
    random = np.random.default_rng(1)
    return write(tmp_path / "a.tif", random.integers(60, 200, (3, 600, 600), np.uint8)).read_bytes()


def raster(text: str) -> RemoteRaster:
    found = RemoteRaster.of(text)
    assert found is not None
    return found


def allowed(*servers: RasterServer) -> tuple[AllowedHost, ...]:
    return tuple(AllowedHost("127.0.0.1", each.port) for each in servers)


def test_a_raster_of_an_allowed_host_is_read_as_the_file_is(tmp_path: Path, content: bytes) -> None:
    with raster_server(content) as server:
        remote_one = open_orthophoto(raster(f"http://{server.at}/city.tif?sig=secret"), hosts=allowed(server))
        box = (100, 100, 500, 500)
        assert (remote_one.read(box).image == open_orthophoto(tmp_path / "a.tif").read(box).image).all()
        assert {path for _, path, _ in server.requests} == {"/city.tif?sig=secret"}  # nothing beside it is guessed
        assert "secret" not in f"{remote_one!r} {remote_one.identity} {remote_one.path}"
        assert '"\\"1\\""' in remote_one.identity
        assert remote_one.taken.value == datetime(2026, 5, 4, 10, 30, tzinfo=UTC).timestamp()
        assert str(len(content)) in remote_one.identity


def test_parts_of_a_vrt_are_read_from_allowed_hosts_alone(
    tmp_path: Path, content: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NO_PROXY", "*")
    path = tmp_path / "city.vrt"
    with raster_server(content) as server, raster_server(content) as other:
        path.write_text(vrt(f"/vsicurl/http://{server.at}/a.tif", relative=0))
        assert open_orthophoto(path, hosts=allowed(server)).read((0, 0, 40, 40)).valid.all()
        with pytest.raises(PictureError, match=rf"city.vrt: names .* --allow-host {server.at} if you trust it"):
            open_orthophoto(path, hosts=allowed(other))
        path.write_text(vrt(f"/vsicurl/http://{server.at}/a.tif?sig=secret", relative=0))
        with pytest.raises(PictureError, match="name such rasters without a query") as refused:
            open_orthophoto(path, hosts=allowed(server))
        assert "secret" not in str(refused.value)
        assert not other.requests


def test_a_redirect_reaches_allowed_hosts_alone(content: bytes) -> None:
    with raster_server(content) as goal, raster_server(b"", redirect=f"http://{goal.at}/b.tif?sig=secret") as first:
        asked = raster(f"http://{first.at}/city.tif")
        with pytest.raises(PictureError, match=rf"city.tif: asks {goal.at}, which is not allowed: add --allow-host"):
            open_orthophoto(asked, hosts=allowed(first))
        assert not goal.requests
        assert open_orthophoto(asked, hosts=allowed(first, goal)).read((0, 0, 40, 40)).valid.all()


@pytest.mark.parametrize("name", ["GDAL_HTTP_USERPWD", "GDAL_HTTP_HEADERS"])
def test_no_key_of_the_environment_is_sent(content: bytes, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setenv(name, "name:key" if name.endswith("PWD") else "Authorization: Bearer key")
    with raster_server(content) as server:
        open_orthophoto(raster(f"http://{server.at}/{name}.tif"), hosts=allowed(server)).read((0, 0, 40, 40))
        assert {key for _, _, key in server.requests} == {""}


@pytest.mark.parametrize("scheme", ["http", "https"])
def test_gdal_asks_the_door_whatever_proxy_the_environment_names(
    content: bytes, monkeypatch: pytest.MonkeyPatch, scheme: str
) -> None:
    with raster_server(content) as server, door(()) as opened:
        for name in ("GDAL_HTTP_PROXY", "GDAL_HTTPS_PROXY", "https_proxy", "HTTPS_PROXY"):
            monkeypatch.setenv(name, f"http://{server.at}")
        monkeypatch.setenv("no_proxy", "*")
        rasterio, asked = gdal.rasterio(), raster(f"{scheme}://{server.at}/city.tif")
        with rasterio.Env(**gdal.remote_options(asked, opened)), pytest.raises(rasterio.errors.RasterioIOError):
            gdal.open_picture(asked)
        assert set(opened.refused) == {server.at}
        assert not server.requests


def test_a_request_to_s3_is_signed_for_an_allowed_host_alone(content: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {"ACCESS_KEY_ID": "name", "SECRET_ACCESS_KEY": "key", "REGION": "eu-west-1"}.items():
        monkeypatch.setenv(f"AWS_{name}", value)
    monkeypatch.setenv("AWS_HTTPS", "NO")
    monkeypatch.setenv("AWS_VIRTUAL_HOSTING", "FALSE")
    with raster_server(content) as server, raster_server(content) as other:
        monkeypatch.setenv("AWS_S3_ENDPOINT", server.at)
        with pytest.raises(PictureError, match=rf"asks {server.at}, which is not allowed"):
            open_orthophoto(raster("s3://tiles/closed.tif"), hosts=allowed(other))
        assert not server.requests + other.requests
        assert open_orthophoto(raster("s3://tiles/city.tif"), hosts=allowed(server)).read((0, 0, 40, 40)).valid.all()
        assert all(key.startswith("AWS4-HMAC-SHA256") for _, _, key in server.requests)
        assert not other.requests


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("hangs", "has not answered within 0.5 s: try again later, or copy"),
        ("whole", r"gives no parts of files \(HTTP ranges\): copy the picture here"),
        ("cut", "answer is cut off: try again later, or copy"),
        ("missing", "answers 404 .*: check the address"),
    ],
)
def test_a_server_that_fails_is_named_with_the_remedy(
    content: bytes, monkeypatch: pytest.MonkeyPatch, fault: str, words: str
) -> None:
    monkeypatch.setattr(remote_raster, "TIMEOUT_S", 0.5)
    with raster_server(content, fault) as server:  # type: ignore[arg-type]
        with pytest.raises(PictureError, match=rf"city.tif: .*{words}") as refused:
            open_orthophoto(raster(f"http://{server.at}/city.tif?sig=secret"), hosts=allowed(server))
        assert "secret" not in str(refused.value)


def test_an_answer_that_is_cut_off_later_is_no_picture(content: bytes) -> None:
    with raster_server(content) as server:
        opened = open_orthophoto(raster(f"http://{server.at}/late.tif?sig=secret"), hosts=allowed(server))
        server.fault = "cut later"
        with pytest.raises(PictureError, match=r"cannot be read as a picture .*try again later, or copy it") as refused:
            opened.read((0, 0, 600, 600))
        assert "secret" not in str(refused.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [(vrt("/etc/passwd").encode(), "copy the VRT here"), (b"<html>login</html>", "is a page of the web: download")],
)
def test_what_is_no_raster_is_refused(content: bytes, words: str) -> None:
    with raster_server(content) as server, pytest.raises(PictureError, match=words):
        open_orthophoto(raster(f"http://{server.at}/city.tif"), hosts=allowed(server))


@pytest.mark.parametrize(
    ("request_line", "status"),
    [
        ("CONNECT 127.0.0.1:1 HTTP/1.1", b"403"),
        ("GET http://127.0.0.1:1/a HTTP/1.1", b"403"),
        ("GET ftp://127.0.0.1:{port}/a HTTP/1.1", b"405"),
        ("POST http://127.0.0.1:{port}/a HTTP/1.1", b"405"),
    ],
)
def test_the_door_opens_no_other_route(request_line: str, status: bytes) -> None:
    with raster_server(b"") as server, door(allowed(server)) as opened:
        port = int(opened.address.rpartition(":")[2])
        with socket.create_connection(("127.0.0.1", port), 5) as client:
            client.sendall(f"{request_line.format(port=server.port)}\r\n\r\n".encode())
            assert status in client.recv(100)
        assert not server.requests


def test_a_tunnel_to_an_allowed_host_passes_bytes() -> None:
    with raster_server(b"ground") as server, door(allowed(server)) as opened:
        port = int(opened.address.rpartition(":")[2])
        with socket.create_connection(("127.0.0.1", port), 5) as client:
            client.sendall(f"CONNECT {server.at} HTTP/1.1\r\n\r\n".encode())
            assert b" 200 " in client.recv(100)
            client.sendall(b"GET /a HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n")
            assert b"".join(iter(lambda: client.recv(4096), b"")).endswith(b"ground")


@given(st.text(st.characters(codec="ascii", exclude_characters="\0"), max_size=30))
def test_no_text_has_secrets_of_an_address(tail: str) -> None:
    said: object = None
    try:
        said = RemoteRaster.of(f"https://host/a.tif?sig=SECRET{tail}")
    except RemoteError as error:
        said = error
    assert "SECRET" not in f"{said} {said!r} {said.name if isinstance(said, RemoteRaster) else ''}"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("https://me:key@host/a.tif", "has a user or password"),
        ("http://[::1/a.tif?sig=SECRET", "names no host and file"),
        ("HTTP://host:0/a.tif", "names no host and file"),
        ("https:///a.tif", "names no host and file"),
        ("https://host/", "names no host and file"),
        ("https://host:99999/a.tif", "names no host and file"),
        ("s3://bucket", "names no bucket and file"),
        ("https://host/a,b.tif", "has a space, comma"),
    ],
)
def test_an_address_that_is_none_is_refused(text: str, words: str) -> None:
    with pytest.raises(RemoteError, match=words):
        RemoteRaster.of(text)


def test_a_host_is_its_name_and_ports() -> None:
    assert AllowedHost("Tiles.Example").fits("tiles.example.", 443)
    assert not AllowedHost("tiles.example").fits("tiles.example", 8080)
    assert AllowedHost("tiles.example", 8080).fits("tiles.example", 8080)
    assert not AllowedHost("tiles.example").fits("a.tiles.example", 443)
