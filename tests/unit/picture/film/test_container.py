from __future__ import annotations

import struct
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.picture.film.container import ContainerFacts, read_made

UNIX = 1_777_890_600
MAC = UNIX + 2_082_844_800


def _box(name: bytes, content: bytes, large: bool = False) -> bytes:
    if large:
        return struct.pack(">I4sQ", 1, name, 16 + len(content)) + content
    return struct.pack(">I4s", 8 + len(content), name) + content


def _header(version: int, seconds: int = MAC) -> bytes:
    times = struct.pack(">QQ" if version else ">II", seconds, seconds)
    return _box(b"mvhd", bytes([version, 0, 0, 0]) + times + bytes(80))


@pytest.mark.parametrize("version", [0, 1])
@pytest.mark.parametrize("large", [False, True])
def test_the_moment_and_the_model_are_read(tmp_path: Path, version: int, large: bool) -> None:
    film = tmp_path / "a.MP4"
    model = _box(b"udta", _box(b"\xa9xyz", b"+46.8-091.9") + _box(b"\xa9mdl", b"FC3170\x00\x00"))
    inner = _header(version) + model
    film.write_bytes(_box(b"ftyp", b"isom") + _box(b"mdat", bytes(1000), large) + _box(b"moov", inner, large))
    assert read_made(film) == ContainerFacts(float(UNIX), "FC3170")


def test_the_standard_form_of_the_model_has_a_length_before_it(tmp_path: Path) -> None:
    film = tmp_path / "a.MOV"
    text = b"HERO9 Black"
    film.write_bytes(_box(b"moov", _box(b"udta", _box(b"\xa9mod", struct.pack(">HH", len(text), 0) + text))))
    assert read_made(film) == ContainerFacts(None, "HERO9 Black")


@pytest.mark.parametrize("seconds", [0, 12_345])
def test_a_clock_that_was_never_set_gives_no_moment(tmp_path: Path, seconds: int) -> None:
    film = tmp_path / "a.MP4"
    film.write_bytes(_box(b"moov", _header(0, seconds)))
    assert read_made(film).begun is None


@given(data=st.binary(max_size=300), cut=st.integers(0, 200))
def test_any_bytes_are_read_without_an_error(data: bytes, cut: int, tmp_path_factory: pytest.TempPathFactory) -> None:
    film = tmp_path_factory.getbasetemp() / "any.MP4"
    film.write_bytes(_box(b"moov", _header(0) + data)[:cut] + data)
    read_made(film)


@pytest.mark.parametrize(("kind", "has"), [(b"text", True), (b"sbtl", True), (b"subt", True), (b"vide", False)])
def test_captions_in_the_film_s_own_track_are_seen(tmp_path: Path, kind: bytes, has: bool) -> None:
    film = tmp_path / "a.MP4"
    track = _box(b"trak", _box(b"tkhd", bytes(84)) + _box(b"mdia", _box(b"hdlr", bytes(8) + kind + bytes(13))))
    film.write_bytes(_box(b"moov", _header(0) + track))
    assert read_made(film).has_captions is has
