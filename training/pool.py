"""A pool of drawn scenes: a process of its own keeps drawing while the network learns."""

from __future__ import annotations

import multiprocessing
import os
import queue
from collections.abc import Sequence
from multiprocessing.queues import Queue
from typing import Final

import cv2
import numpy as np

from hawk.algo.vision.network import VEHICLE_KINDS
from hawk.worlds.scene.render import AS_DRAWN
from training.looks import Dress
from training.scenes import HIDDEN_SHARE, Scene, SceneStall, SceneVehicle, draw_scene
from training.targets import TrainingScene, VehicleLabels

SIDE_PIXELS = 400
KIND_OF_DRAWN: Final = {
    **dict.fromkeys(("sedan", "hatch", "suv", "minivan", "pickup"), "car"),
    **dict.fromkeys(("van", "motorhome"), "van"),
    **dict.fromkeys(("lorry", "coach"), "lorry"),
    "trailer": "trailer",
}
"""Class of each kind of drawn vehicle; a motorcycle has none."""
_WAITING = 24


class ScenePool:
    """Newest scenes of drawing processes; beyond ``capacity`` a new scene replaces the oldest."""

    def __init__(
        self,
        seed: int,
        capacity: int,
        painters: int = 1,
        side: int = SIDE_PIXELS,
        *,
        drawn: int = 0,
        dress: Dress | None = None,
    ) -> None:
        """Begin to draw. ``drawn`` scenes of the seed are left out: a training that goes on has seen them.

        ``dress``: real textures for a part of the scenes.
        """
        context = multiprocessing.get_context("spawn")
        self._queue: Queue[TrainingScene] = context.Queue(_WAITING)
        self._painters = [
            context.Process(
                target=_paint,
                args=(self._queue, seed, drawn + k, painters, side, dress),
                name=f"painter-{k}",
                daemon=True,
            )
            for k in range(painters)
        ]
        self._capacity = capacity
        self._scenes: list[TrainingScene] = []
        self.drawn = drawn
        self._first = drawn
        for painter in self._painters:
            painter.start()

    def __len__(self) -> int:
        return len(self._scenes)

    def __getitem__(self, index: int) -> TrainingScene:
        return self._scenes[index]

    def take(self, at_most: int) -> None:
        """Take up to ``at_most`` drawn scenes.

        The drawing process waits while scenes are left: it draws no more than is used.
        """
        for _ in range(at_most):
            try:
                self._add(self._queue.get_nowait())
            except queue.Empty:
                return

    def take_until(self, drawn: int, timeout: float = 60.0) -> None:
        """Take scenes until ``drawn`` have come since the beginning; wait for them.

        Raises RuntimeError when no scene comes in ``timeout`` seconds.
        """
        while self.drawn < drawn:
            try:
                self._add(self._queue.get(timeout=timeout))
            except queue.Empty:
                raise RuntimeError("no scene was drawn in time: does the painter process run?") from None

    def _add(self, scene: TrainingScene) -> None:
        if len(self._scenes) < self._capacity:
            self._scenes.append(scene)
        else:
            self._scenes[(self.drawn - self._first) % self._capacity] = scene
        self.drawn += 1

    def close(self) -> None:
        """End the drawing process."""
        for painter in self._painters:
            painter.terminate()
            painter.join(5)
        self._queue.cancel_join_thread()
        self._queue.close()


def training_scene(scene: Scene) -> TrainingScene:
    """Return the training scene of a drawn scene.

    Stalls that are hidden and that no row implies, or free without visible paint and not between cars, are not judged:
    a picture does not show them.
    """
    count = len(scene.stalls)
    return TrainingScene(
        image=scene.image,
        labels=np.stack([scene.lot, scene.car, scene.shade, scene.cover], axis=-1),
        quads=np.array([s.quad for s in scene.stalls], np.float32).reshape(count, 4, 2),
        taken=np.array([s.taken for s in scene.stalls], np.bool_),
        judged=np.array([_is_judged(stall) for stall in scene.stalls], np.bool_),
        cast=np.asarray(scene.cast, np.float64),
        vehicles=_vehicle_labels(scene.vehicles),
    )


def _vehicle_labels(vehicles: Sequence[SceneVehicle]) -> VehicleLabels:
    """Return the labels of a drawn scene's vehicles: those under crowns and roofs, and motorcycles, are not judged."""
    kinds = [KIND_OF_DRAWN.get(one.kind) for one in vehicles]
    judged = [kind is not None and one.covered < HIDDEN_SHARE for kind, one in zip(kinds, vehicles, strict=True)]
    return VehicleLabels(
        quads=np.array([one.quad for one in vehicles], np.float32).reshape(-1, 4, 2),
        kind=np.array([VEHICLE_KINDS.index(kind or "car") for kind in kinds], np.intp),
        judged=np.array(judged, np.bool_),
    )


def _is_judged(stall: SceneStall) -> bool:
    return (stall.implied or not stall.hidden) and (stall.lines_visible or stall.taken or stall.framed)


def _paint(
    scenes: Queue[TrainingScene], seed: int, painter: int, painters: int, side: int, dress: Dress | None
) -> None:
    os.nice(5)
    cv2.setNumThreads(1)
    index = painter
    while True:
        looks = dress.looks(seed, index) if dress else AS_DRAWN
        scene = training_scene(draw_scene(np.random.default_rng((seed, index)), side, looks=looks))
        if not _hand_over(scenes, scene):
            scenes.cancel_join_thread()  # nobody will ever empty the pipe
            return
        index += painters


def _hand_over(scenes: Queue[TrainingScene], scene: TrainingScene) -> bool:
    """Wait for room; return False when the trainer is gone, so that no painter outlives it."""
    trainer = multiprocessing.parent_process()
    while trainer is None or trainer.is_alive():
        try:
            scenes.put(scene, timeout=2.0)
        except queue.Full:
            continue
        return True
    return False
