"""A film made of real recordings, read again by OpenCV."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from hawk.cli import main
from hawk.config.sections import StoreSettings
from hawk.store.film import LONGEST_GAP_S, FilmError, write_film
from hawk.store.recording import Recording
from hawk.store.replay import RecordingError
from tests.manual_clock import ManualClock
from tests.unit.store.test_frame_codec import FRAME

BROKEN = b"\xff\xd8broken\xff\xd9"


def jpeg(grey: int, width: int = 64) -> bytes:
    encoded, data = cv2.imencode(".jpg", np.full((width // 2, width, 3), grey, np.uint8))
    assert encoded
    return bytes(data)


async def recorded(folder: Path, pictures: list[tuple[float, bytes]]) -> Path:
    """Return a recording with these pictures, each recorded some seconds after the one before."""
    clock = ManualClock(10.0)
    recording = Recording(StoreSettings(directory=folder, minimum_free_mb=1), clock, {"seed": "1"})
    recording.begin()
    recording.record("facts", {"height": 3.0})
    for wait, data in pictures:
        clock.advance(wait)
        recording.record_frame(replace(FRAME, jpeg=data))
    await recording.close()
    assert recording.path is not None
    return recording.path


def greys(film: Path) -> tuple[float, list[int]]:
    """Return the rate and the grey of each picture of a film."""
    reader = cv2.VideoCapture(str(film))
    found: list[int] = []
    while True:
        is_there, picture = reader.read()
        if not is_there:
            return reader.get(cv2.CAP_PROP_FPS), found
        found.append(round(float(picture.mean()) / 10) * 10)


def films(folder: Path) -> list[str]:
    return [each.name for each in folder.rglob("*.avi")]


async def test_a_film_has_every_picture_in_its_order_and_time(tmp_path: Path) -> None:
    shades = [0, 50, 100, 150, 200, 250]
    recording = await recorded(tmp_path, [(0.1, jpeg(grey)) for grey in shades])
    film = tmp_path / "film.avi"
    made = write_film(recording, film)
    assert (made.pictures, made.unreadable) == (6, 0)
    assert made.seconds == pytest.approx(0.6)
    assert greys(film) == (10.0, shades)
    assert films(tmp_path) == ["film.avi"]


async def test_a_picture_stands_still_until_the_next_one_and_a_long_gap_is_cut(tmp_path: Path) -> None:
    waits = [0.1, 0.1, 0.1, 0.5, 0.1, 60.0]
    recording = await recorded(tmp_path, [(wait, jpeg(40 * number)) for number, wait in enumerate(waits)])
    write_film(recording, tmp_path / "film.avi")
    rate, shown = greys(tmp_path / "film.avi")
    assert rate == 10.0
    assert shown == [0, 40, *[80] * 5, 120, *[160] * round(10 * LONGEST_GAP_S), 200]


async def test_an_unreadable_picture_is_counted_and_another_size_is_fitted(tmp_path: Path) -> None:
    pictures = [(0.1, jpeg(100)), (0.1, BROKEN), (0.1, jpeg(200, width=128))]
    made = write_film(await recorded(tmp_path, pictures), tmp_path / "film.avi")
    assert (made.pictures, made.unreadable) == (2, 1)
    assert greys(tmp_path / "film.avi")[1] == [100, 100, 200]


async def test_a_recording_that_a_crash_tore_gives_what_it_has(tmp_path: Path) -> None:
    recording = await recorded(tmp_path, [(0.1, jpeg(grey)) for grey in (0, 100, 200)])
    data = recording.read_bytes()
    recording.write_bytes(data[: data.rindex(jpeg(200)) + 20])
    assert write_film(recording, tmp_path / "film.avi").pictures == 2


async def test_nothing_is_written_where_a_film_cannot_be_made(tmp_path: Path) -> None:
    recording = await recorded(tmp_path, [(0.1, jpeg(100))])
    empty = await recorded(tmp_path / "empty", [])
    broken = await recorded(tmp_path / "broken", [(0.1, BROKEN)])
    (tmp_path / "there.avi").write_bytes(b"mine" * 100)
    for source, film, words in (
        (recording, "film.mp4", r"ends in \.avi"),
        (recording, "there.avi", "exists already"),
        (recording, "nowhere/film.avi", "is no folder"),
        (recording, f"{'n' * 300}.avi", "File name too long; name a folder"),
        (empty, "film.avi", "has no pictures"),
        (broken, "film.avi", "none of its pictures can be read"),
    ):
        with pytest.raises(FilmError, match=words):
            write_film(source, tmp_path / film)
    with pytest.raises(FilmError, match="1 MB are free, a film may need 50"):
        write_film(recording, tmp_path / "film.avi", free_bytes=lambda _: 1_000_000)
    with pytest.raises(RecordingError):
        write_film(tmp_path / "there.avi", tmp_path / "film.avi")
    assert films(tmp_path) == ["there.avi"]
    assert (tmp_path / "there.avi").read_bytes() == b"mine" * 100


async def test_the_command_says_what_it_made_or_why_not(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recording = await recorded(tmp_path, [(0.1, jpeg(100)), (0.1, jpeg(200))])
    assert main(["film", str(recording), str(tmp_path / "film.avi")]) == 0
    assert "film.avi: 2 pictures, 0.2 s" in capsys.readouterr().out
    assert main(["film", str(recording), str(tmp_path / "film.avi")]) == 1
    assert "exists already" in capsys.readouterr().err
