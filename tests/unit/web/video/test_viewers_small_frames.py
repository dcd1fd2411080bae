from __future__ import annotations

import asyncio
import itertools
import threading
from collections import Counter
from typing import Any

import cv2
import numpy as np
import pytest

from hawk.formats.image import decode, jpeg_size
from hawk.model.pictures import AnnotatedFrame
from hawk.web.video import viewers
from hawk.web.video.viewers import (
    LEAST_RATIO,
    MOST_RATIO,
    QUALITIES,
    SMALL_WIDTH,
    STEPS,
    FrameShrinker,
    SmallFrames,
    width_at,
)


def picture(width: int, quality: int = QUALITIES[0]) -> bytes:
    """Return a picture with edges of every size: rows of stalls, cars, and rough ground."""
    rng = np.random.default_rng(1)
    height = width * 9 // 16
    ground = rng.normal(110, 10, (height // 3, width // 3, 1)).repeat(3, axis=2)
    canvas = cv2.resize(ground.clip(0, 255).astype(np.uint8), (width, height), interpolation=cv2.INTER_CUBIC)
    for _ in range(120):
        x, y = int(rng.integers(0, width)), int(rng.integers(0, height))
        colour = tuple(int(value) for value in rng.integers(0, 255, 3))
        cv2.rectangle(canvas, (x, y), (x + width // 20, y + width // 40), colour, -1)
        cv2.rectangle(canvas, (x - 4, y - 4), (x + width // 18, y + width // 36), (240, 240, 240), 1)
    encoded, data = cv2.imencode(".jpg", canvas, [cv2.IMWRITE_JPEG_QUALITY, quality])
    assert encoded
    return bytes(data)


@pytest.mark.slow
@pytest.mark.parametrize("width", [640, 960, 1280, 1920])
def test_neighbouring_steps_differ_by_what_the_pace_counts_on(width: int) -> None:
    whole = AnnotatedFrame(1, 0.0, picture(width))
    sizes = [len(whole.jpeg), *(len(FrameShrinker().make(whole, step).jpeg) for step in range(1, STEPS + 1))]
    ratios = [larger / smaller for larger, smaller in itertools.pairwise(sizes)]
    assert max(ratios) <= MOST_RATIO, ratios
    if width >= 960:  # the default
        assert min(ratios) >= LEAST_RATIO, ratios


def test_widths_go_down_to_the_smallest_by_the_same_share() -> None:
    assert [width_at(1280, step) for step in range(STEPS + 1)] == [1280, 905, 640, 453, SMALL_WIDTH]
    assert width_at(300, STEPS) == 300


def test_a_smaller_form_has_the_shape_and_the_moment_of_the_whole() -> None:
    frame = AnnotatedFrame(7, 2.5, picture(960))
    small = FrameShrinker().make(frame, 2)
    assert (small.sequence, small.captured) == (7, 2.5)
    assert jpeg_size(small.jpeg) == (554, 312)
    assert decode(small.jpeg).shape == (312, 554, 3)


async def test_each_step_is_made_once_for_all_off_the_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    encoded: Counter[tuple[int, int]] = Counter()
    decoded: list[tuple[int, str]] = []
    encode = viewers._encoded

    def count(frame: AnnotatedFrame, image: Any, size: tuple[int, int], quality: int) -> AnnotatedFrame:
        encoded[size] += 1
        return encode(frame, image, size, quality)

    def note(data: bytes, reduction: int) -> Any:
        decoded.append((reduction, threading.current_thread().name))
        return decode(data, reduction)

    monkeypatch.setattr(viewers, "_encoded", count)
    monkeypatch.setattr(viewers, "decode", note)
    frames = SmallFrames()
    frame = AnnotatedFrame(1, 0.0, picture(1280))
    try:
        asked = [frames.of(frame, step) for step in (1, 4, 1, 4, 2, 3, 1)]
        sizes = [len((await each).jpeg) for each in asked]
        assert await frames.of(frame, 4) is await asked[1]
    finally:
        frames.close()
    assert encoded == {(905, 509): 1, (640, 360): 1, (453, 255): 1, (320, 180): 1}
    assert sorted(reduction for reduction, _ in decoded) == [1, 2, 4]
    assert {name.rstrip("0123456789_") for _, name in decoded} == {"web-small-frames"}
    assert sizes[0] > sizes[4] > sizes[5] > sizes[1]


async def test_a_picture_that_cannot_be_read_stays_as_it_is() -> None:
    frames = SmallFrames()
    broken = AnnotatedFrame(3, 1.5, b"\xff\xd8\xff\xd9")
    try:
        async with asyncio.timeout(5):
            assert await frames.of(broken, 1) is broken
    finally:
        frames.close()
