"""Films whose head says what no film has."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import pytest

from hawk.picture.film import video
from hawk.picture.film.video import Video
from hawk.picture.values import PictureError


class Head:
    """A capture with this head."""

    def __init__(self, fps: float, frames: float, width: float, height: float) -> None:
        self._values: dict[int, float] = {
            cv2.CAP_PROP_FPS: fps,
            cv2.CAP_PROP_FRAME_COUNT: frames,
            cv2.CAP_PROP_FRAME_WIDTH: width,
            cv2.CAP_PROP_FRAME_HEIGHT: height,
        }
        self.is_released = False

    def get(self, name: int) -> float:
        return self._values[name]

    def release(self) -> None:
        self.is_released = True


HEAD = (25.0, 10.0, 1920.0, 1080.0)


def opened(monkeypatch: pytest.MonkeyPatch, head: tuple[float, float, float, float]) -> tuple[Head, Video | str]:
    made = Head(*head)
    monkeypatch.setattr(video.Video, "_opened", lambda _: made)
    try:
        return made, Video(Path("a.mp4"))
    except PictureError as refused:
        return made, str(refused)


@pytest.mark.parametrize("head", [HEAD, (0.5, 1.0, 1.0, 1.0), (1000.0, 1.0, 10_000.0, 6700.0)])
def test_a_head_at_the_limits_is_a_film(
    monkeypatch: pytest.MonkeyPatch, head: tuple[float, float, float, float]
) -> None:
    made, film = opened(monkeypatch, head)
    assert isinstance(film, Video)
    assert (film.fps, *map(float, (film.frames, *film.size))) == head
    assert not made.is_released


@pytest.mark.parametrize(
    ("head", "words"),
    [
        *(
            ((fps, *HEAD[1:]), "no frame of it can be read: it is torn or no film")
            for fps in (0.0, 0.49, 1000.1, math.nan)
        ),
        ((25.0, 0.0, 1920.0, 1080.0), "no frame of it can be read"),
        ((25.0, 9.0, 0.0, 1080.0), "no frame of it can be read"),
        ((25.0, 9.0, 1920.0, 0.0), "no frame of it can be read"),
        ((25.0, 9.0, 10_001.0, 6700.0), "its frames have 10001 by 6700 pixels, 67 million are the most"),
    ],
)
def test_a_head_beyond_the_limits_is_refused_and_the_film_closed(
    monkeypatch: pytest.MonkeyPatch, head: tuple[float, float, float, float], words: str
) -> None:
    made, refused = opened(monkeypatch, head)
    assert isinstance(refused, str)
    assert words in refused
    assert made.is_released
