from __future__ import annotations

import queue
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from hawk.worlds.scene.render import AS_DRAWN, Looks
from training import pool as pool_module
from training.pool import ScenePool, training_scene
from training.scenes import Scene, SceneStall
from training.targets import LABELS, TrainingScene

STALL = SceneStall(np.zeros((4, 2)), False, False, False, True, 1.0, 0.0, "perpendicular")


def drawn(*stalls: SceneStall) -> Scene:
    lot, car = np.ones((64, 80), np.uint8), np.zeros((64, 80), np.uint8)
    car[:10] = 1
    return Scene(
        np.full((64, 80, 3), 7, np.uint8),
        lot,
        car,
        np.zeros((64, 80), np.uint8),
        np.zeros((64, 80), np.uint8),
        stalls,
        (),
        0.1,
        np.array([0.5, -1.0]),
    )


def numbered(number: int) -> TrainingScene:
    return training_scene(replace(drawn(STALL), image=np.full((64, 80, 3), number, np.uint8)))


class Queue:
    """The queue of a painter that drew some scenes and is tired."""

    def __init__(self, count: int) -> None:
        self.scenes = [numbered(number) for number in range(count)]
        self.closed = False

    def get_nowait(self) -> TrainingScene:
        if not self.scenes:
            raise queue.Empty
        return self.scenes.pop(0)

    def get(self, timeout: float) -> TrainingScene:
        assert timeout > 0
        return self.get_nowait()

    def cancel_join_thread(self) -> None:
        pass

    def close(self) -> None:
        self.closed = True


class Painter:
    started: list[tuple[Any, ...]]

    def __init__(self, args: tuple[Any, ...], **_: object) -> None:
        self.args = args
        self.ended = False

    def start(self) -> None:
        Painter.started.append(self.args)

    def terminate(self) -> None:
        self.ended = True

    def join(self, timeout: float) -> None:
        assert timeout > 0


@pytest.fixture
def context(monkeypatch: pytest.MonkeyPatch) -> Queue:
    waiting = Queue(5)
    Painter.started = []

    class Context:
        def Queue(self, _: int) -> Queue:  # noqa: N802
            return waiting

        def Process(self, **options: Any) -> Painter:  # noqa: N802
            return Painter(options.pop("args"), **options)

    monkeypatch.setattr("multiprocessing.get_context", lambda _: Context())
    return waiting


def values(pool: ScenePool) -> list[int]:
    return [int(pool[k].image[0, 0, 0]) for k in range(len(pool))]


def test_scenes_are_taken_up_to_a_number_and_no_more_than_there_are(context: Queue) -> None:
    pool = ScenePool(seed=1, capacity=10)
    pool.take(2)
    assert (values(pool), pool.drawn) == ([0, 1], 2)
    pool.take(20)
    assert (values(pool), pool.drawn) == ([0, 1, 2, 3, 4], 5)
    assert context.scenes == []


def test_beyond_its_capacity_a_new_scene_replaces_the_oldest(context: Queue) -> None:
    pool = ScenePool(seed=1, capacity=3)
    pool.take_until(4)
    assert (values(pool), pool.drawn) == ([3, 1, 2], 4)
    pool.take_until(5)
    assert (values(pool), len(pool)) == ([3, 4, 2], 3)
    assert context.scenes == []


def test_taking_until_a_number_that_came_already_takes_nothing(context: Queue) -> None:
    pool = ScenePool(seed=1, capacity=3)
    pool.take_until(3)
    pool.take_until(1)
    assert pool.drawn == 3
    assert len(context.scenes) == 2


def test_a_painter_that_draws_nothing_is_reported(context: Queue) -> None:
    pool = ScenePool(seed=1, capacity=3)
    with pytest.raises(RuntimeError, match="does the painter process run"):
        pool.take_until(6, timeout=0.1)
    assert pool.drawn == 5
    assert context.scenes == []


def test_each_painter_has_its_own_part_of_the_scenes(context: Queue) -> None:
    pool = ScenePool(seed=9, capacity=3, painters=3, side=200)
    assert [args[1:] for args in Painter.started] == [(9, k, 3, 200, None) for k in range(3)]
    pool.close()
    assert context.closed
    assert all(painter.ended for painter in pool._painters)  # type: ignore[attr-defined]


def test_painters_draw_every_scene_once(monkeypatch: pytest.MonkeyPatch) -> None:
    seeds: list[tuple[int, int]] = []

    def draw(rng: tuple[int, int], side: int, looks: Looks) -> Scene:
        seeds.append(rng)
        assert side == 48
        assert looks is AS_DRAWN
        return drawn(STALL)

    monkeypatch.setattr(pool_module, "draw_scene", draw)
    monkeypatch.setattr("numpy.random.default_rng", lambda seed: seed)
    monkeypatch.setattr("os.nice", lambda _: 0)

    class Full:
        def __init__(self) -> None:
            self.room = 4

        def put(self, _: object, timeout: float) -> None:
            self.room -= 1
            if not self.room:
                raise InterruptedError

        def cancel_join_thread(self) -> None:
            pass

    for painter in (0, 1):
        with pytest.raises(InterruptedError):
            pool_module._paint(Full(), 7, painter, 2, 48, None)  # type: ignore[arg-type]
    assert sorted(seeds) == [(7, number) for number in range(8)]


def test_a_full_queue_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    tries: list[float] = []

    class Slow:
        def put(self, _: object, timeout: float) -> None:
            tries.append(timeout)
            if len(tries) < 3:
                raise queue.Full

    assert pool_module._hand_over(Slow(), numbered(1))  # type: ignore[arg-type]
    assert len(tries) == 3


@pytest.mark.parametrize(
    ("stall", "judged"),
    [
        (STALL, True),
        (replace(STALL, lines_visible=False), False),
        (replace(STALL, lines_visible=False, taken=True), True),
        (replace(STALL, hidden=True), False),
        (replace(STALL, hidden=True, taken=True), False),
        (replace(STALL, hidden=True, implied=True), True),
        (replace(STALL, hidden=True, implied=True, lines_visible=False), False),
        (replace(STALL, worn=True), True),
    ],
)
def test_a_stall_is_judged_when_the_picture_shows_it(stall: SceneStall, judged: bool) -> None:
    assert training_scene(drawn(stall)).judged.tolist() == [judged]


def test_a_training_scene_has_the_masks_and_states_of_its_scene() -> None:
    quad = np.arange(8.0).reshape(4, 2)
    kept = training_scene(drawn(replace(STALL, quad=quad, taken=True), STALL))
    assert kept.labels.shape == (64, 80, LABELS)
    assert kept.labels[..., 0].all()
    assert kept.cast is not None
    assert kept.cast.tolist() == [0.5, -1.0]
    assert kept.labels[..., 1].sum() == 800
    assert kept.quads.dtype == np.float32
    assert kept.quads[0] == pytest.approx(quad)
    assert kept.taken.tolist() == [True, False]


def test_a_scene_without_stalls_has_empty_arrays() -> None:
    kept = training_scene(drawn())
    assert kept.quads.shape == (0, 4, 2)
    assert kept.taken.shape == kept.judged.shape == (0,)
