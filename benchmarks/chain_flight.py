"""The algorithms alone over a world: camera, vision, mapper and planner flown by a kinematic drone, without MAVLink.

    python -m benchmarks.chain_flight --seeds 1-5 --json chain.json
    python -m benchmarks.chain_flight --lots DIR

Prints what was found against the truth, the way flown and the milliseconds of each step. It is several times faster
than a survey through the simulator, and tells errors of the algorithms from errors of the flight.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import shapely

from hawk.algo.frame import FrameInput, FrameOutput
from hawk.algo.manager import AlgorithmManagerApp
from hawk.algo.mapper.app import MapperApp
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.algo.vision.app import VisionApp
from hawk.algo.vision.settings import VisionSettings
from hawk.model import (
    CameraModel,
    Fence,
    GlobalPose,
    HeightParameters,
    MapPoint,
    MapPose,
    PathPlan,
    StateName,
)
from hawk.survey.report import compare
from hawk.survey.survey_map import SurveyMap, unpack_tiles
from hawk.survey.truth import Truth, parse_truth
from hawk.worlds.camera import WorldCamera
from hawk.worlds.generate import generate_world
from hawk.worlds.picture import picture_world
from hawk.worlds.world import World

FRAMES_PER_S = 5.0
SPEED_M_S = 4.0
ACCELERATION = 2.5
YAW_RATE = math.radians(60)
HEIGHT_M = 35.0
FENCE_M = 10.0
TIMEOUT_S = 900.0
ORIGIN = GlobalPose(43.2609, -79.9192, 0.0)
PIXELS = (1280, 720)
FIELD_OF_VIEW = math.radians(70)


@dataclass(slots=True)
class Drone:
    """A point that flies to targets with limited speed, acceleration and turn rate. Metres, map frame."""

    north: float
    east: float
    yaw: float = 0.0
    speed_north: float = 0.0
    speed_east: float = 0.0
    way: float = 0.0

    def step(self, plan: PathPlan, dt: float) -> None:
        """Fly towards the plan's target for ``dt`` seconds."""
        wanted = np.zeros(2)
        if plan.target is not None:
            offset = np.array([plan.target.north - self.north, plan.target.east - self.east])
            distance = float(np.hypot(*offset))
            if distance > 0.05:
                speed = min(SPEED_M_S, math.sqrt(2 * ACCELERATION * 0.7 * distance))
                wanted = offset / distance * speed
        change = wanted - (self.speed_north, self.speed_east)
        size = float(np.hypot(*change))
        if size > ACCELERATION * dt:
            change *= ACCELERATION * dt / size
        self.speed_north += float(change[0])
        self.speed_east += float(change[1])
        self.north += self.speed_north * dt
        self.east += self.speed_east * dt
        self.way += math.hypot(self.speed_north, self.speed_east) * dt
        if plan.yaw is not None:
            turn = math.remainder(plan.yaw - self.yaw, math.tau)
            self.yaw += max(-YAW_RATE * dt, min(YAW_RATE * dt, turn))


def fly(world: World, truth: Truth, model: Path | None, seed: int = 0) -> tuple[FrameOutput, Drone, float, list[float]]:
    """Fly one exploration; return the last output, the drone, seconds flown and milliseconds of every frame."""
    camera_model = _camera_model()
    camera = WorldCamera(world, camera_model)
    manager = _manager(model)
    rng = np.random.default_rng(seed)
    x0, y0 = world.start()
    drone = Drone(0.0, 0.0)
    fence = _fence(truth, x0, y0)
    output: FrameOutput | None = None
    costs: list[float] = []
    dt = 1 / FRAMES_PER_S
    for sequence in range(int(TIMEOUT_S * FRAMES_PER_S)):
        roll, pitch = rng.normal(0, math.radians(0.7), 2)
        picture = camera.render(x0 + drone.east, y0 - drone.north, HEIGHT_M, roll, pitch, drone.yaw, rng=rng)
        jpeg = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes()
        pose = MapPose(drone.north, drone.east, HEIGHT_M, float(roll), float(pitch), drone.yaw)
        output = manager.run(
            FrameInput(
                sequence,
                sequence * dt,
                jpeg,
                camera_model,
                pose,
                math.hypot(drone.speed_north, drone.speed_east),
                StateName.AUTONOMOUS_EXPLORE,
                None,
                HeightParameters(15, HEIGHT_M, 60),
                fence,
                MapPoint(0, 0),
            )
        )
        costs.append(dict(output.timings)["all"])
        if output.path_plan.explore.done:
            break
        drone.step(output.path_plan, dt)
    assert output is not None
    return output, drone, len(costs) * dt, costs


def survey_of(world: World, output: FrameOutput) -> SurveyMap:
    """Return the map of a flight as a survey would: its datum is the world's start."""
    import pymap3d

    x0, y0 = world.start()
    latitude, longitude, _ = pymap3d.ned2geodetic(-y0, x0, 0.0, ORIGIN.latitude, ORIGIN.longitude, 0.0)
    found = output.occupancy_map
    tiles = unpack_tiles({key: tile.data for key, tile in found.tiles.items()})
    mosaic = {key: tile.data for key, tile in found.mosaic.items()}
    return SurveyMap(GlobalPose(float(latitude), float(longitude), 0.0), found.stalls, tiles, mosaic)


def _manager(model: Path | None) -> AlgorithmManagerApp:
    interface = AlgorithmTopicInterface()
    manager = AlgorithmManagerApp()
    manager.init(
        interface, VisionApp(VisionSettings(model=model)), MapperApp(map_id="chain"), PathPlanApp(),
        FrameCamera(interface),
    )  # fmt: skip
    return manager


def _camera_model() -> CameraModel:
    width, height = PIXELS
    focal = width / 2 / math.tan(FIELD_OF_VIEW / 2)
    return CameraModel(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)


def _fence(truth: Truth, x0: float, y0: float) -> Fence:
    lots = shapely.union_all([shapely.Polygon(lot).buffer(0) for lot in truth.lots])
    area = lots.buffer(FENCE_M)
    outer = area if area.geom_type == "Polygon" else area.convex_hull
    ring = tuple((float(y0 - y), float(x - x0)) for x, y in np.asarray(outer.simplify(0.5).exterior.coords)[:-1])
    return Fence(ring, ring, 97.0, 100.0)


def _worlds(options: argparse.Namespace) -> Iterable[tuple[str, World]]:
    if options.lots is not None:
        for path in sorted(options.lots.glob("*.json")):
            scale = json.loads(path.read_text())["metres_per_pixel"]
            yield path.stem, picture_world(path.with_suffix(".jpg"), scale, path)
        return
    first, _, last = options.seeds.partition("-")
    for seed in range(int(first), int(last or first) + 1):
        yield f"seed {seed}", generate_world(seed)


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly every world and print one line each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1-5", metavar="A-B", help="drawn worlds")
    parser.add_argument(
        "--lots", type=Path, metavar="DIR", help="places instead: pictures with truth files beside them"
    )
    parser.add_argument("--model", type=Path, help="an ONNX model in place of the package's")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write each place's map as a picture")
    parser.add_argument("--json", type=Path, metavar="FILE")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    results: dict[str, list[float]] = {}
    for name, world in _worlds(options):
        truth = parse_truth(world.truth_json(), ORIGIN)
        output, drone, seconds, costs = fly(world, truth, options.model)
        survey = survey_of(world, output)
        figures = {**compare(survey, truth), "way_m": drone.way, "seconds": seconds}
        figures |= {"frame_ms_p50": float(np.median(costs)), "frame_ms_p95": float(np.percentile(costs, 95))}
        print(f"{name:20s} " + " ".join(f"{key} {value:.3f}" for key, value in figures.items()), flush=True)
        for key, value in figures.items():
            results.setdefault(key, []).append(float(value))
        if options.out is not None:
            from hawk.survey.map_picture import map_picture

            options.out.mkdir(parents=True, exist_ok=True)
            cv2.imwrite(str(options.out / f"{name.replace(' ', '-')}.png"), map_picture(survey))
    means = {key: float(np.mean(values)) for key, values in results.items()}
    print(f"{'mean':20s} " + " ".join(f"{key} {value:.3f}" for key, value in means.items()))
    if options.json is not None:
        options.json.write_text(json.dumps(means, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
