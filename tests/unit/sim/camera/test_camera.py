from __future__ import annotations

import asyncio
import math
import threading
from collections.abc import AsyncIterator

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.sim.camera.camera import FRAME_S, Camera, Shot, SimulationClock, default_intrinsics, turned_camera


class HandClock(SimulationClock):
    """A simulation clock moved by hand."""

    def __init__(self, speed: float = 1.0) -> None:
        self.real = 0.0
        super().__init__(speed, lambda: self.real)


class GreyRenderer:
    """Draws the height as a grey level; can be held up."""

    def __init__(self) -> None:
        self.gate = threading.Event()
        self.gate.set()
        self.drawn: list[float] = []
        self.fail = False

    def render(
        self,
        x_east: float,
        y_south: float,
        height: float,
        roll: float,
        pitch: float,
        yaw: float,
        *,
        rng: np.random.Generator,
    ) -> NDArray[np.uint8]:
        assert self.gate.wait(5.0)
        if self.fail:
            raise RuntimeError("no paint")
        self.drawn.append(height)
        return np.full((72, 128, 3), round(height), np.uint8)


class Bench:
    def __init__(self) -> None:
        self.clock = HandClock()
        self.renderer = GreyRenderer()
        self.camera = Camera(self.renderer, self.clock, np.random.default_rng(1), latency=0.0)

    def shot(self, height: float) -> None:
        self.camera.expose(Shot(100.0 + self.clock(), self.clock(), 0.0, 0.0, height, 0.0, 0.0, 0.0))


@pytest.fixture
async def bench() -> AsyncIterator[Bench]:
    made = Bench()
    yield made
    made.renderer.gate.set()
    await made.camera.close()


async def settle() -> None:
    for _ in range(5):
        await asyncio.sleep(0)


async def test_nothing_is_drawn_while_nobody_looks(bench: Bench) -> None:
    bench.shot(10.0)
    await settle()
    assert bench.renderer.drawn == []
    assert (bench.camera.due, bench.camera.drawn) == (0, 0)


async def test_a_viewer_gets_the_picture_with_its_stamp(bench: Bench) -> None:
    viewer = asyncio.create_task(bench.camera.next_frame())
    await settle()
    bench.shot(77.0)
    frame = await viewer
    picture = cv2.imdecode(np.frombuffer(frame.jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    assert abs(float(picture.mean()) - 77.0) < 1.5
    assert frame.stamp == pytest.approx(100.0)
    assert bench.camera.drawn == 1
    assert bench.camera.late == 0


async def test_only_newer_pictures_are_given(bench: Bench) -> None:
    bench.camera.watch(1)
    bench.shot(1.0)
    first = await bench.camera.next_frame()
    waiting = asyncio.create_task(bench.camera.next_frame(first.sequence))
    await settle()
    assert not waiting.done()
    bench.shot(2.0)
    assert (await waiting).sequence == first.sequence + 1


async def test_a_shot_that_waits_is_replaced_and_counts_as_late(bench: Bench) -> None:
    bench.camera.watch(1)
    bench.renderer.gate.clear()
    for height in (1.0, 2.0, 3.0):
        bench.shot(height)
        await settle()
    bench.renderer.gate.set()
    frame = await bench.camera.next_frame(1)
    assert frame.sequence == 2
    assert bench.renderer.drawn == [1.0, 3.0]
    assert (bench.camera.due, bench.camera.drawn, bench.camera.late) == (3, 2, 1)


@pytest.mark.parametrize(("delay", "late"), [(FRAME_S * 0.9, 0), (FRAME_S * 1.1, 1)])
async def test_late_is_more_than_one_period_after_its_slot(bench: Bench, delay: float, late: int) -> None:
    bench.camera.watch(1)
    bench.renderer.gate.clear()
    bench.shot(1.0)
    await settle()
    bench.clock.real += delay
    bench.renderer.gate.set()
    await bench.camera.next_frame()
    assert bench.camera.late == late


async def test_a_picture_arrives_after_its_latency() -> None:
    clock, renderer = SimulationClock(4.0), GreyRenderer()
    camera = Camera(renderer, clock, np.random.default_rng(1), latency=0.2)
    camera.watch(1)
    slot = clock()
    camera.expose(Shot(slot, slot, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0))
    await camera.next_frame()
    assert clock() - slot >= 0.2
    await camera.close()


async def test_a_renderer_that_fails_does_not_end_the_camera(bench: Bench) -> None:
    bench.camera.watch(1)
    bench.renderer.fail = True
    bench.shot(1.0)
    waiting = asyncio.create_task(bench.camera.next_frame())
    await asyncio.wait({waiting}, timeout=0.1)
    bench.renderer.fail = False
    bench.shot(5.0)
    assert (await waiting).sequence == 1


async def test_dark_gives_nothing_and_frozen_the_same_again(bench: Bench) -> None:
    bench.camera.watch(1)
    bench.shot(50.0)
    first = await bench.camera.next_frame()
    bench.camera.frozen = True
    bench.shot(90.0)
    second = await bench.camera.next_frame(first.sequence)
    assert second.jpeg == first.jpeg
    bench.camera.dark = True
    bench.shot(90.0)
    waiting = asyncio.create_task(bench.camera.next_frame(second.sequence))
    await asyncio.wait({waiting}, timeout=0.1)
    assert not waiting.done()
    waiting.cancel()


async def test_an_old_picture_is_forgotten_when_nobody_looked(bench: Bench) -> None:
    bench.camera.watch(1)
    bench.shot(1.0)
    await bench.camera.next_frame()
    bench.camera.watch(-1)
    bench.camera.forget()
    waiting = asyncio.create_task(bench.camera.next_frame())
    await settle()
    assert not waiting.done()
    bench.shot(2.0)
    assert (await waiting).sequence == 2


def test_the_lens_is_seventy_degrees_wide() -> None:
    lens = default_intrinsics()
    assert (lens.width, lens.height) == (1280, 720)
    assert math.degrees(2 * math.atan(640 / lens.fx)) == pytest.approx(70.0)
    assert lens.fx == lens.fy


def test_the_clock_runs_at_its_speed() -> None:
    clock = HandClock(3.0)
    clock.real = 2.0
    assert clock() == pytest.approx(6.0)


def axes(roll: float, pitch: float, yaw: float) -> NDArray[np.float64]:
    """Front, right and down of a body in NED, one a column: turns about z, then y, then x."""

    def turn(angle: float, first: int, second: int) -> NDArray[np.float64]:
        matrix = np.eye(3)
        matrix[[first, second], [first, second]] = math.cos(angle)
        matrix[first, second], matrix[second, first] = -math.sin(angle), math.sin(angle)
        return matrix

    return turn(yaw, 0, 1) @ turn(pitch, 2, 0) @ turn(roll, 1, 2)


def test_a_turned_camera_has_its_top_where_the_body_has_its_right() -> None:
    body, camera = axes(0.2, -0.1, 2.5), axes(*turned_camera(0.2, -0.1, 2.5, math.pi / 2))
    assert camera[:, 0] == pytest.approx(body[:, 1])
    assert camera[:, 1] == pytest.approx(-body[:, 0])
    assert camera[:, 2] == pytest.approx(body[:, 2])
    assert turned_camera(0.2, -0.1, 2.5, 0.0) == (0.2, -0.1, 2.5)


async def test_a_mirrored_picture_has_left_and_right_swapped(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    ramp = np.repeat(np.arange(128, dtype=np.uint8)[None, :, None], 72, 0).repeat(3, 2)
    monkeypatch.setattr(bench.renderer, "render", lambda *_, rng: ramp)
    bench.camera.watch(1)
    bench.camera.mirrored = True
    bench.shot(1.0)
    frame = await bench.camera.next_frame()
    picture = cv2.imdecode(np.frombuffer(frame.jpeg, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    assert picture[36, 5] > picture[36, 122] + 100


async def test_a_picture_may_have_little_contrast_and_each_of_a_number_none(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    ramp = np.repeat(np.arange(128, dtype=np.uint8)[None, :, None], 72, 0).repeat(3, 2)
    monkeypatch.setattr(bench.renderer, "render", lambda *_, rng: ramp)
    bench.camera.watch(1)
    spans = []
    for k, (contrast, every) in enumerate(((1.0, 0), (0.3, 0), (1.0, 3), (1.0, 3))):
        bench.camera.contrast, bench.camera.blank_every = contrast, every
        bench.shot(1.0 + k)
        frame = await bench.camera.next_frame(k)
        picture = cv2.imdecode(np.frombuffer(frame.jpeg, np.uint8), cv2.IMREAD_GRAYSCALE)
        assert picture is not None
        spans.append(int(picture.max()) - int(picture.min()))
    assert spans[0] > 120
    assert spans[1] == pytest.approx(0.3 * spans[0], abs=6)
    assert sum(span < 5 for span in spans[2:]) == 1
